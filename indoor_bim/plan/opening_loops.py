"""Rays and points at openings, one by one: the compiled inner loops of `traces`, `opening_edges`, `opening_evidence`, `door_leaves`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_float32s = types.Array(types.float32, 1, "A", readonly=True)
_floats, _ints = types.Array(types.float64, 1, "A", readonly=True), types.Array(types.int64, 1, "C")
_fixed = types.Array(types.float64, 1, "C", readonly=True)
_kinds = types.Array(types.uint8, 1, "C")
_f32, _f64 = types.float32, types.float64
FACE, WENT_IN, THROUGH = 1, 2, 4


@compiled(*[_float32s] * 4, *[_f32] * 7, _kinds)
def kinds_of_rays(  # type: ignore[no-untyped-def]
    depth, slant, along_end, up_end, tolerance, steep, through_depth, first, last, low, high, kinds
):
    """Tell of each ray whether it ended on a face (`FACE`), went in (`WENT_IN`), and through (`THROUGH`)."""
    for i in range(len(depth)):
        kinds[i] = 0
        if abs(depth[i]) <= tolerance:
            if along_end[i] > first and along_end[i] < last and up_end[i] > low and up_end[i] < high:
                kinds[i] = FACE
        elif depth[i] > tolerance and slant[i] > steep:
            kinds[i] = WENT_IN
            if depth[i] > through_depth:
                kinds[i] = WENT_IN + THROUGH


@compiled(*[_float32s] * 3, *[_f32] * 5, _ints)
def rays_into(along, up, depth, least, start, end, low, high, rows):  # type: ignore[no-untyped-def]
    """Write the rows of the rays that met the face within a rectangle and ended deeper than `least`; return how many there are."""
    found = 0
    for i in range(len(along)):
        if (depth[i] > least) & (along[i] > start) & (along[i] < end) & (up[i] > low) & (up[i] < high):
            rows[found] = i
            found += 1
    return found


@compiled(_fixed, _fixed, _fixed, *[_f64] * 4)
def count_within(along, up, side, start, end, low, high):  # type: ignore[no-untyped-def]
    """Number of places within a rectangle, from the left and from the right."""
    left = right = 0
    for i in range(len(along)):
        if (along[i] > start) & (along[i] < end) & (up[i] > low) & (up[i] < high):
            if side[i] > 0:
                left += 1
            else:
                right += 1
    return left, right


@compiled(*[_fixed] * 3, *[_f64] * 4, _ints)
def rows_at_edge(across, along, side, low, high, place, window, rows):  # type: ignore[no-untyped-def]
    """Write the rows of what lies within a window of an edge and within its length, those from the left first; return how many of each.

    The rows of those from the right end at the end of `rows`.
    """
    lefts, rights = 0, len(rows)
    for i in range(len(across)):
        if (across[i] > low) & (across[i] < high) & (abs(along[i] - place) < window):
            if side[i] > 0:
                rows[lefts] = i
                lefts += 1
            else:
                rights -= 1
                rows[rights] = i
    return lefts, len(rows) - rights


@compiled(_fixed, _fixed)
def widest_best_gap(low, high):  # type: ignore[no-untyped-def]
    """Ends of the widest interval of thresholds above which fewest of `low`, and below which fewest of `high`, lie; both ascend."""
    a = b = 0
    fewest, best_begin, best_end = len(low) + len(high) + 1, 0.0, 0.0
    begin, open_run = 0.0, False
    while True:
        cut = low[a] if b == len(high) or (a < len(low) and low[a] <= high[b]) else high[b]
        while a < len(low) and low[a] == cut:
            a += 1
        while b < len(high) and high[b] == cut:
            b += 1
        if a == len(low) and b == len(high):
            if fewest > len(low) + len(high):
                return cut, cut
            return best_begin, best_end
        following = low[a] if b == len(high) or (a < len(low) and low[a] <= high[b]) else high[b]
        wrong = len(low) - a + b
        if wrong > fewest:
            open_run = False
            continue
        if wrong < fewest:
            fewest, best_begin, best_end, open_run = wrong, 0.0, -1.0, False
        if not open_run:
            begin, open_run = cut, True
        if best_end < best_begin or following - begin > best_end - best_begin:
            best_begin, best_end = begin, following


@compiled(_fixed, _fixed, _f64, _f64, _fixed, _ints)
def count_close(distance, across, near, far, bounds, counts):  # type: ignore[no-untyped-def]
    """Count what lies close beyond an edge, in equal steps along it."""
    steps = len(counts)
    length = bounds[steps] - bounds[0]
    for i in range(len(distance)):
        if not (distance[i] > near and distance[i] < far):
            continue
        step = min(int((across[i] - bounds[0]) / length * steps), steps - 1)
        if across[i] < bounds[step]:
            step -= 1
        elif step < steps - 1 and across[i] >= bounds[step + 1]:
            step += 1
        counts[step] += 1


@compiled(*[_floats] * 3, *[_f64] * 3, _fixed, _fixed, *[_f64] * 5)
def best_fill(x, y, z, length, slack, pivot_step, cosines, sines, thickest, patch, nearest, low, high):  # type: ignore[no-untyped-def]
    """Largest share of the patches of a leaf that are hit, less that of what follows behind it, over angles and two pivots.

    The points are given from the jamb: `x` towards the other one, `y` away from the wall, `z` up.
    """
    layers = int(np.round((high - low) / patch))
    count = 0
    px, py, layer = np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x), np.int64)
    for i in range(len(x)):
        if np.hypot(x[i], y[i]) < length + slack:
            px[count], py[count], layer[count] = x[i], y[i], min(int((z[i] - low) / patch), layers - 1)
            count += 1
    best = 0.0
    hit = np.zeros((int(length / patch) + 6, layers), np.bool_)
    for p in range(2):
        pivot = p * pivot_step
        for a in range(len(cosines)):
            c, s = cosines[a], sines[a]
            first = max(2 * thickest / s, nearest)
            patches = max(int((length - 0.1 - first) / patch), 1)
            hit[:] = False
            for i in range(count):
                if abs(py[i] * c - (px[i] - pivot) * s) < thickest:
                    out = (px[i] - pivot) * c + py[i] * s
                    column = np.floor((out - first) / patch)
                    if out > 0 and column >= 0 and column < patches + 4:
                        hit[int(column), layer[i]] = True
            filled = hit[:patches].sum() / (patches * layers) - hit[patches + 2 : patches + 4].sum() / (2 * layers)
            best = max(best, filled)
    return best
