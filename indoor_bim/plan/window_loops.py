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


@compiled(_image, types.int64, _image)
def mean_around(image, reach, out):  # type: ignore[no-untyped-def]
    """Mean of the window up to `reach` around each pixel, as `scipy.ndimage.uniform_filter` takes it: first of columns, then of rows."""
    rows, columns = image.shape
    size = 2 * reach + 1
    total = np.zeros(columns)
    means = np.zeros(columns, np.float32)
    for i in range(-reach, reach + 1):
        row = image[_mirrored(i, rows)]
        for j in range(columns):
            total[j] += row[j]
    for i in range(rows):
        for j in range(columns):
            means[j] = total[j] / size
        gone, come = image[_mirrored(i - reach, rows)], image[_mirrored(i + reach + 1, rows)]
        for j in range(columns):
            total[j] += np.float64(come[j]) - np.float64(gone[j])
        here = 0.0
        for j in range(-reach, reach + 1):
            here += means[_mirrored(j, columns)]
        for j in range(columns):
            out[i, j] = here / size
            before = means[j - reach] if j >= reach else means[_mirrored(j - reach, columns)]
            after = means[j + reach + 1] if j + reach + 1 < columns else means[_mirrored(j + reach + 1, columns)]
            here += np.float64(after) - np.float64(before)


@compiled(_image, types.int64, _image)
def largest_around(image, reach, out):  # type: ignore[no-untyped-def]
    """Largest value of the window up to `reach` around each pixel: of two, four, eight rows or columns, then of two such that overlap."""
    rows, columns = image.shape
    size = 2 * reach + 1
    padded = np.full((rows + 2 * reach, columns), -np.inf, np.float32)
    padded[reach : reach + rows] = image
    line = np.full(columns + 2 * reach, -np.inf, np.float32)
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
        line[:reach] = -np.inf
        line[reach + columns :] = -np.inf
        width = 1
        while 2 * width <= size:
            for j in range(len(line) - width):
                line[j] = line[j + width] if line[j + width] > line[j] else line[j]
            width *= 2
        for j in range(columns):
            out[i, j] = line[j] if line[j] > line[j + rest] else line[j + rest]
