"""Numbers in ascending order: whole ones digit by digit, others from buckets; and the one in their middle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FEW = 5000
"""So many numbers are compared, sooner than they are counted."""


def order_of(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rows of keys in ascending order, those of equal keys in their own.

    Parameters
    ----------
    keys : (n,) int64
        Keys from 0 on.

    Returns
    -------
    (n,) int64

    Examples
    --------
    >>> order_of(np.array([7, 2, 7, 5])).tolist()
    [1, 3, 0, 2]
    """
    if len(keys) <= FEW:
        return np.argsort(keys, kind="stable")
    from indoor_bim.ordering_loops import DIGIT, by_digits

    order, spare = np.zeros((2, len(keys)), dtype=np.int64)
    passes = max(-(-int(keys.max()).bit_length() // DIGIT), 1)
    by_digits(np.ascontiguousarray(keys), passes, order, spare)
    return order if passes % 2 else spare


def ascending(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Numbers (n,) in ascending order; fast where all are finite and no small interval holds most of them.

    Examples
    --------
    >>> ascending(np.array([0.5, -1.0, 0.25])).tolist()
    [-1.0, 0.25, 0.5]
    """
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    if len(values) <= FEW or not np.isfinite(high - low):
        return np.sort(values)
    from indoor_bim.ordering_loops import from_buckets

    out = np.zeros(len(values))
    from_buckets(np.ascontiguousarray(values), low, high, out)
    return out


def ascending_in_groups(
    group: NDArray[np.int64], values: NDArray[np.float64], groups: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Numbers in ascending order within their groups, these one after the other.

    Parameters
    ----------
    group : (n,) int64
        Group of each number.
    values : (n,) float64
        Numbers.
    groups : int
        Number of groups.

    Returns
    -------
    first : (groups + 1,) int64
        Where each group begins, and the end of the last.
    ordered : (n,) float64

    Examples
    --------
    >>> [part.tolist() for part in ascending_in_groups(np.array([2, 0, 2]), np.array([0.5, 9.0, 0.25]), 3)]
    [[0, 1, 1, 3], [9.0, 0.25, 0.5]]
    """
    from indoor_bim.ordering_loops import by_group

    first, ordered = np.zeros(groups + 1, dtype=np.int64), np.zeros(len(values))
    by_group(np.ascontiguousarray(group), np.ascontiguousarray(values), first, ordered)
    return first, ordered


def median(values: NDArray[np.float64]) -> float:
    """Median of numbers (n,), as by `numpy.median`; fast where all are finite and no small interval holds most of them.

    Examples
    --------
    >>> median(np.array([0.5, -1.0, 0.25, 1.0]))
    0.375
    """
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    if len(values) <= FEW or not np.isfinite(high - low):
        return float(np.median(values))
    from indoor_bim.ordering_loops import middle_of_buckets

    return float(middle_of_buckets(np.ascontiguousarray(values), low, high))
