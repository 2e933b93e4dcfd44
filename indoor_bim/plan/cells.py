"""The plan cut into cells by wall lines, and the cells labelled room or not by a minimum cut."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.plan.passing_rays import Rays
from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


TOUCHING = 1e-3  # metres; edges on one line that are nearer follow one another
SEEN_FROM_AFAR = 25.0  # rays stopped by a metre of a face that hardly shows


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Planar cells and the edges between them.

    Parameters
    ----------
    polygons : (k,) object
        Shapely polygons of the bounded cells.
    edge_line : (e,) int64
        Line that the edge lies on.
    edge_start, edge_end : (e, 2) float64
        Ends of the edge, in the direction of its line, metres.
    left, right : (e,) int64
        Cells to the left and right of the line's direction; -1 for the outside of the plan.
    """

    polygons: NDArray
    edge_line: Ints
    edge_start: Floats
    edge_end: Floats
    left: Ints
    right: Ints


def cut_into_cells(p: Floats, q: Floats) -> Cells:
    """Cells of the arrangement of line segments.

    Parameters
    ----------
    p, q : (m, 2) float64
        Ends of the segments, metres; free space to the left of p -> q.
    """
    segments = shapely.linestrings(np.stack([p, q], axis=1))
    noded = shapely.union_all(segments, grid_size=1e-6)
    polygons = shapely.get_parts(shapely.polygonize([noded]))
    rings, owners = [], []
    for number, polygon in enumerate(shapely.orient_polygons(polygons)):
        for ring in (polygon.exterior, *polygon.interiors):
            rings.append(np.asarray(ring.coords))
            owners.append(number)
    tail = np.vstack([ring[:-1] for ring in rings])
    head = np.vstack([ring[1:] for ring in rings])
    cell = np.repeat(np.array(owners), [len(ring) - 1 for ring in rings])
    line = _line_of(segments, p, q, (tail + head) / 2)
    direction = (q - p) / np.hypot(*(q - p).T)[:, None]
    forward = ((head - tail) * direction[line]).sum(axis=1) > 0
    first = np.where(forward[:, None], tail, head)
    last = np.where(forward[:, None], head, tail)
    key = np.round(np.hstack([first, last]), 5)
    (
        _,
        edge,
    ) = np.unique(key, axis=0, return_inverse=True)[:2]
    edge = edge.reshape(-1)
    count = int(edge.max()) + 1
    left, right = np.full(count, -1), np.full(count, -1)
    left[edge[forward]] = cell[forward]
    right[edge[~forward]] = cell[~forward]
    some = np.zeros(count, dtype=np.int64)
    some[edge] = np.arange(len(edge))
    return Cells(polygons, line[some], first[some], last[some], left, right)


def cell_image(polygons: NDArray, template: Raster) -> NDArray[np.int32]:
    """Number of the cell under every pixel of a raster, -1 where there is none."""
    from indoor_bim.plan.polygon_fill import fill

    image = np.full(template.image.shape, -1, dtype=np.int32)
    for number in np.argsort([-polygon.area for polygon in polygons], kind="stable"):
        polygon = polygons[number]
        xy = (np.asarray(polygon.exterior.coords) - template.origin) / template.cell - 0.5
        fill(xy, number, image)
    return image


def close_corners(cells: Cells, wall: Floats, *, gap: float = 0.40, seen: float = 0.5) -> Floats:
    """Wall evidence of edges with the hidden ends of faces: what is missing up to the next wall is taken from the face.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    wall : (e,) float64
        Share of each edge where the face of its line was seen.
    gap : float
        Longest end that was hidden, metres.
    seen : float
        Share from which an edge counts as wall.
    """
    ends = np.round(np.vstack([cells.edge_start, cells.edge_end]), 4)
    _, vertex = np.unique(ends, axis=0, return_inverse=True)
    start, end = vertex.reshape(2, -1)
    strong = wall >= seen
    meets: dict[int, set[int]] = {}
    for k in np.flatnonzero(strong):
        for corner in (int(start[k]), int(end[k])):
            meets.setdefault(corner, set()).add(int(cells.edge_line[k]))
    leads_on = np.flatnonzero(start != end)
    after = {(int(cells.edge_line[k]), int(start[k])): int(k) for k in leads_on}
    before = {(int(cells.edge_line[k]), int(end[k])): int(k) for k in leads_on}
    length = np.hypot(*(cells.edge_end - cells.edge_start).T)
    closed = wall.copy()
    for k in np.flatnonzero(strong):
        line = int(cells.edge_line[k])
        for step, far, corner in ((after, end, int(end[k])), (before, start, int(start[k]))):
            run: list[int] = []
            while not meets.get(corner, set()) - {line} and (line, corner) in step:
                run.append(step[line, corner])
                corner = int(far[run[-1]])
                if strong[run[-1]] or length[run].sum() > gap:
                    break
            if run and not strong[run[-1]] and length[run].sum() <= gap and meets.get(corner, set()) - {line}:
                closed[run] = np.maximum(closed[run], wall[k])
    return closed


