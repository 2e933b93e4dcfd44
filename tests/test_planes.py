"""Levelling by principal components (Remote Sensing 2021, 13, 4930, section 2.1)."""

import numpy as np
import pytest

from indoor_bim import planes
from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.frame import Frame


def box_room(length=7.0, width=5.0, height=2.8, step=0.04, ceiling=True, floor=True, walls=True):
    """Points on the inside of a box, without noise, away from the edges."""

    def plane(a, b):
        u, v = np.meshgrid(np.arange(step / 2, a, step), np.arange(step / 2, b, step))
        return u.ravel(), v.ravel()

    parts = []
    u, v = plane(length, width)
    if floor:
        parts.append(np.column_stack([u, v, 0 * u]))
    if ceiling:
        parts.append(np.column_stack([u, v, 0 * u + height]))
    if walls:
        u, z = plane(length, height)
        parts += [np.column_stack([u, 0 * u, z]), np.column_stack([u, 0 * u + width, z])]
        v, z = plane(width, height)
        parts += [np.column_stack([0 * v, v, z]), np.column_stack([0 * v + length, v, z])]
    return np.concatenate(parts)


def turned(points, tilt, yaw, azimuth=40.0):
    a, t, y = np.deg2rad([azimuth, tilt, yaw])
    axis = np.array([np.cos(a), np.sin(a), 0.0])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    lean = np.eye(3) + np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross
    spin = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
    return points @ (lean @ spin).T


def cloud_of(points):
    return Cloud(points=points - points.mean(axis=0).round(3))


def extent_of_walls(levelled):
    return np.ptp(levelled.points[levelled.part == WALL][:, :2], axis=0)


def test_principal_axes_are_those_of_the_covariance():
    points = np.random.default_rng(1).normal(size=(500, 3)) * [3.0, 2.0, 0.5] + [10, 20, 30]
    mean, axes, variances = planes.principal_axes(points)
    covariance = (points - points.mean(axis=0)).T @ (points - points.mean(axis=0)) / len(points)
    assert np.allclose(mean, points.mean(axis=0))
    assert np.allclose(axes @ covariance @ axes.T, np.diag(variances))
    assert (np.diff(variances) <= 0).all()


def test_alone_in_cell_equals_brute_force():
    xy = np.random.default_rng(2).uniform(-3, 8, size=(400, 2))
    step = (xy.max(axis=0) - xy.min(axis=0)) / 15
    cells = [tuple(min(max(round(float(v)), 1), 15) for v in (p - xy.min(axis=0)) / step) for p in xy]
    expected = [cells.count(cell) == 1 for cell in cells]
    assert planes.alone_in_cell(xy, grid_count=15).tolist() == expected
    assert 0 < sum(expected) < len(xy)


def test_grid_threshold_finds_the_floor_under_walls():
    half = box_room(ceiling=False)
    half = half[half[:, 2] < 1.4]
    plane = planes.horizontal_plane(half, normal=np.array([0.0, 0.0, 1.0]), grid_count=175)
    assert np.degrees(np.arccos(plane.normal[2])) < 1.0
    assert abs(plane.offset) < 0.05


def test_mean_normal_ignores_opposite_orientation():
    a = planes.Plane(np.array([0.0, 0.1, 1.0]) / np.sqrt(1.01), 0.0)
    b = planes.Plane(np.array([0.0, 0.1, -1.0]) / np.sqrt(1.01), 0.0)
    assert np.allclose(planes.mean_normal(a, b), [0, 0, 1])


@pytest.mark.parametrize("tilt", [0.0, 8.0, 17.0])
@pytest.mark.parametrize("yaw", [0.0, 20.0, -44.0, 160.0])
def test_box_room_at_any_attitude_is_levelled_exactly(tilt, yaw):
    levelled = planes.level_by_pca(cloud_of(turned(box_room(), tilt, yaw)))
    (storey,) = levelled.storeys
    assert storey.floor == 0.0
    assert storey.ceiling == pytest.approx(2.8, abs=0.002)
    assert sorted(extent_of_walls(levelled)) == pytest.approx([5.0, 7.0], abs=0.004)
    assert np.abs(levelled.points[levelled.part == FLOOR][:, 2]).max() < 0.06
    assert levelled.points[levelled.part == CEILING][:, 2] == pytest.approx(2.8, abs=0.06)
    assert levelled.warnings == ()


@pytest.mark.parametrize("yaw", [0.0, 30.0, -30.0])
def test_yaw_is_the_smallest_quarter_turn(yaw):
    rotation = planes.level_by_pca(cloud_of(turned(box_room(), 0.0, yaw))).frame.rotation
    assert np.degrees(np.arctan2(rotation[1, 0], rotation[0, 0])) == pytest.approx(-yaw, abs=0.05)


