"""Points counted and summed voxel by voxel: the compiled inner loops of voxel down-sampling and of thinning.

Points are sorted into tiles of 64 voxels a side first, each as its voxel within the tile and its place within the voxel in whole steps.
The occupied voxels of a tile are bits, whose ranks number them. Sums of steps are whole numbers, so that neither the order of the points
nor the number of threads shows in them.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from indoor_bim.cloud.hash_slots import FOLD, FREE, HASH, HIGH, ONE, slot_of
from indoor_bim.cloud.tiles import BEGIN, CHAIN_TYPES, COUNT, END, FIRST_RUN, LONGEST_RUN, NEXT, SHARED, load, most_points, sort_into_tiles
from indoor_bim.compiled import compiled, inlined
from indoor_bim.ordering import order_of
from indoor_bim.threads import even_slices, in_threads, threads_for

RESOLUTION = 2.0**32
TILE_BITS = 6

_LAST = (1 << TILE_BITS) - 1
_points = types.Array(types.float64, 2, "C", readonly=True)
_floats, _keys, _u32 = (types.Array(kind, 1, "C") for kind in (types.float64, types.int64, types.uint32))
_sums, _means, _records = (types.Array(kind, 2, "C") for kind in (types.int64, types.float64, types.uint64))
_grid = (_floats, types.float64, _floats, types.boolean, _keys)  # low corner, unit, sides in units, whether rounded to units, first voxel


def sum_voxels(
    points: NDArray[np.float64], *, low: NDArray[np.float64], voxel_size: float, size: NDArray[np.int64], threads: int | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Keys, numbers of points and means of the occupied voxels, by ascending key.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        Finite points.
    low : (2 or 3,) float64
        Lower corner of the grid.
    voxel_size : float
        Edge of a voxel, same unit.
    size : (2 or 3,) int64
        Number of voxels along each axis.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    keys : (k,) int64
        Number of the voxel in lexicographic order of the indices.
    count : (k,) int64
        Number of points.
    mean : (k, 2 or 3) float64
        Mean of the points.
    """
    flat = points.shape[1] == 2
    low, size = np.append(low, [0.0] * flat), np.append(size, np.ones(int(flat), dtype=np.int64))
    keys, count, mean = _sums_by_voxel(points, (low, voxel_size, np.ones(3), False, np.zeros(3, dtype=np.int64)), size, threads)
    return keys, count, np.ascontiguousarray(mean[:, : points.shape[1]])


def sum_boxes(
    points: NDArray[np.float64],
    *,
    unit: float,
    sides: NDArray[np.float64],
    first: NDArray[np.int64],
    size: NDArray[np.int64],
    threads: int | None = None,
) -> NDArray[np.float64]:
    """Means of the points in the occupied boxes of a grid that is fixed in space, in whole units, by ascending key.

    Parameters
    ----------
    points : (n, 3) float64
        Finite points; they are rounded to whole units first.
    unit : float
        Step of the coordinates.
    sides : (3,) float64
        Sides of the boxes, whole numbers of units.
    first : (3,) int64
        Smallest index of a box along each axis.
    size : (3,) int64
        Number of boxes along each axis.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    (k, 3) float64
    """
    return _sums_by_voxel(points, (np.zeros(3), unit, sides, True, first), size, threads)[2]


