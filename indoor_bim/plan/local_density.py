"""Where walls were scanned thinly right below the ceiling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints, clamp_sample
from indoor_bim.plan.raster import Raster

Bools = NDArray[np.bool_]


def thinly_scanned(points: WallPoints, overhead: Raster, *, sparse: float, cell: float = 0.40, step: float = 0.30) -> Bools:
    """Points of columns whose upper end holds few points per area, as walls that were seen from far away or through a door.

    The points are counted for each of the four quarters that they were seen from, so that the far side of a wall that is
    dense on the near side is sparse.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    overhead : Raster
        Points per square metre of the surface overhead.
    sparse : float
        Points per square metre below which a surface is sparse.
    cell : float
        Side of the columns, and the height of their upper end, metres.
    step : float
        The surface overhead is looked up this far towards the scanner, metres.

    Returns
    -------
    (n,) bool
        Points in columns with fewer at the upper end, their neighbours included, and below a surface that has fewer.
    """
    from scipy import ndimage

    if not len(points):
        return np.zeros(0, dtype=bool)
    columns = np.floor(points.xy / cell).astype(np.int64)
    columns -= columns.min(axis=0)
    shape = columns.max(axis=0) + 1
    quarter = np.zeros(len(points), dtype=np.int64)
    spot = points.xy
    if points.sensor is not None:
        towards = points.sensor - points.xy
        x, y = towards.T
        quarter = 2 * (np.abs(x) > np.abs(y)) + np.where(np.abs(x) > np.abs(y), x > 0, y > 0)
        spot = spot + step * towards / np.maximum(np.hypot(x, y), 1e-9)[:, None]
    key = (quarter * shape[0] + columns[:, 0]) * shape[1] + columns[:, 1]
    count = np.bincount(key[points.depth < cell], minlength=4 * int(shape.prod())).reshape(4, *shape)
    few: Bools = ndimage.maximum_filter(count, size=(1, 3, 3)).ravel()[key] < sparse * cell**2
    return few & (clamp_sample(overhead, spot) < sparse)
