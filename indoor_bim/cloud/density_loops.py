"""Points kept cube by cube by a hash of their place: the compiled inner loops of density limits."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.cloud.hash_slots import FOLD, HASH, HIGH, ONE
from indoor_bim.compiled import compiled, inlined

BLOCK = 256
"""Points that are looked up together, so that the processor waits for the memory of all of them at once."""
STATE = 4
"""Numbers that `add` hands back: points done, cubes, points stored, sum over the cubes of points up to the most that one keeps."""
LINE = 64
"""Bytes that tell of a cube, a line of the cache: its key plus one as a number of 64 bits, points seen as one of 32, the rest as numbers
of 16: halvings, points kept, and the kept points of each level."""
KEY, SEEN, HALVINGS, KEPT, BY_LEVEL = 0, 2, 6, 7, 8
"""Where they stand in the line, counted in numbers of their kind; all are 0 in a line that is free."""
MOST_HALVINGS = 23

_steps = types.Array(types.int32, 2, "A", readonly=True, aligned=False)
_table = types.Array(types.int32, 2, "C")
_cubes = (types.Array(types.int64, 2, "C"), types.Array(types.int32, 2, "C"), types.Array(types.int16, 2, "C"))
_i64, _i32, _u8 = (types.Array(kind, 1, "C") for kind in (types.int64, types.int32, types.uint8))
_f64 = types.Array(types.float64, 1, "C")
_bytes, _stored = types.Array(types.uint8, 2, "A", readonly=True), types.Array(types.uint8, 2, "C")


@inlined
def _mixed(x, y, z):  # type: ignore[no-untyped-def]
    """Well mixed 32 bits of whole coordinates."""
    word = np.uint64(np.int64(x)) * np.uint64(0x9E3779B97F4A7C15)
    word ^= word >> np.uint64(32)
    word = (word ^ np.uint64(np.int64(y))) * np.uint64(0xC2B2AE3D27D4EB4F)
    word ^= word >> np.uint64(29)
    word = (word ^ np.uint64(np.int64(z))) * np.uint64(0x165667B19E3779F9)
    word ^= word >> np.uint64(32)
    word *= np.uint64(0x9E3779B97F4A7C15)
    return np.uint32(word >> np.uint64(32))


@inlined
def _key(i, j, k):  # type: ignore[no-untyped-def]
    """Number of a cube; cubes two million cubes apart share one, which does no harm."""
    return (np.int64(i) & 0x1FFFFF) << 42 | (np.int64(j) & 0x1FFFFF) << 21 | np.int64(k) & 0x1FFFFF


@inlined
def _level(word):  # type: ignore[no-untyped-def]
    """Number of halvings that a point survives: the leading zeros of its mixed word."""
    word |= word >> np.uint32(1)
    word |= word >> np.uint32(2)
    word |= word >> np.uint32(4)
    word |= word >> np.uint32(8)
    word |= word >> np.uint32(16)
    word -= (word >> np.uint32(1)) & np.uint32(0x55555555)
    word = (word & np.uint32(0x33333333)) + ((word >> np.uint32(2)) & np.uint32(0x33333333))
    word = (word + (word >> np.uint32(4))) & np.uint32(0x0F0F0F0F)
    return min(32 - np.int64(np.uint32(word * np.uint32(0x01010101)) >> np.uint32(24)), MOST_HALVINGS)


@inlined
def _halve(counts, cube, most):  # type: ignore[no-untyped-def]
    """Halve the share of points that a cube keeps until they are few enough."""
    kept, halvings = np.int64(counts[cube, KEPT]), np.int64(counts[cube, HALVINGS])
    while kept > most and halvings < MOST_HALVINGS:
        kept -= counts[cube, BY_LEVEL + halvings]
        halvings += 1
    counts[cube, KEPT], counts[cube, HALVINGS] = kept, halvings


@inlined
def _first_line(key, keys):  # type: ignore[no-untyped-def]
    """Line where the search for a cube begins."""
    word = np.uint64(key)
    return (((word ^ word >> FOLD) * HASH) >> HIGH) & np.uint64(len(keys) - 1)


@inlined
def _line_from(line, key, keys):  # type: ignore[no-untyped-def]
    """Line, from the given one on, that holds the cube, or the free one where it belongs."""
    wrap = np.uint64(len(keys) - 1)
    there = keys[line, KEY]
    while there != key + 1 and there != 0:
        line = (line + ONE) & wrap
        there = keys[line, KEY]
    return line


@compiled(_steps, _bytes, _i64, _f64, types.int64, types.int64, _i64, *_cubes, _u8, _i32, _table, _stored)
def add(steps, raw, columns, per_side, most, start, state, keys, seen, counts, level, cube_of, stored, more):  # type: ignore[no-untyped-def]
    """Add points until there is no room for another block of cubes or points; `state` says how far it went.

    Of what comes with each, the bytes in some columns are kept. `keys`, `seen` and `counts` are the lines of the cubes, seen as numbers of
    64, 32 and 16 bits.
    """
    used, points, bounded = state[1], state[2], state[3]
    here = start
    key_of, line_of = np.zeros(BLOCK, np.int64), np.zeros(BLOCK, np.uint64)
    survived, passing = np.zeros(BLOCK, np.int64), np.zeros(BLOCK + 1, np.int64)
    while here < len(steps) and points + BLOCK <= len(level) and 2 * (used + BLOCK) <= len(keys):
        block = min(BLOCK, len(steps) - here)
        for n in range(block):
            x, y, z = steps[here + n, 0], steps[here + n, 1], steps[here + n, 2]
            i, j, k = np.floor((x + 0.5) * per_side[0]), np.floor((y + 0.5) * per_side[1]), np.floor((z + 0.5) * per_side[2])
            key = _key(i, j, k)
            key_of[n], line_of[n], survived[n] = key, _first_line(key, keys), _level(_mixed(x, y, z))
        found = 0
        for n in range(block):
            cube = _line_from(line_of[n], key_of[n], keys)
            if keys[cube, KEY] == 0:
                keys[cube, KEY] = key_of[n] + 1
                used += 1
            seen[cube, SEEN] += 1
            bounded += seen[cube, SEEN] <= most
            line_of[n], passing[found] = cube, n
            found += survived[n] >= counts[cube, HALVINGS]
        for m in range(found):
            n = passing[m]
            cube = line_of[n]
            if survived[n] < counts[cube, HALVINGS]:  # since this block began
                continue
            level[points], cube_of[points] = survived[n], cube
            for axis in range(3):
                stored[points, axis] = steps[here + n, axis]
            for place in range(len(columns)):
                more[points, place] = raw[here + n, columns[place]]
            points += 1
            counts[cube, BY_LEVEL + survived[n]] += 1
            counts[cube, KEPT] += 1
            if counts[cube, KEPT] > most:
                _halve(counts, cube, most)
        here += block
    state[0], state[1], state[2], state[3] = here, used, points, bounded


@compiled(*_cubes, types.int64)
def halve_all(keys, seen, counts, most):  # type: ignore[no-untyped-def]
    """Halve in all cubes for a new limit; returns the sum over the cubes of points up to it."""
    bounded = 0
    for cube in range(len(keys)):
        bounded += min(np.int64(seen[cube, SEEN]), most)
        _halve(counts, cube, most)
    return bounded


@compiled(types.int64, _u8, _u8, _i32, _table, _stored)
def drop(points, halvings, level, cube_of, stored, more):  # type: ignore[no-untyped-def]
    """Move the points that pass so many halvings of their cubes up; returns how many there are."""
    left = 0
    for place in range(points):
        cube, survived = cube_of[place], level[place]
        level[left], cube_of[left] = survived, cube
        stored[left, 0], stored[left, 1], stored[left, 2] = stored[place, 0], stored[place, 1], stored[place, 2]
        for column in range(more.shape[1]):
            more[left, column] = more[place, column]
        left += survived >= halvings[cube]
    return left


@compiled(_u8, _i32, _u8, types.int64, _i32)
def passing(level, cube_of, halvings, first, rows):  # type: ignore[no-untyped-def]
    """Write the places of the points that pass so many halvings of their cubes; returns how many there are."""
    found = 0
    for place in range(len(level)):
        rows[found] = first + place
        found += level[place] >= halvings[cube_of[place]]
    return found


@compiled(_stored, _i32, types.int64, _stored)
def take_columns(more, rows, first, out):  # type: ignore[no-untyped-def]
    """Bytes of some rows, from a column on."""
    for n in range(len(rows)):
        for column in range(out.shape[1]):
            out[n, column] = more[rows[n], first + column]


@compiled(_cubes[0], _cubes[0], types.int64, _i32)
def move_cubes(keys, wider, points, cube_of):  # type: ignore[no-untyped-def]
    """Move the cubes to a table of more lines, and with them the points."""
    moved = np.zeros(len(keys), np.int32)
    for cube in range(len(keys)):
        if keys[cube, KEY] != 0:
            key = keys[cube, KEY] - 1
            to = _line_from(_first_line(key, wider), key, wider)
            wider[to], moved[cube] = keys[cube], to
    for place in range(points):
        cube_of[place] = moved[cube_of[place]]


@compiled(_cubes[0], _cubes[2], types.int64, types.int64, _u8)
def spread(keys, counts, first, last, out):  # type: ignore[no-untyped-def]
    """Most halvings of each cube and the cubes around it, as far as those of some lines tell."""
    for middle in range(first, last):
        halvings = counts[middle, HALVINGS]
        if halvings == 0:
            continue
        key = keys[middle, KEY] - 1
        i, j, k = key >> 42, key >> 21 & 0x1FFFFF, key & 0x1FFFFF
        for step in range(27):
            around = _key(i + step // 9 - 1, j + step // 3 % 3 - 1, k + step % 3 - 1)
            cube = _line_from(_first_line(around, keys), around, keys)
            if keys[cube, KEY] != 0:
                out[cube] = max(np.int64(out[cube]), np.int64(halvings))
