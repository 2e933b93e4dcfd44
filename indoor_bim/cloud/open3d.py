"""Open3D clouds in, Open3D clouds out: the boundary at which they become arrays and come back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

LEGACY, TENSOR, ARRAY = "legacy", "tensor", "array"


def kind_of(pcd: Any) -> str:
    """Kind of a cloud: an Open3D legacy cloud, an Open3D tensor cloud or an array. Imports Open3D for its own objects only.

    Parameters
    ----------
    pcd : open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 2 or 3) array_like
        The cloud.

    Returns
    -------
    str
        `LEGACY`, `TENSOR` or `ARRAY`.

    Raises
    ------
    TypeError
        If it is another Open3D object.
    """
    if not type(pcd).__module__.startswith("open3d"):
        return ARRAY
    import open3d as o3d

    if isinstance(pcd, o3d.geometry.PointCloud):
        return LEGACY
    if isinstance(pcd, o3d.t.geometry.PointCloud):
        return TENSOR
    raise TypeError(f"expected a point cloud, got {type(pcd).__name__}")


def as_points(pcd: Any) -> NDArray[np.float64]:
    """Points of a cloud as an array, a view where possible; never write to it.

    Parameters
    ----------
    pcd : open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 2 or 3) array_like
        The cloud.

    Returns
    -------
    (n, 2 or 3) float64

    Raises
    ------
    ValueError
        If the shape is another.
    """
    kind = kind_of(pcd)
    if kind == LEGACY:
        xyz = np.asarray(pcd.points)
    elif kind == TENSOR:
        xyz = pcd.point.positions.cpu().numpy() if "positions" in pcd.point else np.zeros((0, 3))
    else:
        xyz = np.asarray(pcd)
    if xyz.ndim != 2 or xyz.shape[1] not in (2, 3):
        raise ValueError(f"expected points of shape (n, 3) or (n, 2), got {xyz.shape}")
    return xyz.astype(np.float64, copy=False)


def select(pcd: Any, keep: NDArray[np.bool_]) -> tuple[Any, Any]:
    """Chosen points of a cloud with all their attributes, and the choice as that kind of cloud states it.

    Parameters
    ----------
    pcd : open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 2 or 3) array_like
        The cloud; not modified.
    keep : (n,) bool
        True for points to keep.

    Returns
    -------
    cloud
        Cloud of the same kind.
    index : list of int, Open3D bool tensor or (k,) int64
        Kept indices of a legacy cloud, mask of a tensor cloud, kept indices of an array.
    """
    kind = kind_of(pcd)
    if kind == LEGACY:
        index = np.flatnonzero(keep).tolist()
        return pcd.select_by_index(index), index
    if kind == TENSOR:
        import open3d as o3d

        mask = o3d.core.Tensor.from_numpy(np.ascontiguousarray(keep)).to(pcd.device)
        return (pcd.select_by_mask(mask) if len(keep) else pcd.clone()), mask
    from indoor_bim.threads import even_slices, in_threads, threads_for

    rows, points = np.flatnonzero(keep), np.asarray(pcd)
    chosen, threads = np.zeros((len(rows), *points.shape[1:]), dtype=points.dtype), threads_for(len(rows))
    in_threads(
        lambda part: points.take(rows[part], axis=0, out=chosen[part], mode="clip"), even_slices(len(rows), threads), threads=threads
    )
    return chosen, rows
