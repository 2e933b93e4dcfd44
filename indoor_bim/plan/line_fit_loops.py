"""One line placed on the points along it: the compiled inner loops of `line_fit.fit_to_points`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

TUKEY = 4.685
"""Tukey's constant: 95 % efficiency where there are no outliers."""
COLUMN = 0.10
LAYERS = 10
"""Cells of a face: width in metres, and number along the height."""
DEPTH = 0.0025
"""Points of a cell that are this close across the line are taken together, metres."""
FULL = 4.0
"""Points of a cell beyond which it hardly gains weight."""
MICROMETRE = 1e-6
ROUNDS = 12
BINS = 256

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_ranges = types.Array(types.int64, 2, "C", readonly=True)
_floats = types.Array(types.float64, 1, "C")


@compiled(_floats, _floats, types.int64, types.float64)
def weighted_median(values, weights, count, limit):  # type: ignore[no-untyped-def]
    """Weighted median of the first `count` values from 0 to the limit: only those of the bin that it lies in are sorted."""
    in_bin = np.zeros(BINS)
    for i in range(count):
        in_bin[min(int(values[i] / limit * BINS), BINS - 1)] += weights[i]
    half = 0.0
    for k in range(BINS):
        half += in_bin[k] / 2
    middle, before = 0, 0.0
    while middle < BINS - 1 and before + in_bin[middle] < half:
        before += in_bin[middle]
        middle += 1
    own, own_weights, number = np.zeros(count), np.zeros(count), 0
    for i in range(count):
        if min(int(values[i] / limit * BINS), BINS - 1) == middle:
            own[number], own_weights[number] = values[i], weights[i]
            number += 1
    gap = number // 2
    while gap > 0:
        for i in range(gap, number):
            value, weight, k = own[i], own_weights[i], i
            while k >= gap and own[k - gap] > value:
                own[k], own_weights[k] = own[k - gap], own_weights[k - gap]
                k -= gap
            own[k], own_weights[k] = value, weight
        gap //= 2
    for i in range(number):
        before += own_weights[i]
        if before >= half:
            return own[i]
    return own[number - 1]


@compiled(_floats, _floats, _floats, types.float64, types.float64, types.bool_)
def robust_line(x, y, share, reach, finest, turn):  # type: ignore[no-untyped-def]
    """Level and slope of the line y = level + slope x by Tukey's weights, and whether there is one."""
    level, slope, width, most = 0.0, 0.0, reach, 0.0
    for i in range(len(share)):
        most += share[i]
    near, near_share = np.zeros(len(x)), np.zeros(len(x))
    for _ in range(ROUNDS):
        inner = 0
        for i in range(len(x)):
            residual = abs(y[i] - level - slope * x[i])
            if residual < width:
                near[inner], near_share[inner] = residual, share[i]
                inner += 1
        scale = 1.4826 * weighted_median(near, near_share, inner, width) if inner else reach
        width = min(max(TUKEY * scale, TUKEY * finest), reach)
        total = mx = my = 0.0
        for i in range(len(x)):
            residual = (y[i] - level - slope * x[i]) / width
            weight = share[i] * max(1 - residual * residual, 0.0) ** 2
            total += weight
            mx += weight * x[i]
            my += weight * y[i]
        if total < 0.2 * most:
            return 0.0, 0.0, False
        mx, my = mx / total, my / total
        if turn:
            xx = xy = 0.0
            for i in range(len(x)):
                residual = (y[i] - level - slope * x[i]) / width
                weight = share[i] * max(1 - residual * residual, 0.0) ** 2
                xx += weight * (x[i] - mx) ** 2
                xy += weight * (x[i] - mx) * (y[i] - my)
            slope = xy / max(xx, 1e-9)
        before, level = level, my - slope * mx
        if abs(level - before) < MICROMETRE:
            break
    return level, slope, True


@compiled(
    *(_points, _values, _points, _ranges, _values, types.float64, types.float64, types.float64),
    *(types.float64, types.float64, types.bool_),
)
def fit_line(xy, rise, sensor, ranges, d, start, offset, length, reach, finest, turn):  # type: ignore[no-untyped-def]
    """Level and slope of the line through the points that lie along a line and were seen from its left, and whether there is one.

    Sums of whole micrometres make it the same for any order of the points.
    """
    slots = int(np.ceil(2 * reach / DEPTH)) + 1
    cells = (int(length / COLUMN) + 1) * LAYERS
    count, in_cell = np.zeros(cells * slots, np.int64), np.zeros(cells, np.int64)
    sum_x, sum_y = np.zeros(cells * slots), np.zeros(cells * slots)
    filled = taken = 0
    for k in range(len(ranges)):
        for i in range(ranges[k, 0], ranges[k, 1]):
            across = xy[i, 1] * d[0] - xy[i, 0] * d[1] - offset
            if not abs(across) < reach:
                continue
            along = xy[i, 0] * d[0] + xy[i, 1] * d[1] - start
            if not (along > 0 and along < length):
                continue
            if len(sensor) and not sensor[i, 1] * d[0] - sensor[i, 0] * d[1] > offset:
                continue
            cell = int(along / COLUMN) * LAYERS + min(max(int(rise[i] * LAYERS), 0), LAYERS - 1)
            slot = cell * slots + int((across + reach) / DEPTH)
            filled += in_cell[cell] == 0
            taken += count[slot] == 0
            count[slot] += 1
            in_cell[cell] += 1
            sum_x[slot] += np.rint(along / MICROMETRE)
            sum_y[slot] += np.rint(across / MICROMETRE)
    if filled < 5:
        return 0.0, 0.0, False
    x, y, share = np.zeros(taken), np.zeros(taken), np.zeros(taken)
    number = 0
    for slot in range(len(count)):
        if count[slot]:
            x[number], y[number] = sum_x[slot] * MICROMETRE / count[slot], sum_y[slot] * MICROMETRE / count[slot]
            share[number] = count[slot] / (in_cell[slot // slots] + FULL)
            number += 1
    return robust_line(x, y, share, reach, finest, turn)
