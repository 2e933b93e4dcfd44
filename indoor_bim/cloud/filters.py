"""Outlier filters that keep the same points as Open3D's and take and return the same kinds of cloud."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.grid import cell_indices, cell_keys, neighbour_offsets, sorted_unique
from indoor_bim.cloud.open3d import as_points, select

if TYPE_CHECKING:
    import open3d as o3d

ROUNDING = 1e-9
MOST_CELLS = 2.0**60


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
    Remote Sensing 2021, 13, 4930, section 2.2 (grid radius outlier removal). Points of a cell whose diagonal is shorter than the
    radius are all neighbours of each other: a cell with more than `nb_points` points is kept without a distance. Distances
    are taken for the sparse cells only. The tensor class of Open3D counts the point itself; this function does not,
    whichever class it is given.

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
    keep = np.zeros(len(points), dtype=np.bool_)
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        keep[finite] = radius_inliers(points[finite], nb_points=nb_points, radius=radius)
        return keep
    if len(points) <= nb_points:
        return keep
    low, extent = points.min(axis=0), float(np.ptp(points, axis=0).max())
    rounding = max(ROUNDING, 16 * np.finfo(np.float64).eps * (extent + float(np.abs(points).max())) / radius)
    if rounding > 0.01 or np.prod(np.ptp(points, axis=0) / radius * 2 + 4) >= MOST_CELLS:
        return _radius_inliers_by_distance(points, points, nb_points=nb_points, radius=radius)
    order, full = _full_cells(points, low=low, edge=radius / np.sqrt(points.shape[1]) * (1 - rounding), more_than=nb_points)
    if not full.all():
        ordered = points[order]
        near = ordered[_near(ordered, ~full, low=low, edge=radius * (1 + rounding))]
        full[~full] = _radius_inliers_by_distance(ordered[~full], near, nb_points=nb_points, radius=radius)
    keep[order] = full
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


def _full_cells(
    points: NDArray[np.float64], *, low: NDArray[np.float64], edge: float, more_than: int
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Order of the points by cell, and in that order whether a point's cell holds more than that many points."""
    cells = cell_indices(points, low=low, edge=edge)
    key = cell_keys(cells, cells.max(axis=0) + 1)
    order = np.argsort(key, kind="stable")
    key = key[order]
    starts = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    counts = np.diff(np.append(starts, len(key)))
    return order, np.repeat(counts > more_than, counts)


def _near(points: NDArray[np.float64], chosen: NDArray[np.bool_], *, low: NDArray[np.float64], edge: float) -> NDArray[np.bool_]:
    """Points in the cells of the chosen points and in the cells beside them; all points where that leaves few out."""
    if np.count_nonzero(chosen) > 0.3 * len(points):
        return np.ones(len(points), dtype=np.bool_)
    cells = cell_indices(points, low=low, edge=edge) + 1
    shape = cells.max(axis=0) + 2
    key = cell_keys(cells, shape)
    around = sorted_unique((sorted_unique(key[chosen])[:, None] + neighbour_offsets(shape)).ravel())
    place = np.minimum(np.searchsorted(around, key), len(around) - 1)
    near: NDArray[np.bool_] = around[place] == key
    return near


def _radius_inliers_by_distance(
    queries: NDArray[np.float64], points: NDArray[np.float64], *, nb_points: int, radius: float
) -> NDArray[np.bool_]:
    """Which queries, themselves among the points, have more than `nb_points` points strictly within the radius."""
    from scipy.spatial import cKDTree

    if len(points) <= nb_points:
        return np.zeros(len(queries), dtype=np.bool_)
    tree = cKDTree(points, balanced_tree=False, leafsize=32)
    distance, _ = tree.query(queries, k=[nb_points + 1], distance_upper_bound=radius * (1 + 2 * ROUNDING), workers=-1)
    keep: NDArray[np.bool_] = distance[:, 0] < radius * (1 - ROUNDING)
    unsure = np.flatnonzero(~keep & np.isfinite(distance[:, 0]))
    if len(unsure):
        around = tree.query_ball_point(queries[unsure], radius * (1 + 2 * ROUNDING), workers=-1)
        owner = np.repeat(np.arange(len(unsure)), [len(indices) for indices in around])
        squares = (points[np.concatenate(around).astype(np.int64)] - queries[unsure[owner]]) ** 2
        within = squares.T.cumsum(axis=0)[-1] < radius * radius
        keep[unsure] = np.bincount(owner, within, len(unsure)) > nb_points
    return keep
