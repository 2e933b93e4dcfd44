"""Voxel down-sampling in a fixed order, independent of the order of the points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.extent import bounds
from indoor_bim.cloud.open3d import ARRAY, LEGACY, TENSOR, as_points, kind_of

if TYPE_CHECKING:
    import open3d as o3d

RESOLUTION = 2.0**32
MOST_VOXELS = 2.0**62
FEW_POINTS = 20_000
"""So many points are sorted, sooner than the compiled sums are loaded."""


@dataclass(frozen=True, slots=True, eq=False)
class Voxels:
    """Occupied voxels in lexicographic order of their indices.

    Parameters
    ----------
    mean : (k, d) float64
        Mean of the points in each voxel.
    count : (k,) int64
        Number of points in each voxel.
    of_point : (n,) int64, optional
        Voxel of each point.
    """

    mean: NDArray[np.float64]
    count: NDArray[np.int64]
    of_point: NDArray[np.int64] | None


@overload
def voxel_down_sample(pcd: NDArray[Any], voxel_size: float) -> NDArray[np.float64]: ...
@overload
def voxel_down_sample(pcd: o3d.geometry.PointCloud, voxel_size: float) -> o3d.geometry.PointCloud: ...
@overload
def voxel_down_sample(pcd: o3d.t.geometry.PointCloud, voxel_size: float) -> o3d.t.geometry.PointCloud: ...
def voxel_down_sample(pcd: Any, voxel_size: float) -> Any:
    """Replace the points of each voxel by their mean.

    The voxels are those of Open3D's legacy ``voxel_down_sample``: the grid begins half a voxel below the smallest coordinates. The
    result is sorted by voxel (x, then y, then z index) and does not depend on the order of the points.

    Parameters
    ----------
    pcd : open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 2 or 3) ndarray
        The cloud; not modified.
    voxel_size : float
        Edge of a voxel in the unit of the points, above 0.

    Returns
    -------
    cloud
        One point for each occupied voxel, same kind as `pcd`. Colours and other attributes are averaged, normals averaged and
        brought to length 1.

    Raises
    ------
    ValueError
        If the voxel size is not above 0 or far too small for the extent, or a coordinate is not finite.

    Examples
    --------
    >>> voxel_down_sample(np.array([[2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.25, 0.0, 0.0]]), 1.0).tolist()
    [[0.125, 0.0, 0.0], [2.0, 0.0, 0.0]]
    """
    points, kind = as_points(pcd), kind_of(pcd)
    bare = kind == ARRAY or (kind == LEGACY and not (pcd.has_colors() or pcd.has_normals()))
    voxels = voxelise(points, voxel_size=voxel_size, members=not bare)
    if kind == LEGACY:
        return _legacy(pcd, voxels)
    if kind == TENSOR:
        return _tensor(pcd, voxels)
    return voxels.mean


def voxelise(points: NDArray[np.float64], *, voxel_size: float, members: bool = True) -> Voxels:
    """Sort points into voxels; see `voxel_down_sample`.

    Means are summed in steps of 2**-32 voxel, so that the sums are exact and no order of the points shows.

    Parameters
    ----------
    points : (n, d) float64
        Finite points.
    voxel_size : float
        Edge of a voxel, same unit.
    members : bool
        Whether `Voxels.of_point` is wanted.

    Returns
    -------
    Voxels

    Raises
    ------
    ValueError
        As `voxel_down_sample`.
    """
    if not (voxel_size > 0 and np.isfinite(voxel_size)):
        raise ValueError(f"expected a finite voxel_size above 0, got {voxel_size}")
    if len(points) == 0:
        return Voxels(points.copy(), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    if len(points) <= FEW_POINTS:
        return voxelise_by_sorting(points, voxel_size=voxel_size, members=members)
    from indoor_bim.cloud.voxel_sums import strides_of, sum_voxels, voxel_of_points

    low, size = _grid(*bounds(points), voxel_size=voxel_size)
    strides = strides_of(size)
    keys, count, mean = sum_voxels(points, low=low, voxel_size=voxel_size, size=size)
    of_point = voxel_of_points(points, low=low, voxel_size=voxel_size, strides=strides, keys=keys) if members else None
    return Voxels(mean, count, of_point)


def voxelise_by_sorting(points: NDArray[np.float64], *, voxel_size: float, members: bool = True) -> Voxels:
    """Twin of `voxelise` in numpy: slower, for few points."""
    low, size = _grid(points.min(axis=0), points.max(axis=0), voxel_size=voxel_size)
    strides = np.append(np.cumprod(size[:0:-1])[::-1], 1)
    place = (points - low) / voxel_size
    floor = np.floor(place)
    _, first, of_point, count = np.unique(floor.astype(np.int64) @ strides, return_index=True, return_inverse=True, return_counts=True)
    steps = np.floor((place - floor) * RESOLUTION)
    inside = np.stack([np.bincount(of_point, column) for column in steps.T], axis=1) / (RESOLUTION * count[:, None])
    return Voxels(low + voxel_size * (floor[first] + inside), count, of_point if members else None)


def _grid(low: NDArray[np.float64], high: NDArray[np.float64], *, voxel_size: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Lower corner of the grid and the number of its voxels along each axis."""
    low = low - 0.5 * voxel_size
    if not np.isfinite(high - low).all():
        raise ValueError("expected finite coordinates: remove points that are not finite first")
    size = np.floor((high - low) / voxel_size) + 1
    if float(np.prod(size)) >= MOST_VOXELS:
        raise ValueError("the grid is too fine for the extent of the points: take larger cells or leave out stray points")
    return low, size.astype(np.int64)


def _average(values: NDArray[Any], voxels: Voxels, *, unit_length: bool) -> NDArray[Any]:
    """Mean of an attribute in each voxel."""
    if voxels.of_point is None:
        raise ValueError("expected voxels that know their points")
    columns = values.reshape(len(values), -1).astype(np.float64)
    mean = np.stack([np.bincount(voxels.of_point, column, len(voxels.count)) for column in columns.T], axis=1) / voxels.count[:, None]
    if unit_length:
        length = np.linalg.norm(mean, axis=1, keepdims=True)
        mean = np.divide(mean, length, out=np.zeros_like(mean), where=length > 0)
    if np.issubdtype(values.dtype, np.integer):
        mean = np.rint(mean)
    return mean.reshape((len(mean), *values.shape[1:])).astype(values.dtype)


def _legacy(pcd: Any, voxels: Voxels) -> Any:
    import open3d as o3d

    thin = o3d.geometry.PointCloud()
    thin.points = o3d.utility.Vector3dVector(voxels.mean)
    if pcd.has_colors():
        thin.colors = o3d.utility.Vector3dVector(_average(np.asarray(pcd.colors), voxels, unit_length=False))
    if pcd.has_normals():
        thin.normals = o3d.utility.Vector3dVector(_average(np.asarray(pcd.normals), voxels, unit_length=True))
    return thin


def _tensor(pcd: Any, voxels: Voxels) -> Any:
    import open3d as o3d

    thin = o3d.t.geometry.PointCloud(pcd.device)
    if len(voxels.count) == 0:
        return pcd.clone()
    for name in sorted(pcd.point):
        values = pcd.point[name].cpu().numpy()
        mean = voxels.mean.astype(values.dtype) if name == "positions" else _average(values, voxels, unit_length=name == "normals")
        thin.point[name] = o3d.core.Tensor.from_numpy(np.ascontiguousarray(mean)).to(pcd.device)
    return thin
