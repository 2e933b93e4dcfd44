"""Tiles with a margin: each holds the points just outside it as well, so that it can be searched for neighbours on its own.

Coordinates within a tile are whole numbers: a cell is `CELL` steps long, a tile `TILE` cells and a margin of one cell on every side.
Records are x | y << 32 and z | row << 32, coordinates from the lower corner of the margin.
"""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.cloud.hash_slots import FOLD, FREE, HASH, HIGH, ONE
from indoor_bim.cloud.tiles import BEGIN, CHAIN_TYPES, COUNT, END, FIRST_RUN, LONGEST_RUN, NEXT, SHARED
from indoor_bim.compiled import compiled

CELL_BITS, TILE_BITS = 17, 6
CELL, TILE = 1 << CELL_BITS, 1 << TILE_BITS
MOST_STEPS = 2.0**43 - 2.0**25
"""Steps from the origin within which all points have to lie."""

_SIDE_BITS = CELL_BITS + TILE_BITS
_SIDE = 1 << _SIDE_BITS
_LAST = _SIDE - 1
_FIRST = 2.0**43 + _SIDE / 2
"""Place of the origin: the middle of a tile, so that a small cloud lies in one."""

_points, _f64 = types.Array(types.float64, 2, "C", readonly=True), types.Array(types.float64, 1, "C")


@compiled(_points, types.int64, _f64, types.float64, *CHAIN_TYPES)
def sort_with_margins(points, first_row, origin, scale, state, slot_key, slot_tile, keys, chain, records):  # type: ignore[no-untyped-def]
    """Loop for `sort_into_tiles`: the grid is an origin (3,) and the steps per unit; points suit it that lie within `MOST_STEPS`."""
    flat = points.shape[1] == 2
    wrap = np.uint64(len(slot_key) - 1)
    step_key, step_xy, step_z = np.zeros(3, np.int64), np.zeros(3, np.int64), np.zeros(3, np.int64)
    x0, y0, z0 = origin[0], origin[1], origin[2]
    start, tiles, used = state[0], state[1], state[2]
    room = len(records) - SHARED * (LONGEST_RUN + 1)
    for i in range(start, len(points)):
        if tiles + SHARED > len(keys) or used > room:
            state[0], state[1], state[2] = i, tiles, used
            return True
        dx, dy = (points[i, 0] - x0) * scale, (points[i, 1] - y0) * scale
        dz = 0.0 if flat else (points[i, 2] - z0) * scale
        if not (abs(dx) < MOST_STEPS and abs(dy) < MOST_STEPS and abs(dz) < MOST_STEPS):
            return False
        x, y, z = np.int64(dx + _FIRST), np.int64(dy + _FIRST), np.int64(dz + _FIRST)
        key = (x >> _SIDE_BITS) << 42 | (y >> _SIDE_BITS) << 21 | z >> _SIDE_BITS
        x, y, z = x & _LAST, y & _LAST, z & _LAST
        xy, z_row = (x + CELL) | (y + CELL) << 32, (z + CELL) | (first_row + i) << 32
        to_x = np.int64(x >= _SIDE - CELL) - np.int64(x < CELL)  # neighbour tiles whose margins the point lies in
        to_y = np.int64(y >= _SIDE - CELL) - np.int64(y < CELL)
        to_z = np.int64(z >= _SIDE - CELL) - np.int64(z < CELL)
        count = np.int64(1)
        if to_x | to_y | to_z:
            step_key[0], step_xy[0], step_z[0] = to_x << 42, to_x * _SIDE, 0
            axes = abs(to_x)
            step_key[axes], step_xy[axes], step_z[axes] = to_y << 21, to_y * _SIDE << 32, 0
            axes += abs(to_y)
            step_key[axes], step_xy[axes], step_z[axes] = to_z, 0, to_z * _SIDE
            count = 1 << (axes + abs(to_z))
        for k in range(count):
            other, xy_here, z_row_here = key, xy, z_row
            if k:
                a, b, c = k & 1, k >> 1 & 1, k >> 2
                other += a * step_key[0] + b * step_key[1] + c * step_key[2]
                xy_here -= a * step_xy[0] + b * step_xy[1] + c * step_xy[2]
                z_row_here -= a * step_z[0] + b * step_z[1] + c * step_z[2]
            word = np.uint64(other)
            slot = (((word ^ word >> FOLD) * HASH) >> HIGH) & wrap
            there = slot_key[slot]
            while there != other and there != FREE:
                slot = (slot + ONE) & wrap
                there = slot_key[slot]
            if there == FREE:
                slot_key[slot], slot_tile[slot], keys[tiles] = other, tiles, other
                chain[tiles, BEGIN], chain[tiles, NEXT], chain[tiles, END] = used, used, used + FIRST_RUN
                used += FIRST_RUN + 1
                tiles += 1
            tile = np.uint64(slot_tile[slot])
            to = chain[tile, NEXT]
            if to == chain[tile, END]:
                length = min(chain[tile, COUNT], LONGEST_RUN)
                records[to, 0], records[to, 1] = used, length
                to = used
                chain[tile, END] = used + length
                used += length + 1
            records[to, 0] = xy_here
            records[to, 1] = z_row_here
            chain[tile, NEXT] = to + 1
            chain[tile, COUNT] += 1
    state[0], state[1], state[2] = len(points), tiles, used
    return True
