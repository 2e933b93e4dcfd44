"""Neighbours within a radius, counted cell by cell: the compiled inner loops of the radius filter.

Cells are cubes whose side is just longer than the radius, so that all neighbours of a point lie in its cell or in one that touches it.
Sixty-four cells above one another make a column, which keeps those that are occupied in the bits of one integer, so that only occupied
cells take memory and three cells above one another are found at once. The points around a cell are looked at some at a time, until
there are enough neighbours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.cloud.grid_columns import FREE, ONE, ones, sort_into_columns
from indoor_bim.compiled import compiled
from indoor_bim.threads import even_slices, in_threads, threads_for

AT_ONCE = 64
"""Points of the cells around that are looked at together."""

_points = types.Array(types.float64, 2, "C", readonly=True)
_i64, _u64, _u32, _u8, _bool = (types.Array(kind, 1, "C") for kind in (types.int64, types.uint64, types.uint32, types.uint8, types.bool_))
_f64 = types.Array(types.float64, 1, "C")
_xyz = types.Array(types.float64, 2, "C")
_decision = (types.int64, types.float64)


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
        Share by which cells are made larger, against rounding; at most 0.01.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    (n,) bool
    """
    threads = threads_for(len(points)) if threads is None else threads
    low, high = (np.append(corner, [0.0] * (3 - len(corner))) for corner in (low, high))
    inverse = 1.0 / (radius * (1 + rounding))
    # an empty column on every side, so that a neighbour's key never wraps around
    size = ((high - low) * inverse).astype(np.int64) // np.array([1, 1, 64]) + 3
    strides = np.array([size[1] * size[2], size[2], 1])
    cells = _cells_of(np.ascontiguousarray(points), low=low, inverse=inverse, strides=strides, threads=threads)
    keep = np.zeros(len(points), dtype=np.bool_)
    in_threads(
        lambda part: _search(*cells, strides, more_than, radius * radius, part.start, part.stop, keep),
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
        Occupied columns, ascending.
    occupied : (b,) uint64
        Their occupied cells.
    first_cell : (b + 1,) uint32
        First cell of each column.
    """

    points: NDArray[np.float64]
    starts: NDArray[np.uint32]
    keys: NDArray[np.int64]
    occupied: NDArray[np.uint64]
    first_cell: NDArray[np.uint32]


def _cells_of(points: NDArray[np.float64], *, low: NDArray[np.float64], inverse: float, strides: NDArray[np.int64], threads: int) -> _Cells:
    columns = sort_into_columns(points, low=low, inverse=inverse, strides=strides, threads=threads)
    every, parts, numbers, cell = range(threads), columns.parts, columns.numbers, columns.column
    first_cell = np.append(np.uint32(0), np.cumsum(np.bitwise_count(columns.occupied), dtype=np.uint32))
    counts = np.zeros((threads, int(first_cell[-1])), dtype=np.uint32)

    def count(k: int) -> None:
        _count(cell[parts[k]], columns.cell[parts[k]], columns.occupied[numbers[k]], first_cell[numbers[k]], counts[k])

    in_threads(count, every, threads=threads)
    place = np.cumsum(counts, axis=0, dtype=np.uint32)
    starts = np.append(np.uint32(0), np.cumsum(place[-1], dtype=np.uint32))
    place += starts[:-1] - counts
    ordered = np.zeros((len(points), 4))
    in_threads(lambda k: _sort(points[parts[k]], cell[parts[k]], place[k], parts[k].start, ordered), every, threads=threads)
    return _Cells(ordered, starts, columns.keys, columns.occupied, first_cell)


@compiled(_u32, _u8, _u64, _u32, _u32)
def _count(column, cell_of, occupied, first_cell, counts):  # type: ignore[no-untyped-def]
    """Turn the column of each point into its cell and count the points of each cell."""
    for i in range(len(column)):
        b = column[i]
        cell = np.uint64(first_cell[b]) + ones(occupied[b] & ((ONE << np.uint64(cell_of[i])) - ONE))
        counts[cell] += np.uint32(1)
        column[i] = cell


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


@compiled(_f64, _f64, _f64, types.int64, types.float64, types.float64, types.float64, types.float64)
def _near_by(xs, ys, zs, count, x, y, z, square):  # type: ignore[no-untyped-def]
    """Number of the first points that are closer to a point than the root of a square."""
    near = 0
    for i in range(count):
        dx, dy, dz = xs[i] - x, ys[i] - y, zs[i] - z
        near += dx * dx + dy * dy + dz * dz < square
    return near


@compiled(_xyz, _u32, _i64, _u64, _u32, _i64, *_decision, types.int64, types.int64, _bool)
def _search(points, starts, keys, occupied, first_cell, strides, more_than, square, low, high, keep):  # type: ignore[no-untyped-def]
    """Decide on the points of the columns from `low` to `high`."""
    around, onward = np.full(27, FREE), np.zeros(9, np.int64)
    for k in range(9):
        onward[k] = np.searchsorted(keys, keys[low] + (k // 3 - 1) * strides[0] + (k % 3 - 1) * strides[1] - 1)
    begin, end = np.zeros(27, np.int64), np.zeros(27, np.int64)
    xs, ys, zs = np.zeros(AT_ONCE), np.zeros(AT_ONCE), np.zeros(AT_ONCE)
    within = np.zeros(1024, np.int64)
    for column in range(low, high):
        for k in range(9):
            want = keys[column] + (k // 3 - 1) * strides[0] + (k % 3 - 1) * strides[1] - 1
            j = onward[k]
            while j < len(keys) and keys[j] < want:
                j += 1
            onward[k] = j
            for step in range(3):
                around[3 * k + step] = FREE
                if j < len(keys) and keys[j] == want + step:
                    around[3 * k + step] = j
                    j += 1
        left = occupied[column]
        cell = np.int64(first_cell[column])
        while left:
            bit = left & (~left + ONE)
            left ^= bit
            first, last = np.int64(starts[cell]), np.int64(starts[cell + 1])
            cell += 1
            window = bit >> ONE | bit | bit << ONE
            ranges = candidates = 0
            for k in range(9):
                other = around[3 * k + 1]
                hit = np.uint64(0) if other == FREE else occupied[other] & window
                if hit:
                    c = np.uint64(first_cell[other]) + ones(occupied[other] & ((hit & (~hit + ONE)) - ONE))
                    begin[ranges], end[ranges] = starts[c], starts[c + ones(hit)]
                    candidates += end[ranges] - begin[ranges]
                    ranges += 1
                other = around[3 * k]
                if bit == ONE and other != FREE and occupied[other] >> np.uint64(63):
                    c = np.uint64(first_cell[other + 1]) - ONE
                    begin[ranges], end[ranges] = starts[c], starts[c + ONE]
                    candidates += end[ranges] - begin[ranges]
                    ranges += 1
                other = around[3 * k + 2]
                if bit >> np.uint64(63) and other != FREE and occupied[other] & ONE:
                    c = np.uint64(first_cell[other])
                    begin[ranges], end[ranges] = starts[c], starts[c + ONE]
                    candidates += end[ranges] - begin[ranges]
                    ranges += 1
            if candidates <= more_than:
                continue
            if len(within) < last - first:
                within = np.zeros(2 * (last - first), np.int64)
            within[: last - first] = 0
            k, i, undecided = 0, begin[0], last - first
            while k < ranges and undecided > 0:
                together = 0
                while k < ranges and together < AT_ONCE:
                    stop = min(end[k], i + AT_ONCE - together)
                    for j in range(i, stop):
                        xs[together], ys[together], zs[together] = points[j, 0], points[j, 1], points[j, 2]
                        together += 1
                    i = stop
                    if i == end[k]:
                        k += 1
                        i = begin[k] if k < ranges else 0
                undecided = np.int64(0)
                for j in range(last - first):
                    if within[j] <= more_than:
                        within[j] += _near_by(
                            xs, ys, zs, together, points[first + j, 0], points[first + j, 1], points[first + j, 2], square
                        )
                        undecided += within[j] <= more_than
            for j in range(last - first):
                keep[np.int64(points[first + j, 3])] = within[j] > more_than
