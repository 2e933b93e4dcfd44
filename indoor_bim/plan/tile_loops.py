"""Rows of points put into tiles of the plan and taken out around walls: the compiled inner loops of `wall_points`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_points, _f64, _i64 = types.Array(types.float64, 2, "C", readonly=True), types.float64, types.int64
_rows, _counts, _places = types.Array(types.int32, 1, "C"), types.Array(types.int64, 1, "C"), types.Array(types.float64, 2, "C")
_wall, _ranges = types.Array(types.float64, 1, "C", readonly=True), types.Array(types.int64, 2, "C", readonly=True)

NONE = np.int32(-1)


@compiled(_points, _f64, _i64, _i64, _i64, _i64, _rows, _counts)
def find_tiles(points, side, column0, row0, columns, rows, tile, count):  # type: ignore[no-untyped-def]
    """Tile of each point, if it lies in one, and the number of points in each tile."""
    for i in range(len(points)):
        column, row = np.int64(np.floor(points[i, 0] / side)) - column0, np.int64(np.floor(points[i, 1] / side)) - row0
        here = NONE
        if 0 <= column < columns and 0 <= row < rows:
            here = np.int32(row * columns + column)
            count[here] += 1
        tile[i] = here


@compiled(_rows, _i64, _counts, _rows)
def put_into_tiles(tile, first_row, place, ordered):  # type: ignore[no-untyped-def]
    """Write the row of each point to the next place of its tile."""
    for i in range(len(tile)):
        if tile[i] != NONE:
            ordered[place[tile[i]]] = first_row + i
            place[tile[i]] += 1


@compiled(_points, _rows, _ranges, _wall, *[_f64] * 5, _places)
def places_within(points, ordered, ranges, wall, reach, start, end, low, high, places):  # type: ignore[no-untyped-def]
    """Write along, across and up of the points near a stretch of a wall, a row of `places` each; return how many there are."""
    x, y, dx, dy, base, widest = wall[0], wall[1], wall[2], wall[3], wall[6], wall[4] + reach
    found = 0
    for r in range(len(ranges)):
        for k in range(ranges[r, 0], ranges[r, 1]):
            i = ordered[k]
            px, py, up = points[i, 0] - x, points[i, 1] - y, points[i, 2] - base
            along, across = px * dx + py * dy, py * dx - px * dy
            places[0, found], places[1, found], places[2, found] = along, across, up
            found += (abs(across) < widest) & (along > start) & (along < end) & (up > low) & (up < high)
    return found