def hidden_wall(
    cells: Cells,
    wall: Floats,
    direction: Floats,
    *,
    empty: Bools,
    seen: float = 0.5,
    least: float = 1.0,
    gap: float = 2.0,
    thickest: float = 0.6,
    met: float = 0.25,
    sided: bool = True,
    rays: Rays | None = None,
    far: float = 8.0,
) -> Bools:
    """Edges where a face is hidden, as behind a cupboard, and the other face of the wall is hidden as well or was seen: it goes on.

    It goes on from one part that was seen to the next, or to the face of a wall across if it is hidden all the way there.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    wall : (e,) float64
        Share of each edge where the face of its line was seen.
    direction : (m, 2) float64
        Unit vectors along the lines of faces; edges of other lines never count.
    empty : (k,) bool
        Cells in which neither floor nor ceiling was seen.
    seen : float
        Share from which an edge counts as wall.
    least : float
        Length of the face that was seen at least, metres.
    gap : float
        Farthest end of the hidden part from what was seen of the face on either side of it, metres.
    thickest : float
        Thickest wall, metres.
    met : float
        Share from which an edge counts as the face of a wall across.
    sided : bool
        Whether it is known which side faces were seen from; only then a seen face says where the other one is.
    rays : Rays, optional
        Rays of the scan. Where none passes, the hidden part may be longer.
    far : float
        Farthest end of a hidden part that no ray passes, metres.
    """
    lines = len(direction)
    length = np.hypot(*(cells.edge_end - cells.edge_start).T)
    thickness = np.array([2 * polygon.area / polygon.length for polygon in cells.polygons])
    right = np.maximum(cells.right, 0)
    behind = (cells.edge_line < lines) & (cells.right >= 0) & (wall < seen) & empty[right] & (thickness[right] < thickest)
    candidate = np.zeros(len(wall), dtype=bool)
    for line in np.unique(cells.edge_line[behind]):
        rows = np.flatnonzero(cells.edge_line == line)
        start, end = cells.edge_start[rows] @ direction[line], cells.edge_end[rows] @ direction[line]
        strong = wall[rows] >= seen
        if (wall[rows] * length[rows])[strong].sum() < least:
            continue
        before = np.where(end[strong][None] <= start[:, None] + TOUCHING, start[:, None] - end[strong][None], np.inf).min(axis=1)
        after = np.where(start[strong][None] >= end[:, None] - TOUCHING, start[strong][None] - end[:, None], np.inf).min(axis=1)
        corners = _met_by_walls(cells, wall, direction, rows, seen=met)
        first, last = _hidden_runs(start, end, behind[rows])
        back, on = start[:, None] - corners[None], corners[None] - end[:, None]
        behind_it = (back > -TOUCHING) & (corners[None] > first[:, None] - TOUCHING)
        ahead = (on > -TOUCHING) & (corners[None] < last[:, None] + TOUCHING)
        before = np.minimum(before, np.where(behind_it, back, np.inf).min(axis=1, initial=np.inf))
        after = np.minimum(after, np.where(ahead, on, np.inf).min(axis=1, initial=np.inf))
        end_of_it = np.maximum(before, after)
        candidate[rows] = behind[rows] & (end_of_it <= gap)
        doubtful = behind[rows] & (end_of_it <= far) & (np.maximum(end_of_it, length[rows]) > gap)
        if rays is None:
            continue
        for k in rows[doubtful]:
            candidate[k] = not rays.seen_through(cells.edge_start[k], cells.edge_end[k], stopped=SEEN_FROM_AFAR)
    hidden = np.zeros(len(wall), dtype=bool)
    for cell in np.unique(right[candidate]):
        sides = np.flatnonzero(candidate & (right == cell))
        backs = np.flatnonzero((candidate | (sided & (wall >= seen))) & (cells.edge_line < lines) & (cells.right == cell))
        facing = direction[cells.edge_line[sides]] @ direction[cells.edge_line[backs]].T
        hidden[sides] = (facing < -0.99).any(axis=1)
    return hidden


