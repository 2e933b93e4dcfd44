"""Integer cells of a regular grid as sortable keys."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def cell_keys(cells: NDArray[np.int64], shape: NDArray[np.int64]) -> NDArray[np.int64]:
    """One integer for each cell, in lexicographic order of the indices.

    Parameters
    ----------
    cells : (n, d) int64
        Indices from 0.
    shape : (d,) int64
        Number of cells along each axis.

    Returns
    -------
    (n,) int64

    Raises
    ------
    ValueError
        If the grid has more cells than an integer can count.
    """
    if float(np.prod(shape.astype(np.float64))) >= 2.0**62:
        raise ValueError("the grid is too fine for the extent of the points: take larger cells or leave out stray points")
    key = cells[:, 0].copy()
    for axis in range(1, cells.shape[1]):
        key *= shape[axis]
        key += cells[:, axis]
    return key
