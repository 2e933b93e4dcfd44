"""Peaks of a histogram of heights, one after the other: the compiled inner loop of `heights.height_peaks`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_heights = types.Array(types.float64, 1, "C", readonly=True)
_floats = types.Array(types.float64, 1, "C")


@compiled(_floats, _heights, types.float64, types.float64, types.float64, types.int64, types.float64, _floats)
def take_peaks(histogram, ordered, low, step, least, half, tolerance, peaks):  # type: ignore[no-untyped-def]
    """Write the median of the heights around each peak of at least so much, the highest first; return their number.

    The histogram is zero wherever it is within twice `half` of a peak afterwards.
    """
    found = 0
    while found < len(peaks):
        top = np.argmax(histogram)
        if histogram[top] < least:
            break
        guess = low + (top + 0.5) * step
        first, last = np.searchsorted(ordered, guess - tolerance), np.searchsorted(ordered, guess + tolerance)
        count = last - first
        peaks[found] = (ordered[first + (count - 1) // 2] + ordered[first + count // 2]) / 2 if count else guess
        histogram[max(top - 2 * half, 0) : top + 2 * half + 1] = 0
        found += 1
    return found
