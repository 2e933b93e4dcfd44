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
from indoor_bim.cloud.density_limit import DensityLimit
from indoor_bim.cloud.hash_slots import FREE

Array = NDArray[Any]

FIRST_CUBES, FIRST_POINTS = 1 << 14, 1 << 20
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
        self.limit, self.most = limit, limit.per_cube
        self._per_side = 1.0 / np.asarray(side, dtype=np.float64)
        self._state = np.zeros(loops.STATE, dtype=np.int64)
        self._keys: Array = np.zeros(FIRST_CUBES, dtype=np.int64)
        self._cubes: Array = np.zeros((FIRST_CUBES, loops.COUNTS), dtype=np.int32)
        self._slots: Array = self._numbered()
        self._level: Array = np.zeros(FIRST_POINTS, dtype=np.uint8)
        self._cube_of: Array = np.zeros(FIRST_POINTS, dtype=np.int32)
        self._steps: Array = np.zeros((FIRST_POINTS, 3), dtype=np.int32)
        self._attributes: dict[str, Array] = {name: np.zeros(FIRST_POINTS, dtype=kind) for name, kind in names.items()}

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
        steps, done, state = np.ascontiguousarray(steps), 0, self._state
        row = np.zeros(len(steps), dtype=np.int64)
        while done < len(steps):
            before = int(state[2])
            loops.add(
                *(steps, self._per_side, self.most, done, state, self._slots, self._keys, self._cubes),
                *(self._level, self._cube_of, self._steps, row),
            )
            for name, values in self._attributes.items():
                values[before : state[2]] = attributes[name][row[: state[2] - before]]
            done = int(state[0])
            if done < len(steps):
                self._make_room()
        while state[3] > SPARE * self.limit.points:
            self._halve()

    def points(self) -> tuple[NDArray[np.int32], dict[str, Array]]:
        """Kept points in the order in which they were added: whole coordinates and attributes; nothing can be added any more.

        Raises
        ------
        TooManyCubesError
            If even `least_per_cube` points of each cube are too many.
        """
        while True:
            halvings = self._halvings()
            loops.spread(int(self._state[1]), self._keys, self._slots, self._cubes, halvings)
            if loops.count_passing(int(self._state[2]), halvings, self._level, self._cube_of) <= self.limit.points:
                break
            self._halve()
        left = self._drop(halvings)
        return self._steps[:left], {name: values[:left].copy() for name, values in self._attributes.items()}

    def _halvings(self) -> NDArray[np.uint8]:
        return self._cubes[: self._state[1], loops.HALVINGS].astype(np.uint8)

    def _halve(self) -> None:
        if self.most < 2 * self.limit.least_per_cube:
            raise TooManyCubesError
        self.most //= 2
        self._state[3] = loops.halve_all(int(self._state[1]), self._cubes, self.most)

    def _drop(self, halvings: NDArray[np.uint8]) -> int:
        """Leave out the stored points that do not pass so many halvings of their cubes; returns how many do."""
        seen = int(self._state[2])
        passes = np.zeros(seen, dtype=np.bool_)
        left = int(loops.drop(seen, halvings, self._level, self._cube_of, self._steps, passes))
        for values in self._attributes.values():
            values[:left] = values[:seen][passes]
        self._state[2] = left
        return left

    def _make_room(self) -> None:
        """Room for more cubes, and for more points: by dropping those that do not stay, or else by wider arrays."""
        if self._state[1] == len(self._keys):
            self._keys, self._cubes = _wider(self._keys), _wider(self._cubes)
            self._slots = self._numbered()
        stored = int(self._state[2])
        if stored == len(self._level) and self._drop(self._halvings()) > 0.7 * stored:
            self._level, self._cube_of, self._steps = _wider(self._level), _wider(self._cube_of), _wider(self._steps)
            self._attributes = {name: _wider(values) for name, values in self._attributes.items()}

    def _numbered(self) -> Array:
        """Table of the cubes with room for twice as many as there are places for."""
        slots = np.zeros((2 * len(self._keys), 2), dtype=np.int64)
        slots[:, 0] = FREE
        loops.number_slots(int(self._state[1]), self._keys, slots)
        return slots


def _wider(values: Array) -> Array:
    wider = np.zeros((2 * len(values), *values.shape[1:]), dtype=values.dtype)
    wider[: len(values)] = values
    return wider
