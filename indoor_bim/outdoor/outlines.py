"""From wall faces to closed outlines: the plane is cut by the lines of the walls, and each cell is inside or outside.

The cut of least cost is found by maximum flow: a border is free where a wall was seen and costs its length where none was; cells
where ground was seen are outside, cells behind a wall that has ground before it are inside.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.outdoor.ground_seen import GroundSeen
from indoor_bim.outdoor.wall_lines import WallLine

Floats = NDArray[np.float64]
Point = tuple[float, float]

REACH = 8.0
CLOSING_REACH = 20.0
SAME_ANGLE = np.radians(2.5)
SAME_OFFSET = 0.10
SEEN_THROUGH = 1.0
SHORT = 0.2
WALL_COST, SQUARE_COST, OBLIQUE_COST = 0.5, 1.0, 1.7
UNSURE_COST, SEEN_COST = 0.1, 0.02
GROUND_WEIGHT, OVERHEAD_WEIGHT, UNKNOWN_WEIGHT, BEHIND_WALL_WEIGHT = 1.5, 0.2, 0.01, 2.0
UNIT = 1000
LEAST_GROUND_SHARE = 0.15


@dataclass(frozen=True, slots=True)
class OutlineEdge:
    """Side of an outline, counter-clockwise.

    Parameters
    ----------
    start, end : (float, float)
        Ends, metres.
    line : int
        Number of the line it lies on.
    coverage : float
        Share of its length where a wall was seen.
    """

    start: Point
    end: Point
    line: int
    coverage: float

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """Line of one or more faces: unit direction, normal to its left, offset along the normal, stretches seen and their free side.

    `cost` is what a metre of it costs as a border where nothing was seen.
    """

    direction: Floats
    normal: Floats
    offset: float
    stretches: Floats
    outside: Floats
    cost: float = WALL_COST

    def hidden(self, low: float, high: float) -> float:
        """Length between two places along the line where no wall was seen; faces end a little short of their corners."""
        faces = self.stretches[self.stretches[:, 1] > self.stretches[:, 0]]
        seen = np.clip(np.minimum(faces[:, 1] + SHORT, high) - np.maximum(faces[:, 0] - SHORT, low), 0.0, None).sum()
        return max(0.0, high - low - float(seen))

    def free_side(self, low: float, high: float) -> float:
        """Seen length times how much more ground lies left (positive) or right (negative) of it."""
        seen = np.clip(np.minimum(self.stretches[:, 1], high) - np.maximum(self.stretches[:, 0], low), 0.0, None)
        return float((seen * self.outside).sum())


def find_outlines(walls: list[WallLine], seen: GroundSeen, *, least_area: float, least_coverage: float) -> list[list[OutlineEdge]]:
    """Find the closed outlines of houses.

    Parameters
    ----------
    walls : list of WallLine
        Faces of one neighbourhood.
    seen : GroundSeen
        Where the ground was seen.
    least_area : float
        Smallest house, square metres.
    least_coverage : float
        Least share of the outline where a wall was seen.

    Returns
    -------
    list of list of OutlineEdge
        Sides of each outline, counter-clockwise.
    """
    lines = _base_lines(_not_behind_others(walls, seen), seen)
    if len(lines) < 2:
        return []
    cells, borders = _arrangement(lines)
    if not cells:
        return []
    inside = _cut(cells, borders, lines, seen)
    outlines = []
    for polygon in _unions(cells, borders, inside):
        edges = _merged(_edges(polygon, borders, lines), lines)
        length = sum(edge.length for edge in edges)
        covered = sum(edge.length * edge.coverage for edge in edges)
        if len(edges) >= 3 and polygon.area >= least_area and covered >= least_coverage * length and _ground_share(polygon, seen) < 0.3:
            outlines.append(edges)
    return outlines


def _not_behind_others(walls: list[WallLine], seen: GroundSeen) -> list[WallLine]:
    """Faces without those that stand close behind another one: what was seen through windows."""
    ends = np.array([[wall.start, wall.end] for wall in walls])
    kept = []
    for i, wall in enumerate(walls):
        d = (ends[i, 1] - ends[i, 0]) / wall.length
        n = np.array([-d[1], d[0]])
        middle = ends[i].mean(axis=0)
        hidden = 0.0
        for j, other in enumerate(walls):
            e = (ends[j, 1] - ends[j, 0]) / other.length
            offset = float((ends[j].mean(axis=0) - middle) @ n)
            if j == i or abs(e @ n) > np.sin(np.radians(5.0)) or not SAME_OFFSET < abs(offset) < SEEN_THROUGH:
                continue
            low, high = np.sort((ends[j] - ends[i, 0]) @ d)
            overlap = min(high, wall.length) - max(low, 0.0)
            if overlap > 0 and _side(ends[j], d, n, seen) * offset > 0:
                hidden += overlap
        if hidden < 0.7 * wall.length:
            kept.append(wall)
    return kept


def _base_lines(walls: list[WallLine], seen: GroundSeen) -> list[_Line]:
    """Lines that carry the faces, those in one line together, and the lines that may close a side that was not seen."""
    groups: list[list[int]] = []
    ends = np.array([[wall.start, wall.end] for wall in walls])
    order = sorted(range(len(walls)), key=lambda i: (-walls[i].length, walls[i].start))
    for i in order:
        for group in groups:
            p, q = ends[group[0]]
            d = (q - p) / np.hypot(*(q - p))
            n = np.array([-d[1], d[0]])
            away = np.abs((ends[i] - p) @ n)
            e = ends[i, 1] - ends[i, 0]
            apart = _apart(ends[group], ends[i])
            if abs(e @ n) < np.sin(SAME_ANGLE) * np.hypot(*e) and away.max() < SAME_OFFSET and apart < 2 * REACH:
                group.append(i)
                break
        else:
            groups.append([i])
    lines = []
    for group in groups:
        p, q = ends[group[0]]
        d = (q - p) / np.hypot(*(q - p))
        n = np.array([-d[1], d[0]])
        offset = float(np.average([ends[i].mean(axis=0) @ n for i in group], weights=[walls[i].length for i in group]))
        stretches = np.array([sorted(ends[i] @ d) for i in group])
        outside = np.array([_side(ends[i], d, n, seen) for i in group])
        lines.append(_Line(d, n, offset, stretches, outside))
    return lines + _closing_lines(lines)


def _apart(group: Floats, ends: Floats) -> float:
    return min(float(shapely.LineString(other).distance(shapely.LineString(ends))) for other in group)


def _side(ends: Floats, d: Floats, n: Floats, seen: GroundSeen) -> float:
    """How much more ground lies left (1) or right (-1) of a face."""
    low, high = sorted(ends @ d)
    along = np.arange(low + 0.1, high, 0.2)
    across = np.arange(0.3, 1.7, 0.2)
    at = (ends.mean(axis=0) @ n) * n + along[:, None, None] * d
    left, right = (seen.is_ground((at + sign * across[:, None] * n).reshape(-1, 2)).mean() if len(along) else 0.0 for sign in (1, -1))
    return float((left - right) / max(left, right, LEAST_GROUND_SHARE))


def _closing_lines(lines: list[_Line]) -> list[_Line]:
    """Lines square to a face through its open ends, and lines that join open ends."""
    open_ends = []
    for i, line in enumerate(lines):
        for low, high in line.stretches:
            if high - low < 1.5:
                continue
            for at in (low, high):
                point = line.offset * line.normal + at * line.direction
                if not any(_meets(other, line, point) for j, other in enumerate(lines) if j != i):
                    open_ends.append((i, point))
    closing = []
    for i, point in open_ends:
        n = lines[i].direction
        closing.append((np.array([n[1], -n[0]]), point, SQUARE_COST))
    for k, (i, p) in enumerate(open_ends):
        for j, q in open_ends[k + 1 :]:
            length = float(np.hypot(*(q - p)))
            if i != j and 0.5 < length < CLOSING_REACH:
                closing.append(((q - p) / length, p, OBLIQUE_COST))
    none = np.zeros((0, 2))
    made: list[_Line] = []
    for d, p, cost in closing:
        n = np.array([-d[1], d[0]])
        at = float(p @ d)
        line = _Line(d, n, float(p @ n), none, np.zeros(0))
        if not any(_same(line, other, p) for other in [*lines, *made]):
            made.append(_Line(d, n, line.offset, np.array([[at, at]]), np.zeros(1), cost))
    return made


def _meets(other: _Line, line: _Line, point: Floats) -> bool:
    """Whether a face of another line, not parallel, comes near a point."""
    if abs(other.direction @ line.normal) < np.sin(np.radians(20)) or abs(point @ other.normal - other.offset) > 1.0:
        return False
    at = point @ other.direction
    return bool(((other.stretches[:, 0] - 1.0 < at) & (at < other.stretches[:, 1] + 1.0)).any())


def _same(line: _Line, other: _Line, point: Floats) -> bool:
    return bool(abs(line.direction @ other.normal) < np.sin(SAME_ANGLE) and abs(point @ other.normal - other.offset) < 0.3)


def _arrangement(lines: list[_Line]) -> tuple[list[shapely.Polygon], dict[tuple[Point, Point], tuple[int, int]]]:
    """Cells between the lines, and for each directed border (cell to its left) the number of the cell and of the line."""
    strokes = []
    for line in lines:
        reach = REACH if len(line.outside) and line.stretches[0, 1] > line.stretches[0, 0] else CLOSING_REACH
        low, high = line.stretches[:, 0].min() - reach, line.stretches[:, 1].max() + reach
        strokes.append(shapely.LineString([line.offset * line.normal + at * line.direction for at in (low, high)]))
    noded = shapely.union_all(strokes, grid_size=1e-6)
    cells = [shapely.orient_polygons(cell) for cell in shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))]
    cells.sort(key=lambda cell: cell.bounds)
    normals, offsets = np.array([line.normal for line in lines]), np.array([line.offset for line in lines])
    borders: dict[tuple[Point, Point], tuple[int, int]] = {}
    for number, cell in enumerate(cells):
        for ring in (cell.exterior, *cell.interiors):
            corners = np.asarray(ring.coords)
            near = np.maximum(np.abs(corners[:-1] @ normals.T - offsets), np.abs(corners[1:] @ normals.T - offsets))
            for p, q, line in zip(corners[:-1].tolist(), corners[1:].tolist(), near.argmin(axis=1).tolist(), strict=True):
                borders[(tuple(p), tuple(q))] = (number, line)
    return cells, borders


def _cut(
    cells: list[shapely.Polygon], borders: dict[tuple[Point, Point], tuple[int, int]], lines: list[_Line], seen: GroundSeen
) -> NDArray[np.bool_]:
    """Which cells are inside."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    count = len(cells)
    beyond, source, sink = count, count + 1, count + 2
    inward, outward = np.zeros(count + 1), np.zeros(count + 1)
    for number, cell in enumerate(cells):
        ground, overhead = _seen_areas(cell, seen)
        outward[number] += GROUND_WEIGHT * ground + UNKNOWN_WEIGHT * cell.area
        inward[number] += OVERHEAD_WEIGHT * overhead
    outward[beyond] += 1e5
    links: dict[tuple[int, int], float] = defaultdict(float)
    for (p, q), (left, number) in borders.items():
        right = borders.get((q, p), (beyond, number))[0]
        line = lines[number]
        low, high = sorted((float(np.dot(p, line.direction)), float(np.dot(q, line.direction))))
        hidden = line.hidden(low, high)
        free = line.free_side(low, high) * (1.0 if np.dot(np.subtract(q, p), line.direction) > 0 else -1.0)
        reward = BEHIND_WALL_WEIGHT * abs(free)
        if free > 0:
            outward[left] += reward
        else:
            inward[left] += reward
        if right == beyond or left < right:
            covered = high - low - hidden
            sure = min(1.0, 2 * abs(free) / covered) if covered > 0 else 0.0
            links[(left, right)] += line.cost * hidden + covered * (SEEN_COST * sure + UNSURE_COST * (1 - sure))
    rows, columns, capacity = [], [], []
    for (a, b), cost in sorted(links.items()):
        value = round(UNIT * cost)
        rows += [a, b]
        columns += [b, a]
        capacity += [value, value]
    for node in range(count + 1):
        net = inward[node] - outward[node]
        rows += [source, node]
        columns += [node, sink]
        capacity += [round(UNIT * max(net, 0.0)), round(UNIT * max(-net, 0.0))]
    graph = csr_array((np.array(capacity, dtype=np.int32), (rows, columns)), shape=(count + 3, count + 3))
    graph.sum_duplicates()
    residual = (graph - maximum_flow(graph, source, sink).flow).tocsr()
    residual.data = np.where(residual.data > 0, residual.data, 0)
    residual.eliminate_zeros()
    inside = np.zeros(count + 3, dtype=np.bool_)
    inside[breadth_first_order(residual, source, return_predecessors=False)] = True
    return inside[:count]


