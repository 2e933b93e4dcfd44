"""The surface overhead: the ceiling, or whatever level surface spans a spot of the plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import FEW_POINTS
from indoor_bim.plan.grouping import group_keys
from indoor_bim.plan.labels import connected_cells
from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]

_COARSE = 0.20
_LAYER = 0.10
_MIN_HEADROOM = 1.8
_MIN_SURFACE_AREA = 1.0


def overhead_surface(points: Floats, *, floor: float, top: float, sloped: bool = False) -> Raster | None:
    """Height of the ceiling, or whatever level surface spans overhead, on a coarse grid.

    Cells that are filled along both axes within a thin layer are surface pieces; connected pieces of a square metre and
    more are surface, so lintels and lamps are not.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned points in model coordinates, metres.
    floor : float
        Floor height, metres.
    top : float
        Nothing above this height is looked at, metres.
    sloped : bool
        Also take surfaces of up to 60 degrees: roofs, which may come down to the floor.

    Returns
    -------
    Raster or None
        Heights in metres, NaN where nothing was seen; None where there is no such surface.
    """
    lowest = floor + (0.5 if sloped else _MIN_HEADROOM)
    p = points.take(np.flatnonzero((points[:, 2] > lowest) & (points[:, 2] < top)), axis=0)
    if not len(p):
        return None
    sides = (_COARSE, _COARSE, _COARSE if sloped else _LAYER)
    cells = [np.floor(values / side).astype(np.int64) for values, side in zip(p.T, sides, strict=True)]
    low = np.array([values.min() for values in cells])
    shape = np.array([values.max() for values in cells]) - low + 1
    key = ((cells[0] - low[0]) * shape[1] + cells[1] - low[1]) * shape[2] + cells[2] - low[2]
    first, group, count = group_keys(key)
    mean, (xx, yy, xy, zz, xz, yz) = _moments(p, group, count)
    minor = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)
    level = (count >= 4) & (minor > 0.25 * _COARSE**2 / 12) & (zz < 0.4 * minor + 0.0002)
    if sloped:
        moments = np.stack([np.stack([xx, xy, xz], -1), np.stack([xy, yy, yz], -1), np.stack([xz, yz, zz], -1)], -2)
        values, vectors = np.linalg.eigh(moments)
        level |= (count >= 6) & (values[:, 0] < 0.15 * values[:, 1]) & (np.abs(vectors[:, 2, 0]) > 0.5)
    if not level.any():
        return None
    i, j, k = np.unravel_index(key[first[level]], shape)
    occupied = np.zeros(shape, dtype=bool)
    occupied[i, j, k] = True
    labels, boxes = connected_cells(occupied)
    label = labels[i, j, k].astype(np.int64)
    columns = np.unique(label * (shape[0] * shape[1]) + i * shape[1] + j)
    area = np.bincount(columns // (shape[0] * shape[1]), minlength=len(boxes) + 1) * _COARSE**2
    large = area[label] >= _MIN_SURFACE_AREA
    height = np.full(shape[:2], -np.inf)
    np.maximum.at(height, (i[large], j[large]), mean[level][large, 2])
    if not np.isfinite(height).any():
        return None
    height[~np.isfinite(height)] = np.nan
    return Raster(height.T, low[:2] * _COARSE, _COARSE)


def _moments(points: Floats, group: NDArray[np.int64], count: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Mean (k, 3) of the points of each group, and their central moments (6, k): xx, yy, xy, zz, xz, yz."""
    if len(points) > FEW_POINTS:
        from indoor_bim.plan.moment_loops import central_moments

        means, moments = np.zeros((len(count), 3)), np.zeros((len(count), 6))
        central_moments(points, group, count, means, moments)
        return means, np.ascontiguousarray(moments.T)
    mean = np.column_stack([np.bincount(group, weights=values) / count for values in points.T])
    x, y, z = (points - mean[group]).T
    return mean, np.array([np.bincount(group, weights=w) / count for w in (x * x, y * y, x * y, z * z, x * z, y * z)])


def fill_nearest(raster: Raster) -> Raster:
    """Raster whose NaN cells take the value of the nearest known cell."""
    from scipy import ndimage

    known = ~np.isnan(raster.image)
    _, (rows, columns) = ndimage.distance_transform_edt(~known, return_indices=True)
    return Raster(raster.image[rows, columns], raster.origin, raster.cell)
