"""Times of points on the path of the scanner: the compiled inner loops of `scanner_path`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

_floats, _table = types.Array(types.float64, 1, "A", readonly=True), types.Array(types.float64, 2, "C", readonly=True)
_fixed = types.Array(types.float64, 1, "C", readonly=True)
_out, _ints = types.Array(types.float64, 2, "C"), types.Array(types.int64, 1, "C")
_flags = types.Array(types.bool_, 1, "C", readonly=True)


@inlined
def _row_at(time, t, guess):  # type: ignore[no-untyped-def]
    """Last row that is not later than a time, -1 where all are; times of neighbours are mostly in the same row or the next."""
    if guess >= 0 and time[guess] <= t:
        for row in range(guess, min(guess + 3, len(time) - 1)):
            if t < time[row + 1]:
                return row
    return np.searchsorted(time, t, side="right") - 1


@compiled(_floats, _fixed, _table, _out)
def positions_at(times, time, path, out):  # type: ignore[no-untyped-def]
    """Positions on a path (m, 3) at the given times, between its rows in proportion, before and after it those of its ends."""
    row = -1
    for i in range(len(times)):
        t = times[i]
        row = _row_at(time, t, row)
        if row < 0 or row >= len(time) - 1:
            for k in range(3):
                out[i, k] = np.nan if np.isnan(t) else path[max(row, 0), k]
            continue
        for k in range(3):
            slope = (path[row + 1, k] - path[row, k]) / (time[row + 1] - time[row])
            out[i, k] = slope * (t - time[row]) + path[row, k]


@compiled(_floats, _fixed, _flags, types.float64, _ints)
def periods_at(times, time, stood, length, out):  # type: ignore[no-untyped-def]
    """Number of the period that each time is in; all of a row in which the scanner stood share that of its beginning."""
    row = -1
    for i in range(len(times)):
        row = max(_row_at(time, times[i], row), 0)
        since = time[row] if stood[row] else times[i]
        out[i] = np.int64(np.floor((since - time[0]) / length))
