"""Rooms from labelled cells: outlines whose every side lies on one wall line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.plan.cells import Cells

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class OutlineRing:
    """Closed ring of straight sides with the room to their left.

    Parameters
    ----------
    corners : tuple of (float, float)
        Corner k is the start of side k, metres.
    lines : tuple of int
        Line that each side lies on.
    """

    corners: tuple[tuple[float, float], ...]
    lines: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class RoomOutline:
    """Outer ring of a room and the rings around what stands in it."""

    exterior: OutlineRing
    holes: tuple[OutlineRing, ...] = ()

    @property
    def polygon(self) -> shapely.Polygon:
        """The outline as a shapely polygon."""
        return shapely.Polygon(self.exterior.corners, [hole.corners for hole in self.holes])


def room_outlines(
    cells: Cells,
    room: Bools,
    wall: Floats,
    *,
    spanned: Bools,
    min_closed: float = 0.4,
    min_area: float = 1.0,
    min_width: float = 0.5,
    min_column_area: float = 0.01,
) -> list[RoomOutline]:
    """Outlines of connected room cells.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    room : (k,) bool
        Cells that are room.
    wall : (e,) float64
        Wall evidence of each edge.
    spanned : (k,) bool
        Cells with a surface overhead; a wall face between a cell with and one without parts rooms.
    min_closed : float
        Least share of a room's border that was seen as wall.
    min_area : float
        Smallest room, square metres.
    min_width : float
        Smallest diameter of the largest circle in a room, metres.
    min_column_area : float
        Smallest hole in a room, square metres; at least half of its border must be wall.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    inner = (cells.left >= 0) & (cells.right >= 0)
    both = inner.copy()
    both[inner] = room[cells.left[inner]] & room[cells.right[inner]]
    parted = inner & (wall > 0.7)
    parted[inner] &= spanned[cells.left[inner]] != spanned[cells.right[inner]]
    both &= ~parted
    count = len(cells.polygons)
    graph = coo_matrix((np.ones(both.sum()), (cells.left[both], cells.right[both])), shape=(count, count))
    _, component = connected_components(graph, directed=False)
    owner = np.where(room, component, -1)
    area = np.array([polygon.area for polygon in cells.polygons])
    left = np.where(cells.left >= 0, owner[cells.left], -1)
    right = np.where(cells.right >= 0, owner[cells.right], -1)
    outlines = []
    for number in np.unique(owner[owner >= 0]):
        mine = owner == number
        mostly_spanned = area[mine & spanned].sum() > 0.5 * area[mine].sum()
        forward = (left == number) & (right != number)
        backward = (right == number) & (left != number)
        tail = np.vstack([cells.edge_start[forward], cells.edge_end[backward]])
        head = np.vstack([cells.edge_end[forward], cells.edge_start[backward]])
        line = np.concatenate([cells.edge_line[forward], cells.edge_line[backward]])
        support = np.concatenate([wall[forward], 0.0 * wall[backward]])
        rings = _rings(tail, head, line)
        standing = [_share(ring, tail, head, support) for ring in rings]
        polygons = [shapely.Polygon(ring.corners) if len(ring.corners) > 2 else shapely.Polygon() for ring in rings]
        outer = int(np.argmax([polygon.area for polygon in polygons]))
        holes = tuple(ring for k, ring in enumerate(rings) if k != outer and polygons[k].area > min_column_area and standing[k] > 0.5)
        straight = straighten(rings[outer])
        outline = RoomOutline(straight if shapely.Polygon(straight.corners).is_valid else rings[outer], holes)
        polygon = outline.polygon
        if (
            polygon.area >= min_area
            and standing[outer] >= (min_closed if not mostly_spanned else 0.5 * min_closed)
            and not polygon.buffer(-min_width / 2).is_empty
        ):
            outlines.append(outline)
    return outlines


