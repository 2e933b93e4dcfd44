"""Where walls were scanned thinly right below the ceiling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import FEW_POINTS, WallPoints, clamp_sample, towards_scanner
from indoor_bim.plan.raster import Raster
from indoor_bim.threads import even_slices, in_threads, threads_for

Bools = NDArray[np.bool_]


def thinly_scanned(
    points: WallPoints, overhead: Raster, *, sparse: float, whole: bool = False, cell: float = 0.40, step: float = 0.30
) -> Bools:
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
    whole : bool
        The columns have to be sparse down to the floor.
    cell : float
        Side of the cubes that make up the columns, metres.
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
    if len(points) > FEW_POINTS:
        return _thinly_scanned_of_many(points, overhead, sparse=sparse, whole=whole, cell=cell, step=step)
    columns = [np.floor(values / cell).astype(np.int64) for values in points.xy.T]
    columns = [column - column.min() for column in columns]
    shape = [int(column.max()) + 1 for column in columns]
    quarter = np.zeros(len(points), dtype=np.int64)
    spot = points.xy
    if points.sensor is not None:
        x, y = (points.sensor[:, k] - points.xy[:, k] for k in range(2))
        crosswise = np.abs(x) > np.abs(y)
        quarter = 2 * crosswise + np.where(crosswise, x > 0, y > 0)
        spot = towards_scanner(points.xy, points.sensor, step)
    key = (quarter * shape[0] + columns[0]) * shape[1] + columns[1]
    layer = np.maximum((points.depth / cell).astype(np.int64), 0)
    densest = np.zeros(4 * shape[0] * shape[1], dtype=np.int64)
    for height in range(int(layer.max()) + 1 if whole else 1):
        np.maximum(densest, np.bincount(key[layer == height], minlength=len(densest)), out=densest)
    few: Bools = ndimage.maximum_filter(densest.reshape(4, *shape), size=(1, 3, 3)).ravel()[key] < sparse * cell**2
    return few & (clamp_sample(overhead, spot) < sparse)


def _thinly_scanned_of_many(points: WallPoints, overhead: Raster, *, sparse: float, whole: bool, cell: float, step: float) -> Bools:
    """As `thinly_scanned`, a share of the points in each thread."""
    from scipy import ndimage

    from indoor_bim.plan.density_loops import count_in_columns, in_thin_columns

    xy, depth = np.ascontiguousarray(points.xy), np.ascontiguousarray(points.depth)
    sensor = np.zeros((0, 2)) if points.sensor is None else np.ascontiguousarray(points.sensor)
    (column, row), (last_column, last_row) = np.floor(points.corners / cell).astype(np.int64).tolist()
    layers = max(int(depth.max() / cell), 0) + 1 if whole else 1
    parts = even_slices(len(points), threads_for(len(points)))
    counts = np.zeros((len(parts), layers, 4, last_column - column + 1, last_row - row + 1), dtype=np.int64)
    in_threads(
        lambda k: count_in_columns(xy[parts[k]], sensor[parts[k]], depth[parts[k]], cell, column, row, counts[k]),
        range(len(parts)),
        threads=len(parts),
    )
    densest = ndimage.maximum_filter(counts.sum(axis=0).max(axis=0), size=(1, 3, 3))
    image = np.ascontiguousarray(overhead.image, dtype=np.float32)
    place = (float(overhead.origin[0]), float(overhead.origin[1]), overhead.cell)
    thin = np.zeros(len(points), dtype=bool)
    in_threads(
        lambda part: in_thin_columns(
            xy[part], sensor[part], cell, column, row, densest, sparse * cell**2, image, *place, step, sparse, thin[part]
        ),
        parts,
        threads=len(parts),
    )
    return thin
