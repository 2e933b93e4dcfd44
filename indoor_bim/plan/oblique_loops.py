"""Points that lie on none of some lines, one by one: the compiled inner loop of `oblique.unexplained`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_points, _values = types.Array(types.float64, 2, "C", readonly=True), types.Array(types.float64, 1, "C", readonly=True)
_f64 = types.float64


@compiled(_points, _values, _f64, _points, _f64, _f64, types.Array(types.int64, 1, "C"))
def off_lines(xy, rise, upper, lines, near, past, rows):  # type: ignore[no-untyped-def]
    """Write the rows of the points high on the walls that are on no line, or too far past its ends; return how many there are.

    `lines` has a row for each: dx, dy, nx, ny, offset, start, end.
    """
    found = 0
    for i in range(len(rise)):
        if not rise[i] > upper:
            continue
        x, y, free = xy[i, 0], xy[i, 1], True
        for k in range(len(lines)):
            if np.abs(x * lines[k, 2] + y * lines[k, 3] - lines[k, 4]) <= near:
                along = x * lines[k, 0] + y * lines[k, 1]
                if along >= lines[k, 5] - past and along <= lines[k, 6] + past:
                    free = False
                    break
        if free:
            rows[found] = i
            found += 1
    return found
