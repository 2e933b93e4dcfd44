"""Floor and ceiling of each room: steps between rooms, podiums, lowered and raised ceilings, roofs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.ordering import median
from indoor_bim.plan.evidence import rows_within
from indoor_bim.plan.raster import Raster
from indoor_bim.threads import in_threads, threads_for

if TYPE_CHECKING:
    import shapely

Floats = NDArray[np.float64]

SAME_LEVEL = 0.05
"""Rooms that differ by less from the storey have its level: drift bends floors by as much, metres."""
STEP = 1.2
"""A room's floor lies at most this far above or below that of the storey, metres."""
HEADROOM = 1.8
BAND = 0.04
TILE = 0.20
COLUMN = 0.5
"""Width of the columns that points are sorted into, metres."""


def room_levels(
    points: Floats,
    rooms: Sequence[shapely.Polygon],
    *,
    floor: float,
    ceiling: float,
    low: float = -np.inf,
    high: float = np.inf,
    roof: Raster | None = None,
) -> tuple[tuple[float, float], ...]:
    """Floor and ceiling of each room from the level surfaces in it.

    The floor is the lowest level surface that covers much of the room, the ceiling the lowest such surface above head
    height. Where there is none, or it lies within `SAME_LEVEL` of the storey's, the room has the storey's level. Under a roof
    without a level ceiling the highest point of the room counts.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned points in model coordinates, metres.
    rooms : sequence of shapely.Polygon
        Free space of each room.
    floor, ceiling : float
        Levels of the storey, metres.
    low, high : float
        Ceiling of the storey below and floor of the storey above, metres.
    roof : Raster, optional
        Height of the roof, NaN where nothing was seen, metres.

    Returns
    -------
    tuple of (float, float)
        Floor and ceiling of each room, metres.

    Examples
    --------
    >>> import shapely
    >>> x, y = np.meshgrid(np.arange(0, 4, 0.05), np.arange(0, 4, 0.05))
    >>> step, lowered = (np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)]) for z in (0.34, 2.3))
    >>> [tuple(map(float, levels)) for levels in room_levels(np.vstack([step, lowered]), [shapely.box(0, 0, 4, 4)], floor=0.0, ceiling=2.6)]
    [(0.34, 2.3)]
    """
    import shapely

    column = np.floor(points[:, 0] / COLUMN)
    if (np.diff(column) < 0).any():
        order = np.argsort(column, kind="stable")
        points, column = points.take(order, axis=0), column.take(order)

    def levels(room: shapely.Polygon) -> tuple[float, float]:
        core = room.buffer(-0.15)
        core = room if core.is_empty else core
        shapely.prepare(core)
        x0, y0, x1, y1 = core.bounds
        near = points[slice(*np.searchsorted(column, [np.floor(x0 / COLUMN), np.floor(x1 / COLUMN) + 1]))]
        near = near.take(rows_within(near, np.array([x0, y0, max(floor - STEP, low + 0.10)]), np.array([x1, y1, high - 0.10])), axis=0)
        near = near.take(np.flatnonzero(shapely.contains_xy(core, near[:, 0], near[:, 1])), axis=0)
        below = near[near[:, 2] < floor + STEP]
        foot = _lowest_level(below, core.area)
        foot = floor if foot is None or abs(foot - floor) < SAME_LEVEL else foot
        above = near[near[:, 2] > foot + HEADROOM]
        head = _lowest_level(above, core.area, cover=0.5 if roof is not None else 0.2)
        if head is None and roof is not None:
            head = _highest(roof, core)
        return foot, ceiling if head is None or abs(head - ceiling) < SAME_LEVEL else head

    return tuple(in_threads(levels, rooms, threads=min(threads_for(len(points)), 2)))


def _lowest_level(points: Floats, area: float, *, cover: float = 0.2, share: float = 0.5) -> float | None:
    """Lowest height at which points cover a share of an area, and no less than a share of what any height covers, metres."""
    if not len(points):
        return None
    height = np.ascontiguousarray(points[:, 2])
    first = float(height.min())
    layer = ((height - first) / (BAND / 2)).astype(np.int64)
    column, row = np.floor(points[:, :2].T / TILE).astype(np.int64)
    row -= row.min()
    tile = (column - column.min()) * (int(row.max()) + 1) + row
    count = int(layer.max()) + 1
    hit = np.zeros((count + 2, int(tile.max()) + 1), dtype=bool)
    hit[layer + 1, tile] = True
    covered = (hit[:-2] | hit[1:-1] | hit[2:]).sum(axis=1)
    if covered.max() * TILE**2 < cover * area:
        return None
    enough = np.flatnonzero(covered >= max(share * covered.max(), cover * area / TILE**2))
    start = int(enough[0])
    peak = start + int(np.argmax(covered[start : start + 4]))
    guess = first + (peak + 0.5) * BAND / 2
    for _ in range(3):
        guess = median(height[np.abs(height - guess) < BAND])
    return guess


def _highest(roof: Raster, room: shapely.Polygon) -> float | None:
    """Highest point of the roof over a room; a hundredth of it may be noise."""
    import shapely

    known = np.argwhere(~np.isnan(roof.image))
    centre = roof.centre(known)
    inside = shapely.contains_xy(room, centre[:, 0], centre[:, 1])
    return float(np.quantile(roof.image[tuple(known[inside].T)], 0.99)) if inside.any() else None
