"""Neighbours within a radius, counted cell by cell: the compiled inner loops of the radius filter.

Cells are cubes whose diagonal is just shorter than the radius, so that all points of a cell are neighbours of each other and all
neighbours of a point lie at most two cells away. Sixty-four cells make a block; a block keeps which of its cells are occupied in the
bits of one integer, so that only occupied cells take memory.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.compiled import compiled, inlined
from indoor_bim.threads import even_slices, in_threads, threads_for

FREE = np.int64(-1)
FIRST_SLOTS = 1024
HASH = np.uint64(0x9E3779B97F4A7C15)
ONE = np.uint64(1)

_points = types.Array(types.float64, 2, "C", readonly=True)
_i64, _u64, _u32, _u8, _bool = (types.Array(kind, 1, "C") for kind in (types.int64, types.uint64, types.uint32, types.uint8, types.bool_))
_f64 = types.Array(types.float64, 1, "C")
_xyz = types.Array(types.float64, 2, "C")
_decision = (types.int64, types.float64)
_block_table, _mask_table = types.Array(types.uint8, 2, "C"), types.Array(types.uint64, 2, "C")


def count_within(
    points: NDArray[np.float64],
    *,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    more_than: int,
    radius: float,
    rounding: float,
    threads: int | None = None,
) -> NDArray[np.bool_]:
    """Points with more than a number of points, themselves included, strictly within a radius.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        Finite points, fewer than 2**32.
    low, high : (2 or 3,) float64
        Their smallest and largest coordinates.
    more_than : int
        Number that has to be exceeded.
    radius : float
        Radius, same unit.
    rounding : float
        Share by which cells are made smaller, against rounding; at most 0.01.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    (n,) bool
    """
    threads = threads_for(len(points)) if threads is None else threads
    low, high = (np.append(corner, [0.0] * (3 - len(corner))) for corner in (low, high))
    inverse = np.sqrt(points.shape[1]) / (radius * (1 - rounding))
    # an empty block on every side, so that a neighbour's key never wraps around
    size = ((high - low) * inverse).astype(np.int64) // 4 + 3
    strides = np.array([size[1] * size[2], size[2], 1])
    cells = _cells_of(np.ascontiguousarray(points), low=low, inverse=inverse, strides=strides, threads=threads)
    keep = np.zeros(len(points), dtype=np.bool_)
    in_threads(
        lambda part: _search(*cells, strides, *_NEAR, *_FAR, more_than, radius * radius, part.start, part.stop, keep),
        even_slices(len(cells.keys), 1 if threads == 1 else 8 * threads),
        threads=threads,
    )
    return keep


class _Cells(NamedTuple):
    """Points sorted into cells.

    Parameters
    ----------
    points : (n, 4) float64
        Points in the order of their cells; the fourth column is their place in the input.
    starts : (c + 1,) uint32
        First point of each occupied cell.
    keys : (b,) int64
        Occupied blocks, ascending.
    occupied : (b,) uint64
        Their occupied cells.
    first_cell : (b + 1,) uint32
        First cell of each block.
    """

    points: NDArray[np.float64]
    starts: NDArray[np.uint32]
    keys: NDArray[np.int64]
    occupied: NDArray[np.uint64]
    first_cell: NDArray[np.uint32]


def _cells_of(points: NDArray[np.float64], *, low: NDArray[np.float64], inverse: float, strides: NDArray[np.int64], threads: int) -> _Cells:
    parts, every = even_slices(len(points), threads), range(threads)
    cell, in_block = np.zeros(len(points), dtype=np.uint32), np.zeros(len(points), dtype=np.uint8)
    found = in_threads(lambda part: _blocks_of(points[part], low, inverse, strides, cell[part], in_block[part]), parts, threads=threads)
    keys, numbers = _union([keys for keys, _ in found])
    occupied = np.zeros(len(keys), dtype=np.uint64)
    for number, (_, occupied_here) in zip(numbers, found, strict=True):
        occupied[number] |= occupied_here
    first_cell = np.append(np.uint32(0), np.cumsum(np.bitwise_count(occupied), dtype=np.uint32))
    counts = np.zeros((threads, int(first_cell[-1])), dtype=np.uint32)

    def count(k: int) -> None:
        _count(cell[parts[k]], in_block[parts[k]], occupied[numbers[k]], first_cell[numbers[k]], counts[k])

    in_threads(count, every, threads=threads)
    place = np.cumsum(counts, axis=0, dtype=np.uint32)
    starts = np.append(np.uint32(0), np.cumsum(place[-1], dtype=np.uint32))
    place += starts[:-1] - counts
    ordered = np.zeros((len(points), 4))
    in_threads(lambda k: _sort(points[parts[k]], cell[parts[k]], place[k], parts[k].start, ordered), every, threads=threads)
    return _Cells(ordered, starts, keys, occupied, first_cell)


def _blocks_of(
    points: NDArray[np.float64],
    low: NDArray[np.float64],
    inverse: float,
    strides: NDArray[np.int64],
    block: NDArray[np.uint32],
    in_block: NDArray[np.uint8],
) -> tuple[NDArray[np.int64], NDArray[np.uint64]]:
    """Keys of the occupied blocks and their occupied cells; fills in the block (place in the keys) and the cell of every point."""
    slot_key, slot_block = np.full(FIRST_SLOTS, FREE), np.zeros(FIRST_SLOTS, dtype=np.uint32)
    done = blocks = 0
    occupied = np.zeros(FIRST_SLOTS // 2, dtype=np.uint64)
    while True:
        done, blocks = _assign(points, low, inverse, strides, done, blocks, slot_key, slot_block, block, in_block, occupied)
        taken = slot_key != FREE
        keys, places = slot_key[taken], slot_block[taken]
        if done == len(points):
            break
        slot_key, slot_block = np.full(4 * len(slot_key), FREE), np.zeros(4 * len(slot_key), dtype=np.uint32)
        _insert(keys, places, slot_key, slot_block)
        occupied = np.concatenate([occupied, np.zeros(3 * len(occupied), dtype=np.uint64)])
    by_block = np.zeros(blocks, dtype=np.int64)
    by_block[places] = keys
    return by_block, occupied[:blocks]


def _union(parts: list[NDArray[np.int64]]) -> tuple[NDArray[np.int64], list[NDArray[np.int64]]]:
    """Distinct keys in ascending order and the place of each part's keys in them."""
    together = np.concatenate(parts)
    order = np.argsort(together)
    ordered = together[order]
    new = np.append(True, ordered[1:] != ordered[:-1])
    place = np.zeros(len(together), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return ordered[new], np.split(place, np.cumsum([len(part) for part in parts])[:-1])


def _cells_within(reach: int) -> NDArray[np.uint64]:
    """Cells at most `reach` cells away along each axis, as bits, for each cell of a block (64) and each block around it (27)."""
    masks = np.zeros((64, 27), dtype=np.uint64)
    steps = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    for cell in range(64):
        x, y, z = (offsets + np.array([cell >> 4, cell >> 2 & 3, cell & 3])).T
        block = ((x >> 2) + 1) * 9 + ((y >> 2) + 1) * 3 + (z >> 2) + 1
        np.bitwise_or.at(masks, (cell, block), ONE << ((x & 3) << 4 | (y & 3) << 2 | z & 3).astype(np.uint64))
    masks[np.arange(64), 13] &= ~(ONE << np.arange(64, dtype=np.uint64))
    return masks


def _by_block(masks: NDArray[np.uint64]) -> tuple[NDArray[np.uint8], NDArray[np.uint64]]:
    """The blocks (64, 9) that hold any of the cells, the own one first, and the cells (64, 9) in them; 0 where there are no more."""
    blocks, cells = np.zeros((64, 9), dtype=np.uint8), np.zeros((64, 9), dtype=np.uint64)
    for cell, row in enumerate(masks):
        held = np.flatnonzero(row)
        held = held[np.argsort(held != 13, kind="stable")]
        blocks[cell, : len(held)], cells[cell, : len(held)] = held, row[held]
    return blocks, cells


_NEAR = _by_block(_cells_within(1))
_FAR = _by_block(_cells_within(2) & ~_cells_within(1))


@inlined
def _ones(word):  # type: ignore[no-untyped-def]
    """Number of bits that are set."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (word * np.uint64(0x0101010101010101)) >> np.uint64(56)


@compiled(_points, _f64, types.float64, _i64, types.int64, types.int64, _i64, _u32, _u32, _u8, _u64)
def _assign(points, low, inverse, strides, start, blocks, slot_key, slot_block, block, in_block, occupied):  # type: ignore[no-untyped-def]
    """Number the blocks in order of appearance until half of the slots are taken; returns the points done and the blocks found."""
    flat = points.shape[1] == 2
    wrap = np.uint64(len(slot_key) - 1)
    shift = np.uint64(64) - _ones(wrap)
    x0, y0, z0 = low[0], low[1], low[2]
    along_x, along_y = strides[0], strides[1]
    for i in range(start, len(points)):
        x = np.int64((points[i, 0] - x0) * inverse) + 4
        y = np.int64((points[i, 1] - y0) * inverse) + 4
        z = 4 if flat else np.int64((points[i, 2] - z0) * inverse) + 4
        key = (x >> 2) * along_x + (y >> 2) * along_y + (z >> 2)
        slot = (np.uint64(key) * HASH) >> shift
        taken = slot_key[slot]
        while taken != key and taken != FREE:
            slot = (slot + ONE) & wrap
            taken = slot_key[slot]
        if taken == FREE:
            if blocks == len(occupied):
                return i, blocks
            slot_key[slot] = key
            slot_block[slot] = blocks
            blocks += 1
        b = slot_block[slot]
        cell = np.uint8((x & 3) << 4 | (y & 3) << 2 | z & 3)
        occupied[b] |= ONE << np.uint64(cell)
        block[i] = b
        in_block[i] = cell
    return len(points), blocks


@compiled(_i64, _u32, _i64, _u32)
def _insert(keys, blocks, slot_key, slot_block):  # type: ignore[no-untyped-def]
    """Put keys that are all different into free slots."""
    wrap = np.uint64(len(slot_key) - 1)
    shift = np.uint64(64) - _ones(wrap)
    for i in range(len(keys)):
        slot = (np.uint64(keys[i]) * HASH) >> shift
        while slot_key[slot] != FREE:
            slot = (slot + ONE) & wrap
        slot_key[slot] = keys[i]
        slot_block[slot] = blocks[i]


@compiled(_u32, _u8, _u64, _u32, _u32)
def _count(block, in_block, occupied, first_cell, counts):  # type: ignore[no-untyped-def]
    """Turn the block of each point into its cell and count the points of each cell."""
    for i in range(len(block)):
        b = block[i]
        cell = np.uint64(first_cell[b]) + _ones(occupied[b] & ((ONE << np.uint64(in_block[i])) - ONE))
        counts[cell] += np.uint32(1)
        block[i] = cell


@compiled(_points, _u32, _u32, types.int64, _xyz)
def _sort(points, cell, place, first, ordered):  # type: ignore[no-untyped-def]
    """Put points at the next free place of their cell."""
    flat = points.shape[1] == 2
    for i in range(len(cell)):
        to = place[cell[i]]
        place[cell[i]] = to + np.uint32(1)
        ordered[to, 0] = points[i, 0]
        ordered[to, 1] = points[i, 1]
        if not flat:
            ordered[to, 2] = points[i, 2]
        ordered[to, 3] = first + i


@compiled(
    _xyz, _u32, _i64, _u64, _u32, _i64, _block_table, _mask_table, _block_table, _mask_table, *_decision, types.int64, types.int64, _bool
)
def _search(  # type: ignore[no-untyped-def]
    points, starts, keys, occupied, first_cell, strides, near_block, near_cells, far_block, far_cells, more_than, square, low, high, keep
):
    """Decide on the points of the blocks from `low` to `high`: by their cell where it is full, else by distance to those around."""
    around = np.full(27, FREE)
    column = np.zeros(9, np.int64)
    for k in range(9):
        column[k] = np.searchsorted(keys, keys[low] + (k // 3 - 1) * strides[0] + (k % 3 - 1) * strides[1] - 1)
    begin, end = np.zeros(128, np.int64), np.zeros(128, np.int64)
    within = np.zeros(more_than + 1, np.int64)
    for b in range(low, high):
        looked_around = False
        cell = np.int64(first_cell[b])
        left = occupied[b]
        while left:
            bit = left & (~left + ONE)
            left ^= bit
            first, last = np.int64(starts[cell]), np.int64(starts[cell + 1])
            cell += 1
            if last - first > more_than:
                for j in range(first, last):
                    keep[np.int64(points[j, 3])] = True
                continue
            if not looked_around:
                looked_around = True
                for k in range(9):
                    want = keys[b] + (k // 3 - 1) * strides[0] + (k % 3 - 1) * strides[1] - 1
                    j = column[k]
                    while j < len(keys) and keys[j] < want:
                        j += 1
                    column[k] = j
                    for step in range(3):
                        around[3 * k + step] = FREE
                        if j < len(keys) and keys[j] == want + step:
                            around[3 * k + step] = j
                            j += 1
            place = _ones(bit - ONE)
            for j in range(last - first):
                within[j] = last - first
            for ring in range(2):
                ranges = candidates = 0
                for h in range(8):
                    cells = near_cells[place, h] if ring == 0 else far_cells[place, h]
                    if cells == 0:
                        break
                    other = around[near_block[place, h] if ring == 0 else far_block[place, h]]
                    if other == FREE:
                        continue
                    hit = occupied[other] & cells
                    while hit:
                        lowest = hit & (~hit + ONE)
                        run = hit & ~(hit + lowest)
                        hit ^= run
                        c = np.uint64(first_cell[other]) + _ones(occupied[other] & (lowest - ONE))
                        begin[ranges], end[ranges] = starts[c], starts[c + _ones(run)]
                        candidates += end[ranges] - begin[ranges]
                        ranges += 1
                undecided = 0
                for j in range(last - first):
                    count = within[j]
                    if count > more_than:
                        continue
                    if ring == 0 or count + candidates > more_than:
                        x, y, z = points[first + j, 0], points[first + j, 1], points[first + j, 2]
                        for k in range(ranges):
                            for i in range(begin[k], end[k]):
                                dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
                                count += dx * dx + dy * dy + dz * dz < square
                            if count > more_than:
                                break
                        within[j] = count
                    undecided += count <= more_than
                if undecided == 0:
                    break
            for j in range(last - first):
                keep[np.int64(points[first + j, 3])] = within[j] > more_than
