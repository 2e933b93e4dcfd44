"""Integer cells of a regular grid as sortable keys."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray


def cell_indices(points: NDArray[np.float64], *, low: NDArray[np.float64], edge: float) -> NDArray[np.int64]:
    """Cell of each point: ``floor((point - low) / edge)``.

    Parameters
    ----------
    points : (n, d) float64
        Points.
    low : (d,) float64
        Lower corner of cell 0.
    edge : float
        Edge of a cell, same unit.

    Returns
    -------
    (n, d) int64
    """
    return np.floor((points - low) / edge).astype(np.int64)


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


def neighbour_offsets(shape: NDArray[np.int64]) -> NDArray[np.int64]:
    """Differences of the keys of a cell and its direct neighbours, itself included.

    Parameters
    ----------
    shape : (d,) int64
        Number of cells along each axis; cells at the border must be empty.

    Returns
    -------
    (3**d,) int64
    """
    around = np.array(list(itertools.product((-1, 0, 1), repeat=len(shape))), dtype=np.int64)
    strides = np.append(np.cumprod(shape[:0:-1])[::-1], 1)
    offsets: NDArray[np.int64] = around @ strides
    return offsets


def sorted_unique(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Distinct keys in ascending order, by sorting: faster for millions of keys than the hashing of `numpy.unique`.

    Parameters
    ----------
    keys : (n,) int64
        Keys.

    Returns
    -------
    (k,) int64
    """
    ordered = np.sort(keys)
    distinct: NDArray[np.int64] = ordered[np.append(True, ordered[1:] != ordered[:-1])] if len(ordered) else ordered
    return distinct
