"""Number, mean and covariance of the points in every box of a grid: what surfaces look like piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_bim.cloud.extent import bounds
from indoor_bim.ordering import order_of

Floats = NDArray[np.float64]

FEW_POINTS = 20_000
"""So many points are sorted, sooner than the compiled sums are loaded."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxMoments:
    """Occupied boxes, by x, then y, then z index.

    Parameters
    ----------
    index : (m, 3) int64
        Place of the box in the grid; times the sides: its lower corner.
    count : (m,) int64
        Number of points.
    mean : (m, 3) float64
        Mean point.
    covariance : (m, 3, 3) float64
        Mean product of the offsets from the mean.
    """

    index: NDArray[np.int64]
    count: NDArray[np.int64]
    mean: Floats
    covariance: Floats

    def merged(self, factors: ArrayLike) -> BoxMoments:
        """Moments of boxes that are so many times as wide along each axis.

        Parameters
        ----------
        factors : (3,) array_like
            Whole numbers.

        Examples
        --------
        >>> points = np.array([[0.1, 0, 0], [0.3, 0, 0], [1.5, 1, 1]])
        >>> wide = box_moments(points, sides=(1, 1, 1)).merged((2, 2, 2))
        >>> wide.count.tolist(), wide.mean.round(6).tolist(), np.allclose(wide.covariance[0], np.cov(points.T, ddof=0))
        ([3], [[0.633333, 0.333333, 0.333333]], True)
        """
        index = self.index // np.asarray(factors, dtype=np.int64)
        first = index.min(axis=0)
        size = index.max(axis=0) - first + 1
        key = ((index[:, 0] - first[0]) * size[1] + index[:, 1] - first[1]) * size[2] + index[:, 2] - first[2]
        order = order_of(key)
        new = np.flatnonzero(np.append(True, np.diff(key[order]) != 0))
        count, index = np.add.reduceat(self.count[order], new), index[order][new]
        mean = np.add.reduceat((self.count[:, None] * self.mean)[order], new) / count[:, None]
        share = self.count[order] / np.repeat(count, np.diff(np.append(new, len(order))))
        offset = self.mean[order] - np.repeat(mean, np.diff(np.append(new, len(order))), axis=0)
        spread = self.covariance[order] + offset[:, :, None] * offset[:, None, :]
        return BoxMoments(index, count, mean, np.add.reduceat(share[:, None, None] * spread, new))


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

    low, high = bounds(points)
    first = np.floor(low / edges)
    size = (np.floor(high / edges) - first).astype(np.int64) + 1
    strides = np.array([size[1] * size[2], size[2], 1])
    count, corner, sums = sum_products(points, sides=edges, first=first.astype(np.int64), strides=strides)
    mean, products = sums[:, :3] / count[:, None], sums[:, 3:] / count[:, None]
    covariance = np.zeros((len(count), 3, 3))
    for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        covariance[:, i, j] = covariance[:, j, i] = products[:, column] - mean[:, i] * mean[:, j]
    return BoxMoments(corner, count, corner * edges + mean, covariance)


def box_moments_by_sorting(points: Floats, *, sides: Floats) -> BoxMoments:
    """Twin of `box_moments` in numpy: slower, for few points."""
    index = np.floor(points / sides).astype(np.int64)
    cells = index - index.min(axis=0)
    spans = cells.max(axis=0) + 1
    keys = (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
    _, one_of, group, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    mean = np.column_stack([np.bincount(group, weights=points[:, k]) for k in range(3)]) / count[:, None]
    offset = points - mean[group]
    covariance = np.zeros((len(count), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            covariance[:, i, j] = covariance[:, j, i] = np.bincount(group, weights=offset[:, i] * offset[:, j]) / count
    return BoxMoments(index[one_of], count, mean, covariance)
