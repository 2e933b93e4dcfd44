"""Columns of 64 grid cells that hold points: numbered by a table, which of their cells are occupied in the bits of an integer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.compiled import compiled, inlined
from indoor_bim.threads import even_slices, in_threads

FREE = np.int64(-1)
FIRST_SLOTS = 1024
HASH = np.uint64(0x9E3779B97F4A7C15)
ONE = np.uint64(1)

_points = types.Array(types.float64, 2, "C", readonly=True)
_i64, _u64, _u32, _u8 = (types.Array(kind, 1, "C") for kind in (types.int64, types.uint64, types.uint32, types.uint8))
_f64 = types.Array(types.float64, 1, "C")


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """Occupied columns by ascending key.

    Parameters
    ----------
    keys : (b,) int64
        Sum of the products of the column's indices and the strides.
    occupied : (b,) uint64
        Their occupied cells.
    numbers : list of (k,) int64
        Place in `keys` of the columns that each part of the points lies in, in order of their appearance.
    column : (n,) uint32
        Column of each point, in the numbers of its part.
    cell : (n,) uint8
        Cell of each point in its column.
    parts : list of slice
        Parts of the points.
    """

    keys: NDArray[np.int64]
    occupied: NDArray[np.uint64]
    numbers: list[NDArray[np.int64]]
    column: NDArray[np.uint32]
    cell: NDArray[np.uint8]
    parts: list[slice]


def sort_into_columns(
    points: NDArray[np.float64], *, low: NDArray[np.float64], inverse: float, strides: NDArray[np.int64], threads: int
) -> Columns:
    """Columns and cells of points.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        Finite points.
    low : (3,) float64
        Smallest coordinates.
    inverse : float
        Cells per unit.
    strides : (3,) int64
        Difference of the keys of columns that lie side by side along each axis.
    threads : int
        Threads, each for a part of the points.
    """
    parts = even_slices(len(points), threads)
    column, cell = np.zeros(len(points), dtype=np.uint32), np.zeros(len(points), dtype=np.uint8)
    found = in_threads(lambda part: _columns_of(points[part], low, inverse, strides, column[part], cell[part]), parts, threads=threads)
    keys, numbers = _union([keys for keys, _ in found])
    occupied = np.zeros(len(keys), dtype=np.uint64)
    for number, (_, occupied_here) in zip(numbers, found, strict=True):
        occupied[number] |= occupied_here
    return Columns(keys, occupied, numbers, column, cell, parts)


def _columns_of(
    points: NDArray[np.float64],
    low: NDArray[np.float64],
    inverse: float,
    strides: NDArray[np.int64],
    column: NDArray[np.uint32],
    cell_of: NDArray[np.uint8],
) -> tuple[NDArray[np.int64], NDArray[np.uint64]]:
    """Keys of the occupied columns and their occupied cells; fills in the column (place in the keys) and the cell of every point."""
    slot_key, slot_column = np.full(FIRST_SLOTS, FREE), np.zeros(FIRST_SLOTS, dtype=np.uint32)
    done = columns = 0
    occupied = np.zeros(FIRST_SLOTS // 2, dtype=np.uint64)
    while True:
        done, columns = _assign(points, low, inverse, strides, done, columns, slot_key, slot_column, column, cell_of, occupied)
        taken = slot_key != FREE
        keys, places = slot_key[taken], slot_column[taken]
        if done == len(points):
            break
        slot_key, slot_column = np.full(4 * len(slot_key), FREE), np.zeros(4 * len(slot_key), dtype=np.uint32)
        _insert(keys, places, slot_key, slot_column)
        occupied = np.concatenate([occupied, np.zeros(3 * len(occupied), dtype=np.uint64)])
    by_column = np.zeros(columns, dtype=np.int64)
    by_column[places] = keys
    return by_column, occupied[:columns]


def _union(parts: list[NDArray[np.int64]]) -> tuple[NDArray[np.int64], list[NDArray[np.int64]]]:
    """Distinct keys in ascending order and the place of each part's keys in them."""
    together = np.concatenate(parts)
    order = np.argsort(together)
    ordered = together[order]
    new = np.append(True, ordered[1:] != ordered[:-1])
    place = np.zeros(len(together), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return ordered[new], np.split(place, np.cumsum([len(part) for part in parts])[:-1])


@inlined
def ones(word):  # type: ignore[no-untyped-def]
    """Number of bits that are set."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (word * np.uint64(0x0101010101010101)) >> np.uint64(56)


@compiled(_points, _f64, types.float64, _i64, types.int64, types.int64, _i64, _u32, _u32, _u8, _u64)
def _assign(points, low, inverse, strides, start, columns, slot_key, slot_column, column, cell_of, occupied):  # type: ignore[no-untyped-def]
    """Number the columns in order of appearance until half of the slots are taken; returns the points done and the columns found."""
    flat = points.shape[1] == 2
    wrap = np.uint64(len(slot_key) - 1)
    shift = np.uint64(64) - ones(wrap)
    x0, y0, z0 = low[0], low[1], low[2]
    along_x, along_y = strides[0], strides[1]
    for i in range(start, len(points)):
        x = np.int64((points[i, 0] - x0) * inverse) + 1
        y = np.int64((points[i, 1] - y0) * inverse) + 1
        z = 0 if flat else np.int64((points[i, 2] - z0) * inverse)
        key = x * along_x + y * along_y + (z >> 6) + 1
        slot = (np.uint64(key) * HASH) >> shift
        taken = slot_key[slot]
        while taken != key and taken != FREE:
            slot = (slot + ONE) & wrap
            taken = slot_key[slot]
        if taken == FREE:
            if columns == len(occupied):
                return i, columns
            slot_key[slot] = key
            slot_column[slot] = columns
            columns += 1
        b = slot_column[slot]
        cell = np.uint8(z & 63)
        occupied[b] |= ONE << np.uint64(cell)
        column[i] = b
        cell_of[i] = cell
    return len(points), columns


@compiled(_i64, _u32, _i64, _u32)
def _insert(keys, columns, slot_key, slot_column):  # type: ignore[no-untyped-def]
    """Put keys that are all different into free slots."""
    wrap = np.uint64(len(slot_key) - 1)
    shift = np.uint64(64) - ones(wrap)
    for i in range(len(keys)):
        slot = (np.uint64(keys[i]) * HASH) >> shift
        while slot_key[slot] != FREE:
            slot = (slot + ONE) & wrap
        slot_key[slot] = keys[i]
        slot_column[slot] = columns[i]
