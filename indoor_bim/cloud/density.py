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
        self._slots()
        self._keys: Array = np.zeros(FIRST_CUBES, dtype=np.int64)
        self._cubes: list[Array] = [np.zeros(FIRST_CUBES, dtype=kind) for kind in (np.uint32, np.int32, np.uint8, np.int32)]
        self._store: list[Array] = [np.zeros(FIRST_POINTS, dtype=kind) for kind in (np.uint32, np.int32)]
        self._cube_of: Array = np.zeros(FIRST_POINTS, dtype=np.int32)
        self._row: Array = np.zeros(FIRST_POINTS, dtype=np.int64)
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
        while done < len(steps):
            before = int(state[2])
            loops.add(
                *(steps, self._per_side, self.most, done, state, self._slot_key, self._slot_cube, self._keys),
                *(*self._cubes, *self._store, self._cube_of, self._steps, self._row),
            )
            rows = self._row[before : state[2]]
            for name, values in self._attributes.items():
                values[before : state[2]] = attributes[name][rows]
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
        cubes = int(self._state[1])
        while True:
            halvings = self._cubes[2].copy()
            loops.spread(cubes, self._keys, self._slot_key, self._slot_cube, self._cubes[2], halvings)
            if loops.count_passing(int(self._state[2]), halvings, self._store[0], self._cube_of) <= self.limit.points:
                break
            self._halve()
        self._cubes[2] = halvings
        left = self._drop()
        return self._steps[:left], {name: values[:left].copy() for name, values in self._attributes.items()}

    def _halve(self) -> None:
        if self.most < 2 * self.limit.least_per_cube:
            raise TooManyCubesError
        self.most //= 2
        self._state[3] = loops.halve_all(int(self._state[1]), *self._cubes, *self._store, self.most)

    def _drop(self) -> int:
        """Leave out the stored points that do not stay; returns how many do."""
        seen = int(self._state[2])
        left = loops.drop(seen, self._cubes[2], self._cubes[3], *self._store, self._cube_of, self._steps, self._row)
        for values in self._attributes.values():
            values[:left] = values[self._row[:left]]
        self._state[2] = left
        return int(left)

    def _make_room(self) -> None:
        """Room for more cubes, and for more points: by dropping those that do not stay, or else by wider arrays."""
        cubes = int(self._state[1])
        if cubes == len(self._keys):
            self._keys = _wider(self._keys)
            self._cubes = [_wider(values) for values in self._cubes]
            self._slots()
        if self._state[2] < len(self._cube_of):
            return
        stored = int(self._state[2])
        if self._drop() > 0.7 * stored:
            self._store = [_wider(values) for values in self._store]
            self._cube_of, self._steps, self._row = _wider(self._cube_of), _wider(self._steps), _wider(self._row)
            self._attributes = {name: _wider(values) for name, values in self._attributes.items()}

    def _slots(self) -> None:
        """Table of the cubes with room for as many as there are places for."""
        cubes = int(self._state[1])
        count = 2 * max(2 * cubes, FIRST_CUBES)
        count = 1 << (count - 1).bit_length()
        self._slot_key, self._slot_cube = np.full(count, FREE), np.zeros(count, dtype=np.int32)
        if cubes:
            loops.number_slots(cubes, self._keys, self._slot_key, self._slot_cube)


def _wider(values: Array) -> Array:
    wider = np.zeros((2 * len(values), *values.shape[1:]), dtype=values.dtype)
    wider[: len(values)] = values
    return wider
