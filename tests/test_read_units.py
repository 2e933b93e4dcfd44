"""Units and axes: taken as told, recognised where evident, left alone in doubt."""

import numpy as np
import pytest
from test_read import UTM, box_points

from indoor_bim.cloud.read import as_cloud
from indoor_bim.cloud.spacing import point_spacing
from indoor_bim.errors import ReadError


def rooms(*, size=(9.0, 7.0, 2.8), tilt=0.0, yaw=0.0, count=60_000):
    """A box room with noise, tilted about x and turned about z (degrees)."""
    points = box_points(size=size, count=count) + np.random.default_rng(5).normal(0, 0.004, (count, 3))
    a, b = np.radians([tilt, yaw])
    turn = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    lean = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    return points @ (lean @ turn).T


def turned_y_up(points):
    return points[:, [0, 2, 1]] * [1, 1, -1]


@pytest.mark.parametrize("offset", [0 * UTM, UTM])
def test_millimetres_are_recognised(offset):
    points = rooms()
    cloud = as_cloud(points * 1000 + offset * 1000)
    assert cloud.frame.scale == 0.001
    assert "millimetres" in cloud.warnings[0]
    assert np.ptp(cloud.points, axis=0) == pytest.approx(np.ptp(points, axis=0), abs=1e-9)
    assert np.abs(cloud.frame.to_scan(cloud.points) - (points + offset) * 1000).max() < 1e-5


@pytest.mark.parametrize("size", [(9.0, 7.0, 2.8), (1500.0, 900.0, 25.0), (4000.0, 6000.0, 60.0)])
@pytest.mark.parametrize("offset", [0 * UTM, UTM])
def test_metres_stay_metres(size, offset):
    cloud = as_cloud(rooms(size=size) + offset)
    assert cloud.frame.scale == 1.0
    assert cloud.warnings == ()


def test_stray_points_do_not_make_millimetres():
    points = rooms()
    points[:20, 2] = 9000.0
    assert as_cloud(points).frame.scale == 1.0


@pytest.mark.parametrize(
    ("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("dm", 0.1), ("ft", 0.3048), ("us-ft", 1200 / 3937), ("in", 0.0254)]
)
def test_unit_as_told(unit, metres):
    points = rooms(count=2000)
    cloud = as_cloud(points / metres, unit=unit)
    assert cloud.points + cloud.frame.origin * metres == pytest.approx(points, abs=1e-9)
    assert cloud.warnings == ()


def test_told_metres_overrule_what_looks_like_millimetres():
    assert as_cloud(rooms() * 1000, unit="m").frame.scale == 1.0


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize("yaw", [0.0, 30.0])
def test_y_up_is_recognised_and_turned(scale, yaw):
    points = rooms(yaw=yaw)
    cloud = as_cloud(turned_y_up(points) * scale)
    assert "y axis" in cloud.warnings[0]
    assert np.linalg.det(cloud.frame.rotation) == pytest.approx(1.0)
    expected = as_cloud(points, up="z").points
    assert np.ptp(cloud.points - expected, axis=0).max() < 1e-9


@pytest.mark.parametrize("tilt", [-20.0, -10.0, 0.0, 17.0, 20.0])
@pytest.mark.parametrize("yaw", [0.0, 20.0, 45.0, 90.0])
@pytest.mark.parametrize("size", [(9.0, 7.0, 2.8), (30.0, 2.0, 2.8), (3.0, 2.0, 2.6), (2.5, 30.0, 4.0)])
def test_tilted_z_up_scans_keep_their_axis(tilt, yaw, size):
    assert np.array_equal(as_cloud(rooms(tilt=tilt, yaw=yaw, size=size, count=20_000)).frame.rotation, np.eye(3))


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_up_as_told_is_a_proper_rotation_that_loses_nothing(up):
    points = rooms(count=3000) + UTM
    cloud = as_cloud(points, up=up)
    assert np.linalg.det(cloud.frame.rotation) == pytest.approx(1.0)
    assert np.array_equal(cloud.points[:, 2], points[:, "xyz".index(up)] - cloud.frame.origin["xyz".index(up)])
    assert cloud.frame.to_local(points) == pytest.approx(cloud.points, abs=1e-12)


@pytest.mark.parametrize("option", [{"unit": "parsec"}, {"up": "w"}])
def test_unknown_options(option):
    with pytest.raises(ReadError, match="expected auto or one of"):
        as_cloud(rooms(count=100), **option)


def test_spacing_of_a_large_cloud_is_sampled_without_bias():
    rng = np.random.default_rng(2)
    x, y = np.meshgrid(np.arange(700) * 0.02, np.arange(700) * 0.02)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    assert point_spacing(points, sample_size=5000) == pytest.approx(0.02)
    assert point_spacing(points[rng.permutation(len(points))], sample_size=5000) == point_spacing(points, sample_size=5000)
    noisy = points + rng.normal(0, 0.002, points.shape)
    assert point_spacing(noisy, sample_size=5000) == pytest.approx(point_spacing(noisy, sample_size=10**6), rel=0.03)
    assert point_spacing(np.repeat(points[:500], 3, axis=0)) == pytest.approx(0.02)
    assert np.isnan(point_spacing(np.zeros((4, 3))))
