"""Rows with the same key: as `numpy.unique` finds them, but without sorting where keys lie close together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


def group_keys(keys: Ints, *, sparse: int = 16) -> tuple[Ints, Ints, Ints]:
    """Groups of equal keys, by ascending key.

    Parameters
    ----------
    keys : (n,) int64
        Keys from 0 on.
    sparse : int
        Keys are sorted if the largest is more than this many times their number.

    Returns
    -------
    first : (k,) int64
        First row of each group.
    group : (n,) int64
        Number of the group of each row.
    count : (k,) int64
        Rows in each group.

    Examples
    --------
    >>> [part.tolist() for part in group_keys(np.array([7, 2, 7, 5]))]
    [[1, 3, 0], [2, 0, 2, 1], [1, 1, 2]]
    """
    if not len(keys) or keys.max() > sparse * len(keys):
        _, first, group, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
        return first, group, count
    every = np.bincount(keys)
    row = np.zeros(len(every), dtype=np.int64)
    row[keys[::-1]] = np.arange(len(keys))[::-1]
    taken = np.flatnonzero(every)
    return row[taken], (np.cumsum(every > 0) - 1)[keys], every[taken]