def _hidden_runs(start: Floats, end: Floats, hidden: Bools) -> tuple[Floats, Floats]:
    """Where the run of hidden edges that each edge of a line is part of begins and ends."""
    first, last = start.copy(), end.copy()
    order = np.argsort(start, kind="stable")
    for rows, reach, near, far in ((order, first, start, end), (order[::-1], last, end, start)):
        for before, k in itertools.pairwise(rows):
            if hidden[before] and hidden[k] and abs(near[k] - far[before]) < TOUCHING:
                reach[k] = reach[before]
    return first, last


def _met_by_walls(cells: Cells, wall: Floats, direction: Floats, rows: Ints, *, seen: float) -> Floats:
    """Places along a line, given by its edges, where the face of a wall across it begins, ends or crosses."""
    line = cells.edge_line[rows[0]]
    across = np.flatnonzero((cells.edge_line < len(direction)) & (wall >= seen))
    across = across[np.abs(direction[cells.edge_line[across]] @ direction[line]) < 0.5]
    own, theirs = (np.round(np.vstack([cells.edge_start[k], cells.edge_end[k]]), 4) for k in (rows, across))
    shared = np.isin(own[:, 0] + 1j * own[:, 1], theirs[:, 0] + 1j * theirs[:, 1])
    places: Floats = own[shared] @ direction[line]
    return places


def label_cells(cells: Cells, *, inside: Floats, wall: Floats, border: float = 0.25, solid: float = 0.30) -> Bools:
    """Which cells are room: the minimum cut between evidence for free space and evidence for walls.

    A cell that is called room against its evidence, or not room against it, costs the evidence; every metre of border
    between room and not room costs what it lacks in wall evidence; and what lies behind a seen face is solid.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    inside : (k,) float64
        Evidence in square metres that a cell is free space; negative where it is not.
    wall : (e,) float64
        Share of each edge where a wall face looking to its left was seen.
    border : float
        Cost of a metre of border without wall, square metres per metre.
    solid : float
        Depth behind a seen face that counts as solid, metres.

    References
    ----------
    Boykov, Kolmogorov, An experimental comparison of min-cut/max-flow algorithms for energy minimization in vision, 2004.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    count = len(cells.polygons)
    length = np.hypot(*(cells.edge_end - cells.edge_start).T)
    unary = inside.copy()
    behind = cells.right >= 0
    np.add.at(unary, cells.right[behind], -solid * (wall * length)[behind])
    scale = 1e4
    source, sink = count, count + 1
    left = np.where(cells.left >= 0, cells.left, sink)
    right = np.where(cells.right >= 0, cells.right, sink)
    rows = [np.full(count, source), np.arange(count), left, right]
    columns = [np.arange(count), np.full(count, sink), right, left]
    capacity = [np.maximum(unary, 0), np.maximum(-unary, 0), border * length * (1 - wall), border * length]
    r, c, w = np.concatenate(rows), np.concatenate(columns), np.rint(np.concatenate(capacity) * scale).astype(np.int64)
    keep = (r != c) & (r != sink) & (w > 0)
    graph = coo_matrix((w[keep].astype(np.int32), (r[keep], c[keep])), shape=(count + 2, count + 2)).tocsr()
    graph.sum_duplicates()
    flow = maximum_flow(graph, source, sink).flow
    residual = graph - flow
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    reached = breadth_first_order(residual, source, return_predecessors=False)
    room = np.zeros(count + 2, dtype=bool)
    room[reached] = True
    return room[:count]


def _line_of(segments: NDArray, p: Floats, q: Floats, spots: Floats) -> Ints:
    """Nearest line of each spot; ties go to the first line."""
    tree = shapely.STRtree(segments)
    spot, line = tree.query(shapely.points(spots), predicate="dwithin", distance=1e-4)
    direction = (q - p) / np.hypot(*(q - p).T)[:, None]
    away = spots[spot] - p[line]
    distance = np.abs(away[:, 0] * direction[line, 1] - away[:, 1] * direction[line, 0])
    order = np.lexsort((line, np.round(distance, 7), spot))
    spot, line = spot[order], line[order]
    found, first = np.unique(spot, return_index=True)
    out = np.zeros(len(spots), dtype=np.int64)
    out[found] = line[first]
    return out
