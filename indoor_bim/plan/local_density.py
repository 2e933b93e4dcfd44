"""How densely the surfaces around each wall point were scanned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints, clamp_sample
from indoor_bim.plan.raster import Raster

Bools = NDArray[np.bool_]


def thinly_scanned(points: WallPoints, overhead: Raster, *, sparse: float = 300.0, cell: float = 0.40, step: float = 0.30) -> Bools:
    """Points on surfaces that hold few points per area, as walls that were seen from far away or through a door.

    The points are counted in cubes, for each of the four quarters that they were seen from, so that the far side of a
    wall that is dense on the near side is sparse.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    overhead : Raster
        Points per square metre of the surface overhead.
    sparse : float
        Points per square metre below which a surface is sparse.
    cell : float
        Side of the cubes, metres.
    step : float
        The surface overhead is looked up this far towards the scanner, metres.

    Returns
    -------
    (n,) bool
        Points that have fewer in their own cube and in those around it, and below a surface that has fewer.
    """
    from scipy import ndimage

    if not len(points):
        return np.zeros(0, dtype=bool)
    cubes = np.floor(np.column_stack([points.xy, points.depth]) / cell).astype(np.int64)
    cubes -= cubes.min(axis=0)
    shape = cubes.max(axis=0) + 1
    quarter = np.zeros(len(points), dtype=np.int64)
    if points.sensor is not None:
        x, y = (points.sensor - points.xy).T
        quarter = 2 * (np.abs(x) > np.abs(y)) + np.where(np.abs(x) > np.abs(y), x > 0, y > 0)
    key = ((quarter * shape[0] + cubes[:, 0]) * shape[1] + cubes[:, 1]) * shape[2] + cubes[:, 2]
    count = np.bincount(key, minlength=4 * int(shape.prod())).reshape(4, *shape)
    most = ndimage.maximum_filter(count, size=(1, 3, 3, 3))
    few: Bools = most.ravel()[key] < sparse * cell**2
    spot = points.xy
    if points.sensor is not None:
        towards = points.sensor - points.xy
        spot = spot + step * towards / np.maximum(np.hypot(*towards.T), 1e-9)[:, None]
    return few & (clamp_sample(overhead, spot) < sparse)