def _sums_by_voxel(
    points: NDArray[np.float64], grid: tuple[object, ...], size: NDArray[np.int64], threads: int | None
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    points = np.ascontiguousarray(points)
    threads = threads_for(len(points)) if threads is None else threads
    strides, tile_strides = strides_of(size), strides_of((size + _LAST) >> TILE_BITS)
    tiles = sort_into_tiles(points, _sort, (*grid, tile_strides), threads=threads)
    if tiles is None:
        raise AssertionError("points suit every grid")

    def add(part: slice) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        chains = tiles.first_chain[part.start : part.stop + 1]
        most = int(tiles.count[chains[0] : chains[-1]].sum())
        keys, count, mean = np.zeros(most, dtype=np.int64), np.zeros(most, dtype=np.int64), np.zeros((most, 3))
        voxels = _add(
            tiles.keys[part], tile_strides, chains, tiles.first_run, tiles.count, tiles.records, *grid, strides, keys, count, mean
        )
        return keys[:voxels], count[:voxels], mean[:voxels]

    shares = in_threads(add, tiles.shares(threads), threads=threads)
    keys, count, mean = (np.concatenate([share[k] for share in shares]) for k in range(3))
    order = _order_by_slab(keys, strides[0] << TILE_BITS, threads)
    ordered = np.zeros_like(mean)
    in_threads(
        lambda part: mean.take(order[part], axis=0, out=ordered[part], mode="clip"), even_slices(len(order), threads), threads=threads
    )
    return keys.take(order), count.take(order), ordered


def _order_by_slab(keys: NDArray[np.int64], slab: int, threads: int) -> NDArray[np.int64]:
    """Rows of keys in ascending order; multiples of the slab, that of a column of tiles, already ascend."""
    number, order = keys // slab, np.zeros(len(keys), dtype=np.int64)
    edges = [*np.flatnonzero(np.diff(number, prepend=-1)).tolist(), len(keys)]

    def sort(part: slice) -> None:
        order[part] = order_of(keys[part] - number[part.start] * slab) + part.start

    in_threads(sort, [slice(a, b) for a, b in pairwise(edges)], threads=threads)
    return order


def strides_of(size: ArrayLike) -> NDArray[np.int64]:
    """Difference of the keys of voxels side by side along each axis, for grids of a size (d,).

    Examples
    --------
    >>> strides_of([5, 4, 3]).tolist()
    [12, 3, 1]
    """
    return np.append(np.cumprod(np.asarray(size, dtype=np.int64)[:0:-1])[::-1], 1)


def voxel_of_points(
    points: NDArray[np.float64], *, low: NDArray[np.float64], voxel_size: float, strides: NDArray[np.int64], keys: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Place of each point's voxel among the keys of `sum_voxels`, with the same arguments.

    Returns
    -------
    (n,) int64
    """
    points = np.ascontiguousarray(points)
    slots = 1 << (2 * len(keys) + 512).bit_length()
    taken, place = np.full(slots, FREE), np.zeros((slots, 4), dtype=np.int64)
    _move(keys, np.repeat(np.arange(len(keys))[:, None], 4, axis=1), taken, place)
    voxel = np.zeros(len(points), dtype=np.int64)
    threads = threads_for(len(points))
    in_threads(
        lambda part: _look_up(points[part], low, voxel_size, strides, taken, place, voxel[part]),
        even_slices(len(points), threads),
        threads=threads,
    )
    return voxel


@compiled(_points, types.int64, *_grid, _keys, *CHAIN_TYPES)
def _sort(points, first_row, low, unit, sides, whole, first, along, state, slot_key, slot_tile, keys, chain, records):  # type: ignore[no-untyped-def]
    """Loop for `sort_into_tiles`; records are the steps along x and y, those along z and the voxel in its tile."""
    flat = points.shape[1] == 2
    wrap = np.uint64(len(slot_key) - 1)
    x0, y0, z0, side_x, side_y, side_z = low[0], low[1], low[2], sides[0], sides[1], sides[2]
    tiles, used = state[1], state[2]
    room = len(records) - SHARED * (LONGEST_RUN + 1)
    for i in range(state[0], len(points)):
        if tiles + SHARED > len(keys) or used > room:
            state[0], state[1], state[2] = i, tiles, used
            return True
        x, y, z = (points[i, 0] - x0) / unit, (points[i, 1] - y0) / unit, 0.0 if flat else (points[i, 2] - z0) / unit
        if whole:
            x, y, z = np.rint(x), np.rint(y), np.rint(z)
            column, row, layer = np.int64(np.floor(x / side_x)), np.int64(np.floor(y / side_y)), np.int64(np.floor(z / side_z))
            x, y, z = x - column * side_x, y - row * side_y, z - layer * side_z
            column, row, layer = column - first[0], row - first[1], layer - first[2]
        else:
            column, row, layer = np.int64(x), np.int64(y), np.int64(z)
            x, y, z = (x - column) * RESOLUTION, (y - row) * RESOLUTION, (z - layer) * RESOLUTION
        key = (column >> TILE_BITS) * along[0] + (row >> TILE_BITS) * along[1] + (layer >> TILE_BITS)
        voxel = (column & _LAST) << 2 * TILE_BITS | (row & _LAST) << TILE_BITS | layer & _LAST
        word = np.uint64(key)
        slot = (((word ^ word >> FOLD) * HASH) >> HIGH) & wrap
        there = slot_key[slot]
        while there != key and there != FREE:
            slot = (slot + ONE) & wrap
            there = slot_key[slot]
        if there == FREE:
            slot_key[slot], slot_tile[slot], keys[tiles] = key, tiles, key
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
        records[to, 0], records[to, 1] = np.int64(x) | np.int64(y) << 32, np.int64(z) | voxel << 32
        chain[tile, NEXT] = to + 1
        chain[tile, COUNT] += 1
    state[0], state[1], state[2] = len(points), tiles, used
    return True


@inlined
def _ones(word):  # type: ignore[no-untyped-def]
    """Number of bits that are set."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (word * np.uint64(0x0101010101010101)) >> np.uint64(56)


@compiled(_keys, _keys, _keys, _keys, _keys, _records, *_grid, _keys, _keys, _keys, _means)
def _add(tile_keys, tiles_along, first_chain, first_run, count, records, low, unit, sides, whole, first, along, keys, numbers, means):  # type: ignore[no-untyped-def]
    """Keys, numbers of points and means of the occupied voxels of some tiles; returns how many there are."""
    most = most_points(first_chain, count)
    xs, ys, zs, voxels = np.zeros(most, np.uint32), np.zeros(most, np.uint32), np.zeros(most, np.uint32), np.zeros(most, np.uint32)
    sums = np.zeros((most, 4), np.int64)
    occupied, before = np.zeros(1 << 2 * TILE_BITS, np.uint64), np.zeros(1 << 2 * TILE_BITS, np.uint64)
    last = np.uint32(_LAST)
    line_bits = np.uint32(TILE_BITS)
    done = np.int64(0)
    for tile in range(len(tile_keys)):
        total = load(first_chain[tile : tile + 2], first_run, count, records, xs, ys, zs, voxels)
        low_line, high_line = np.uint32(len(occupied)), np.uint32(0)
        for i in range(total):
            line = voxels[i] >> line_bits
            occupied[line] |= ONE << np.uint64(voxels[i] & last)
            low_line, high_line = min(low_line, line), max(high_line, line)
        found = np.uint64(0)
        for line in range(np.int64(low_line), np.int64(high_line) + 1):
            before[line] = found
            found += _ones(occupied[line])
        for i in range(np.int64(found)):
            sums[i, 0], sums[i, 1], sums[i, 2], sums[i, 3] = 0, 0, 0, 0
        for i in range(total):
            line = voxels[i] >> line_bits
            below = (ONE << np.uint64(voxels[i] & last)) - ONE
            place = before[line] + _ones(occupied[line] & below)
            sums[place, 0] += 1
            sums[place, 1] += np.int64(xs[i])
            sums[place, 2] += np.int64(ys[i])
            sums[place, 3] += np.int64(zs[i])
        column = tile_keys[tile] // tiles_along[0]
        row = (tile_keys[tile] - column * tiles_along[0]) // tiles_along[1]
        layer = tile_keys[tile] - column * tiles_along[0] - row * tiles_along[1]
        for n in range(np.int64(low_line), np.int64(high_line) + 1):
            left = occupied[n]
            occupied[n] = 0
            k = np.int64(before[n])
            while left:
                bit = left & (~left + ONE)
                left ^= bit
                x = np.int64(column << TILE_BITS | n >> TILE_BITS)
                y, z = np.int64(row << TILE_BITS | n & _LAST), np.int64(layer << TILE_BITS | np.int64(_ones(bit - ONE)))
                keys[done], numbers[done] = x * along[0] + y * along[1] + z * along[2], sums[k, 0]
                if whole:
                    x, y, z = x + first[0], y + first[1], z + first[2]
                    means[done, 0] = np.rint((sums[k, 1] + x * np.int64(sides[0]) * sums[k, 0]) / sums[k, 0]) * unit
                    means[done, 1] = np.rint((sums[k, 2] + y * np.int64(sides[1]) * sums[k, 0]) / sums[k, 0]) * unit
                    means[done, 2] = np.rint((sums[k, 3] + z * np.int64(sides[2]) * sums[k, 0]) / sums[k, 0]) * unit
                else:
                    means[done, 0] = low[0] + unit * (x + sums[k, 1] / (RESOLUTION * sums[k, 0]))
                    means[done, 1] = low[1] + unit * (y + sums[k, 2] / (RESOLUTION * sums[k, 0]))
                    means[done, 2] = low[2] + unit * (z + sums[k, 3] / (RESOLUTION * sums[k, 0]))
                k += 1
                done += 1
    return done


@compiled(_keys, _sums, _keys, _sums)
def _move(keys, values, taken, sums):  # type: ignore[no-untyped-def]
    """Put rows under keys that are all different into free slots."""
    for i in range(len(keys)):
        slot = slot_of(keys[i], taken)
        taken[slot] = keys[i]
        for k in range(4):
            sums[slot, k] = values[i, k]


@compiled(_points, _floats, types.float64, _keys, _keys, _sums, _keys)
def _look_up(points, low, voxel_size, strides, taken, place, voxel):  # type: ignore[no-untyped-def]
    for i in range(len(points)):
        key = 0
        for axis in range(points.shape[1]):
            key += np.int64((points[i, axis] - low[axis]) / voxel_size) * strides[axis]
        voxel[i] = place[slot_of(key, taken), 0]
