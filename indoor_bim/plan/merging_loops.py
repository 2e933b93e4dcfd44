"""Lines that continue one another: the compiled inner loop of `line_merging`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

SHORT_TURN = np.radians(8.0)
"""Largest angle that a short piece may have to a long one."""

_lines = types.Array(types.float64, 2, "C", readonly=True)


@inlined
def _continue(one, other, gap, apart, turn):  # type: ignore[no-untyped-def]
    """Whether the shorter of two lines (angle, offset, start, end) continues the longer one."""
    longer, shorter = (other, one) if other[3] - other[2] > one[3] - one[2] else (one, other)
    angle = shorter[0] - longer[0]
    if abs((angle + np.pi) % (2 * np.pi) - np.pi) > max(turn, min(apart / (shorter[3] - shorter[2]), SHORT_TURN)):
        return False
    cos, sin = np.cos(angle), np.sin(angle)
    first, last = shorter[2] * cos - shorter[1] * sin, shorter[3] * cos - shorter[1] * sin
    if max(first, longer[2]) - min(last, longer[3]) > gap:
        return False
    across = shorter[1] * cos - longer[1]
    return abs(shorter[2] * sin + across) <= apart and abs(shorter[3] * sin + across) <= apart


@compiled(_lines, types.int64, types.boolean, types.float64, types.float64, types.float64)
def first_pair(lines, row, changed, gap, apart, turn):  # type: ignore[no-untyped-def]
    """Rows of the first two lines of which one continues the other: an earlier line and this one, if it has changed; this and a later.

    Both are -1 if there are none.
    """
    for k in range(row if changed else 0):
        if _continue(lines[k], lines[row], gap, apart, turn):
            return k, row
    for k in range(row + 1, len(lines)):
        if _continue(lines[row], lines[k], gap, apart, turn):
            return row, k
    return -1, -1
