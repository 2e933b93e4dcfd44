"""Points on and around faces: the compiled inner loops of `face_support.measure` and `beams.without_beams`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

MICROMETRE = 1e-6

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_ranges = types.Array(types.int64, 2, "C", readonly=True)
_table, _flags = types.Array(types.float64, 2, "C"), types.Array(types.bool_, 1, "C")
_image = types.Array(types.boolean, 2, "C", readonly=True)
_bool, _counts = types.Array(types.bool_, 2, "C"), types.Array(types.int64, 2, "C")


@compiled(_points, _values, _points, _ranges, *[_values] * 3, *[types.float64] * 4, _bool, _counts)
def points_on_face(xy, rise, sensor, ranges, p, d, n, length, reach, column, upper, hit, across_counts):  # type: ignore[no-untyped-def]
    """Number of points on a face, the sum of their squared distances in square micrometres, and the cells of it that they hit.

    `across_counts` (stretches along the face, bins across) takes the number of points that are higher than the share `upper` of the room.
    """
    count, squares = np.int64(0), np.int64(0)
    columns, layers = hit.shape
    stretches, bins = across_counts.shape
    for k in range(len(ranges)):
        for i in range(ranges[k, 0], ranges[k, 1]):
            x, y = xy[i, 0] - p[0], xy[i, 1] - p[1]
            across = x * n[0] + y * n[1]
            if not abs(across) < reach:
                continue
            along = x * d[0] + y * d[1]
            if not (along > 0 and along < length):
                continue
            if len(sensor) and not (sensor[i, 0] - p[0]) * n[0] + (sensor[i, 1] - p[1]) * n[1] > 0:
                continue
            count += 1
            squares += np.int64(np.rint(across / MICROMETRE)) ** 2
            hit[min(int(along / column), columns - 1), max(min(int(rise[i] * layers), layers - 1), 0)] = True
            if not rise[i] > upper:
                continue
            stretch = min(int(along / length * stretches), stretches - 1)
            across_counts[stretch, min(int((across + reach) / (2 * reach) * bins), bins - 1)] += 1
    return count, squares


@compiled(_points, _values, _ranges, _values, _values, types.float64, types.float64, types.float64, types.float64, _table)
def middle_points(xy, rise, ranges, p, d, length, depth, low, high, out):  # type: ignore[no-untyped-def]
    """Places along and across a face, and shares of the height, of points around it and between two such shares; returns their number."""
    count = 0
    for k in range(len(ranges)):
        for i in range(ranges[k, 0], ranges[k, 1]):
            if not (rise[i] > low and rise[i] < high):
                continue
            x, y = xy[i, 0] - p[0], xy[i, 1] - p[1]
            along, across = x * d[0] + y * d[1], y * d[0] - x * d[1]
            if abs(across) < depth and along > 0 and along < length:
                out[count, 0], out[count, 1], out[count, 2] = along, across, rise[i]
                count += 1
    return count


@compiled(_image, *[types.float64] * 3, _points, *[_values] * 3, _flags)
def hit_beside(image, x0, y0, cell, spots, left, shifts, depths, hit):  # type: ignore[no-untyped-def]
    """Keep the flags of spots beside which a pixel is hit: shifted along and at some depths to the right."""
    rows, columns = image.shape
    for n in range(len(spots)):
        found = False
        for s in shifts:
            for t in depths:
                x, y = spots[n, 0] + s * left[1] - t * left[0], spots[n, 1] - s * left[0] - t * left[1]
                column, row = int(np.floor((x - x0) / cell)), int(np.floor((y - y0) / cell))
                if row >= 0 and row < rows and column >= 0 and column < columns and image[row, column]:
                    found = True
                    break
            if found:
                break
        hit[n] &= found
