"""Points kept cube by cube by a hash of their place: the compiled inner loops of density limits."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.cloud.hash_slots import FREE, slot_of
from indoor_bim.compiled import compiled, inlined

MOST_HALVINGS = 24
STATE = 4
"""Numbers that `add` hands back: points done, cubes, points stored, sum over the cubes of points up to the most that one keeps."""

_steps = types.Array(types.int32, 2, "C", readonly=True)
_table = types.Array(types.int32, 2, "C")
_i64, _i32, _u32, _u8 = (types.Array(kind, 1, "C") for kind in (types.int64, types.int32, types.uint32, types.uint8))
_f64 = types.Array(types.float64, 1, "C")
_cubes = (_u32, _i32, _u8, _i32)  # points seen, points kept, halvings, first stored point of every cube
_store = (_u32, _i32)  # hash and next point of the same cube of every stored point


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


@compiled(types.int64, *_cubes, *_store, types.int64)
def _halve(cube, seen, kept, halvings, first, mixed, following, most):  # type: ignore[no-untyped-def]
    """Halve the share of points that a cube keeps until they are few enough."""
    while kept[cube] > most and halvings[cube] < MOST_HALVINGS:
        halvings[cube] += 1
        limit = np.uint32(1 << (32 - halvings[cube]))
        place, left, count = first[cube], np.int32(-1), 0
        while place >= 0:
            then = following[place]
            if mixed[place] < limit:
                following[place] = left
                left = place
                count += 1
            place = then
        first[cube] = left
        kept[cube] = count


@compiled(_steps, _f64, types.int64, types.int64, _i64, _i64, _i32, _i64, *_cubes, *_store, _i32, _table, _i64)
def add(  # type: ignore[no-untyped-def]
    steps, per_side, most, start, state, slot_key, slot_cube, keys, seen, kept, halvings, first, mixed, following, cube_of, stored, row
):
    """Add points until there is no room for another cube or point; `state` says how far it went."""
    cubes, points, bounded = state[1], state[2], state[3]
    done = len(steps)
    for n in range(start, len(steps)):
        if points == len(mixed) or cubes == len(seen):
            done = n
            break
        x, y, z = steps[n, 0], steps[n, 1], steps[n, 2]
        i, j, k = np.floor((x + 0.5) * per_side[0]), np.floor((y + 0.5) * per_side[1]), np.floor((z + 0.5) * per_side[2])
        key = _key(i, j, k)
        slot = slot_of(key, slot_key)
        if slot_key[slot] == FREE:
            slot_key[slot] = key
            slot_cube[slot] = cubes
            keys[cubes] = key
            seen[cubes], kept[cubes], halvings[cubes], first[cubes] = 0, 0, 0, -1
            cubes += 1
        cube = slot_cube[slot]
        seen[cube] += np.uint32(1)
        bounded += seen[cube] <= most
        word = _mixed(x, y, z)
        if halvings[cube] and word >= np.uint32(1 << (32 - halvings[cube])):
            continue
        mixed[points], cube_of[points], row[points] = word, cube, n
        following[points] = first[cube]
        first[cube] = points
        stored[points, 0], stored[points, 1], stored[points, 2] = x, y, z
        points += 1
        kept[cube] += 1
        if kept[cube] > most:
            _halve(cube, seen, kept, halvings, first, mixed, following, most)
    state[0], state[1], state[2], state[3] = done, cubes, points, bounded


@compiled(types.int64, *_cubes, *_store, types.int64)
def halve_all(cubes, seen, kept, halvings, first, mixed, following, most):  # type: ignore[no-untyped-def]
    """Halve in all cubes for a new limit; returns the sum over the cubes of points up to it."""
    bounded = 0
    for cube in range(cubes):
        bounded += min(np.int64(seen[cube]), most)
        _halve(cube, seen, kept, halvings, first, mixed, following, most)
    return bounded


@compiled(types.int64, _u8, _i32, *_store, _i32, _table, _i64)
def drop(points, halvings, first, mixed, following, cube_of, stored, row):  # type: ignore[no-untyped-def]
    """Move the points that pass up, chain those of every cube anew and note where they were; returns how many there are."""
    first[:] = -1
    left = 0
    for place in range(points):
        cube = cube_of[place]
        if halvings[cube] and mixed[place] >= np.uint32(1 << (32 - halvings[cube])):
            continue
        mixed[left], cube_of[left], row[left] = mixed[place], cube, place
        stored[left, 0], stored[left, 1], stored[left, 2] = stored[place, 0], stored[place, 1], stored[place, 2]
        following[left] = first[cube]
        first[cube] = left
        left += 1
    return left


@compiled(types.int64, _u8, _u32, _i32)
def count_passing(points, halvings, mixed, cube_of):  # type: ignore[no-untyped-def]
    """Number of stored points that pass so many halvings of their cubes."""
    count = 0
    for place in range(points):
        times = halvings[cube_of[place]]
        count += times == 0 or mixed[place] < np.uint32(1 << (32 - times))
    return count


@compiled(types.int64, _i64, _i64, _i32)
def number_slots(cubes, keys, slot_key, slot_cube):  # type: ignore[no-untyped-def]
    """Put the keys of all cubes into free slots."""
    for cube in range(cubes):
        slot = slot_of(keys[cube], slot_key)
        slot_key[slot] = keys[cube]
        slot_cube[slot] = cube


@compiled(types.int64, _i64, _i64, _i32, _u8, _u8)
def spread(cubes, keys, slot_key, slot_cube, halvings, out):  # type: ignore[no-untyped-def]
    """Most halvings of each cube and the cubes around it."""
    for cube in range(cubes):
        if halvings[cube] == 0:
            continue
        i, j, k = keys[cube] >> 42, keys[cube] >> 21 & 0x1FFFFF, keys[cube] & 0x1FFFFF
        for step in range(27):
            key = _key(i + step // 9 - 1, j + step // 3 % 3 - 1, k + step % 3 - 1)
            slot = slot_of(key, slot_key)
            if slot_key[slot] != FREE:
                other = slot_cube[slot]
                out[other] = max(out[other], halvings[cube])