def _rings(tail: Floats, head: Floats, line: Ints) -> list[OutlineRing]:
    """Chain directed edges to rings; at corners that rings share, turn right as far as possible, so that rings stay simple."""
    key: dict[tuple[float, ...], list[int]] = {}
    for k, point in enumerate(np.round(tail, 5)):
        key.setdefault(tuple(point), []).append(k)
    unused = set(range(len(tail)))
    rings = []
    for start in range(len(tail)):
        if start not in unused:
            continue
        chain = [start]
        unused.discard(start)
        while True:
            last = chain[-1]
            following = [k for k in key.get(tuple(np.round(head[last], 5)), []) if k in unused]
            if not following:
                break
            back = tail[last] - head[last]
            angle = [_clockwise(back, head[k] - tail[k]) for k in following]
            chain.append(following[int(np.argmax(angle))])
            unused.discard(chain[-1])
        merged = [(tail[k], int(line[k])) for k in chain]
        sides = [merged[k] for k in range(len(merged)) if merged[k][1] != merged[k - 1][1]] or merged[:1]
        rings.append(OutlineRing(tuple((float(p[0]), float(p[1])) for p, _ in sides), tuple(n for _, n in sides)))
    return rings


def straighten(ring: OutlineRing, *, jog: float = 0.12, short: float = 1.5, turn: float = 5.0) -> OutlineRing:
    """Ring without jogs between two sides that are all but one line: the longer side runs on.

    Parameters
    ----------
    ring : OutlineRing
        Ring.
    jog : float
        Largest step across that is taken out, metres.
    short : float
        Longer sides than this keep a step that is larger than two fifths of `jog`, metres.
    turn : float
        Largest angle between the two sides, degrees.
    """
    corners, lines = [np.array(c) for c in ring.corners], list(ring.lines)
    changed = True
    while changed and len(corners) > 4:
        changed = False
        count = len(corners)
        ends = [corners[(k + 1) % count] for k in range(count)]
        length = [float(np.hypot(*(ends[k] - corners[k]))) for k in range(count)]
        for k in sorted(range(count), key=lambda k: (length[k], tuple(corners[k]))):
            if length[k] > jog:
                break
            a, b = (k - 1) % count, (k + 1) % count
            da, db = (ends[a] - corners[a]) / max(length[a], 1e-9), (ends[b] - corners[b]) / max(length[b], 1e-9)
            if da @ db < np.cos(np.radians(turn)):
                continue
            keep, drop = (a, b) if length[a] >= length[b] else (b, a)
            if length[drop] > short and length[k] > 0.4 * jog:
                continue
            other = (drop + 1) % count if drop == b else (drop - 1) % count
            meeting = _meet(corners[keep], ends[keep], corners[other], ends[other])
            if meeting is None or np.hypot(*(meeting - (ends[drop] if drop == b else corners[drop]))) > 3 * jog:
                continue
            if drop == b:
                corners[other] = meeting
            else:
                corners[a] = meeting
                lines[a] = lines[keep]
            gone = {k, b}
            corners = [c for i, c in enumerate(corners) if i not in gone]
            lines = [n for i, n in enumerate(lines) if i not in gone]
            changed = True
            break
    return OutlineRing(tuple((float(c[0]), float(c[1])) for c in corners), tuple(lines))


def _meet(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats | None:
    """Intersection of the lines a-b and c-d; None where they are all but parallel."""
    u, v = b - a, d - c
    cross = u[0] * v[1] - u[1] * v[0]
    if abs(cross) < 0.1 * np.hypot(*u) * np.hypot(*v):
        return None
    w = c - a
    point: Floats = a + u * (w[0] * v[1] - w[1] * v[0]) / cross
    return point


def _share(ring: OutlineRing, tail: Floats, head: Floats, support: Floats) -> float:
    """Wall evidence along a ring, averaged over its length."""
    corners = np.array(ring.corners)
    if len(corners) < 3:
        return 0.0
    line = shapely.LinearRing(corners)
    shapely.prepare(line)
    middle = shapely.points((tail + head) / 2)
    on = shapely.dwithin(line, middle, 1e-3)
    length = np.hypot(*(head - tail).T) * on
    return float((support * length).sum() / max(length.sum(), 1e-9))


def _clockwise(a: Floats, b: Floats) -> float:
    """Clockwise angle from a to b in (0, 2 pi]."""
    turn = float(np.arctan2(a[1], a[0]) - np.arctan2(b[1], b[0]))
    return turn % (2 * np.pi) or 2 * np.pi
