"""Footprints of walls whose joints do not overlap, at any angle and for any number of walls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.graph import Meeting
from indoor_bim.plan.walls import Walls

if TYPE_CHECKING:
    import shapely

Floats = NDArray[np.float64]

LONGEST_MITRE = 3.0  # a mitre reaches no farther than this times the thicker wall's thickness
SLIVER = 1e-6  # square metres
LEAST_OVERLAP = 1e-7  # square metres: below a cubic centimetre in any storey
GRID = 1e-6  # metres; corners that two walls share are equal to the last digit
DECIMALS = 6


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
    """Tell which outlines lie in a larger one for more than half of their area.

    Parameters
    ----------
    polygons : list of shapely.Polygon
        Outlines of walls.

    Returns
    -------
    (n,) bool
        Walls that the wall around them makes needless.

    Examples
    --------
    >>> import shapely
    >>> swallowed([shapely.box(0, 0, 4, 0.3), shapely.box(1, 0.1, 2, 0.2), shapely.box(4, 0, 5, 0.3)]).tolist()
    [False, True, False]
    """
    import shapely

    out = np.zeros(len(polygons), dtype=bool)
    if not polygons:
        return out
    tree = shapely.STRtree(polygons)
    for k, j in tree.query(polygons, predicate="intersects").T.tolist():
        smaller = (polygons[k].area, k) < (polygons[j].area, j)
        if k != j and smaller and polygons[k].intersection(polygons[j]).area > 0.5 * polygons[k].area:
            out[k] = True
    return out


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
        mine = out[k]
        for j in sorted(tree.query(polygons[k], predicate="intersects")):
            if place[j] < place[k] and shapely.intersection(mine, out[j], grid_size=GRID).area > LEAST_OVERLAP:
                mine = max(_parts(shapely.difference(mine, out[j], grid_size=GRID)), key=lambda part: part.area, default=mine)
        out[k] = shapely.Polygon(mine.exterior)
    return out


def _parts(geometry: shapely.Geometry) -> list[shapely.Polygon]:
    import shapely

    return [g for g in shapely.get_parts(geometry) if g.geom_type == "Polygon" and g.area > SLIVER]
