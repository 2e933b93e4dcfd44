"""Numbers put in order without comparing all of them: the compiled inner loops of `ordering`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

DIGIT = 11
"""Bits of a key that are looked at together."""
BUCKETS = 4096
"""Buckets among which that with the median is sought."""
FULL = 64
"""Numbers of a bucket that are sorted by insertion at most."""

_keys, _order = types.Array(types.int64, 1, "C", readonly=True), types.Array(types.int64, 1, "C")
_given, _sorted = types.Array(types.float64, 1, "C", readonly=True), types.Array(types.float64, 1, "C")


@compiled(_sorted, types.int64, types.int64)
def _sort(values, first, last):  # type: ignore[no-untyped-def]
    """Sort some numbers in their place: few of them by insertion."""
    if last - first > FULL:
        values[first:last] = np.sort(values[first:last])
    for i in range(first + 1, last):
        value = values[i]
        j = i - 1
        while j >= first and values[j] > value:
            values[j + 1] = values[j]
            j -= 1
        values[j + 1] = value


@compiled(_keys, types.int64, _order, _order)
def by_digits(keys, passes, one, other):  # type: ignore[no-untyped-def]
    """Sort rows by one digit of their keys after the other, the lowest first; the last pass of an odd number writes to `one`."""
    mask = (1 << DIGIT) - 1
    for k in range(passes):
        to, rows = (one, other) if k % 2 == 0 else (other, one)
        place = np.zeros(mask + 2, np.int64)
        for i in range(len(keys)):
            place[(keys[i] >> k * DIGIT & mask) + 1] += 1
        for digit in range(mask):
            place[digit + 1] += place[digit]
        for i in range(len(keys)):
            row = rows[i] if k else i
            digit = keys[row] >> k * DIGIT & mask
            to[place[digit]] = row
            place[digit] += 1


@compiled(_given, types.float64, types.float64, _sorted)
def from_buckets(values, low, high, out):  # type: ignore[no-untyped-def]
    """Put numbers into as many buckets of equal width, and sort these one by one."""
    count = len(values)
    scale = (count - 1) / (high - low) if high - low > 1e-300 else 0.0
    bucket, place = np.zeros(count, np.int32), np.zeros(count + 1, np.int64)
    for i in range(count):
        bucket[i] = np.int32((values[i] - low) * scale)  # at most count - 1: what is not whole falls away
        place[bucket[i] + 1] += 1
    for k in range(count):
        place[k + 1] += place[k]
    for i in range(count):
        out[place[bucket[i]]] = values[i]
        place[bucket[i]] += 1
    first = 0
    for k in range(count):
        last = place[k]
        if last - first > 1:
            _sort(out, first, last)
        first = last


@compiled(_keys, _given, _order, _sorted)
def by_group(group, values, first, out):  # type: ignore[no-untyped-def]
    """Put numbers into their groups, and sort these one by one."""
    for i in range(len(group)):
        first[group[i] + 1] += 1
    for k in range(len(first) - 1):
        first[k + 1] += first[k]
    place = first[:-1].copy()
    for i in range(len(group)):
        out[place[group[i]]] = values[i]
        place[group[i]] += 1
    for k in range(len(first) - 1):
        _sort(out, first[k], first[k + 1])


@compiled(_given, types.float64, types.float64)
def middle_of_buckets(values, low, high):  # type: ignore[no-untyped-def]
    """Median of numbers: only those of the buckets that the two in the middle lie in are sorted."""
    count = len(values)
    scale = (BUCKETS - 1) / (high - low) if high - low > 1e-300 else 0.0
    number = np.zeros(BUCKETS, np.int64)
    for i in range(count):
        number[np.int64((values[i] - low) * scale)] += 1
    first, before = 0, 0
    while before + number[first] <= (count - 1) // 2:
        before += number[first]
        first += 1
    last, until = first, before + number[first]
    while until <= count // 2:
        last += 1
        until += number[last]
    near, found = np.zeros(until - before), 0
    for i in range(count):
        bucket = np.int64((values[i] - low) * scale)
        if bucket >= first and bucket <= last:
            near[found] = values[i]
            found += 1
    near = np.sort(near)
    return (near[(count - 1) // 2 - before] + near[count // 2 - before]) / 2
