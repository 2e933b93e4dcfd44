"""Closed contours: those around free space are rooms, those around something that stands in a room are columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from indoor_bim.plan.contour_completion import Contour

if TYPE_CHECKING:
    import shapely

LEAST_AREA = 1.0  # square metres of a room
WIDEST_COLUMN = 1.2  # metres


def contour_rooms(contour: Contour) -> tuple[tuple[shapely.Polygon, ...], tuple[shapely.Polygon, ...]]:
    """Rooms and columns that closed contours draw.

    Parameters
    ----------
    contour : Contour
        Completed contour; free space to the left of its segments.

    Returns
    -------
    rooms, columns : tuple of shapely.Polygon
        Sorted by position. A gap for a door or window is crossed in a straight line.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from indoor_bim.plan.contour_completion import complete_contour
    >>> from indoor_bim.plan.segments import Segments
    >>> sides = Segments.from_ends([[0, 0.1], [0.1, 3], [4, 2.9], [3.9, 0]], [[0, 2.9], [3.9, 3], [4, 0.1], [0.1, 0]])
    >>> sides = replace(sides, p=sides.q, q=sides.p, sided=np.ones(4, dtype=bool))
    >>> rooms, columns = contour_rooms(complete_contour(sides))
    >>> rooms[0].area, len(columns)
    (12.0, 0)
    """
    import shapely

    rooms, columns = [], []
    for ring in contour.rings():
        if not contour.segments.sided[ring].all():
            continue
        corners = np.stack([contour.segments.p[ring], contour.segments.q[ring]], axis=1).reshape(-1, 2)
        polygon = shapely.Polygon(corners)
        if not polygon.is_valid or polygon.area <= 0:
            continue
        size = np.ptp(corners, axis=0)
        if shapely.is_ccw(polygon.exterior):
            if polygon.area >= LEAST_AREA:
                rooms.append(polygon.normalize())
        elif np.hypot(*size) <= np.sqrt(2) * WIDEST_COLUMN:
            columns.append(polygon.normalize())
    return tuple(sorted(rooms, key=lambda r: r.bounds)), tuple(sorted(columns, key=lambda c: c.bounds))
