"""Wall candidates told from other points and put into their tiles: the compiled inner loops of `evidence.wall_points`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_points = types.Array(types.float64, 2, "C", readonly=True)
_image = types.Array(types.float64, 2, "C", readonly=True)
_place = (types.float64, types.float64, types.float64)
_values, _table = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
_tiles, _counts = types.Array(types.int32, 1, "C"), types.Array(types.int64, 1, "C")

NONE = np.int32(-1)


@compiled(
    *(_points, _points, types.float64, _image, _image, *_place, types.float64, types.float64, types.float64),
    *(types.int64, types.int64, types.int64, _values, _tiles, _counts),
)
def find_candidates(  # type: ignore[no-untyped-def]
    points, sensor, step, overhead, slack, x0, y0, cell, floor, tolerance, tile_side, column0, row0, columns, height, tile, count
):
    """Overhead height and tile of each point between floor and overhead surface, and the number of these in each tile."""
    last_row, last_column = overhead.shape[0] - 1, overhead.shape[1] - 1
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        tile[i] = NONE
        if not z > floor + tolerance:
            continue
        spot_x, spot_y = x, y
        if len(sensor):
            towards_x, towards_y = sensor[i, 0] - x, sensor[i, 1] - y
            far = max(np.sqrt(towards_x * towards_x + towards_y * towards_y), 1e-9)
            spot_x, spot_y = x + step * towards_x / far, y + step * towards_y / far
        column = min(max(int(np.floor((spot_x - x0) / cell)), 0), last_column)
        row = min(max(int(np.floor((spot_y - y0) / cell)), 0), last_row)
        above = overhead[row, column]
        if z < above - (tolerance + slack[row, column]) and above > floor + 0.5:
            here = (int(np.floor(y / tile_side)) - row0) * columns + int(np.floor(x / tile_side)) - column0
            height[i] = above
            tile[i] = here
            count[here] += 1


@compiled(_points, _points, types.float64, _values, _tiles, _counts, _table, _values, _values, _table)
def put_into_tiles(points, sensor, floor, height, tile, place, xy, rise, depth, seen_from):  # type: ignore[no-untyped-def]
    """Write the candidates to the next place of their tile."""
    for i in range(len(points)):
        if tile[i] == NONE:
            continue
        k = place[tile[i]]
        place[tile[i]] += 1
        z = points[i, 2]
        xy[k, 0], xy[k, 1] = points[i, 0], points[i, 1]
        rise[k], depth[k] = (z - floor) / (height[i] - floor), height[i] - z
        if len(sensor):
            seen_from[k, 0], seen_from[k, 1] = sensor[i, 0], sensor[i, 1]
