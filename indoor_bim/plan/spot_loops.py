"""Points summed in the cells of the plan, one by one: the compiled inner loop of `arcs.wall_spots`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled
from indoor_bim.plan.strip_loops import layer_of

_points, _values = types.Array(types.float64, 2, "C", readonly=True), types.Array(types.float64, 1, "C", readonly=True)
_ints, _sums = types.Array(types.int64, 1, "C"), types.Array(types.float64, 2, "C")
_f64, _i64 = types.float64, types.int64


@compiled(_points, _values, _values, _f64, _f64, _i64, _i64, _i64, _i64, _i64, _f64, _f64, _ints, _ints, _sums)
def sum_in_cells(  # type: ignore[no-untyped-def]
    xy, rise, depth, cell, scale, column0, row0, rows, even, layers, fine_height, clearance, count, hit, sums
):
    """Number of points, bits of the height layers that they hit, and sums of their whole steps, column by column of the plan."""
    for i in range(len(xy)):
        x, y = xy[i, 0], xy[i, 1]
        place = (np.int64(np.floor(x / cell)) - column0) * rows + np.int64(np.floor(y / cell)) - row0
        count[place] += 1
        hit[place] |= np.int64(1) << np.int64(layer_of(rise[i], depth[i], even, layers, fine_height, clearance))
        sums[place, 0] += np.rint(x * scale)
        sums[place, 1] += np.rint(y * scale)
