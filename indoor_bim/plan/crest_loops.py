"""A robust line through the strips around a crest: the compiled inner loop of `face_lines`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined
from indoor_bim.plan.block_image import BLOCK, BLOCK_BITS
from indoor_bim.plan.strip_loops import ones

WINDOW = 6
"""Strips on either side of a crest that take part."""
ROUNDS = 8
LONG = 6
"""Crests over more strips may be askew."""

_slot, _words = types.Array(types.int32, 2, "C", readonly=True), types.Array(types.uint32, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)


@inlined
def _median(values):  # type: ignore[no-untyped-def]
    """Median of values most of which are in order."""
    ordered = np.zeros(len(values))
    for i in range(len(values)):
        k = i
        while k > 0 and ordered[k - 1] > values[i]:
            ordered[k] = ordered[k - 1]
            k -= 1
        ordered[k] = values[i]
    return (ordered[(len(values) - 1) // 2] + ordered[len(values) // 2]) / 2


@compiled(_slot, _words, types.int64, types.int64, _values, types.uint32, types.float64, types.float64)
def fit_crest(slot, words, columns, first, path, band, along, across):  # type: ignore[no-untyped-def]
    """Line y = level + slope (x - middle) by Tukey's weights, in metres from the corner of the strips, and the scatter across it.

    At first the layers of the band count, which stand for walls alone, then all layers of the column. The crest runs through strip
    `path[i]` of row `first` + i. Returns whether there are enough layers, slope, middle, level and scatter.
    """
    count, size = len(path), 2 * WINDOW + 1
    upper, whole, y = np.zeros((count, size)), np.zeros((count, size)), np.zeros((count, size))
    x = np.zeros(count)
    total = middle = 0.0
    for i in range(count):
        x[i] = (first + i + 0.5) * along
        for k in range(size):
            strip = min(max(int(np.rint(path[i])) + k - WINDOW, 0), columns - 1)
            word = words[slot[first + i, strip >> BLOCK_BITS], strip & (BLOCK - 1)]
            whole[i, k], upper[i, k], y[i, k] = ones(word), ones(word & band), (strip + 0.5) * across
            total += upper[i, k]
            middle += upper[i, k] * x[i]
    if total < 5:
        return False, 0.0, 0.0, 0.0, 0.0
    middle /= total
    slope, level = 0.0, (_median(path) + 0.5) * across
    if count > LONG:
        mean_x = mean_y = xx = xy = 0.0
        for i in range(count):
            mean_x += x[i]
            mean_y += path[i]
        mean_x, mean_y = mean_x / count, (mean_y / count + 0.5) * across
        for i in range(count):
            xx += (x[i] - mean_x) ** 2
            xy += (x[i] - mean_x) * ((path[i] + 0.5) * across - mean_y)
        slope = xy / xx
        level = mean_y + slope * (middle - mean_x)
    weight, width, spread = upper, 0.06, 0.02
    for step in range(ROUNDS):
        if step == ROUNDS // 2:
            weight, width = whole, min(max(3 * spread, 0.02), 0.05)
        total = mean_x = mean_y = squares = inner = inner_squares = 0.0
        for i in range(count):
            for k in range(size):
                residual = y[i, k] - level - slope * (x[i] - middle)
                if abs(residual) < width:
                    w = weight[i, k] * (1 - (residual / width) ** 2) ** 2
                    total += w
                    mean_x += w * x[i]
                    mean_y += w * y[i, k]
                    squares += w * residual**2
                    inner += weight[i, k]
                    inner_squares += weight[i, k] * residual**2
        if total < 1e-9:
            return False, 0.0, 0.0, 0.0, 0.0
        mean_x, mean_y = mean_x / total, mean_y / total
        xx = xy = 0.0
        if count > LONG:
            for i in range(count):
                for k in range(size):
                    residual = y[i, k] - level - slope * (x[i] - middle)
                    if abs(residual) < width:
                        w = weight[i, k] * (1 - (residual / width) ** 2) ** 2
                        xx += w * (x[i] - mean_x) ** 2
                        xy += w * (x[i] - mean_x) * (y[i, k] - mean_y)
        slope = xy / max(xx, 1e-9)
        level = mean_y + slope * (middle - mean_x)
        spread = np.sqrt(squares / total)
        if step < ROUNDS // 2:
            width = min(max(4 * 1.4826 * np.sqrt(inner_squares / max(inner, 1e-9)) / 1.2, 0.015), 0.06)
    return True, slope, middle, level, spread
