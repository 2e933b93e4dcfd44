"""Outlier filters that keep the same points as Open3D's and take and return the same kinds of cloud."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.open3d import as_points, select

if TYPE_CHECKING:
    import open3d as o3d

ROUNDING = 1e-9
FEW_POINTS = 20_000
"""So many points are searched by tree, sooner than the compiled search is loaded."""


@overload
def grid_radius_outlier_removal(
    pcd: NDArray[Any], nb_points: int, radius: float, print_progress: bool = False
) -> tuple[NDArray[Any], NDArray[np.int64]]: ...
@overload
def grid_radius_outlier_removal(
    pcd: o3d.geometry.PointCloud, nb_points: int, radius: float, print_progress: bool = False
) -> tuple[o3d.geometry.PointCloud, list[int]]: ...
@overload
def grid_radius_outlier_removal(
    pcd: o3d.t.geometry.PointCloud, nb_points: int, radius: float, print_progress: bool = False
) -> tuple[o3d.t.geometry.PointCloud, o3d.core.Tensor]: ...
def grid_radius_outlier_removal(pcd: Any, nb_points: int, radius: float, print_progress: bool = False) -> tuple[Any, Any]:
    """Remove points that have fewer than `nb_points` neighbours within `radius` (GROR).

    Keeps exactly the points that Open3D's legacy ``remove_radius_outlier`` keeps: a neighbour is another point (a duplicate
    counts) strictly closer than `radius`.

    Parameters
    ----------
    pcd : open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 2 or 3) ndarray
        The cloud; not modified. Points that are not finite are removed.
    nb_points : int
        Neighbours that a point needs, itself not counted; at least 1.
    radius : float
        Radius in the unit of the points, above 0.
    print_progress : bool
        Accepted for Open3D's sake; nothing is printed.

    Returns
    -------
    cloud
        Remaining points with all their attributes, same kind as `pcd`.
    index : list of int, Open3D bool tensor or (k,) int64
        Kept indices of a legacy cloud, mask of a tensor cloud, kept indices of an array.

    Raises
    ------
    ValueError
        If a parameter is out of bounds or the array has another shape.

    Notes
    -----
    Remote Sensing 2021, 13, 4930, section 2.2 (grid radius outlier removal). All neighbours of a point lie in its cell of the grid or
    in one that touches it: where these hold too few points, or an eighth of the cell holds enough, no distance is taken; elsewhere only
    until there are enough neighbours. The tensor class of Open3D counts the point itself; this function does not, whichever class it is
    given.

    Examples
    --------
    >>> row = np.stack([np.arange(5) * 0.25, np.zeros(5), np.zeros(5)], axis=1)
    >>> grid_radius_outlier_removal(row, nb_points=2, radius=0.3)[1].tolist()
    [1, 2, 3]
    >>> grid_radius_outlier_removal(row, nb_points=2, radius=0.25)[1].tolist()
    []
    """
    _check(nb_points, radius, "nb_points", "radius")
    return select(pcd, radius_inliers(as_points(pcd), nb_points=nb_points, radius=radius))


@overload
def statistical_outlier_removal(
    pcd: NDArray[Any], nb_neighbors: int, std_ratio: float, print_progress: bool = False
) -> tuple[NDArray[Any], NDArray[np.int64]]: ...
@overload
def statistical_outlier_removal(
    pcd: o3d.geometry.PointCloud, nb_neighbors: int, std_ratio: float, print_progress: bool = False
) -> tuple[o3d.geometry.PointCloud, list[int]]: ...
@overload
def statistical_outlier_removal(
    pcd: o3d.t.geometry.PointCloud, nb_neighbors: int, std_ratio: float, print_progress: bool = False
) -> tuple[o3d.t.geometry.PointCloud, o3d.core.Tensor]: ...
def statistical_outlier_removal(pcd: Any, nb_neighbors: int, std_ratio: float, print_progress: bool = False) -> tuple[Any, Any]:
    """Remove points whose mean distance to their nearest neighbours is far above the average (SOR).

    Keeps the points that Open3D's legacy ``remove_statistical_outlier`` keeps.

    Parameters
    ----------
    pcd : open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 2 or 3) ndarray
        The cloud; not modified. Points that are not finite are removed.
    nb_neighbors : int
        Nearest points to take the mean distance of, the point itself counted; at least 1.
    std_ratio : float
        Standard deviations above the average at which a point becomes an outlier; above 0.
    print_progress : bool
        Accepted for Open3D's sake; nothing is printed.

    Returns
    -------
    cloud
        Remaining points with all their attributes, same kind as `pcd`.
    index : list of int, Open3D bool tensor or (k,) int64
        Kept indices of a legacy cloud, mask of a tensor cloud, kept indices of an array.

    Raises
    ------
    ValueError
        If a parameter is out of bounds or the array has another shape.

    Notes
    -----
    A point stays when ``0 < d < mean(d) + std_ratio * std(d)`` with d its mean distance and the standard deviation of the sample
    (n - 1). As in Open3D, a point with d = 0 (as many duplicates as neighbours) goes. R. B. Rusu et al., "Towards 3D point
    cloud based object maps for household environments", Robotics and Autonomous Systems 56 (2008).

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(10.0), np.arange(10.0))
    >>> grid = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    >>> kept, index = statistical_outlier_removal(np.vstack([grid, [[50.0, 50.0, 50.0]]]), 8, 2.0)
    >>> len(kept)
    100
    """
    _check(nb_neighbors, std_ratio, "nb_neighbors", "std_ratio")
    return select(pcd, statistical_inliers(as_points(pcd), nb_neighbors=nb_neighbors, std_ratio=std_ratio))


def radius_inliers(points: NDArray[np.float64], *, nb_points: int, radius: float) -> NDArray[np.bool_]:
    """Points with at least `nb_points` other points strictly within `radius`; see `grid_radius_outlier_removal`.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        Points.
    nb_points : int
        Neighbours that a point needs.
    radius : float
        Radius, same unit.

    Returns
    -------
    (n,) bool
    """
    if len(points) > FEW_POINTS:
        from indoor_bim.cloud.radius_search import MOST_POINTS, count_within

        found = count_within(points, more_than=nb_points, radius=radius) if len(points) < MOST_POINTS else None
        if found is not None:
            return found
    finite = np.isfinite(points).all(axis=1)
    if finite.all():
        return radius_inliers_by_tree(points, nb_points=nb_points, radius=radius)
    keep = np.zeros(len(points), dtype=np.bool_)
    keep[finite] = radius_inliers(points[finite], nb_points=nb_points, radius=radius)
    return keep


def radius_inliers_by_tree(points: NDArray[np.float64], *, nb_points: int, radius: float) -> NDArray[np.bool_]:
    """Twin of `radius_inliers` by a tree over all points: slower, for few points and for coordinates too large for a grid.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        Finite points.
    nb_points : int
        Neighbours that a point needs.
    radius : float
        Radius, same unit.

    Returns
    -------
    (n,) bool
    """
    from scipy.spatial import cKDTree

    if len(points) <= nb_points:
        return np.zeros(len(points), dtype=np.bool_)
    tree = cKDTree(points, balanced_tree=False, leafsize=32)
    distance, _ = tree.query(points, k=[nb_points + 1], distance_upper_bound=radius * (1 + 2 * ROUNDING), workers=-1)
    keep: NDArray[np.bool_] = distance[:, 0] < radius * (1 - ROUNDING)
    unsure = np.flatnonzero(~keep & np.isfinite(distance[:, 0]))
    if len(unsure):
        around = tree.query_ball_point(points[unsure], radius * (1 + 2 * ROUNDING), workers=-1)
        owner = np.repeat(np.arange(len(unsure)), [len(indices) for indices in around])
        squares = (points[np.concatenate(around).astype(np.int64)] - points[unsure[owner]]) ** 2
        within = squares.T.cumsum(axis=0)[-1] < radius * radius
        keep[unsure] = np.bincount(owner, within, len(unsure)) > nb_points
    return keep


def statistical_inliers(points: NDArray[np.float64], *, nb_neighbors: int, std_ratio: float) -> NDArray[np.bool_]:
    """Points whose mean neighbour distance is not far above the average; see `statistical_outlier_removal`.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        Points.
    nb_neighbors : int
        Nearest points, the point itself counted.
    std_ratio : float
        Standard deviations above the average.

    Returns
    -------
    (n,) bool
    """
    from scipy.spatial import cKDTree

    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        keep = np.zeros(len(points), dtype=np.bool_)
        keep[finite] = statistical_inliers(points[finite], nb_neighbors=nb_neighbors, std_ratio=std_ratio)
        return keep
    if len(points) < 2:
        return np.zeros(len(points), dtype=np.bool_)
    count = min(nb_neighbors, len(points))
    distance, _ = cKDTree(points).query(points, k=np.arange(1, count + 1), workers=-1)
    mean = np.add.accumulate(distance, axis=1)[:, -1] / count
    total_mean = np.add.accumulate(mean)[-1] / len(mean)
    squares = np.where(mean > 0, (mean - total_mean) ** 2, 0.0)
    deviation = np.sqrt(np.add.accumulate(squares)[-1] / (len(mean) - 1))
    inlier: NDArray[np.bool_] = (mean > 0) & (mean < total_mean + std_ratio * deviation)
    return inlier


def _check(count: int, size: float, count_name: str, size_name: str) -> None:
    if count < 1:
        raise ValueError(f"expected {count_name} of at least 1, got {count}")
    if not (size > 0 and np.isfinite(size)):
        raise ValueError(f"expected a finite {size_name} above 0, got {size}")
