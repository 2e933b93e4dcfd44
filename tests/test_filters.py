"""Filters keep what Open3D keeps, in whichever kind of cloud."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from indoor_bim.cloud.filters import FEW_POINTS, radius_inliers, radius_inliers_by_tree
from indoor_bim.cloud.radius_search import count_within
from indoor_bim.filters import grid_radius_outlier_removal, statistical_outlier_removal

RADII = (0.25, 0.1, 0.3, 1 / 3)


def legacy_cloud(points):
    import open3d as o3d

    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))


def awkward_points(seed, radius):
    """Random points, duplicates, a line of points exactly a radius apart and a lattice of half a radius."""
    rng = np.random.default_rng(seed)
    free = rng.uniform(-1, 1, (1500, 3)) * [1, 1, 0.1 * (seed % 3)]
    lattice = np.round(rng.uniform(-1, 1, (1000, 3)) / radius * 2) * radius / 2
    line = np.arange(200)[:, None] * np.array([radius, 0, 0])
    points = np.vstack([free, free[:100], free[:40], free[:40], lattice, lattice[:80], line])
    return points + np.array([0, 5.8e6 if seed % 5 == 0 else 0, 0])


def brute_force(points, nb_points, radius):
    squares = ((points[:, None] - points[None]) ** 2).cumsum(axis=2)[:, :, -1]
    return (squares < radius * radius).sum(axis=1) > nb_points


def by_cells(points, nb_points, radius, **options):
    keep = count_within(points, more_than=nb_points, radius=radius, **options)
    assert keep is not None
    return keep


@pytest.mark.parametrize("seed", range(20))
def test_radius_filter_keeps_the_points_that_open3d_keeps(seed):
    radius, nb_points = RADII[seed % 4], int(np.random.default_rng(seed).integers(1, 12))
    points = awkward_points(seed, radius)
    expected = legacy_cloud(points).remove_radius_outlier(nb_points, radius)[1]
    kept, index = grid_radius_outlier_removal(points, nb_points, radius)
    assert index.tolist() == list(expected)
    assert np.array_equal(kept, points[index])
    assert 0 < len(index) < len(points)
    assert np.flatnonzero(by_cells(points, nb_points, radius)).tolist() == list(expected)


def walls_with_noise(count, seed=0):
    """Two crossing walls 4 mm rough with stray points and duplicates, shuffled; dense and sparse cells side by side."""
    rng = np.random.default_rng(seed)
    along, across, height = rng.random(count) ** 2 * 6, rng.normal(0, 0.004, count), rng.random(count) * 2.5
    walls = np.stack([along, across, height], axis=1)
    walls[::3] = walls[::3, [1, 0, 2]]
    stray = rng.uniform(-1, 6, (count // 10, 3))
    return rng.permutation(np.vstack([walls, stray, walls[: count // 20]]))


@pytest.mark.parametrize(("columns", "nb_points", "radius"), [(3, 10, 0.03), (3, 60, 0.03), (3, 2, 0.004), (2, 150, 0.02), (3, 1500, 0.2)])
def test_radius_filter_on_many_points_equals_its_twin(columns, nb_points, radius):
    points = np.ascontiguousarray(walls_with_noise(60_000)[:, :columns])
    assert len(points) > FEW_POINTS
    keep = radius_inliers(points, nb_points=nb_points, radius=radius)
    assert np.array_equal(keep, radius_inliers_by_tree(points, nb_points=nb_points, radius=radius))
    assert 0.02 < keep.mean() < 0.98


@pytest.mark.parametrize(
    ("points", "nb_points", "radius"),
    [
        (np.round(walls_with_noise(60_000), 2), 6, 0.05),
        (np.round(walls_with_noise(60_000) / 0.05) * 0.05 + np.array([5e5, 5.8e6, 0]), 6, 0.05),
        (walls_with_noise(60_000) * 1000, 1, 3.0),
        (np.repeat(walls_with_noise(600), 50, axis=0), 49, 0.01),
        (np.vstack([walls_with_noise(60_000), [[1e5, 1e5, 0]]]), 5, 0.02),
        (np.insert(walls_with_noise(60_000) + np.array([5e6, 5.8e7, 0]), 0, 0.0, axis=0), 5, 0.02),
        (np.arange(30_000.0)[:, None] * [0.03, 0, 0], 2, 0.0300001),
    ],
    ids=["at the radius", "at the radius, far away", "sparse", "duplicates", "a stray point", "the first point astray", "a line"],
)
def test_radius_filter_on_awkward_points_equals_its_twin(points, nb_points, radius):
    keep = radius_inliers(points, nb_points=nb_points, radius=radius)
    assert np.array_equal(keep, radius_inliers_by_tree(points, nb_points=nb_points, radius=radius))
    assert keep.any()


def test_the_densest_of_clouds_takes_no_distances():
    points = np.random.default_rng(3).permutation(np.vstack([walls_with_noise(60_000) * 1e-3, [[0.1, 0.1, 0.1]] * 5]))
    keep = by_cells(points, 10, 0.02)
    assert np.array_equal(np.flatnonzero(~keep), np.flatnonzero(points[:, 0] == 0.1))


def test_points_too_far_apart_or_nowhere_are_not_searched_by_cells():
    points = walls_with_noise(3000)
    for stray in ([1e7, 0, 0], [np.nan, 0, 0], [0, np.inf, 0]):
        for place in (0, 2000, 3000):
            assert count_within(np.insert(points, place, stray, axis=0), more_than=3, radius=0.03) is None


def test_neither_threads_nor_memory_layout_nor_order_matter():
    points = walls_with_noise(60_000, seed=1)
    keep = by_cells(points, 10, 0.03)
    for threads in (2, 3, 8):
        assert np.array_equal(by_cells(points, 10, 0.03, threads=threads), keep)
    fortran = np.asfortranarray(points)
    fortran.flags.writeable = False
    assert np.array_equal(radius_inliers(fortran, nb_points=10, radius=0.03), keep)
    order = np.random.default_rng(2).permutation(len(points))
    assert np.array_equal(radius_inliers(points[order], nb_points=10, radius=0.03), keep[order])
    broken = np.vstack([points, [[np.nan, 0, 0], [0, -np.inf, 0]]])
    assert np.array_equal(radius_inliers(broken, nb_points=10, radius=0.03), np.append(keep, [False, False]))


@pytest.mark.parametrize("seed", range(10))
def test_statistical_filter_keeps_the_points_that_open3d_keeps(seed):
    points = awkward_points(seed, RADII[seed % 4])
    expected = legacy_cloud(points).remove_statistical_outlier(2 + seed, 1.0)[1]
    index = statistical_outlier_removal(points, 2 + seed, 1.0)[1]
    assert index.tolist() == list(expected)
    assert 0 < len(index) < len(points)


def test_points_at_exactly_the_radius_do_not_count():
    row = np.arange(4)[:, None] * np.array([0.5, 0.0, 0.0])
    assert grid_radius_outlier_removal(row, 1, 0.5)[1].tolist() == []
    assert grid_radius_outlier_removal(row, 1, np.nextafter(0.5, 1))[1].tolist() == [0, 1, 2, 3]
    assert grid_radius_outlier_removal(row, 2, 0.50001)[1].tolist() == [1, 2]


def test_duplicates_are_neighbours():
    points = np.repeat([[1.0, 2.0, 3.0]], 4, axis=0)
    assert len(grid_radius_outlier_removal(points, 3, 0.01)[0]) == 4
    assert len(grid_radius_outlier_removal(points, 4, 0.01)[0]) == 0


coordinates = st.integers(-12, 12).map(lambda step: step * 0.05) | st.floats(-1, 1, width=32)


@settings(max_examples=150, deadline=None)
@given(
    points=st.integers(0, 60).flatmap(
        lambda n: st.sampled_from([2, 3]).flatmap(lambda d: arrays(np.float64, (n, d), elements=coordinates))
    ),
    nb_points=st.integers(1, 8),
    radius=st.sampled_from([0.05, 0.1, 0.15, 0.2, 0.33, 5.0]),
)
def test_radius_filter_equals_brute_force(points, nb_points, radius):
    expected = brute_force(points, nb_points, radius)
    assert np.array_equal(radius_inliers(points, nb_points=nb_points, radius=radius), expected)
    if len(points):
        assert np.array_equal(by_cells(points, nb_points, radius), expected)


def test_far_coordinates_and_small_radii():
    rng = np.random.default_rng(3)
    points = np.vstack([rng.normal(0, 0.002, (300, 3)), rng.uniform(-1, 1, (200, 3)), [[1e9, 1e9, 1e9]]])
    assert np.array_equal(radius_inliers(points, nb_points=5, radius=1e-3), brute_force(points, 5, 1e-3))
    shifted = points[:-1] + 1e12
    assert np.array_equal(radius_inliers(shifted, nb_points=5, radius=1e-3), brute_force(shifted, 5, 1e-3))


def test_plan_points_are_treated_as_lying_at_one_height():
    points = awkward_points(1, 0.1)
    points[:, 2] = 0.0
    flat = grid_radius_outlier_removal(points[:, :2], 6, 0.1)[1]
    assert np.array_equal(flat, grid_radius_outlier_removal(points, 6, 0.1)[1])


@pytest.mark.parametrize("function", [lambda p: grid_radius_outlier_removal(p, 5, 0.1), lambda p: statistical_outlier_removal(p, 6, 1.5)])
def test_order_does_not_matter_and_points_that_are_not_finite_go(function):
    points = awkward_points(4, 0.25)
    order = np.random.default_rng(0).permutation(len(points))
    kept = np.zeros(len(points), dtype=bool)
    kept[function(points)[1]] = True
    assert np.array_equal(np.flatnonzero(kept[order]), function(points[order])[1])
    broken = np.vstack([[[np.nan, 0, 0]], points, [[0, np.inf, 0]]])
    assert np.array_equal(function(broken)[1], np.flatnonzero(kept) + 1)


@pytest.mark.parametrize("function", [lambda p: grid_radius_outlier_removal(p, 5, 0.1), lambda p: statistical_outlier_removal(p, 6, 1.5)])
def test_same_kind_out_with_attributes_and_input_untouched(function):
    o3d = pytest.importorskip("open3d")
    points = awkward_points(2, 0.25)
    index = function(points)[1]
    colours = np.random.default_rng(1).random(points.shape)
    legacy = legacy_cloud(points)
    legacy.colors = o3d.utility.Vector3dVector(colours)
    clean, kept = function(legacy)
    assert isinstance(clean, o3d.geometry.PointCloud)
    assert isinstance(kept, list)
    assert kept == index.tolist()
    assert np.array_equal(np.asarray(clean.colors), colours[index])
    assert np.array_equal(np.asarray(legacy.points), points)
    tensor = o3d.t.geometry.PointCloud(o3d.core.Tensor(points))
    tensor.point.intensity = o3d.core.Tensor(np.arange(len(points), dtype=np.int32)[:, None])
    clean, mask = function(tensor)
    assert isinstance(clean, o3d.t.geometry.PointCloud)
    assert np.array_equal(np.flatnonzero(mask.numpy()), index)
    assert np.array_equal(clean.point.intensity.numpy().ravel(), index)


def test_empty_clouds():
    o3d = pytest.importorskip("open3d")
    for function in (grid_radius_outlier_removal, statistical_outlier_removal):
        assert function(np.zeros((0, 3)), 4, 0.1)[0].shape == (0, 3)
        assert function(o3d.geometry.PointCloud(), 4, 0.1)[1] == []
        clean, mask = function(o3d.t.geometry.PointCloud(), 4, 0.1)
        assert isinstance(clean, o3d.t.geometry.PointCloud)
        assert mask.shape[0] == 0


@pytest.mark.parametrize(("count", "size"), [(0, 0.1), (-1, 0.1), (3, 0.0), (3, -1.0), (3, np.nan), (3, np.inf)])
def test_parameters_out_of_bounds(count, size):
    for function in (grid_radius_outlier_removal, statistical_outlier_removal):
        with pytest.raises(ValueError, match=r"above 0|at least 1"):
            function(np.zeros((5, 3)), count, size)


def test_other_shapes_and_objects():
    o3d = pytest.importorskip("open3d")
    with pytest.raises(ValueError, match="shape"):
        grid_radius_outlier_removal(np.zeros((5, 4)), 3, 0.1)
    with pytest.raises(TypeError, match="TriangleMesh"):
        grid_radius_outlier_removal(o3d.geometry.TriangleMesh(), 3, 0.1)
