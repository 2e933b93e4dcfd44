"""Footprints of walls whose joints do not overlap, at any angle and for any number of walls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.curve import Curve
from indoor_bim.plan.graph import Meeting, join_walls
from indoor_bim.plan.walls import Walls

if TYPE_CHECKING:
    import shapely

Floats = NDArray[np.float64]

LONGEST_MITRE = 3.0  # a mitre reaches no farther than this times the thicker wall's thickness
SLIVER = 1e-3  # square metres: less is no wall, but a crumb of one
LEAST_OVERLAP = 1e-7  # square metres: below a cubic centimetre in any storey
GRID = 1e-9  # metres; corners that two walls share are equal to the last digit
HAIR = 3e-9  # metres between outlines that were cut: more than the grid can move them
DECIMALS = 9


def footprints(walls: Walls, meetings: tuple[Meeting, ...]) -> list[shapely.Polygon]:
    """Plan outline of every wall.

    Ends that meet (L, Y) are mitred: each wall runs to the intersections of its faces with those of its neighbours round the
    corner, and to the corner itself. An end that meets a wall along its path (T, X) is cut at that wall's face. What still
    overlaps goes to the thicker, then the longer wall.

    Parameters
    ----------
    walls : Walls
        Joined walls, metres.
    meetings : tuple of Meeting
        Their corners.

    Returns
    -------
    list of shapely.Polygon
        One simple polygon per wall, no two of which overlap.
    """
    import shapely

    caps: dict[tuple[int, int], list[Floats]] = {}
    for meeting in meetings:
        caps.update(_caps(walls, meeting))
    out = []
    for k in range(len(walls)):
        half = walls.normal[k] * walls.thickness[k] / 2
        start = caps.get((k, 0), [walls.p[k] + half, walls.p[k] - half])  # left to right, seen along p -> q
        end = caps.get((k, 1), [walls.q[k] - half, walls.q[k] + half])
        ring = shapely.Polygon(np.round([*start, *end], DECIMALS))
        out.append(ring if ring.is_valid and ring.area > SLIVER else _rectangle(walls, k))
    return _without_overlaps(walls, out)


def swallowed(polygons: list[shapely.Polygon]) -> NDArray[np.bool_]:
    """Tell which outlines lie in larger ones for more than half of their area.

    Parameters
    ----------
    polygons : list of shapely.Polygon
        Outlines of walls.

    Returns
    -------
    (n,) bool
        Walls that the walls around them make needless.

    Examples
    --------
    >>> import shapely
    >>> swallowed([shapely.box(0, 0, 4, 0.3), shapely.box(1, 0.1, 2, 0.2), shapely.box(4, 0, 5, 0.3)]).tolist()
    [False, True, False]
    """
    import shapely

    out = np.zeros(len(polygons), dtype=bool)
    tree = shapely.STRtree(polygons)
    for k, polygon in enumerate(polygons):
        larger = [polygons[j] for j in tree.query(polygon) if (polygons[j].area, j) > (polygon.area, k)]
        out[k] = polygon.intersection(shapely.union_all(larger)).area > 0.5 * polygon.area
    return out


def join_without_overlaps(
    walls: Walls, *, snap: float, far_snap: float, curves: Sequence[Curve] = ()
) -> tuple[Walls, tuple[Meeting, ...], list[shapely.Polygon]]:
    """Join walls and leave out those that others make needless.

    Parameters
    ----------
    walls : Walls
        Walls in metres.
    snap, far_snap : float
        Slack of corners, as in `join_walls`, metres.
    curves : sequence of Curve
        Curves that walls are pieces of.

    Returns
    -------
    walls : Walls
        Joined walls.
    meetings : tuple of Meeting
        Their corners.
    outlines : list of shapely.Polygon
        Their footprints.
    """
    while True:
        joined, meetings = join_walls(walls, snap=snap, far_snap=far_snap, curves=curves)
        outlines = footprints(joined, meetings)
        needless = swallowed(outlines)
        if not needless.any():
            return joined, meetings, outlines
        walls = joined.take(~needless)


def _rectangle(walls: Walls, k: int) -> shapely.Polygon:
    import shapely

    half = walls.normal[k] * walls.thickness[k] / 2
    return shapely.Polygon([walls.p[k] + half, walls.p[k] - half, walls.q[k] - half, walls.q[k] + half])


def _caps(walls: Walls, meeting: Meeting) -> dict[tuple[int, int], list[Floats]]:
    """End outlines at one corner, as points from the left to the right face seen from inside looking out, in ring order."""
    point = np.array(meeting.point)
    arms: list[tuple[float, int, int, Floats]] = []  # angle, wall, end (-1 for a through wall), direction away from the corner
    for k, kind in zip(meeting.walls, meeting.ends, strict=True):
        d = walls.direction[k]
        for end, away in ((0, d), (1, -d)) if kind == "path" else (((0, d),) if kind == "start" else ((1, -d),)):
            arms.append((float(np.arctan2(away[1], away[0])), k, -1 if kind == "path" else end, away))
    arms.sort(key=lambda arm: (arm[0], arm[1], arm[2]))
    through = any(end < 0 for _, _, end, _ in arms)
    out = {}
    for i, (_, k, end, away) in enumerate(arms):
        if end < 0:
            continue
        after, before = arms[(i + 1) % len(arms)], arms[i - 1]
        left = np.array([-away[1], away[0]])
        half = walls.thickness[k] / 2
        reach = LONGEST_MITRE * max(half * 2, walls.thickness[after[1]], walls.thickness[before[1]])
        corners = []
        for side, (_, other, _, direction) in ((1.0, after), (-1.0, before)):
            # face of this wall on that side against the neighbour's face that looks towards it
            turned = np.array([-direction[1], direction[0]])
            corners.append(
                _crossing(point + side * half * left, away, point - side * walls.thickness[other] / 2 * turned, direction, point, reach)
            )
        ring = [corners[1], point, corners[0]] if len(arms) > 1 and not through else [corners[1], corners[0]]
        out[(k, end)] = ring[::-1]
    return out


def _crossing(a: Floats, da: Floats, b: Floats, db: Floats, point: Floats, reach: float) -> Floats:
    """Intersection of two face lines; the foot of the corner on the first one where they are parallel or meet far away."""
    cross = da[0] * db[1] - da[1] * db[0]
    foot = a + da * ((point - a) @ da)
    if abs(cross) < 0.05:
        return foot
    s = ((b - a)[0] * db[1] - (b - a)[1] * db[0]) / cross
    hit = a + s * da
    return hit if np.hypot(*(hit - point)) <= reach else foot


def _without_overlaps(walls: Walls, polygons: list[shapely.Polygon]) -> list[shapely.Polygon]:
    """Give what two walls share to the thicker, then the longer one."""
    import shapely

    rank = np.lexsort((np.arange(len(walls)), -np.round(walls.length, 3), -np.round(walls.thickness, 3)))
    place = np.argsort(rank)
    tree = shapely.STRtree(polygons)
    out = list(polygons)
    for k in rank:
        near = np.sort(tree.query(polygons[k], predicate="intersects"))
        out[k] = _cut(polygons[k], [out[j] for j in near if place[j] < place[k]])
    return out


def _cut(outline: shapely.Polygon, others: list[shapely.Polygon]) -> shapely.Polygon:
    """Largest part of an outline outside the others, on the grid.

    The outline itself where nothing is left of it, or where another one lies in its midst: then one of them is needless.
    """
    import shapely

    hair = 0.0  # corners on the grid may lie on either side of the cut: then a hair more is cut off
    while over := [other for other in others if outline.intersection(other).area > LEAST_OVERLAP]:
        rest = shapely.difference(outline, shapely.union_all(shapely.buffer(over, hair, join_style="mitre")))
        hair = HAIR
        parts = [part for part in shapely.get_parts(shapely.set_precision(rest, GRID)) if part.area > SLIVER]
        if not parts:
            return outline
        largest = max(parts, key=lambda part: (part.area, part.bounds))
        if largest.interiors:
            return outline
        outline = largest
    return outline
