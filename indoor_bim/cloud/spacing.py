"""Bounded samples and the point spacing, independent of the order of the points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

MULTIPLIERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)

FEW_POINTS = 20_000
"""So many points are hashed in numpy, sooner than the compiled loop is loaded."""


def sample_mask(points: NDArray[np.float64], count: int) -> NDArray[np.bool_]:
    """Choose about `count` points, spread evenly over the points, by a hash of their coordinates.

    The choice depends on each point's coordinates alone, not on the order of the points.

    Parameters
    ----------
    points : (n, 3) float64
        Points.
    count : int
        Number of points wanted; all are taken when there are no more than this.

    Returns
    -------
    (n,) bool
    """
    if len(points) <= count:
        return np.ones(len(points), dtype=np.bool_)
    chosen, limit = np.zeros(len(points), dtype=np.bool_), np.uint64(2**64 * (count / len(points)))
    if len(points) > FEW_POINTS:
        from indoor_bim.cloud.point_loops import choose
        from indoor_bim.threads import even_slices, in_threads, threads_for

        words, threads = np.ascontiguousarray(points).view(np.uint64), threads_for(len(points))
        in_threads(lambda part: choose(words[part], MULTIPLIERS, limit, chosen[part]), even_slices(len(points), threads), threads=threads)
        return chosen
    return sample_by_hashing(points, limit=limit)


def sample_by_hashing(points: NDArray[np.float64], *, limit: np.uint64) -> NDArray[np.bool_]:
    """Twin of `point_loops.choose` in numpy: slower, for few points."""
    chosen: NDArray[np.bool_] = _hash(np.ascontiguousarray(points + 0.0).view(np.uint64)) < limit
    return chosen


def point_spacing(points: ArrayLike, *, sample_size: int = 100_000) -> float:
    """Median distance from a point to its nearest neighbour at another place.

    Large clouds are sampled in blocks, so that every chosen point keeps its true neighbours; the blocks are chosen
    by a hash of their place, so the result does not depend on the order of the points.

    Parameters
    ----------
    points : (n, 3) array_like
        Points, any unit.
    sample_size : int
        Number of points to look at, roughly.

    Returns
    -------
    float
        Spacing in the unit of the points; NaN with fewer than two different points.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(20) * 0.05, np.arange(20) * 0.05)
    >>> round(point_spacing(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)), 6)
    0.05
    """
    from scipy.spatial import cKDTree

    from indoor_bim.threads import threads_for

    xyz = _blocks(np.asarray(points, dtype=np.float64), sample_size)
    xyz = xyz[np.lexsort(xyz.T)]
    xyz = xyz[np.append(True, (xyz[1:] != xyz[:-1]).any(axis=1))] if len(xyz) else xyz
    if len(xyz) < 2:
        return float("nan")
    distance, _ = cKDTree(xyz, balanced_tree=False).query(xyz, k=2, workers=threads_for(len(xyz)))
    return float(np.median(distance[:, 1]))


def _blocks(xyz: NDArray[np.float64], sample_size: int) -> NDArray[np.float64]:
    """Points of evenly spread blocks that hold about `sample_size` points together."""
    if len(xyz) <= 2 * sample_size:
        return xyz
    low, high = np.quantile(xyz[sample_mask(xyz, sample_size)], [0.01, 0.99], axis=0)
    edge = max(float((high - low).max()) / 64, np.finfo(np.float64).tiny)
    for share in sample_size / len(xyz) * 4.0 ** np.arange(10):
        chosen = _in_blocks(xyz, low, edge, np.uint64(2**64 * min(share, 0.999999)))
        if np.count_nonzero(chosen) >= sample_size // 4:
            return xyz[chosen]
    return xyz


def _in_blocks(xyz: NDArray[np.float64], low: NDArray[np.float64], edge: float, limit: np.uint64) -> NDArray[np.bool_]:
    """Points (n,) in the blocks whose hash is below a limit."""
    if len(xyz) <= FEW_POINTS:
        return blocks_by_hashing(xyz, low=low, edge=edge, limit=limit)
    from indoor_bim.cloud.point_loops import choose_blocks
    from indoor_bim.threads import even_slices, in_threads, threads_for

    points, chosen, threads = np.ascontiguousarray(xyz), np.zeros(len(xyz), dtype=np.bool_), threads_for(len(xyz))
    in_threads(
        lambda part: choose_blocks(points[part], low, edge, MULTIPLIERS, limit, chosen[part]),
        even_slices(len(points), threads),
        threads=threads,
    )
    return chosen


def blocks_by_hashing(xyz: NDArray[np.float64], *, low: NDArray[np.float64], edge: float, limit: np.uint64) -> NDArray[np.bool_]:
    """Twin of `point_loops.choose_blocks` in numpy: slower, for few points."""
    chosen: NDArray[np.bool_] = _hash(np.floor((xyz - low) / edge).astype(np.int64).view(np.uint64)) < limit
    return chosen


def _hash(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Well mixed 64-bit hash of each row."""
    mixed = np.zeros(len(words), dtype=np.uint64)
    for column, factor in zip(words.T, MULTIPLIERS, strict=False):
        mixed ^= column
        mixed *= factor
        mixed ^= mixed >> np.uint64(32)
    mixed *= MULTIPLIERS[0]
    mixed ^= mixed >> np.uint64(29)
    return mixed
