"""Points kept cube by cube by a hash of their place: the compiled inner loops of density limits."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.cloud.hash_slots import FOLD, FREE, HASH, HIGH, ONE
from indoor_bim.compiled import compiled, inlined

MOST_HALVINGS = 24
BLOCK = 256
"""Points that are looked up together, so that the processor waits for the memory of all of them at once."""
STATE = 4
"""Numbers that `add` hands back: points done, cubes, points stored, sum over the cubes of points up to the most that one keeps."""
KEY, CUBE, SEEN, HALVINGS = 0, 1, 2, 3
"""What a slot holds of a cube: its key, its row of the counts, points seen, halvings."""
KEPT, BY_LEVEL = 0, 1
"""What is counted of a cube: points kept, and those of each level."""
COUNTS = 32

_steps = types.Array(types.int32, 2, "A", readonly=True, aligned=False)
_table, _counts, _slots = types.Array(types.int32, 2, "C"), types.Array(types.int16, 2, "C"), types.Array(types.int64, 2, "C")
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
def _halve(slots, slot, counts, most):  # type: ignore[no-untyped-def]
    """Halve the share of points that a cube keeps until they are few enough."""
    cube, halvings = slots[slot, CUBE], slots[slot, HALVINGS]
    kept = counts[cube, KEPT]
    while kept > most and halvings < MOST_HALVINGS:
        kept -= counts[cube, BY_LEVEL + halvings]
        halvings += 1
    counts[cube, KEPT], slots[slot, HALVINGS] = kept, halvings


@inlined
def _first_slot(key, slots):  # type: ignore[no-untyped-def]
    """Row of the slots where the search for a key begins."""
    word = np.uint64(key)
    return (((word ^ word >> FOLD) * HASH) >> HIGH) & np.uint64(len(slots) - 1)


@inlined
def _slot_from(slot, key, slots):  # type: ignore[no-untyped-def]
    """Row of the slots, from the given one on, that holds the key, or the free one where it belongs."""
    wrap = np.uint64(len(slots) - 1)
    there = slots[slot, KEY]
    while there != key and there != FREE:
        slot = (slot + ONE) & wrap
        there = slots[slot, KEY]
    return slot


@compiled(_steps, _bytes, _i64, _f64, types.int64, types.int64, _i64, _slots, _counts, _u8, _i32, _table, _stored)
def add(steps, raw, columns, per_side, most, start, state, slots, counts, level, cube_of, stored, more):  # type: ignore[no-untyped-def]
    """Add points until there is no room for another block of cubes or points; `state` says how far it went.

    Of what comes with each, the bytes in some columns are kept.
    """
    used, points, bounded = state[1], state[2], state[3]
    here = start
    keys, slot_of = np.zeros(BLOCK, np.int64), np.zeros(BLOCK, np.uint64)
    survived, passing = np.zeros(BLOCK, np.int64), np.zeros(BLOCK + 1, np.int64)
    while here < len(steps) and points + BLOCK <= len(level) and used + BLOCK <= len(counts):
        block = min(BLOCK, len(steps) - here)
        for n in range(block):
            x, y, z = steps[here + n, 0], steps[here + n, 1], steps[here + n, 2]
            i, j, k = np.floor((x + 0.5) * per_side[0]), np.floor((y + 0.5) * per_side[1]), np.floor((z + 0.5) * per_side[2])
            key = _key(i, j, k)
            keys[n], slot_of[n], survived[n] = key, _first_slot(key, slots), _level(_mixed(x, y, z))
        found = 0
        for n in range(block):
            slot = _slot_from(slot_of[n], keys[n], slots)
            if slots[slot, KEY] == FREE:
                slots[slot, KEY], slots[slot, CUBE] = keys[n], used
                used += 1
            seen = slots[slot, SEEN] + 1
            slots[slot, SEEN] = seen
            bounded += seen <= most
            slot_of[n], passing[found] = slot, n
            found += survived[n] >= slots[slot, HALVINGS]
        for m in range(found):
            n = passing[m]
            slot = slot_of[n]
            if survived[n] < slots[slot, HALVINGS]:  # since this block began
                continue
            cube = slots[slot, CUBE]
            level[points], cube_of[points] = survived[n], cube
            for axis in range(3):
                stored[points, axis] = steps[here + n, axis]
            for place in range(len(columns)):
                more[points, place] = raw[here + n, columns[place]]
            points += 1
            counts[cube, BY_LEVEL + survived[n]] += 1
            counts[cube, KEPT] += 1
            if counts[cube, KEPT] > most:
                _halve(slots, slot, counts, most)
        here += block
    state[0], state[1], state[2], state[3] = here, used, points, bounded


@compiled(_slots, _counts, types.int64)
def halve_all(slots, counts, most):  # type: ignore[no-untyped-def]
    """Halve in all cubes for a new limit; returns the sum over the cubes of points up to it."""
    bounded = 0
    for slot in range(len(slots)):
        if slots[slot, KEY] != FREE:
            bounded += min(slots[slot, SEEN], most)
            _halve(slots, slot, counts, most)
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


@compiled(_slots, _slots)
def move_slots(slots, wider):  # type: ignore[no-untyped-def]
    """Move all cubes to a table with free slots."""
    for old in range(len(slots)):
        if slots[old, KEY] != FREE:
            wider[_slot_from(_first_slot(slots[old, KEY], wider), slots[old, KEY], wider)] = slots[old]


@compiled(_slots, _u8)
def halvings_of(slots, out):  # type: ignore[no-untyped-def]
    """Halvings of each cube."""
    for slot in range(len(slots)):
        if slots[slot, KEY] != FREE:
            out[slots[slot, CUBE]] = slots[slot, HALVINGS]


@compiled(_slots, _u8)
def spread(slots, out):  # type: ignore[no-untyped-def]
    """Most halvings of each cube and the cubes around it."""
    for middle in range(len(slots)):
        halvings = slots[middle, HALVINGS]
        if slots[middle, KEY] == FREE or halvings == 0:
            continue
        i, j, k = slots[middle, KEY] >> 42, slots[middle, KEY] >> 21 & 0x1FFFFF, slots[middle, KEY] & 0x1FFFFF
        for step in range(27):
            key = _key(i + step // 9 - 1, j + step // 3 % 3 - 1, k + step % 3 - 1)
            slot = _slot_from(_first_slot(key, slots), key, slots)
            if slots[slot, KEY] != FREE:
                other = slots[slot, CUBE]
                out[other] = max(np.int64(out[other]), halvings)
