"""Bounded numbers of points: of every small cube, those whose coordinates mix to the smallest numbers.

The choice depends on the points alone, not on their order, and points can be added piece by piece in bounded memory. The share
that is kept is the same in a cube and in the cubes around it wherever points are dense, so that it does not change within the
thickness of a wall and shifts no surface.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_bim.cloud import density_loops as loops
from indoor_bim.cloud.density_limit import MOST_PER_CUBE, DensityLimit
from indoor_bim.cloud.hash_slots import FREE
from indoor_bim.threads import even_slices, in_threads, rows_of, threads_for

Array = NDArray[Any]

FIRST_CUBES = 1 << 15
LEAST_ROOM, MOST_ROOM = 1 << 20, 1 << 24
"""Points that there is room for at first; what is not used of the room takes no memory."""
AT_ONCE = 1 << 14
"""Points that are added together: few enough to stay in the cache while their attributes are looked up."""
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
    names : dict of str to dtype
        Attributes that come with the points.
    """

    def __init__(self, *, side: ArrayLike, limit: DensityLimit, names: dict[str, type[np.generic]]) -> None:
        self.limit, self.most = limit, min(limit.per_cube, MOST_PER_CUBE)
        self._per_side = 1.0 / np.asarray(side, dtype=np.float64)
        self._state = np.zeros(loops.STATE, dtype=np.int64)
        self._counts: Array = np.zeros((FIRST_CUBES, loops.COUNTS), dtype=np.int16)
        self._slots: Array = _free_slots(FIRST_CUBES)
        room = min(max(2 * SPARE * limit.points, LEAST_ROOM), MOST_ROOM)
        self._level: Array = np.zeros(room, dtype=np.uint8)
        self._cube_of: Array = np.zeros(room, dtype=np.int32)
        self._steps: Array = np.zeros((room, 3), dtype=np.int32)
        self._attributes: dict[str, Array] = {name: np.zeros(room, dtype=kind) for name, kind in names.items()}

    def add(self, steps: NDArray[np.int32], attributes: dict[str, Array]) -> None:
        """Add points.

        Parameters
        ----------
        steps : (n, 3) int32
            Whole coordinates.
        attributes : dict of str to (n,) arrays
            Their attributes.

        Raises
        ------
        TooManyCubesError
            If even `least_per_cube` points of each cube are too many.
        """
        for start in range(0, len(steps), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            self._add(steps[part], {name: attributes[name][part] for name in self._attributes})
        while self._state[3] > SPARE * self.limit.points:
            self._halve()

    def _add(self, steps: NDArray[np.int32], attributes: dict[str, Array]) -> None:
        done, state, row = 0, self._state, np.zeros(len(steps), dtype=np.int32)
        while done < len(steps):
            before = int(state[2])
            loops.add(
                *(steps, self._per_side, self.most, done, state, self._slots, self._counts),
                *(self._level, self._cube_of, self._steps, row),
            )
            for name, values in self._attributes.items():
                attributes[name].take(row[: state[2] - before], out=values[before : state[2]], mode="clip")
            done = int(state[0])
            if done < len(steps):
                self._make_room()

    def points(self) -> tuple[NDArray[np.int32], dict[str, Array]]:
        """Kept points in the order in which they were added: whole coordinates and attributes; nothing can be added any more.

        Raises
        ------
        TooManyCubesError
            If even `least_per_cube` points of each cube are too many.
        """
        while True:
            halvings = self._halvings()
            loops.spread(self._slots, halvings)
            rows = self._passing(halvings)
            if len(rows) <= self.limit.points:
                break
            self._halve()
        return rows_of(self._steps, rows), {name: rows_of(values, rows) for name, values in self._attributes.items()}

    def _passing(self, halvings: NDArray[np.uint8]) -> NDArray[np.int32]:
        """Places of the stored points that pass so many halvings of their cubes."""
        seen = int(self._state[2])
        threads = threads_for(seen)

        def of_part(part: slice) -> NDArray[np.int32]:
            rows = np.zeros(part.stop - part.start, dtype=np.int32)
            return rows[: loops.passing(self._level[part], self._cube_of[part], halvings, part.start, rows)]

        return np.concatenate(in_threads(of_part, even_slices(seen, threads), threads=threads))

    def _halvings(self) -> NDArray[np.uint8]:
        halvings = np.zeros(self._state[1], dtype=np.uint8)
        loops.halvings_of(self._slots, halvings)
        return halvings

    def _halve(self) -> None:
        if self.most < 2 * self.limit.least_per_cube:
            raise TooManyCubesError
        self.most //= 2
        self._state[3] = loops.halve_all(self._slots, self._counts, self.most)

    def _drop(self, halvings: NDArray[np.uint8]) -> int:
        """Leave out the stored points that do not pass so many halvings of their cubes; returns how many do."""
        seen = int(self._state[2])
        rows = np.zeros(seen, dtype=np.int32)
        left = int(loops.drop(seen, halvings, self._level, self._cube_of, self._steps, rows))
        for values in self._attributes.values():
            values[:left] = values.take(rows[:left])
        self._state[2] = left
        return left

    def _make_room(self) -> None:
        """Room for more cubes, and for more points: by dropping those that do not stay, or else by wider arrays."""
        if self._state[1] + loops.BLOCK > len(self._counts):
            self._counts, slots = _wider(self._counts), _free_slots(2 * len(self._counts))
            loops.move_slots(self._slots, slots)
            self._slots = slots
        stored = int(self._state[2])
        if stored + loops.BLOCK > len(self._level) and self._drop(self._halvings()) > 0.7 * stored:
            self._level, self._cube_of, self._steps = _wider(self._level), _wider(self._cube_of), _wider(self._steps)
            self._attributes = {name: _wider(values) for name, values in self._attributes.items()}


def _free_slots(cubes: int) -> Array:
    """Table with room for twice as many cubes."""
    slots = np.zeros((2 * cubes, 4), dtype=np.int64)
    slots[:, loops.KEY] = FREE
    return slots


def _wider(values: Array) -> Array:
    wider = np.zeros((2 * len(values), *values.shape[1:]), dtype=values.dtype)
    wider[: len(values)] = values
    return wider
