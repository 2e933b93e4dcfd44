"""Unique rows of whole numbers, through one key per row: many times faster than sorting rows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


class UniqueRows(NamedTuple):
    """Rows (k, c) in lexicographic order, first place (k,) of each, its number (n,) for every row given, and how often (k,)."""

    rows: Ints
    first: Ints
    group: Ints
    counts: Ints


def unique_rows(rows: Ints) -> UniqueRows:
    """Unique rows, as ``numpy.unique(rows, axis=0)`` finds them.

    Parameters
    ----------
    rows : (n, c) int64
        Rows.

    Examples
    --------
    >>> found = unique_rows(np.array([[2, 1], [0, 5], [2, 1], [0, -3]]))
    >>> found.rows.tolist(), found.first.tolist(), found.group.tolist(), found.counts.tolist()
    ([[0, -3], [0, 5], [2, 1]], [3, 1, 0], [2, 1, 2, 0], [1, 1, 2])
    """
    if not len(rows):
        none = np.zeros(0, dtype=np.int64)
        return UniqueRows(rows, none, none, none)
    columns = [column - column.min() for column in rows.T]
    if np.prod([float(column.max()) + 1 for column in columns]) >= 2**62:
        columns = [np.unique(column, return_inverse=True)[1].reshape(-1) for column in columns]
    key = np.zeros(len(rows), dtype=np.int64)
    for column in columns:
        key = key * (int(column.max()) + 1) + column
    order = np.argsort(key, kind="stable")
    starts = np.append(True, key[order][1:] != key[order][:-1])
    first = order[starts]
    group = np.zeros(len(rows), dtype=np.int64)
    group[order] = np.cumsum(starts) - 1
    return UniqueRows(rows[first], first, group, np.diff(np.append(np.flatnonzero(starts), len(rows))))
