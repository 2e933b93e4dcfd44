"""Turning and shifting points in bulk."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

FEW_POINTS = 20_000
"""So many points are turned in numpy, sooner than the compiled loop is loaded."""


def moved(points: Floats, rotation: Floats, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Points turned about the origin and then shifted; the same on every machine, for it is no matrix product of a library.

    Parameters
    ----------
    points : (n, 3) float64
        Points.
    rotation : (3, 3) float64
        Matrix whose rows are the new axes.
    shift : (3,) array_like
        Added after the turn, same unit.

    Returns
    -------
    (n, 3) float64

    Examples
    --------
    >>> moved(np.array([[1.0, 0.0, 2.0]]), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), (0, 0, 1)).tolist()
    [[0.0, 1.0, 3.0]]
    """
    offset = np.asarray(shift, dtype=np.float64)
    if len(points) <= FEW_POINTS:
        x, y, z = points.T
        return np.column_stack([x * r[0] + y * r[1] + z * r[2] + s for r, s in zip(rotation, offset, strict=True)])
    from indoor_bim.cloud.point_loops import move
    from indoor_bim.threads import even_slices, in_threads, threads_for

    points, rotation = np.ascontiguousarray(points), np.ascontiguousarray(rotation)
    out = np.zeros(points.shape)
    threads = threads_for(len(points))
    in_threads(lambda part: move(points[part], rotation, offset, out[part]), even_slices(len(points), threads), threads=threads)
    return out
