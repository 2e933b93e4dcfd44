"""Points counted and summed voxel by voxel: the compiled inner loops of voxel down-sampling.

Sums are whole numbers of 2**-32 voxel, so neither the order of the points nor the number of threads shows in them. Every thread
looks at all points and takes those of its share of the columns.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.compiled import compiled, inlined
from indoor_bim.threads import even_slices, in_threads, threads_for

FREE = np.int64(-1)
HASH = np.uint64(0x9E3779B97F4A7C15)
ONE = np.uint64(1)
RESOLUTION = 2.0**32

_points = types.Array(types.float64, 2, "C", readonly=True)
_floats, _keys, _numbers = (types.Array(kind, 1, "C") for kind in (types.float64, types.int64, types.uint32))
_sums, _means = types.Array(types.int64, 2, "C"), types.Array(types.float64, 2, "C")


def sum_voxels(
    points: NDArray[np.float64], *, low: NDArray[np.float64], voxel_size: float, strides: NDArray[np.int64], threads: int | None = None
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
    strides : (2 or 3,) int64
        Difference of the keys of voxels that lie side by side along each axis.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    keys : (k,) int64
        Sum of the products of the voxel's indices and the strides.
    count : (k,) int64
        Number of points.
    mean : (k, 2 or 3) float64
        Mean of the points.
    """
    points = np.ascontiguousarray(points)
    threads = threads_for(len(points)) if threads is None else threads
    grid = (low, voxel_size, strides)
    shares = in_threads(lambda part: _share(_add, points, grid, part, threads), range(threads), threads=threads)
    keys, places = _ranked([keys for keys, _, _ in shares])
    count, mean = np.zeros(len(keys), dtype=np.int64), np.zeros((len(keys), points.shape[1]))
    in_threads(lambda k: _mean(*shares[k], places[k], *grid, count, mean), range(threads), threads=threads)
    return keys, count, mean


