"""Hits on the face of a wall, one by one: the compiled inner loops of `relief`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_floats, _ints = types.Array(types.float64, 1, "C"), types.Array(types.int64, 1, "C")
_fixed_floats, _fixed_ints = types.Array(types.float64, 1, "C", readonly=True), types.Array(types.int64, 1, "C", readonly=True)
_float32s = types.Array(types.float32, 1, "A", readonly=True)
_sides = types.Array(types.int8, 1, "A", readonly=True)
_periods = types.Array(types.int64, 1, "A", readonly=True)
_f64, _f32, _i64 = types.float64, types.float32, types.int64


@compiled(_sides, _float32s, _float32s, _i64, _f64, _f32, _ints)
def hits_on_face(sides, depth, slant, side, reach, steep, rows):  # type: ignore[no-untyped-def]
    """Write the rows of the rays from one side that ended close to its face; return how many there are."""
    found = 0
    for i in range(len(sides)):
        if sides[i] == side and abs(np.float64(depth[i])) < reach and slant[i] > steep:
            rows[found] = i
            found += 1
    return found


@compiled(_fixed_floats, _f64)
def densest(ordered, width):  # type: ignore[no-untyped-def]
    """First of the ascending values from which on an interval of this width holds most, and how many; the first of equal ones."""
    first = most = end = 0
    for i in range(len(ordered)):
        while end < len(ordered) and ordered[end] <= ordered[i] + width:
            end += 1
        if end - i > most:
            first, most = i, end - i
    return first, most


@compiled(_fixed_ints, _i64, _fixed_ints, _i64, _fixed_floats, _ints, _ints, _ints, _floats)
def pair_sums(period, periods, place, places, steps, pair_period, pair_place, count, total):  # type: ignore[no-untyped-def]
    """Number and sum of the hits of each period at each place, by period and place; return how many pairs there are."""
    by_place, order = np.zeros(len(place), np.int64), np.zeros(len(place), np.int64)
    first = np.zeros(places + 1, np.int64)
    for i in range(len(place)):
        first[place[i] + 1] += 1
    for k in range(places):
        first[k + 1] += first[k]
    for i in range(len(place)):
        by_place[first[place[i]]] = i
        first[place[i]] += 1
    first = np.zeros(periods + 1, np.int64)
    for i in range(len(place)):
        first[period[i] + 1] += 1
    for k in range(periods):
        first[k + 1] += first[k]
    for k in range(len(by_place)):
        i = by_place[k]
        order[first[period[i]]] = i
        first[period[i]] += 1
    pairs = 0
    for k in range(len(order)):
        i = order[k]
        if pairs == 0 or period[i] != pair_period[pairs - 1] or place[i] != pair_place[pairs - 1]:
            pair_period[pairs], pair_place[pairs], count[pairs], total[pairs] = period[i], place[i], 0, 0.0
            pairs += 1
        count[pairs - 1] += 1
        total[pairs - 1] += steps[i]
    return pairs


@compiled(_fixed_floats, _fixed_ints, _fixed_ints, _fixed_ints, _fixed_floats, _fixed_floats, _i64, _floats, _floats)
def alternate_means(total, count, period, place, per_period, per_place, rounds, offset, face):  # type: ignore[no-untyped-def]
    """Offsets of periods and of places, each by turns the mean over the other."""
    for _ in range(rounds):
        offset[:] = 0.0
        for k in range(len(total)):
            offset[period[k]] += total[k] - count[k] * face[place[k]]
        for k in range(len(offset)):
            offset[k] /= per_period[k]
        face[:] = 0.0
        for k in range(len(total)):
            face[place[k]] += total[k] - count[k] * offset[period[k]]
        for k in range(len(face)):
            face[k] /= max(per_place[k], 1.0)


@compiled(_sides, _i64, _periods, _fixed_ints, _fixed_floats, _floats)
def take_off(sides, side, period, names, offset, depth):  # type: ignore[no-untyped-def]
    """Take the offset of its period, between those of the nearest named ones, off the depth of each ray from one side."""
    last, value = names[0] - 1, offset[0]
    for i in range(len(sides)):
        if sides[i] != side:
            continue
        if period[i] != last:
            last = period[i]
            k = np.searchsorted(names, last, side="right") - 1
            if k < 0:
                value = offset[0]
            elif k >= len(names) - 1:
                value = offset[-1]
            else:
                value = (offset[k + 1] - offset[k]) / (names[k + 1] - names[k]) * (last - names[k]) + offset[k]
        depth[i] -= value
