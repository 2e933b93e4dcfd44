"""Voxel down-sampling: Open3D's voxels, in a fixed order."""

import numpy as np
import pytest

from indoor_bim.cloud.extent import bounds
from indoor_bim.cloud.voxel_sums import sum_voxels
from indoor_bim.cloud.voxels import FEW_POINTS, voxelise, voxelise_by_sorting
from indoor_bim.filters import voxel_down_sample


def cloud_points(seed):
    rng = np.random.default_rng(seed)
    points = np.vstack([rng.uniform(-3, 3, (4000, 3)), np.round(rng.uniform(-3, 3, (1000, 3)), 1)])
    return np.vstack([points, points[:300]])


def by_place(points):
    return points[np.lexsort(np.round(points, 6).T)]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("size", [0.05, 0.3, 1.0, 20.0])
def test_same_voxels_as_open3d(seed, size):
    o3d = pytest.importorskip("open3d")
    points = cloud_points(seed) + np.array([0, 5.8e3 * (seed % 2), 0])
    expected = np.asarray(o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)).voxel_down_sample(size).points)
    thin = voxel_down_sample(points, size)
    assert thin.shape == expected.shape
    assert np.abs(by_place(thin) - by_place(expected)).max() < 1e-9 * max(size, 1.0)


def test_sorted_by_voxel_and_independent_of_order():
    points = np.random.default_rng(0).uniform(-3, 3, (5000, 3))
    thin = voxel_down_sample(points, 0.4)
    assert np.array_equal(voxel_down_sample(points[::-1], 0.4), thin)
    assert np.array_equal(voxel_down_sample(points[np.random.default_rng(1).permutation(len(points))], 0.4), thin)
    cells = np.floor((thin - (points.min(axis=0) - 0.2)) / 0.4)
    assert np.array_equal(np.lexsort(cells.T[::-1]), np.arange(len(thin)))
    assert len(np.unique(cells, axis=0)) == len(thin)


@pytest.mark.parametrize("columns", [2, 3])
@pytest.mark.parametrize("size", [0.002, 0.1, 50.0])
def test_many_points_equal_their_twin_to_the_bit(columns, size):
    points = np.random.default_rng(5).uniform(-3, 3, (2 * FEW_POINTS, columns)) ** 3 + 100
    fast, slow = voxelise(points, voxel_size=size), voxelise_by_sorting(points, voxel_size=size)
    assert np.array_equal(fast.mean, slow.mean)
    assert np.array_equal(fast.count, slow.count)
    assert np.array_equal(fast.of_point, slow.of_point)
    assert voxelise(points, voxel_size=size, members=False).of_point is None


def test_the_number_of_threads_does_not_matter():
    points = np.random.default_rng(6).uniform(-3, 3, (30_000, 3))
    low = bounds(points)[0]
    size = np.array([10**3] * 3)
    single = sum_voxels(points, low=low, voxel_size=0.05, size=size, threads=1)
    for threads in (2, 3, 8):
        for one, other in zip(single, sum_voxels(points, low=low, voxel_size=0.05, size=size, threads=threads), strict=True):
            assert np.array_equal(one, other)


def test_plan_points():
    points = cloud_points(2)
    points[:, 2] = 0.0
    assert voxel_down_sample(points[:, :2], 0.2) == pytest.approx(voxel_down_sample(points, 0.2)[:, :2], abs=1e-12)


def test_attributes_are_averaged():
    o3d = pytest.importorskip("open3d")
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [5, 0, 0]])
    legacy = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    legacy.colors = o3d.utility.Vector3dVector(np.array([[0.0, 0, 0], [1, 0.5, 0], [1, 1, 1]]))
    legacy.normals = o3d.utility.Vector3dVector(np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]))
    thin = voxel_down_sample(legacy, 1.0)
    assert np.asarray(thin.points) == pytest.approx(np.array([[0.05, 0, 0], [5, 0, 0]]), abs=1e-9)
    assert np.asarray(thin.colors) == pytest.approx(np.array([[0.5, 0.25, 0], [1, 1, 1]]))
    assert np.asarray(thin.normals) == pytest.approx(np.array([[0.5**0.5, 0.5**0.5, 0], [0, 0, 1]]))
    assert len(legacy.points) == 3
    tensor = o3d.t.geometry.PointCloud(o3d.core.Tensor(points.astype(np.float32)))
    tensor.point.intensity = o3d.core.Tensor(np.array([[10], [20], [7]], dtype=np.int32))
    thin = voxel_down_sample(tensor, 1.0)
    assert thin.point.positions.dtype == o3d.core.float32
    assert thin.point.intensity.numpy().tolist() == [[15], [7]]


def test_empty_and_wrong():
    assert voxel_down_sample(np.zeros((0, 3)), 0.1).shape == (0, 3)
    for size in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="voxel_size"):
            voxel_down_sample(np.zeros((2, 3)), size)
    with pytest.raises(ValueError, match="finite"):
        voxel_down_sample(np.array([[np.nan, 0, 0]]), 1.0)
    with pytest.raises(ValueError, match="too fine"):
        voxel_down_sample(np.array([[0.0, 0, 0], [1e9, 1e9, 1e9]]), 1e-3)


@pytest.mark.parametrize("columns", [2, 3])
def test_sparse_points_and_points_of_many_tiles_equal_their_twin(columns):
    points = np.random.default_rng(7).integers(-2000, 2000, (2 * FEW_POINTS, columns)) * 0.25
    fast, slow = voxelise(points, voxel_size=0.5), voxelise_by_sorting(points, voxel_size=0.5)
    assert np.array_equal(fast.mean, slow.mean)
    assert np.array_equal(fast.count, slow.count)
    assert np.array_equal(fast.of_point, slow.of_point)
