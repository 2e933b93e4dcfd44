"""Points sorted in one pass into the tiles of a grid, each with the points just outside it, so that every tile can be searched alone.

Coordinates within a tile are whole numbers: a cell is `CELL` steps long, a tile `TILE` cells and a margin of one cell on every side. The
points of a tile stand in runs that are chained, each twice as long as the one before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.compiled import compiled, inlined
from indoor_bim.threads import even_slices, in_threads

CELL_BITS, TILE_BITS = 17, 6
CELL, TILE = 1 << CELL_BITS, 1 << TILE_BITS
MOST_STEPS = 2.0**43 - 2.0**25
"""Steps from the first point within which all points have to lie."""

_SIDE_BITS = CELL_BITS + TILE_BITS
_SIDE = 1 << _SIDE_BITS
_LAST = _SIDE - 1
_FIRST = 2.0**43 + _SIDE / 2
"""Place of the first point: the middle of a tile, so that a small cloud lies in one."""
_FREE = np.int64(-1)
_HASH = np.uint64(0x9E3779B97F4A7C15)
_ONE = np.uint64(1)
_SHARED = 8
"""Tiles that a point can belong to, with those whose margin it lies in."""
_FIRST_TILES = 512
FIRST_RUN, LONGEST_RUN = 4, 256
_BEGIN, _NEXT, _END, _COUNT = range(4)
"""What is known of a chain: where it begins, the next free record, the end of its last run, and its number of points."""

_points = types.Array(types.float64, 2, "C", readonly=True)
_f64, _i64, _i32 = (types.Array(kind, 1, "C") for kind in (types.float64, types.int64, types.int32))
_chain, _records = types.Array(types.int64, 2, "C"), types.Array(types.uint64, 2, "C")


@dataclass(frozen=True, slots=True, eq=False)
class Tiles:
    """Points by tile, in chains of runs; every thread that sorted them has left a chain of its own in the tiles that it met.

    Parameters
    ----------
    first_chain : (t + 1,) int64
        First chain of each tile, by ascending key of the tile.
    first_run : (c,) int64
        Where the first run of each chain begins.
    count : (c,) int64
        Number of points of each chain, those in the margin included.
    records : (m, 2) uint64
        The points: coordinates from the lower corner of the margin, in steps, and rows, as x | y << 32 and z | row << 32. The first run
        of a chain is `FIRST_RUN` long; behind each full run stand the beginning and the length of the next.
    """

    first_chain: NDArray[np.int64]
    first_run: NDArray[np.int64]
    count: NDArray[np.int64]
    records: NDArray[np.uint64]


def sort_into_tiles(points: NDArray[np.float64], *, steps_per_unit: float, threads: int) -> Tiles | None:
    """Tiles of points.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        At least one point, fewer than 2**31.
    steps_per_unit : float
        Steps per unit of the coordinates.
    threads : int
        Threads, each for a part of the points.

    Returns
    -------
    Tiles or None
        None if a point lies `MOST_STEPS` or more from the first one along an axis, or has a coordinate that is not finite.
    """
    origin = np.append(points[0], 0.0)[:3]
    if not np.isfinite(origin).all():
        return None
    parts = list(enumerate(even_slices(len(points), threads)))
    room = 2 * (len(points) // threads + 1) + 2**16
    while True:
        records = np.zeros((threads * room, 2), dtype=np.uint64)

        def sort(part: tuple[int, slice], records: NDArray[np.uint64] = records, room: int = room) -> _Part:
            return _sort_part(points[part[1]], part[1].start, origin, steps_per_unit, part[0] * room, records[: (part[0] + 1) * room])

        done = in_threads(sort, parts, threads=threads)
        if not all(part.near for part in done):
            return None
        if all(part.whole for part in done):
            break
        room *= 2
    keys = np.concatenate([part.keys for part in done])
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    first_chain = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1], [True]]))
    first_run, count = (np.concatenate([part.chain[:, column] for part in done])[order] for column in (_BEGIN, _COUNT))
    return Tiles(first_chain, first_run, count, records)


class _Part(NamedTuple):
    """Chains of a part of the points; whether all of these lie near enough, and whether there was room for all."""

    keys: NDArray[np.int64]
    chain: NDArray[np.int64]
    near: bool
    whole: bool


def _sort_part(
    points: NDArray[np.float64],
    first_row: int,
    origin: NDArray[np.float64],
    steps_per_unit: float,
    first_record: int,
    records: NDArray[np.uint64],
) -> _Part:
    most = _FIRST_TILES
    keys, chain = np.zeros(most, dtype=np.int64), np.zeros((most, 4), dtype=np.int64)
    slot_key, slot_tile = np.full(2 * most, _FREE), np.zeros(2 * most, dtype=np.int32)
    state = np.array([0, 0, first_record])
    while True:
        near = bool(_sort(points, first_row, origin, steps_per_unit, state, slot_key, slot_tile, keys, chain, records))
        done, tiles, _ = (int(number) for number in state)
        if not near or done == len(points) or tiles + _SHARED <= most:
            return _Part(keys[:tiles], chain[:tiles], near, done == len(points))
        keys, chain = np.concatenate([keys, np.zeros_like(keys)]), np.concatenate([chain, np.zeros_like(chain)])
        most *= 2
        slot_key, slot_tile = np.full(2 * most, _FREE), np.zeros(2 * most, dtype=np.int32)
        _insert(keys[:tiles], slot_key, slot_tile)


@inlined
def _slot_of(key, slot_key, shift):  # type: ignore[no-untyped-def]
    """Slot that holds the key, or the free one where it belongs."""
    wrap = np.uint64(len(slot_key) - 1)
    slot = (np.uint64(key) * _HASH) >> shift
    there = slot_key[slot]
    while there != key and there != _FREE:
        slot = (slot + _ONE) & wrap
        there = slot_key[slot]
    return slot


@inlined
def _shift_of(slots):  # type: ignore[no-untyped-def]
    """Bits by which a hash is shifted to become one of so many slots, a power of two."""
    shift = np.uint64(64)
    while slots > 1:
        slots >>= 1
        shift -= _ONE
    return shift


@compiled(_points, types.int64, _f64, types.float64, _i64, _i64, _i32, _i64, _chain, _records)
def _sort(points, first_row, origin, scale, state, slot_key, slot_tile, keys, chain, records):  # type: ignore[no-untyped-def]
    """Put points into their tiles until there is no room for another tile or run; returns whether all of them lie near enough."""
    flat = points.shape[1] == 2
    shift, wrap = _shift_of(len(slot_key)), np.uint64(len(slot_key) - 1)
    x0, y0, z0 = origin[0], origin[1], origin[2]
    start, tiles, used = state[0], state[1], state[2]
    room = len(records) - _SHARED * (LONGEST_RUN + 1)
    for i in range(start, len(points)):
        if tiles + _SHARED > len(keys) or used > room:
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
        for a in range(1 + abs(to_x)):
            for b in range(1 + abs(to_y)):
                for c in range(1 + abs(to_z)):
                    other = key + ((a * to_x) << 42) + ((b * to_y) << 21) + c * to_z
                    slot = (np.uint64(other) * _HASH) >> shift
                    there = slot_key[slot]
                    while there != other and there != _FREE:
                        slot = (slot + _ONE) & wrap
                        there = slot_key[slot]
                    if there == _FREE:
                        slot_key[slot], slot_tile[slot], keys[tiles] = other, tiles, other
                        chain[tiles, _BEGIN], chain[tiles, _NEXT], chain[tiles, _END] = used, used, used + FIRST_RUN
                        used += FIRST_RUN + 1
                        tiles += 1
                    tile = np.uint64(slot_tile[slot])
                    to = chain[tile, _NEXT]
                    if to == chain[tile, _END]:
                        length = min(chain[tile, _COUNT], LONGEST_RUN)
                        records[to, 0], records[to, 1] = used, length
                        to = used
                        chain[tile, _END] = used + length
                        used += length + 1
                    records[to, 0] = xy - a * to_x * _SIDE - (b * to_y * _SIDE << 32)
                    records[to, 1] = z_row - c * to_z * _SIDE
                    chain[tile, _NEXT] = to + 1
                    chain[tile, _COUNT] += 1
    state[0], state[1], state[2] = len(points), tiles, used
    return True


@compiled(_i64, _i64, _i32)
def _insert(keys, slot_key, slot_tile):  # type: ignore[no-untyped-def]
    """Put keys that are all different into free slots."""
    shift = _shift_of(len(slot_key))
    for i in range(len(keys)):
        slot = _slot_of(keys[i], slot_key, shift)
        slot_key[slot], slot_tile[slot] = keys[i], i
