"""Points counted in columns by the side that they were seen from: the compiled inner loops of `local_density`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_counts, _bools = types.Array(types.int64, 4, "C"), types.Array(types.bool_, 1, "C")
_dense = types.Array(types.int64, 3, "C", readonly=True)
_image = types.Array(types.float32, 2, "C", readonly=True)
_place = (types.float64, types.float64, types.float64)


@inlined
def _quarter(x, y):  # type: ignore[no-untyped-def]
    """Quarter that a direction lies in."""
    if abs(x) > abs(y):
        return 3 if x > 0 else 2
    return 1 if y > 0 else 0


@compiled(_points, _points, _values, types.float64, types.int64, types.int64, _counts)
def count_in_columns(xy, sensor, depth, cell, column0, row0, counts):  # type: ignore[no-untyped-def]
    """Count points by layer below the surface overhead, quarter that they were seen from, and column; deeper layers are left out."""
    for i in range(len(xy)):
        layer = max(int(depth[i] / cell), 0)
        if layer < len(counts):
            quarter = _quarter(sensor[i, 0] - xy[i, 0], sensor[i, 1] - xy[i, 1]) if len(sensor) else 0
            counts[layer, quarter, int(np.floor(xy[i, 0] / cell)) - column0, int(np.floor(xy[i, 1] / cell)) - row0] += 1


@compiled(
    *(_points, _points, types.float64, types.int64, types.int64, _dense, types.float64),
    *(_image, *_place, types.float64, types.float64, _bools),
)
def in_thin_columns(  # type: ignore[no-untyped-def]
    xy, sensor, cell, column0, row0, densest, least, overhead, x0, y0, pixel, step, sparse, thin
):
    """Points in columns that hold fewer than `least`, below a spot of the surface overhead that is sparse."""
    last_row, last_column = overhead.shape[0] - 1, overhead.shape[1] - 1
    for i in range(len(xy)):
        x, y, quarter = xy[i, 0], xy[i, 1], 0
        towards_x = towards_y = 0.0
        if len(sensor):
            towards_x, towards_y = sensor[i, 0] - x, sensor[i, 1] - y
            quarter = _quarter(towards_x, towards_y)
        thin[i] = False
        if densest[quarter, int(np.floor(x / cell)) - column0, int(np.floor(y / cell)) - row0] < least:
            if len(sensor):
                far = max(np.hypot(towards_x, towards_y), 1e-9)
                x, y = x + step * towards_x / far, y + step * towards_y / far
            column, row = int(np.floor((x - x0) / pixel)), int(np.floor((y - y0) / pixel))
            thin[i] = overhead[min(max(row, 0), last_row), min(max(column, 0), last_column)] < sparse
