"""Order of whole numbers, digit by digit."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.compiled import compiled

FEW_KEYS = 5000
"""So many keys are compared, sooner than they are counted by digits."""

_DIGIT = 11
_keys = types.Array(types.int64, 1, "C", readonly=True)
_order = types.Array(types.int64, 1, "C")


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
    if len(keys) <= FEW_KEYS:
        return np.argsort(keys, kind="stable")
    order, spare = np.zeros((2, len(keys)), dtype=np.int64)
    passes = max(-(-int(keys.max()).bit_length() // _DIGIT), 1)
    _by_digits(np.ascontiguousarray(keys), passes, order, spare)
    return order if passes % 2 else spare


@compiled(_keys, types.int64, _order, _order)
def _by_digits(keys, passes, one, other):  # type: ignore[no-untyped-def]
    """Sort rows by one digit of their keys after the other, the lowest first; the last pass of an odd number writes to `one`."""
    mask = (1 << _DIGIT) - 1
    for k in range(passes):
        to, rows = (one, other) if k % 2 == 0 else (other, one)
        place = np.zeros(mask + 2, np.int64)
        for i in range(len(keys)):
            place[(keys[i] >> k * _DIGIT & mask) + 1] += 1
        for digit in range(mask):
            place[digit + 1] += place[digit]
        for i in range(len(keys)):
            row = rows[i] if k else i
            digit = keys[row] >> k * _DIGIT & mask
            to[place[digit]] = row
            place[digit] += 1
