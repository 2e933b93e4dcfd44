"""Bounding box of many points in one pass."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.compiled import compiled
from indoor_bim.threads import even_slices, in_threads, threads_for


def bounds(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest coordinates; not finite where a coordinate is not.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        At least one point.

    Returns
    -------
    low, high : (2 or 3,) float64
    """
    points = np.ascontiguousarray(points)
    threads = threads_for(len(points))
    corners = np.array(in_threads(lambda part: _extent(points[part]), even_slices(len(points), threads), threads=threads))
    dimensions = points.shape[1]
    return corners[:, 0, :dimensions].min(axis=0), corners[:, 1, :dimensions].max(axis=0)


@compiled(types.Array(types.float64, 2, "C", readonly=True))
def _extent(points):  # type: ignore[no-untyped-def]
    """Smallest and largest coordinates (2, 3); NaN where any coordinate is NaN."""
    corners = np.zeros((2, 3))
    numbers = True
    flat = points.shape[1] == 2
    x0 = y0 = z0 = np.inf
    x1 = y1 = z1 = -np.inf
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], 0.0 if flat else points[i, 2]
        numbers &= (x == x) & (y == y) & (z == z)
        x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
        x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
    if not numbers:
        return np.full((2, 3), np.nan)
    corners[0, 0], corners[0, 1], corners[0, 2] = x0, y0, z0
    corners[1, 0], corners[1, 1], corners[1, 2] = x1, y1, z1
    return corners
