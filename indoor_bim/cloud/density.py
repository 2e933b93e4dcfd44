"""Bounded numbers of points: of every small cube, those whose coordinates mix to the smallest numbers.

The choice depends on the points alone, not on their order, and points can be added piece by piece in bounded memory. The share
that is kept is the same in a cube and in the cubes around it wherever points are dense, so that it does not change within the
thickness of a wall and shifts no surface.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_bim.cloud import density_loops as loops
from indoor_bim.cloud.density_limit import MOST_PER_CUBE, DensityLimit
from indoor_bim.threads import even_slices, in_threads, threads_for

Array = NDArray[Any]

FIRST_LINES = 1 << 18
LEAST_ROOM, MOST_ROOM = 1 << 21, 1 << 23
"""Room at first for cubes and points; what is not used of it takes no memory."""
SPARE = 3
"""While they are added, as many times the points may be stored as may be kept in the end."""


class TooManyCubesError(Exception):
    """The cubes are too small for the number of points that may be kept."""


class DensitySample:
    """Points kept of all that were added so far.

    Parameters
    ----------
    side : (3,) array_like of int
        Side of the cubes in steps of the coordinates.
    limit : DensityLimit
        How many points may be kept.
    kind : dtype
        Attributes that come with the points: a structured type, as of `numpy.dtype([("row", "i8")])`.
    """

    def __init__(self, *, side: ArrayLike, limit: DensityLimit, kind: np.dtype[np.void]) -> None:
        self.limit, self.most = limit, min(limit.per_cube, MOST_PER_CUBE)
        self._per_side = 1.0 / np.asarray(side, dtype=np.float64)
        self._state = np.zeros(loops.STATE, dtype=np.int64)
        self._cubes = _free_lines(FIRST_LINES)
        room = min(max(2 * SPARE * limit.points, LEAST_ROOM), MOST_ROOM)
        self._level: Array = np.zeros(room, dtype=np.uint8)
        self._cube_of: Array = np.zeros(room, dtype=np.int32)
        self._steps: Array = np.zeros((room, 3), dtype=np.int32)
        self._kind = kind
        self._more: Array = np.zeros((room, kind.itemsize), dtype=np.uint8)

    def add(self, steps: NDArray[np.int32], records: NDArray[np.void], begun: Callable[[], object] | None = None) -> None:
        """Add points.

        Parameters
        ----------
        steps : (n, 3) int32
            Whole coordinates.
        records : (n,) structured array
            What comes with the points, the attributes among it.
        begun : callable, optional
            Called when all is ready for the work that needs Python's lock no more.

        Raises
        ------
        TooManyCubesError
            If even `least_per_cube` points of each cube are too many.
        """
        fields: Any = records.dtype.fields
        columns = [np.arange(self._kind[name].itemsize) + fields[name][1] for name in self._kind.names or ()]
        raw = records.view(np.uint8).reshape(len(records), -1)
        given = (steps, raw, np.concatenate(columns).astype(np.int64), self._per_side)
        self._make_room(len(steps))
        if begun is not None:
            begun()
        done = 0
        while True:
            stored = (self._level, self._cube_of, self._steps, self._more)
            loops.add(*given, self.most, done, self._state, *_seen_as(self._cubes), *stored)
            done = int(self._state[0])
            if done == len(steps):
                break
            self._make_room(len(steps) - done)
        while self._state[3] > SPARE * self.limit.points:
            self._halve()

    def kept(self) -> NDArray[np.int32]:
        """Places (k,) of the kept points, in the order in which they were added; nothing can be added any more.

        Raises
        ------
        TooManyCubesError
            If even `least_per_cube` points of each cube are too many.
        """
        while True:
            rows = self._passing(self._halvings_around())
            if len(rows) <= self.limit.points:
                return rows
            self._halve()

    def steps(self, places: NDArray[np.int32]) -> NDArray[np.int32]:
        """Whole coordinates (k, 3) of the points at some places."""
        return self._steps.take(places, axis=0)

    def attribute(self, name: str, places: NDArray[np.int32]) -> Array:
        """One attribute (k,) of the points at some places."""
        fields: Any = self._kind.fields
        (kind, first), threads = fields[name], threads_for(len(places))
        out, parts = np.zeros((len(places), kind.itemsize), dtype=np.uint8), even_slices(len(places), threads)
        in_threads(lambda part: loops.take_columns(self._more, places[part], first, out[part]), parts, threads=threads)
        return out.reshape(-1).view(kind)

    def _passing(self, halvings: NDArray[np.uint8]) -> NDArray[np.int32]:
        """Places of the stored points that pass so many halvings of their cubes."""
        seen = int(self._state[2])
        threads = threads_for(seen)

        def of_part(part: slice) -> NDArray[np.int32]:
            rows = np.zeros(part.stop - part.start, dtype=np.int32)
            return rows[: loops.passing(self._level[part], self._cube_of[part], halvings, part.start, rows)]

        return np.concatenate(in_threads(of_part, even_slices(seen, threads), threads=threads))

    def _halvings_around(self) -> NDArray[np.uint8]:
        """Most halvings of each cube and of those around it."""
        keys, _, counts = _seen_as(self._cubes)
        threads = threads_for(len(keys))

        def of_part(part: slice) -> NDArray[np.uint8]:
            out = np.zeros(len(keys), dtype=np.uint8)
            loops.spread(keys, counts, part.start, part.stop, out)
            return out

        most: NDArray[np.uint8] = np.max(in_threads(of_part, even_slices(len(keys), threads), threads=threads), axis=0)
        return most

    def _halve(self) -> None:
        if self.most < 2 * self.limit.least_per_cube:
            raise TooManyCubesError
        self.most //= 2
        self._state[3] = loops.halve_all(*_seen_as(self._cubes), self.most)

    def _drop(self, halvings: NDArray[np.uint8]) -> None:
        """Leave out the stored points that do not pass so many halvings of their cubes."""
        self._state[2] = loops.drop(int(self._state[2]), halvings, self._level, self._cube_of, self._steps, self._more)

    def _make_room(self, more: int) -> None:
        """Room for another block of cubes, and for more points: by dropping those that do not stay, or else by wider arrays."""
        if 2 * (self._state[1] + loops.BLOCK) > len(self._cubes):
            wider = _free_lines(2 * len(self._cubes))
            loops.move_cubes(_seen_as(self._cubes)[0], _seen_as(wider)[0], int(self._state[2]), self._cube_of)
            self._cubes = wider
        if self._state[2] + more + loops.BLOCK <= len(self._level):
            return
        self._drop(self._halvings_around())
        while self._state[2] > min(len(self._level) - more - loops.BLOCK, 0.7 * len(self._level)):
            self._level, self._cube_of = _wider(self._level), _wider(self._cube_of)
            self._steps, self._more = _wider(self._steps), _wider(self._more)


def _free_lines(count: int) -> NDArray[np.uint8]:
    """Table of so many lines for cubes, each in one line of the cache."""
    room = np.zeros((count + 1) * loops.LINE, dtype=np.uint8)
    first = -room.ctypes.data % loops.LINE
    return room[first : first + count * loops.LINE].reshape(count, loops.LINE)


def _seen_as(lines: NDArray[np.uint8]) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int16]]:
    """Lines as numbers of 64, 32 and 16 bits."""
    return lines.view(np.int64), lines.view(np.int32), lines.view(np.int16)


def _wider(values: Array) -> Array:
    wider = np.zeros((2 * len(values), *values.shape[1:]), dtype=values.dtype)
    wider[: len(values)] = values
    return wider