def test_frame_and_points_agree():
    scan = turned(box_room(), 12.0, 70.0) + np.array([500_000.0, 5_800_000.0, 100.0])
    origin = scan.mean(axis=0).round()
    cloud = Cloud(points=scan - origin, frame=Frame(origin, np.eye(3), 1.0, np.zeros(3)))
    levelled = planes.level_by_pca(cloud)
    assert np.allclose(levelled.frame.to_local(scan), levelled.points, atol=1e-6)
    assert np.allclose(levelled.frame.rotation @ levelled.frame.rotation.T, np.eye(3))
    assert np.linalg.det(levelled.frame.rotation) == pytest.approx(1.0)


def test_order_of_points_does_not_matter():
    rng = np.random.default_rng(3)
    points = cloud_of(turned(box_room(), 9.0, 25.0)).points + rng.normal(scale=0.01, size=(len(box_room()), 3))
    order = rng.permutation(len(points))
    straight, shuffled = planes.level_by_pca(Cloud(points=points)), planes.level_by_pca(Cloud(points=points[order]))
    assert straight.frame.matrix.tobytes() == shuffled.frame.matrix.tobytes()
    assert straight.storeys == shuffled.storeys
    assert np.array_equal(straight.part[order], shuffled.part)


def test_points_far_outside_do_not_shift_the_planes():
    rng = np.random.default_rng(4)
    inside = turned(box_room(), 10.0, 15.0)
    outside = turned(rng.uniform([-40, -40, -4], [40, 40, 9], size=(3000, 3)), 10.0, 15.0)
    levelled = planes.level_by_pca(cloud_of(np.concatenate([inside, outside])))
    assert levelled.storeys[0].ceiling == pytest.approx(2.8, abs=0.004)


def test_tall_shaft_is_levelled_with_a_warning():
    levelled = planes.level_by_pca(cloud_of(turned(box_room(length=2.0, width=2.5, height=9.0), 5.0, 10.0)))
    assert levelled.storeys[0].ceiling == pytest.approx(9.0, abs=0.004)
    assert any("principal axis" in warning for warning in levelled.warnings)


def test_missing_ceiling_is_said():
    levelled = planes.level_by_pca(cloud_of(box_room(ceiling=False)))
    assert levelled.storeys[0].floor == 0.0
    assert levelled.storeys[0].ceiling is None
    assert "the ceiling was not seen" in levelled.warnings


def test_missing_floor_is_said_and_walls_stand_at_zero():
    levelled = planes.level_by_pca(cloud_of(box_room(floor=False)))
    assert levelled.storeys[0].floor is None
    assert levelled.storeys[0].ceiling == pytest.approx(2.8, abs=0.06)
    assert "the floor was not seen" in levelled.warnings


def test_a_floor_that_was_hardly_seen_is_found_below_the_ceiling():
    scan = box_room(length=12.0, width=9.0)
    low = scan[:, 2] < 0.01
    dimly = scan[~low | (np.random.default_rng(5).random(len(scan)) < 0.2)]
    levelled = planes.level_by_pca(cloud_of(dimly))
    assert levelled.storeys[0].floor == pytest.approx(0.0)
    assert levelled.storeys[0].ceiling == pytest.approx(2.8, abs=0.005)
    assert not levelled.warnings


def test_trajectory_moves_with_the_cloud():
    cloud = cloud_of(box_room())
    path = np.column_stack([[np.nan, 1.0], cloud.points[:2]])
    levelled = planes.level_by_pca(Cloud(points=cloud.points, trajectory=path))
    assert np.allclose(levelled.trajectory[:, 1:], levelled.points[:2], atol=1e-9)
    assert np.array_equal(levelled.trajectory[:, 0], path[:, 0], equal_nan=True)


def test_nothing_but_floor_and_ceiling_is_an_error():
    with pytest.raises(NothingToReconstructError, match="walls"):
        planes.level_by_pca(cloud_of(box_room(walls=False)))


def test_too_few_points_are_an_error():
    with pytest.raises(NothingToReconstructError, match="found 3 points"):
        planes.level_by_pca(Cloud(points=np.eye(3)))


def test_no_horizontal_surface_is_an_error():
    ball = np.random.default_rng(5).normal(size=(20_000, 3))
    with pytest.raises(NothingToReconstructError, match="no floor and no ceiling"):
        planes.level_by_pca(Cloud(points=ball))


def test_published_grid_count_is_accepted():
    levelled = planes.level_by_pca(cloud_of(turned(box_room(), 17.0, 30.0)), grid_count=200)
    assert levelled.storeys[0].ceiling == pytest.approx(2.8, abs=0.002)
