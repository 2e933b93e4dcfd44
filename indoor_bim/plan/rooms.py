"""Rooms: what walls enclose, as far as somebody saw its floor or ceiling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from indoor_bim.plan.raster import Raster

if TYPE_CHECKING:
    import shapely

SAME_ROOM = 0.8  # share of the larger area that two outlines of one room have in common at least
GRID = 1e-6  # metres; the precision of plan coordinates


def room_polygons(
    footprints: list[shapely.Polygon], *, crack: float = 0.10, min_area: float = 1.0, min_width: float = 0.5
) -> list[shapely.Polygon]:
    """Free space that walls enclose.

    Walls are grown until cracks between them close; each hole in what they cover is a room, grown back to the faces of its walls.

    Parameters
    ----------
    footprints : list of shapely.Polygon
        Outlines of the walls, metres.
    crack : float
        Widest gap between walls that does not open a room, metres.
    min_area : float
        Smallest room, square metres.
    min_width : float
        Smallest diameter of the largest circle that fits into a room, metres.

    Returns
    -------
    list of shapely.Polygon
        Rooms, sorted by position; no two overlap, none overlaps a wall.

    Examples
    --------
    >>> import shapely
    >>> ring = shapely.box(0, 0, 5, 4).difference(shapely.box(0.2, 0.2, 4.8, 3.8))
    >>> [room.area for room in room_polygons([ring])]
    [16.56]
    """
    import shapely

    if not footprints:
        return []
    walls = shapely.union_all(footprints, grid_size=GRID)
    grown = walls.buffer(crack / 2, join_style="mitre")
    around = shapely.union_all([shapely.Polygon(ring) for part in shapely.get_parts(grown) for ring in part.interiors])
    free = shapely.get_parts(around.difference(grown))
    rooms = []
    for hole in free:
        if hole.geom_type != "Polygon":
            continue
        back = shapely.difference(hole.buffer(crack / 2, join_style="mitre"), walls, grid_size=GRID)
        room = max(shapely.get_parts(back), key=lambda part: part.area)
        if room.area >= min_area and not room.buffer(-min_width / 2).is_empty:
            rooms.append(_without_spikes(room.simplify(0.001)))
    return sorted(rooms, key=lambda room: tuple(np.round([*room.representative_point().coords[0], room.area], 4)))


def known_rooms(known: Sequence[shapely.Polygon], footprints: list[shapely.Polygon], **limits: float) -> list[shapely.Polygon]:
    """Rooms that a method knows, with the faces of the walls round them.

    Where walls enclose a known room, the room is what they enclose; otherwise it keeps its outline, less the walls.

    Parameters
    ----------
    known : sequence of shapely.Polygon
        Free space of each room, metres.
    footprints : list of shapely.Polygon
        Outlines of the walls, metres.
    **limits : float
        Those of `room_polygons`.

    Returns
    -------
    list of shapely.Polygon
        One polygon for each known room that something is left of, in the order given.
    """
    import shapely

    enclosed = room_polygons(footprints, **limits)
    walls = shapely.union_all(footprints, grid_size=GRID)
    rooms = []
    for room, shared in zip(known, shared_areas(known, enclosed), strict=True):
        same = [enclosed[k] for k, area in shared.items() if area > SAME_ROOM * max(enclosed[k].area, room.area)]
        if same:
            rooms.append(same[0])
            continue
        parts = [part for part in shapely.get_parts(shapely.difference(room, walls, grid_size=GRID)) if part.geom_type == "Polygon"]
        if parts:
            rooms.append(_without_spikes(max(parts, key=lambda part: part.area)))
    return rooms


def shared_areas(rooms: Sequence[shapely.Polygon], others: Sequence[shapely.Polygon]) -> list[dict[int, float]]:
    """Areas that each of some rooms shares with others, by the numbers of these in ascending order; no more than touching is left out.

    Examples
    --------
    >>> import shapely
    >>> shared_areas([shapely.box(0, 0, 4, 3)], [shapely.box(9, 0, 12, 3), shapely.box(3, 0, 9, 3), shapely.box(0, 0, 1, 1)])
    [{1: 3.0, 2: 1.0}]
    """
    import shapely

    found: list[dict[int, float]] = [{} for _ in rooms]
    if not len(rooms) or not len(others):
        return found
    first, second = shapely.STRtree(others).query(rooms)
    area = shapely.area(shapely.intersection(np.array(rooms)[first], np.array(others)[second]))
    for k, other, shared in sorted(zip(first.tolist(), second.tolist(), area.tolist(), strict=True)):
        if shared > 0:
            found[k][other] = shared
    return found


def reading_order(rooms: Sequence[shapely.Polygon], *, precision: float = 0.01) -> list[int]:
    """Order in which one reads rooms off a plan: rows from the top, each from left to right.

    A row is the room with the highest middle of those left, and all that share more than half of the lower one's extent with it.

    Parameters
    ----------
    rooms : sequence of shapely.Polygon
        Rooms, metres.
    precision : float
        Smaller differences do not count, metres.

    Examples
    --------
    >>> import shapely
    >>> reading_order([shapely.box(0, 0, 4, 3), shapely.box(5, 4.2, 9, 7), shapely.box(0, 4, 4, 7)])
    [2, 1, 0]
    """
    bounds = np.rint(np.array([room.bounds for room in rooms]).reshape(-1, 4) / precision).astype(np.int64).tolist()
    left = sorted(range(len(rooms)), key=lambda k: (-(bounds[k][1] + bounds[k][3]), bounds[k], k))
    order: list[int] = []
    while left:
        first = bounds[left[0]]
        row = [k for k in left if _beside(bounds[k], first)]
        order += sorted(row, key=lambda k: (bounds[k][0] + bounds[k][2], -bounds[k][3], bounds[k], k))
        left = [k for k in left if k not in row]
    return order


def _beside(a: Sequence[int], b: Sequence[int]) -> bool:
    """Whether two bounding boxes share more than half of the lower one's extent in y."""
    return 2 * (min(a[3], b[3]) - max(a[1], b[1])) >= min(a[3] - a[1], b[3] - b[1])


