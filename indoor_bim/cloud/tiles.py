"""Points sorted in one pass into the tiles of a grid, as chains of runs that each thread makes for itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.cloud.hash_slots import FREE, slot_of
from indoor_bim.compiled import compiled, inlined
from indoor_bim.threads import even_slices, in_threads

SHARED = 8
"""Most tiles that a point is put into."""
FIRST_TILES = 512
FIRST_RUN, LONGEST_RUN = 4, 256
BEGIN, NEXT, END, COUNT = range(4)
"""What is known of a chain: where it begins, the next free record, the end of its last run, and its number of points."""

_i64, _i32, _u32 = (types.Array(kind, 1, "C") for kind in (types.int64, types.int32, types.uint32))
CHAIN_TYPES = (_i64, _i64, _i32, _i64, types.Array(types.int64, 2, "C"), types.Array(types.uint64, 2, "C"))
"""Types of what a loop that sorts keeps its state in: points done, tiles and records in use; keys of the slots, their tiles; keys of the
tiles, their chains; records."""


@dataclass(frozen=True, slots=True, eq=False)
class Tiles:
    """Points by tile, in chains of runs; every thread that sorted them has left a chain of its own in the tiles that it met.

    Parameters
    ----------
    keys : (t,) int64
        Tiles, ascending.
    first_chain : (t + 1,) int64
        First chain of each tile.
    first_run : (c,) int64
        Where the first run of each chain begins.
    count : (c,) int64
        Number of points of each chain.
    records : (m, 2) uint64
        The points. The first run of a chain is `FIRST_RUN` long; behind each full run stand the beginning and the length of the next.
    """

    keys: NDArray[np.int64]
    first_chain: NDArray[np.int64]
    first_run: NDArray[np.int64]
    count: NDArray[np.int64]
    records: NDArray[np.uint64]

    def shares(self, threads: int) -> list[slice]:
        """Slices of the tiles that hold about as many points each, several for each thread."""
        before = np.append(0, np.cumsum(self.count))[self.first_chain]
        shares = 1 if threads == 1 else 16 * threads
        ends = np.unique(np.searchsorted(before, before[-1] * np.arange(shares + 1) // shares))
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def sort_into_tiles(points: NDArray[np.float64], sort: Callable[..., bool], grid: tuple[Any, ...], *, threads: int) -> Tiles | None:
    """Tiles of points.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        At least one point, fewer than 2**31.
    sort : callable
        Compiled loop: takes points, the row of the first of them, the grid and what `CHAIN_TYPES` tells of; goes on where the state says
        until there is no room for `SHARED` more tiles or runs; returns whether the points suit the grid.
    grid : tuple
        What the loop needs to know of the grid.
    threads : int
        Threads, each for a part of the points.

    Returns
    -------
    Tiles or None
        None if the points do not suit the grid.
    """
    parts = list(enumerate(even_slices(len(points), threads)))
    room = 2 * (len(points) // threads + 1) + 2**16
    while True:
        records = np.zeros((threads * room, 2), dtype=np.uint64)

        def work(part: tuple[int, slice], records: NDArray[np.uint64] = records, room: int = room) -> _Part:
            return _sort_part(points[part[1]], part[1].start, sort, grid, part[0] * room, records[: (part[0] + 1) * room])

        done = in_threads(work, parts, threads=threads)
        if not all(part.suited for part in done):
            return None
        if all(part.whole for part in done):
            break
        room *= 2
    keys = np.concatenate([part.keys for part in done])
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    first_chain = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1], [True]]))
    first_run, count = (np.concatenate([part.chain[:, column] for part in done])[order] for column in (BEGIN, COUNT))
    return Tiles(keys[first_chain[:-1]], first_chain, first_run, count, records)


class _Part(NamedTuple):
    """Chains of a part of the points; whether these suit the grid, and whether there was room for all."""

    keys: NDArray[np.int64]
    chain: NDArray[np.int64]
    suited: bool
    whole: bool


def _sort_part(
    points: NDArray[np.float64],
    first_row: int,
    sort: Callable[..., bool],
    grid: tuple[Any, ...],
    first_record: int,
    records: NDArray[np.uint64],
) -> _Part:
    most = FIRST_TILES
    keys, chain = np.zeros(most, dtype=np.int64), np.zeros((most, 4), dtype=np.int64)
    slot_key, slot_tile = np.full(2 * most, FREE), np.zeros(2 * most, dtype=np.int32)
    state = np.array([0, 0, first_record])
    while True:
        suited = bool(sort(points, first_row, *grid, state, slot_key, slot_tile, keys, chain, records))
        done, tiles, _ = (int(number) for number in state)
        if not suited or done == len(points) or tiles + SHARED <= most:
            return _Part(keys[:tiles], chain[:tiles], suited, done == len(points))
        keys, chain = np.concatenate([keys, np.zeros_like(keys)]), np.concatenate([chain, np.zeros_like(chain)])
        most *= 2
        slot_key, slot_tile = np.full(2 * most, FREE), np.zeros(2 * most, dtype=np.int32)
        _insert(keys[:tiles], slot_key, slot_tile)


@compiled(_i64, _i64, _i32)
def _insert(keys, slot_key, slot_tile):  # type: ignore[no-untyped-def]
    """Put keys that are all different into free slots."""
    for i in range(len(keys)):
        slot = slot_of(keys[i], slot_key)
        slot_key[slot], slot_tile[slot] = keys[i], i


@inlined
def load(chains, first_run, count, records, a, b, c, d):  # type: ignore[no-untyped-def]
    """Bring the points of some chains together, each word of the records in halves; returns their number."""
    done, half = np.int64(0), np.uint64(32)
    for chain in range(chains[0], chains[1]):
        left, run, length = count[chain], np.int64(first_run[chain]), np.int64(FIRST_RUN)
        while left:
            here = np.uint64(min(left, length))
            at, to = np.uint64(run), np.uint64(done)
            for i in range(here):
                first, second = records[at + i, 0], records[at + i, 1]
                a[to + i], b[to + i] = np.uint32(first), np.uint32(first >> half)
                c[to + i], d[to + i] = np.uint32(second), np.uint32(second >> half)
            left -= np.int64(here)
            done += np.int64(here)
            if left:
                run, length = np.int64(records[run + length, 0]), np.int64(records[run + length, 1])
    return done


@inlined
def most_points(first_chain, count):  # type: ignore[no-untyped-def]
    """Number of points of the fullest tile."""
    most = np.int64(0)
    for tile in range(len(first_chain) - 1):
        total = np.int64(0)
        for chain in range(first_chain[tile], first_chain[tile + 1]):
            total += count[chain]
        most = max(most, total)
    return most
