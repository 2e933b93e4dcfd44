"""Sums and products of coordinates box by box: the compiled inner loops of `box_moments`."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.cloud.hash_slots import FREE, slot_of
from indoor_bim.compiled import compiled
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
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    new = np.flatnonzero(np.append(True, keys[1:] != keys[:-1]))
    return np.add.reduceat(count[order], new), corner[order[new]], np.add.reduceat(sums[order], new)


def _sum_part(
    points: NDArray[np.float64], sides: NDArray[np.float64], first: NDArray[np.int64], strides: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    number = np.zeros(len(points), dtype=np.int64)
    taken, member = np.full(FIRST_SLOTS, FREE), np.zeros(FIRST_SLOTS, dtype=np.int64)
    done = boxes = 0
    while True:
        done, boxes = _number(points, sides, first, strides, done, boxes, taken, member, number)
        if done == len(points):
            break
        keys, places = taken[taken != FREE], member[taken != FREE]
        taken, member = np.full(4 * len(taken), FREE), np.zeros(4 * len(member), dtype=np.int64)
        _insert(keys, places, taken, member)
    count, corner, sums = np.zeros(boxes, dtype=np.int64), np.zeros((boxes, 3), dtype=np.int64), np.zeros((boxes, 9))
    _sum(points, sides, number, count, corner, sums)
    return count, corner, sums


@compiled(_keys, _keys, _keys, _keys)
def _insert(keys, places, taken, member):  # type: ignore[no-untyped-def]
    """Put keys that are all different into free slots."""
    for i in range(len(keys)):
        slot = slot_of(keys[i], taken)
        taken[slot] = keys[i]
        member[slot] = places[i]


@compiled(_points, _floats, _keys, _keys, types.int64, types.int64, _keys, _keys, _keys)
def _number(points, sides, first, strides, start, boxes, taken, member, number):  # type: ignore[no-untyped-def]
    """Number the boxes in order of appearance until half of the slots are taken; returns the points done and the boxes found."""
    for i in range(start, len(points)):
        column = np.int64(np.floor(points[i, 0] / sides[0])) - first[0]
        row = np.int64(np.floor(points[i, 1] / sides[1])) - first[1]
        layer = np.int64(np.floor(points[i, 2] / sides[2])) - first[2]
        key = column * strides[0] + row * strides[1] + layer * strides[2]
        slot = slot_of(key, taken)
        if taken[slot] == FREE:
            if 2 * boxes == len(taken):
                return i, boxes
            taken[slot] = key
            member[slot] = boxes
            boxes += 1
        number[i] = member[slot]
    return len(points), boxes


@compiled(_points, _floats, _keys, _keys, _indices, _table)
def _sum(points, sides, number, count, corner, sums):  # type: ignore[no-untyped-def]
    for i in range(len(points)):
        box = number[i]
        if count[box] == 0:
            for axis in range(3):
                corner[box, axis] = np.int64(np.floor(points[i, axis] / sides[axis]))
        count[box] += 1
        x = points[i, 0] - corner[box, 0] * sides[0]
        y = points[i, 1] - corner[box, 1] * sides[1]
        z = points[i, 2] - corner[box, 2] * sides[2]
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