def _seen_areas(cell: shapely.Polygon, seen: GroundSeen) -> tuple[float, float]:
    """Areas of a cell with ground and with something overhead, square metres."""
    x0, y0, x1, y1 = cell.bounds
    step = seen.pixel
    if cell.area < 4 * step**2:
        point = np.asarray(cell.representative_point().coords)
        return float(seen.is_ground(point)[0]) * cell.area, float(seen.is_overhead(point)[0]) * cell.area
    columns, rows = np.arange(np.floor(x0 / step), np.ceil(x1 / step)), np.arange(np.floor(y0 / step), np.ceil(y1 / step))
    x, y = np.meshgrid((columns + 0.5) * step, (rows + 0.5) * step)
    xy = np.column_stack([x.ravel(), y.ravel()])
    xy = xy[shapely.contains_xy(cell, xy)]
    return float(seen.is_ground(xy).sum()) * step**2, float(seen.is_overhead(xy).sum()) * step**2


def _ground_share(polygon: shapely.Polygon, seen: GroundSeen) -> float:
    return _seen_areas(polygon, seen)[0] / float(polygon.area)


def _unions(
    cells: list[shapely.Polygon], borders: dict[tuple[Point, Point], tuple[int, int]], inside: NDArray[np.bool_]
) -> list[shapely.Polygon]:
    """Union of the inside cells that hang together by a border, holes filled."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = [(a, borders[(q, p)][0]) for (p, q), (a, _) in borders.items() if (q, p) in borders]
    pairs = [(a, b) for a, b in pairs if inside[a] and inside[b]]
    rows, columns = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    _, group = connected_components(coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(cells),) * 2), directed=False)
    unions = []
    for number in np.unique(group[inside]):
        union = shapely.union_all([cells[i] for i in np.flatnonzero(inside & (group == number))])
        for part in shapely.get_parts(union):
            unions.append(shapely.orient_polygons(shapely.Polygon(part.exterior)))
    return unions


def _edges(polygon: shapely.Polygon, borders: dict[tuple[Point, Point], tuple[int, int]], lines: list[_Line]) -> list[OutlineEdge]:
    """Sides of an outline, each with its line; pieces in one line joined."""
    corners = [tuple(corner) for corner in polygon.exterior.coords]
    pieces = []
    normals, offsets = np.array([line.normal for line in lines]), np.array([line.offset for line in lines])
    for p, q in pairwise(corners):
        if (p, q) in borders:
            number = borders[(p, q)][1]
        else:
            number = int(np.maximum(np.abs(normals @ np.array(p) - offsets), np.abs(normals @ np.array(q) - offsets)).argmin())
        pieces.append((p, q, number))
    first = next((i for i in range(len(pieces)) if pieces[i][2] != pieces[i - 1][2]), 0)
    pieces = pieces[first:] + pieces[:first]
    edges: list[OutlineEdge] = []
    for p, q, number in pieces:
        if edges and edges[-1].line == number and abs(np.dot(np.subtract(q, edges[-1].end), lines[number].direction)) > 0:
            p = edges.pop().start
        edges.append(_edge(p, q, number, lines))
    return edges


def _edge(p: Point, q: Point, number: int, lines: list[_Line]) -> OutlineEdge:
    line = lines[number]
    low, high = sorted((float(np.dot(p, line.direction)), float(np.dot(q, line.direction))))
    return OutlineEdge(p, q, number, 1.0 - line.hidden(low, high) / max(high - low, 1e-9))


def _merged(edges: list[OutlineEdge], lines: list[_Line], *, shortest: float = 0.4) -> list[OutlineEdge]:
    """Outline without the short steps that come from lines crossing near a corner."""
    while len(edges) > 3:
        short = [(edge.length, i) for i, edge in enumerate(edges) if edge.length < shortest]
        if not short:
            break
        i = min(short)[1]
        before, after = edges[i - 1], edges[(i + 1) % len(edges)]
        a, b = lines[before.line], lines[after.line]
        cross = a.direction[0] * b.direction[1] - a.direction[1] * b.direction[0]
        if abs(cross) < np.sin(np.radians(10.0)):
            number = before.line if before.length >= after.length else after.line
            joined = [_edge(before.start, after.end, number, lines)]
        else:
            corner = np.linalg.solve(np.array([a.normal, b.normal]), [a.offset, b.offset])
            at = (float(corner[0]), float(corner[1]))
            joined = [_edge(before.start, at, before.line, lines), _edge(at, after.end, after.line, lines)]
        first = (i - 1) % len(edges)
        edges = [*joined, *(edges[first:] + edges[:first])[3:]]
    return edges