def sum_boxes(
    points: NDArray[np.float64],
    *,
    unit: float,
    sides: NDArray[np.float64],
    first: NDArray[np.int64],
    strides: NDArray[np.int64],
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
    strides : (3,) int64
        Difference of the keys of boxes that lie side by side along each axis.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    (k, 3) float64
    """
    points = np.ascontiguousarray(points)
    threads = threads_for(len(points)) if threads is None else threads
    grid = (unit, sides, first, strides)
    shares = in_threads(lambda part: _share(_add_whole, points, grid, part, threads), range(threads), threads=threads)
    keys, places = _ranked([keys for keys, _, _ in shares])
    mean = np.zeros((len(keys), 3))
    in_threads(lambda k: _whole_mean(shares[k][1], shares[k][2], places[k], unit, mean), range(threads), threads=threads)
    return mean


def _share(
    add: Any, points: NDArray[np.float64], grid: tuple[Any, ...], part: int, parts: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Keys of one thread's voxels, their slots, and the numbers of points and sums in all slots."""
    slots = 1 << (max(len(points) // (2 * parts), 512)).bit_length()
    taken, sums = np.full(slots, FREE), np.zeros((slots, 4), dtype=np.int64)
    done = used = 0
    while True:
        done, used = add(points, *grid, part, parts, done, used, taken, sums)
        filled = np.flatnonzero(taken != FREE)
        if done == len(points):
            return taken.take(filled), filled, sums
        wider, wider_sums = np.full(2 * len(taken), FREE), np.zeros((2 * len(taken), 4), dtype=np.int64)
        _move(taken.take(filled), sums.take(filled, axis=0), wider, wider_sums)
        taken, sums = wider, wider_sums


def _ranked(parts: list[NDArray[np.int64]]) -> tuple[NDArray[np.int64], list[NDArray[np.int64]]]:
    """All keys in ascending order and the place of each part's keys among them."""
    together = np.concatenate(parts)
    order = np.argsort(together)
    place = np.zeros(len(together), dtype=np.int64)
    place[order] = np.arange(len(together))
    return together.take(order), np.split(place, np.cumsum([len(part) for part in parts])[:-1])


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


@inlined
def slot_of(key, taken):  # type: ignore[no-untyped-def]
    """Slot that holds the key, or the free one where it belongs."""
    wrap = np.uint64(len(taken) - 1)
    slot = ((np.uint64(key) * HASH) >> np.uint64(24)) & wrap
    there = taken[slot]
    while there != key and there != FREE:
        slot = (slot + ONE) & wrap
        there = taken[slot]
    return slot


@compiled(_points, _floats, types.float64, _keys, types.int64, types.int64, types.int64, types.int64, _keys, _sums)
def _add(points, low, voxel_size, strides, part, parts, start, used, taken, sums):  # type: ignore[no-untyped-def]
    """Add points to their voxels until three quarters of the slots are taken; returns the points done and the voxels found."""
    flat = points.shape[1] == 2
    x0, y0, z0 = low[0], low[1], 0.0 if flat else low[2]
    along_x, along_y, along_z = strides[0], strides[1], 0 if flat else strides[2]
    most = len(taken) // 4 * 3
    for i in range(start, len(points)):
        x, y = (points[i, 0] - x0) / voxel_size, (points[i, 1] - y0) / voxel_size
        column, row = np.int64(x), np.int64(y)
        if parts > 1:
            tile = (np.uint64(column) >> np.uint64(4)) * np.uint64(0xC2B2AE3D27D4EB4F) + (np.uint64(row) >> np.uint64(4)) * HASH
            if ((tile >> np.uint64(32)) * np.uint64(parts)) >> np.uint64(32) != np.uint64(part):
                continue
        z = 0.0 if flat else (points[i, 2] - z0) / voxel_size
        layer = np.int64(z)
        key = column * along_x + row * along_y + layer * along_z
        slot = slot_of(key, taken)
        if taken[slot] == FREE:
            if used == most:
                return i, used
            taken[slot] = key
            used += 1
        sums[slot, 0] += 1
        sums[slot, 1] += np.int64(np.rint((x - column) * RESOLUTION))
        sums[slot, 2] += np.int64(np.rint((y - row) * RESOLUTION))
        sums[slot, 3] += np.int64(np.rint((z - layer) * RESOLUTION))
    return len(points), used


@compiled(_points, types.float64, _floats, _keys, _keys, types.int64, types.int64, types.int64, types.int64, _keys, _sums)
def _add_whole(points, unit, sides, first, strides, part, parts, start, used, taken, sums):  # type: ignore[no-untyped-def]
    """As `_add`, for boxes that are whole numbers of units."""
    side_x, side_y, side_z = sides[0], sides[1], sides[2]
    first_x, first_y, first_z = first[0], first[1], first[2]
    along_x, along_y, along_z = strides[0], strides[1], strides[2]
    most = len(taken) // 4 * 3
    for i in range(start, len(points)):
        x, y = np.rint(points[i, 0] / unit), np.rint(points[i, 1] / unit)
        column, row = np.int64(np.floor(x / side_x)) - first_x, np.int64(np.floor(y / side_y)) - first_y
        if parts > 1:
            tile = (np.uint64(column) >> np.uint64(4)) * np.uint64(0xC2B2AE3D27D4EB4F) + (np.uint64(row) >> np.uint64(4)) * HASH
            if ((tile >> np.uint64(32)) * np.uint64(parts)) >> np.uint64(32) != np.uint64(part):
                continue
        z = np.rint(points[i, 2] / unit)
        layer = np.int64(np.floor(z / side_z)) - first_z
        key = column * along_x + row * along_y + layer * along_z
        slot = slot_of(key, taken)
        if taken[slot] == FREE:
            if used == most:
                return i, used
            taken[slot] = key
            used += 1
        sums[slot, 0] += 1
        sums[slot, 1] += np.int64(x)
        sums[slot, 2] += np.int64(y)
        sums[slot, 3] += np.int64(z)
    return len(points), used


@compiled(_keys, _sums, _keys, types.float64, _means)
def _whole_mean(slots, sums, places, unit, mean):  # type: ignore[no-untyped-def]
    for i in range(len(slots)):
        total = sums[slots[i]]
        for axis in range(3):
            mean[places[i], axis] = np.rint(total[1 + axis] / total[0]) * unit


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


@compiled(_keys, _keys, _sums, _keys, _floats, types.float64, _keys, _keys, _means)
def _mean(keys, slots, sums, places, low, voxel_size, strides, count, mean):  # type: ignore[no-untyped-def]
    for i in range(len(keys)):
        key, total, place = keys[i], sums[slots[i]], places[i]
        count[place] = total[0]
        for axis in range(mean.shape[1]):
            cell = key // strides[axis]
            key -= cell * strides[axis]
            mean[place, axis] = low[axis] + voxel_size * (cell + total[1 + axis] / (RESOLUTION * total[0]))
