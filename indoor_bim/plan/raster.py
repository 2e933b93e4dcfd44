"""Images in plan with a place in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Image over the plan; pixel ``[i, j]`` covers x from ``origin[0] + j * cell`` and y from ``origin[1] + i * cell``.

    Parameters
    ----------
    image : (rows, columns) array
        Values; rows run along y, columns along x.
    origin : (2,) float64
        Lower left corner of pixel [0, 0], metres.
    cell : float
        Side of a pixel, metres.
    """

    image: NDArray
    origin: Floats
    cell: float

    def pixel(self, xy: Floats) -> NDArray[np.int64]:
        """Row and column (n, 2) of the pixels that hold points (n, 2); outside points give indices outside the image."""
        return np.floor((np.asarray(xy, dtype=np.float64) - self.origin) / self.cell).astype(np.int64)[:, ::-1]

    def centre(self, rows_columns: NDArray[np.int64]) -> Floats:
        """Centres (n, 2) in metres of pixels (n, 2) given as row, column."""
        return self.origin + (np.asarray(rows_columns, dtype=np.float64)[:, ::-1] + 0.5) * self.cell

    def sample(self, xy: Floats, outside: float = 0) -> NDArray:
        """Values (n,) of the pixels under points (n, 2); `outside` where there is no image."""
        rc = self.pixel(xy)
        inside = ((rc >= 0) & (rc < self.image.shape)).all(axis=1)
        out = np.full(len(rc), outside, dtype=np.result_type(self.image.dtype, type(outside)))
        out[inside] = self.image[rc[inside, 0], rc[inside, 1]]
        return out


def count_raster(xy: Floats, *, cell: float) -> Raster:
    """Count points per pixel.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    cell : float
        Side of a pixel, metres; pixels lie on multiples of it.

    Examples
    --------
    >>> count_raster(np.array([[0.1, 0.1], [0.2, 0.1], [1.5, 0.1]]), cell=1.0).image.tolist()
    [[2, 1]]
    """
    if not len(xy):
        return Raster(np.zeros((1, 1), dtype=np.int64), np.zeros(2), cell)
    index = np.floor(np.asarray(xy, dtype=np.float64) / cell).astype(np.int64)
    low = index.min(axis=0)
    columns, rows = index.max(axis=0) - low + 1
    key = (index[:, 1] - low[1]) * columns + index[:, 0] - low[0]
    return Raster(np.bincount(key, minlength=int(rows * columns)).reshape(rows, columns), low * cell, cell)
