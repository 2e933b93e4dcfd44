"""Points on faces, counted column by column of the plan: the compiled inner loops of `face_support.measure`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

MICROMETRE = 1e-6

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_table, _i64 = types.Array(types.float64, 2, "C"), types.Array(types.int64, 1, "C")
_bool = types.Array(types.bool_, 2, "C")


@compiled(_points, _values, _points, types.float64, types.float64, _i64, _table)
def sort_by_column(xy, rise, sensor, low, width, first, ordered):  # type: ignore[no-untyped-def]
    """Rows x, y, rise, sensor x, sensor y in the order of the columns of the plan that the points lie in; `first`: of each column."""
    for i in range(len(xy)):
        first[int((xy[i, 0] - low) / width) + 1] += 1
    for column in range(1, len(first)):
        first[column] += first[column - 1]
    place = first.copy()
    for i in range(len(xy)):
        column = int((xy[i, 0] - low) / width)
        row = ordered[place[column]]
        place[column] += 1
        row[0], row[1], row[2] = xy[i, 0], xy[i, 1], rise[i]
        if len(sensor):
            row[3], row[4] = sensor[i, 0], sensor[i, 1]


@compiled(_points, types.bool_, types.int64, types.int64, _values, _values, _values, types.float64, types.float64, types.float64, _bool)
def points_on_face(rows, sided, start, stop, p, d, n, length, reach, column, hit):  # type: ignore[no-untyped-def]
    """Number of points on a face, the sum of their squared distances in square micrometres, and the cells of it that they hit."""
    count, squares = np.int64(0), np.int64(0)
    columns, layers = hit.shape
    for i in range(start, stop):
        x, y = rows[i, 0] - p[0], rows[i, 1] - p[1]
        across = x * n[0] + y * n[1]
        if not abs(across) < reach:
            continue
        along = x * d[0] + y * d[1]
        if not (along > 0 and along < length):
            continue
        if sided and not (rows[i, 3] - p[0]) * n[0] + (rows[i, 4] - p[1]) * n[1] > 0:
            continue
        count += 1
        squares += np.int64(np.rint(across / MICROMETRE)) ** 2
        hit[min(int(along / column), columns - 1), max(min(int(rows[i, 2] * layers), layers - 1), 0)] = True
    return count, squares
