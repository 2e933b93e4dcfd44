"""Ground, building and other points: from the classes of the file, else from their shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

GROUND_CLASSES, BUILDING_CLASSES = (2,), (6,)
LEAST_SHARE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Classes:
    """Which points are ground and which may be of a building.

    Parameters
    ----------
    ground : (n,) bool
        Points on the ground.
    building : (n,) bool
        Points of buildings; without class codes, all that are not ground.
    from_file : bool
        Whether the class codes of the file said so.
    """

    ground: Mask
    building: Mask
    from_file: bool


def classify(points: Floats, classification: NDArray[np.uint8] | None) -> Classes:
    """Find the ground and what may be a building.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z up.
    classification : (n,) uint8, optional
        ASPRS classes; used when ground and building each have at least 1 % of the points.

    Returns
    -------
    Classes
    """
    if classification is not None and len(points):
        ground, building = np.isin(classification, GROUND_CLASSES), np.isin(classification, BUILDING_CLASSES)
        if min(ground.mean(), building.mean()) >= LEAST_SHARE:
            return Classes(ground, building, from_file=True)
    ground = ground_points(points)
    return Classes(ground, ~ground, from_file=False)


def ground_points(
    points: Floats, *, cell: float = 0.5, widest_house: float = 40.0, slope: float = 0.15, step: float = 0.2, thickness: float = 0.2
) -> Mask:
    """Find the ground by a progressive morphological filter.

    The lowest point of each cell makes a surface; openings with growing windows flatten what stands out of it by more than the
    slope of the ground over the window allows. Points near what remains are ground.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z up.
    cell : float
        Side of a cell, metres.
    widest_house : float
        Window at which the filter ends, metres: more than the width of the widest house.
    slope : float
        Steepest ground, as rise over run.
    step : float
        Height in metres by which a cell may stand out at the smallest window.
    thickness : float
        Largest distance of ground points from the surface, metres.

    Returns
    -------
    (n,) bool

    Notes
    -----
    T. J. Pingel, K. C. Clarke and W. A. McBride, "An improved simple morphological filter for the terrain classification of airborne
    LIDAR data", ISPRS J. Photogramm. Remote Sens. 77 (2013). Isolated low points are taken out by a median first.
    """
    from scipy.ndimage import distance_transform_edt, grey_opening, median_filter

    from indoor_bim.outdoor.terrain import ground_terrain

    if not len(points):
        return np.zeros(0, dtype=np.bool_)
    index = np.floor(points[:, :2] / cell).astype(np.int64)
    low = index.min(axis=0)
    columns, rows = (index.max(axis=0) - low + 1).tolist()
    key = (index[:, 1] - low[1]) * columns + index[:, 0] - low[0]
    lowest = np.full(rows * columns, np.inf)
    np.minimum.at(lowest, key, points[:, 2])
    surface = lowest.reshape(rows, columns)
    nearest = distance_transform_edt(np.isinf(surface), return_distances=False, return_indices=True)
    surface = surface[tuple(nearest)]
    around = median_filter(surface, size=5, mode="nearest")
    surface = np.where(surface < around - 2 * step, around, surface)
    is_ground = np.isfinite(lowest).reshape(rows, columns)
    opened = surface
    for radius in range(1, int(np.ceil(widest_house / 2 / cell)) + 1, 2):
        smaller = grey_opening(opened, size=2 * radius + 1, mode="nearest")
        is_ground &= opened - smaller <= max(step, slope * 2 * cell) if radius == 1 else opened - smaller <= slope * 2 * cell
        opened = smaller
    on_surface = is_ground.ravel()[key] & (points[:, 2] <= surface.ravel()[key] + thickness)
    if not on_surface.any():
        return np.zeros(len(points), dtype=np.bool_)
    terrain = ground_terrain(points[on_surface], spacing=1.0)
    ground: Mask = np.abs(points[:, 2] - terrain.at(points[:, :2])) <= thickness
    return ground
