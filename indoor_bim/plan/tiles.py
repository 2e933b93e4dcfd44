"""Points kept tile by tile of the plan, so that what lies along a line is found without looking at the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TILE = 0.5
"""Side of a tile, metres; a whole number of the cells that points are grouped in, so that these stay together."""


@dataclass(frozen=True, slots=True, eq=False)
class Tiles:
    """Where the points of each tile are in a table that is ordered by tile.

    Parameters
    ----------
    low : (2,) int64
        Column (along x) and row (along y) of the first tile; tiles lie on multiples of `TILE`.
    columns : int
        Tiles in a row.
    first : (rows * columns + 1,) int64
        Place of the first point of each tile, row by row, and the number of points.
    """

    low: Ints
    columns: int
    first: Ints

    @property
    def corners(self) -> Floats:
        """Corners (2, 2) of the rectangle that the tiles cover, metres."""
        shape = np.array([self.columns, (len(self.first) - 1) // self.columns])
        covered: Floats = np.stack([self.low, self.low + shape]) * TILE
        return covered

    def along(self, p: Floats, q: Floats, reach: float) -> Ints:
        """Ranges (k, 2) of the table with all points within reach of the line from p to q, and some others.

        Examples
        --------
        >>> tiles = Tiles(np.array([0, 0]), 4, np.arange(0, 90, 10))
        >>> tiles.along(np.array([0.6, 0.7]), np.array([1.2, 0.7]), 0.05).tolist()
        [[50, 70]]
        """
        rows = (len(self.first) - 1) // self.columns
        low, high = np.minimum(p, q) - reach, np.maximum(p, q) + reach
        first, last = (int(np.floor(y / TILE)) - int(self.low[1]) for y in (low[1], high[1]))
        row = np.arange(max(first, 0), min(last, rows - 1) + 1)
        if not len(row):
            return np.zeros((0, 2), dtype=np.int64)
        ends = (row[:, None] + np.array([0, 1]) + self.low[1]) * TILE + np.array([-reach, reach])
        rise = q[1] - p[1]
        share = np.clip((ends - p[1]) / rise, 0.0, 1.0) if abs(rise) > reach else np.tile([0.0, 1.0], (len(row), 1))
        x = p[0] + share * (q[0] - p[0])
        left = np.floor((x.min(axis=1) - reach) / TILE).astype(np.int64) - self.low[0]
        right = np.floor((x.max(axis=1) + reach) / TILE).astype(np.int64) - self.low[0] + 1
        left, right = np.clip(left, 0, self.columns), np.clip(right, 0, self.columns)
        ranges: Ints = np.column_stack([self.first[row * self.columns + left], self.first[row * self.columns + right]])
        return ranges[ranges[:, 0] < ranges[:, 1]]


def tiles_of(xy: Floats) -> tuple[Tiles, Ints]:
    """Tiles of points (n, 2), and the order (n,) that sorts them into these."""
    cells = np.floor(xy / TILE).astype(np.int64)
    low, high = (cells.min(axis=0), cells.max(axis=0)) if len(cells) else (np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.int64))
    columns, rows = (int(side) for side in high - low + 1)
    tile = (cells[:, 1] - low[1]) * columns + cells[:, 0] - low[0]
    first = np.concatenate([[0], np.cumsum(np.bincount(tile, minlength=rows * columns))]).astype(np.int64)
    return Tiles(low, columns, first), np.argsort(tile, kind="stable")