def _without_spikes(room: shapely.Polygon, *, widest: float = 0.02) -> shapely.Polygon:
    """The room without slits and spikes that are narrower, metres; unchanged where it has none."""
    opened = room.buffer(-widest / 2, join_style="mitre").buffer(widest / 2, join_style="mitre").simplify(0.001)
    return opened if opened.geom_type == "Polygon" and _corners(opened) < _corners(room) else room


def _corners(polygon: shapely.Polygon) -> int:
    return len(polygon.exterior.coords) + sum(len(ring.coords) for ring in polygon.interiors)


def observed_share(polygon: shapely.Polygon, seen: Raster) -> float:
    """Share of a polygon's area that lies under pixels other than zero.

    Parameters
    ----------
    polygon : shapely.Polygon
        Plan polygon, metres.
    seen : Raster
        Image that is not zero where floor or ceiling was seen.
    """
    from indoor_bim.plan.polygon_fill import fill

    low = seen.pixel(np.array([polygon.bounds[:2]]))[0]
    high = seen.pixel(np.array([polygon.bounds[2:]]))[0]
    inside = np.zeros(high - low + 1, dtype=np.int32)
    for value, ring in ((1, polygon.exterior), *((0, hole) for hole in polygon.interiors)):
        corners = (np.array(ring.coords)[:, :2] - seen.origin) / seen.cell - 0.5 - low[::-1]
        fill(np.ascontiguousarray(corners), value, inside)
    rows, columns = (slice(max(low[k], 0), max(high[k] + 1, 0)) for k in (0, 1))
    image = seen.image[rows, columns]
    first = np.maximum(-low, 0)
    under = inside[first[0] :, first[1] :][: image.shape[0], : image.shape[1]]
    return float((under[image != 0] > 0).sum()) / max(float(inside.sum()), 1.0)
