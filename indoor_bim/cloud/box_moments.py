"""Number, mean and covariance of the points in every box of a grid: what surfaces look like piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

FEW_POINTS = 20_000
"""So many points are sorted, sooner than the compiled sums are loaded."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxMoments:
    """Occupied boxes, by x, then y, then z index.

    Parameters
    ----------
    count : (m,) int64
        Number of points.
    mean : (m, 3) float64
        Mean point.
    covariance : (m, 3, 3) float64
        Mean product of the offsets from the mean.
    """

    count: NDArray[np.int64]
    mean: Floats
    covariance: Floats


def box_moments(points: Floats, *, sides: ArrayLike) -> BoxMoments:
    """Sort points into boxes and take their moments.

    Parameters
    ----------
    points : (n, 3) float64
        At least one point, finite.
    sides : (3,) array_like
        Sides of the boxes, same unit; the grid has a corner at the origin.

    Returns
    -------
    BoxMoments

    Examples
    --------
    >>> boxes = box_moments(np.array([[0.1, 0, 0], [0.3, 0, 0], [1.5, 1, 1]]), sides=(1, 1, 1))
    >>> boxes.count.tolist(), boxes.mean.round(6).tolist(), round(float(boxes.covariance[0, 0, 0]), 6)
    ([2, 1], [[0.2, 0.0, 0.0], [1.5, 1.0, 1.0]], 0.01)
    """
    edges = np.asarray(sides, dtype=np.float64)
    if len(points) <= FEW_POINTS:
        return box_moments_by_sorting(points, sides=edges)
    from indoor_bim.cloud.box_sums import sum_products
    from indoor_bim.cloud.extent import bounds

    low, high = bounds(points)
    first = np.floor(low / edges)
    size = (np.floor(high / edges) - first).astype(np.int64) + 1
    strides = np.array([size[1] * size[2], size[2], 1])
    count, corner, sums = sum_products(points, sides=edges, first=first.astype(np.int64), strides=strides)
    mean, products = sums[:, :3] / count[:, None], sums[:, 3:] / count[:, None]
    covariance = np.zeros((len(count), 3, 3))
    for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        covariance[:, i, j] = covariance[:, j, i] = products[:, column] - mean[:, i] * mean[:, j]
    return BoxMoments(count, corner * edges + mean, covariance)


def box_moments_by_sorting(points: Floats, *, sides: Floats) -> BoxMoments:
    """Twin of `box_moments` in numpy: slower, for few points."""
    cells = np.floor(points / sides).astype(np.int64)
    cells -= cells.min(axis=0)
    spans = cells.max(axis=0) + 1
    keys = (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
    _, group, count = np.unique(keys, return_inverse=True, return_counts=True)
    mean = np.column_stack([np.bincount(group, weights=points[:, k]) for k in range(3)]) / count[:, None]
    offset = points - mean[group]
    covariance = np.zeros((len(count), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            covariance[:, i, j] = covariance[:, j, i] = np.bincount(group, weights=offset[:, i] * offset[:, j]) / count
    return BoxMoments(count, mean, covariance)
