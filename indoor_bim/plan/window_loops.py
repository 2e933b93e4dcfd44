"""Means and maxima of square windows of an image: the compiled inner loops of `evidence.local_density`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

_image = types.Array(types.float32, 2, "C")


@inlined
def _mirrored(i, count):  # type: ignore[no-untyped-def]
    """Index that an index outside is reflected to, the border repeated."""
    i = i % (2 * count)
    return i if i < count else 2 * count - 1 - i


@inlined
def _sum_across(one, other, reach, out, other_out):  # type: ignore[no-untyped-def]
    """Sums of the windows along two lines; they are exact, so nothing depends on where they begin."""
    count = len(one)
    here = other_here = 0.0
    for j in range(-reach, reach + 1):
        here, other_here = here + one[_mirrored(j, count)], other_here + other[_mirrored(j, count)]
    for j in range(count):
        out[j], other_out[j] = here, other_here
        gone = j - reach if j >= reach else _mirrored(j - reach, count)
        come = j + reach + 1 if j + reach + 1 < count else _mirrored(j + reach + 1, count)
        here += np.float64(one[come]) - np.float64(one[gone])
        other_here += np.float64(other[come]) - np.float64(other[gone])


@compiled(_image, _image, types.int64, types.float32, _image)
def share_around(image, weight, reach, least, out):  # type: ignore[no-untyped-def]
    """Mean of an image by that of a weight, of `least` at least, in the window up to `reach` around each pixel.

    Means are those of `scipy.ndimage.uniform_filter`: first of columns, then of rows.
    """
    rows, columns = image.shape
    size = 2 * reach + 1
    total, total_weight, across, across_weight = np.zeros(columns), np.zeros(columns), np.zeros(columns), np.zeros(columns)
    line, line_weight = np.zeros(columns, np.float32), np.zeros(columns, np.float32)
    for i in range(-reach, reach + 1):
        k = _mirrored(i, rows)
        for j in range(columns):
            total[j] += image[k, j]
            total_weight[j] += weight[k, j]
    for i in range(rows):
        for j in range(columns):
            line[j], line_weight[j] = total[j] / size, total_weight[j] / size
        gone, come = _mirrored(i - reach, rows), _mirrored(i + reach + 1, rows)
        for j in range(columns):
            total[j] += np.float64(image[come, j]) - np.float64(image[gone, j])
            total_weight[j] += np.float64(weight[come, j]) - np.float64(weight[gone, j])
        _sum_across(line, line_weight, reach, across, across_weight)
        for j in range(columns):
            out[i, j] = np.float32(across[j] / size) / max(np.float32(across_weight[j] / size), least)


@compiled(_image, types.int64, _image)
def largest_around(image, reach, out):  # type: ignore[no-untyped-def]
    """Largest value of the window up to `reach` around each pixel: of two, four, eight rows or columns, then of two such that overlap."""
    rows, columns = image.shape
    size = 2 * reach + 1
    padded = np.zeros((rows + 2 * reach, columns), np.float32)
    for i in range(len(padded)):
        row, inside = padded[i], i >= reach and i < reach + rows
        for j in range(columns):
            row[j] = image[i - reach, j] if inside else -np.inf
    line = np.zeros(columns + 2 * reach, np.float32)
    step = 1
    while 2 * step <= size:
        for i in range(len(padded) - step):
            row, further = padded[i], padded[i + step]
            for j in range(columns):
                row[j] = further[j] if further[j] > row[j] else row[j]
        step *= 2
    rest = size - step
    for i in range(rows):
        first, second = padded[i], padded[i + rest]
        for j in range(columns):
            line[reach + j] = first[j] if first[j] > second[j] else second[j]
        for j in range(reach):
            line[j] = line[reach + columns + j] = -np.inf
        width = 1
        while 2 * width <= size:
            for j in range(len(line) - width):
                line[j] = line[j + width] if line[j + width] > line[j] else line[j]
            width *= 2
        for j in range(columns):
            out[i, j] = line[j] if line[j] > line[j + rest] else line[j + rest]
