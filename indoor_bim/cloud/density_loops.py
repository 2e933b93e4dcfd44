"""Points kept cube by cube by a hash of their place: the compiled inner loops of density limits."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.cloud.hash_slots import FOLD, FREE, HASH, HIGH, ONE
from indoor_bim.compiled import compiled, inlined

MOST_HALVINGS = 24
STATE = 4
"""Numbers that `add` hands back: points done, cubes, points stored, sum over the cubes of points up to the most that one keeps."""
SEEN, KEPT, HALVINGS, BY_LEVEL = 0, 1, 2, 3
"""What is counted of a cube: points seen, points kept, halvings, and the kept points of each level."""
COUNTS = 32

_steps = types.Array(types.int32, 2, "C", readonly=True)
_table, _slots = types.Array(types.int32, 2, "C"), types.Array(types.int64, 2, "C")
_i64, _i32, _u8, _bool = (types.Array(kind, 1, "C") for kind in (types.int64, types.int32, types.uint8, types.bool_))
_f64 = types.Array(types.float64, 1, "C")


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
def _halve(cubes, cube, most):  # type: ignore[no-untyped-def]
    """Halve the share of points that a cube keeps until they are few enough."""
    kept, halvings = cubes[cube, KEPT], cubes[cube, HALVINGS]
    while kept > most and halvings < MOST_HALVINGS:
        kept -= cubes[cube, BY_LEVEL + halvings]
        halvings += 1
    cubes[cube, KEPT], cubes[cube, HALVINGS] = kept, halvings


@inlined
def _slot(key, slots):  # type: ignore[no-untyped-def]
    """Row of the slots that holds the key, or the free one where it belongs."""
    wrap, word = np.uint64(len(slots) - 1), np.uint64(key)
    slot = (((word ^ word >> FOLD) * HASH) >> HIGH) & wrap
    while slots[slot, 0] != key and slots[slot, 0] != FREE:
        slot = (slot + ONE) & wrap
    return slot


@compiled(_steps, _f64, types.int64, types.int64, _i64, _slots, _i64, _table, _u8, _i32, _table, _i64)
def add(steps, per_side, most, start, state, slots, keys, cubes, level, cube_of, stored, row):  # type: ignore[no-untyped-def]
    """Add points until there is no room for another cube or point; `state` says how far it went."""
    used, points, bounded = state[1], state[2], state[3]
    done = len(steps)
    for n in range(start, len(steps)):
        if points == len(level) or used == len(cubes):
            done = n
            break
        x, y, z = steps[n, 0], steps[n, 1], steps[n, 2]
        i, j, k = np.floor((x + 0.5) * per_side[0]), np.floor((y + 0.5) * per_side[1]), np.floor((z + 0.5) * per_side[2])
        key = _key(i, j, k)
        slot = _slot(key, slots)
        if slots[slot, 0] == FREE:
            slots[slot, 0], slots[slot, 1], keys[used] = key, used, key
            cubes[used] = 0
            used += 1
        cube = slots[slot, 1]
        cubes[cube, SEEN] += 1
        bounded += cubes[cube, SEEN] <= most
        survived = _level(_mixed(x, y, z))
        if survived < cubes[cube, HALVINGS]:
            continue
        level[points], cube_of[points], row[points - state[2]] = survived, cube, n
        stored[points, 0], stored[points, 1], stored[points, 2] = x, y, z
        points += 1
        cubes[cube, BY_LEVEL + survived] += 1
        cubes[cube, KEPT] += 1
        if cubes[cube, KEPT] > most:
            _halve(cubes, cube, most)
    state[0], state[1], state[2], state[3] = done, used, points, bounded


@compiled(types.int64, _table, types.int64)
def halve_all(used, cubes, most):  # type: ignore[no-untyped-def]
    """Halve in all cubes for a new limit; returns the sum over the cubes of points up to it."""
    bounded = 0
    for cube in range(used):
        bounded += min(np.int64(cubes[cube, SEEN]), most)
        _halve(cubes, cube, most)
    return bounded


@compiled(types.int64, _u8, _u8, _i32, _table, _bool)
def drop(points, halvings, level, cube_of, stored, passes):  # type: ignore[no-untyped-def]
    """Move the points that pass so many halvings of their cubes up, and note which do; returns how many there are."""
    left = 0
    for place in range(points):
        cube = cube_of[place]
        passes[place] = level[place] >= halvings[cube]
        if passes[place]:
            level[left], cube_of[left] = level[place], cube
            stored[left, 0], stored[left, 1], stored[left, 2] = stored[place, 0], stored[place, 1], stored[place, 2]
            left += 1
    return left


@compiled(types.int64, _u8, _u8, _i32)
def count_passing(points, halvings, level, cube_of):  # type: ignore[no-untyped-def]
    """Number of stored points that pass so many halvings of their cubes."""
    count = 0
    for place in range(points):
        count += level[place] >= halvings[cube_of[place]]
    return count


@compiled(types.int64, _i64, _slots)
def number_slots(used, keys, slots):  # type: ignore[no-untyped-def]
    """Put the keys of all cubes into free slots."""
    for cube in range(used):
        slot = _slot(keys[cube], slots)
        slots[slot, 0], slots[slot, 1] = keys[cube], cube


@compiled(types.int64, _i64, _slots, _table, _u8)
def spread(used, keys, slots, cubes, out):  # type: ignore[no-untyped-def]
    """Most halvings of each cube and the cubes around it."""
    for cube in range(used):
        halvings = cubes[cube, HALVINGS]
        if halvings == 0:
            continue
        i, j, k = keys[cube] >> 42, keys[cube] >> 21 & 0x1FFFFF, keys[cube] & 0x1FFFFF
        for step in range(27):
            key = _key(i + step // 9 - 1, j + step // 3 % 3 - 1, k + step % 3 - 1)
            slot = _slot(key, slots)
            if slots[slot, 0] != FREE:
                other = slots[slot, 1]
                out[other] = max(out[other], halvings)
