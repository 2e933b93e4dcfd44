"""Sums and products of coordinates box by box: the compiled inner loops of `box_moments`."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.cloud.hash_slots import FREE, slot_of
from indoor_bim.compiled import compiled
from indoor_bim.ordering import order_of
from indoor_bim.threads import even_slices, in_threads, threads_for

FIRST_SLOTS = 1 << 14
POINTS_PER_PART, MOST_PARTS = 50_000, 8
"""Parts are summed one by one and then added, as many of them on every machine, so that sums are rounded alike."""

_points = types.Array(types.float64, 2, "C", readonly=True)
_floats, _keys = types.Array(types.float64, 1, "C"), types.Array(types.int64, 1, "C")
_table, _indices = types.Array(types.float64, 2, "C"), types.Array(types.int64, 2, "C")


def sum_products(
    points: NDArray[np.float64], *, sides: NDArray[np.float64], first: NDArray[np.int64], strides: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Occupied boxes by ascending key: numbers of points, indices and sums.

    Parameters
    ----------
    points : (n, 3) float64
        Finite points.
    sides : (3,) float64
        Sides of the boxes.
    first : (3,) int64
        Smallest index of a box along each axis.
    strides : (3,) int64
        Difference of the keys of boxes that lie side by side along each axis.

    Returns
    -------
    count : (m,) int64
        Number of points.
    corner : (m, 3) int64
        Indices of the boxes; times the sides: their corners.
    sums : (m, 9) float64
        Sums of x, y, z, xx, yy, zz, xy, xz and yz from the corner of the box.
    """
    points = np.ascontiguousarray(points)
    parts = even_slices(len(points), max(1, min(len(points) // POINTS_PER_PART, MOST_PARTS)))
    done = in_threads(lambda part: _sum_part(points[part], sides, first, strides), parts, threads=threads_for(len(points)))
    count, corner, sums = (np.concatenate([part[k] for part in done]) for k in range(3))
    keys = (corner - first) @ strides
    order = order_of(keys)
    keys = keys[order]
    new = np.flatnonzero(np.append(True, keys[1:] != keys[:-1]))
    return np.add.reduceat(count[order], new), corner[order[new]], np.add.reduceat(sums[order], new)


def _sum_part(
    points: NDArray[np.float64], sides: NDArray[np.float64], first: NDArray[np.int64], strides: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    taken, member, most = np.full(FIRST_SLOTS, FREE), np.zeros(FIRST_SLOTS, dtype=np.int64), FIRST_SLOTS // 2
    count, corner, sums = np.zeros(most, dtype=np.int64), np.zeros((most, 3), dtype=np.int64), np.zeros((most, 9))
    done = boxes = 0
    while True:
        done, boxes = _sum(points, sides, first, strides, done, boxes, taken, member, count, corner, sums)
        if done == len(points):
            return count[:boxes], corner[:boxes], sums[:boxes]
        keys, places = taken[taken != FREE], member[taken != FREE]
        taken, member = np.full(4 * len(taken), FREE), np.zeros(4 * len(member), dtype=np.int64)
        _insert(keys, places, taken, member)
        count, corner, sums = (np.concatenate([table, *3 * [np.zeros_like(table)]]) for table in (count, corner, sums))


@compiled(_keys, _keys, _keys, _keys)
def _insert(keys, places, taken, member):  # type: ignore[no-untyped-def]
    """Put keys that are all different into free slots."""
    for i in range(len(keys)):
        slot = slot_of(keys[i], taken)
        taken[slot] = keys[i]
        member[slot] = places[i]


@compiled(_points, _floats, _keys, _keys, types.int64, types.int64, _keys, _keys, _keys, _indices, _table)
def _sum(points, sides, first, strides, start, boxes, taken, member, count, corner, sums):  # type: ignore[no-untyped-def]
    """Add points to boxes in order of appearance until there is no room for another; returns the points done and the boxes found."""
    before, box = FREE, 0
    for i in range(start, len(points)):
        column = np.int64(np.floor(points[i, 0] / sides[0]))
        row = np.int64(np.floor(points[i, 1] / sides[1]))
        layer = np.int64(np.floor(points[i, 2] / sides[2]))
        key = (column - first[0]) * strides[0] + (row - first[1]) * strides[1] + (layer - first[2]) * strides[2]
        if key != before:
            slot = slot_of(key, taken)
            if taken[slot] == FREE:
                if boxes == len(count):
                    return i, boxes
                taken[slot], member[slot] = key, boxes
                corner[boxes, 0], corner[boxes, 1], corner[boxes, 2] = column, row, layer
                boxes += 1
            before, box = key, member[slot]
        count[box] += 1
        x, y, z = points[i, 0] - column * sides[0], points[i, 1] - row * sides[1], points[i, 2] - layer * sides[2]
        total = sums[box]
        total[0] += x
        total[1] += y
        total[2] += z
        total[3] += x * x
        total[4] += y * y
        total[5] += z * z
        total[6] += x * y
        total[7] += x * z
        total[8] += y * z
    return len(points), boxes
