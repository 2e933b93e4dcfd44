"""Rays, points and cells at openings, one by one: the compiled inner loops of `traces`, `holes`, `edge_fits`, `door_leaves` and others."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

_float32s = types.Array(types.float32, 1, "A", readonly=True)
_floats, _ints = types.Array(types.float64, 1, "A", readonly=True), types.Array(types.int64, 1, "C")
_fixed = types.Array(types.float64, 1, "C", readonly=True)
_kinds = types.Array(types.uint8, 1, "C")
_cells, _runs = types.Array(types.boolean, 2, "A", readonly=True), types.Array(types.int64, 2, "C")
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


@compiled(*[_fixed] * 2, *[_f64] * 5, types.int64, *[_f64] * 2)
def frame_edge(distance, depth, near, far, narrowest, widest, least_face, enough, smallest_step, sure):  # type: ignore[no-untyped-def]
    """Distance from an edge that parts depths best into two, those of a frame and of the face beyond it; 0 where none surely does."""
    count = 0
    given, values = np.zeros(len(distance)), np.zeros(len(distance))
    for i in range(len(distance)):
        if distance[i] > near and distance[i] < far:
            given[count], values[count] = distance[i], depth[i]
            count += 1
    if count < 2 * enough:
        return 0.0
    order = np.argsort(given[:count], kind="mergesort")
    x, total, square = np.zeros(count), np.zeros(count), np.zeros(count)
    here = here_square = 0.0
    for i in range(count):
        value = values[order[i]]
        here, here_square = here + value, here_square + value * value
        x[i], total[i], square[i] = given[order[i]], here, here_square
    best, width = sure, 0.0
    for i in range(enough - 1, count - enough):
        middle, before, after = (x[i] + x[i + 1]) / 2, i + 1, count - i - 1
        if middle < narrowest or middle > min(widest, x[-1] - least_face):
            continue
        mean, beyond = total[i] / before, (total[-1] - total[i]) / after
        if not abs(mean - beyond) > smallest_step:
            continue
        spread = (square[-1] - before * mean**2 - after * beyond**2) / count
        score = abs(mean - beyond) / np.sqrt(max(spread, 1e-8) * (1 / before + 1 / after))
        if score > best:
            best, width = score, middle
    return width


@inlined
def _ninth_decile(values):  # type: ignore[no-untyped-def]
    """Value that nine tenths are below."""
    ordered = np.sort(values)
    place = 0.9 * (len(ordered) - 1)
    low = int(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (ordered[high] - ordered[low]) * (place - low)


@compiled(_cells, _cells, *[_f64] * 4, _runs)
def open_runs(part, wall, cell, full, narrow, thin, runs):  # type: ignore[no-untyped-def]
    """Write the stretches of columns that are open over a share of their typical length (`full`); return how many there are.

    Narrow bars do not part them, unless they show a wall that is not thin.
    """
    rows, columns = part.shape
    count, solid = np.zeros(columns, np.int64), np.zeros(columns, np.int64)
    filled, walls = 0, 0
    for j in range(columns):
        stopped = 0
        for i in range(rows):
            count[j] += part[i, j]
            stopped += wall[i, j]
        filled += count[j] > 0
        walls += stopped > count[j]
        solid[j] = walls
    if filled == 0:
        return 0
    least = full * _ninth_decile(count[count > 0])
    found, j = 0, 0
    while j < columns:
        if count[j] < least:
            j += 1
            continue
        begin = j
        while j < columns and count[j] >= least:
            j += 1
        last = runs[found - 1, 1] if found else 0
        bar = solid[begin - 1] - solid[last - 1] if found else 0
        if found and (begin - last + 1) * cell <= narrow + cell and bar * cell < thin:
            runs[found - 1, 1] = j
        else:
            runs[found, 0], runs[found, 1] = begin, j
            found += 1
    return found
