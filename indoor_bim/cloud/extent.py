"""Bounding box of points in one pass."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.threads import even_slices, in_threads, threads_for

FEW_POINTS = 20_000
"""So many points are compared in numpy, sooner than the compiled loop is loaded."""


def bounds(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest coordinates; not finite where a coordinate is not.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        At least one point.

    Returns
    -------
    low, high : (2 or 3,) float64

    Examples
    --------
    >>> [corner.tolist() for corner in bounds(np.array([[1.0, 5], [2, 4]]))]
    [[1.0, 4.0], [2.0, 5.0]]
    """
    if len(points) <= FEW_POINTS:  # column by column: numpy takes its time over short rows
        return np.array([column.min() for column in points.T]), np.array([column.max() for column in points.T])
    from indoor_bim.cloud.point_loops import extent

    points = np.ascontiguousarray(points)
    threads = threads_for(len(points))
    corners = np.array(in_threads(lambda part: extent(points[part]), even_slices(len(points), threads), threads=threads))
    dimensions = points.shape[1]
    return corners[:, 0, :dimensions].min(axis=0), corners[:, 1, :dimensions].max(axis=0)
