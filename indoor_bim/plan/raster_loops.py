"""Points on rasters: the compiled inner loops of `evidence` and `hit_images`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled
from indoor_bim.plan.block_image import BLOCK, BLOCK_BITS

_points = types.Array(types.float64, 2, "A", readonly=True)
_values = types.Array(types.float64, 1, "A", readonly=True)
_given, _bools = types.Array(types.float64, 1, "C", readonly=True), types.Array(types.bool_, 1, "C")
_solid = types.Array(types.float64, 2, "C", readonly=True)
_image, _place = types.Array(types.float64, 2, "C", readonly=True), (types.float64, types.float64, types.float64)
_out, _spots = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
_hit, _words = types.Array(types.bool_, 2, "C"), types.Array(types.uint32, 2, "C")
_state, _slots = types.Array(types.int64, 1, "C"), types.Array(types.int32, 2, "C")


@compiled(_points, _image, *_place, _out)
def look_up(xy, image, x0, y0, cell, out):  # type: ignore[no-untyped-def]
    """Values of the pixels under points; points outside take the value at the border."""
    rows, columns = image.shape
    for n in range(len(xy)):
        column, row = int(np.floor((xy[n, 0] - x0) / cell)), int(np.floor((xy[n, 1] - y0) / cell))
        out[n] = image[min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)]


@compiled(_points, *_place, _hit)
def mark(xy, x0, y0, cell, image):  # type: ignore[no-untyped-def]
    """Mark the pixels that hold a point."""
    rows, columns = image.shape
    for n in range(len(xy)):
        column, row = int(np.floor((xy[n, 0] - x0) / cell)), int(np.floor((xy[n, 1] - y0) / cell))
        if row >= 0 and row < rows and column >= 0 and column < columns:
            image[row, column] = True


@compiled(_solid, types.float64, types.float64, types.float64, *_place, _hit)
def mark_level(points, base, least, most, x0, y0, cell, image):  # type: ignore[no-untyped-def]
    """Mark the pixels that hold a point between two heights above a base."""
    rows, columns = image.shape
    for n in range(len(points)):
        above = points[n, 2] - base
        if not (above > least and above < most):
            continue
        column, row = int(np.floor((points[n, 0] - x0) / cell)), int(np.floor((points[n, 1] - y0) / cell))
        if row >= 0 and row < rows and column >= 0 and column < columns:
            image[row, column] = True


@compiled(_solid, _image, _image, *_place, *_place, _hit)
def mark_surface(points, height, slack, left, bottom, side, x0, y0, cell, image):  # type: ignore[no-untyped-def]
    """Mark the pixels that hold a point on a surface, within its slack."""
    rows, columns = image.shape
    last_row, last_column = height.shape[0] - 1, height.shape[1] - 1
    for n in range(len(points)):
        x, y = points[n, 0], points[n, 1]
        i, j = int(np.floor((y - bottom) / side)), int(np.floor((x - left) / side))
        i, j = min(max(i, 0), last_row), min(max(j, 0), last_column)
        if not abs(points[n, 2] - height[i, j]) < slack[i, j]:
            continue
        column, row = int(np.floor((x - x0) / cell)), int(np.floor((y - y0) / cell))
        if row >= 0 and row < rows and column >= 0 and column < columns:
            image[row, column] = True


@compiled(_points, _values, types.float64, types.int64, *_place, types.int64, _state, _slots, _words)
def set_layers(xy, rise, least, layers, x0, y0, cell, columns, state, slots, words):  # type: ignore[no-untyped-def]
    """Set the bit of its height layer in the pixel of each point above a share of the height; the image is kept in blocks.

    The state is the number of points that are done and of slots that are used: goes on until all are done or no slot is left.
    """
    used = state[1]
    for n in range(state[0], len(xy)):
        if used == len(words):
            state[0], state[1] = n, used
            return
        if not rise[n] > least:
            continue
        column, row = int(np.floor((xy[n, 0] - x0) / cell)), int(np.floor((xy[n, 1] - y0) / cell))
        if row >= 0 and row < len(slots) and column >= 0 and column < columns:
            block = column >> BLOCK_BITS
            if slots[row, block] == 0:
                slots[row, block] = used
                used += 1
            words[slots[row, block], column & (BLOCK - 1)] |= np.uint32(1) << np.uint32(min(max(int(rise[n] * layers), 0), layers - 1))
    state[0], state[1] = len(xy), used


@compiled(_points, _points, types.float64, _spots)
def step_towards(xy, sensor, step, out):  # type: ignore[no-untyped-def]
    """Spots a step from points towards the scanner."""
    for n in range(len(xy)):
        x, y = sensor[n, 0] - xy[n, 0], sensor[n, 1] - xy[n, 1]
        far = max(np.hypot(x, y), 1e-9)
        out[n, 0], out[n, 1] = xy[n, 0] + step * x / far, xy[n, 1] + step * y / far


@compiled(_solid, types.Array(types.int64, 1, "C", readonly=True), _spots)
def copy_points(points, rows, out):  # type: ignore[no-untyped-def]
    """Copy the points of some rows."""
    for n in range(len(rows)):
        out[n, 0], out[n, 1], out[n, 2] = points[rows[n], 0], points[rows[n], 1], points[rows[n], 2]


@compiled(_solid, _given, _given, _bools)
def in_box(points, low, high, inside):  # type: ignore[no-untyped-def]
    """Whether points lie within a box."""
    for n in range(len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        inside[n] = x > low[0] and x < high[0] and y > low[1] and y < high[1] and z > low[2] and z < high[2]
