"""Levelling and storeys of synthetic buildings with exact answers."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud
from indoor_bim.cloud.levels import level, main_direction, storey_levels, thin, upright
from indoor_bim.errors import NothingToReconstructError


def box_points(rng, width, depth, floor, ceiling, *, count=40_000, noise=0.005, sides="fcxXyY"):
    """Points on the inside of a box: floor, ceiling and four walls."""
    points = []
    for side in sides:
        u, v = rng.random((2, count // 4))
        x, y, z = u * width, v * depth, floor + v * (ceiling - floor)
        points.append(
            {
                "f": np.column_stack([x, y, np.full_like(x, floor)]),
                "c": np.column_stack([x, y, np.full_like(x, ceiling)]),
                "x": np.column_stack([np.zeros_like(x), u * depth, z]),
                "X": np.column_stack([np.full_like(x, width), u * depth, z]),
                "y": np.column_stack([x, np.zeros_like(x), z]),
                "Y": np.column_stack([x, np.full_like(x, depth), z]),
            }[side]
        )
    out = np.vstack(points)
    return out + rng.normal(0, noise, out.shape)


def rotation(*, tilt=0.0, azimuth=0.0, yaw=0.0):
    t, a, w = np.radians([tilt, azimuth, yaw])
    k = np.array([-np.sin(a), np.cos(a), 0.0])
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    about_z = np.array([[np.cos(w), -np.sin(w), 0], [np.sin(w), np.cos(w), 0], [0, 0, 1]])
    return (np.eye(3) + np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross) @ about_z


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.mark.parametrize(("tilt", "azimuth", "yaw"), [(0, 0, 0), (2, 40, 10), (17.25, 200, 33), (30, 300, 77)])
def test_box_is_levelled_and_aligned_exactly(rng, tilt, azimuth, yaw):
    turn = rotation(tilt=tilt, azimuth=azimuth, yaw=yaw)
    levelled = level(Cloud(box_points(rng, 8.0, 6.0, 0.0, 2.7) @ turn.T + [3.0, -2.0, 5.0]))
    up = levelled.frame.rotation @ turn[:, 2]
    assert np.degrees(np.arccos(min(up[2], 1.0))) < 0.02
    along = levelled.frame.rotation @ turn[:, 0]
    yaw_error = (np.degrees(np.arctan2(along[1], along[0])) + 45) % 90 - 45
    assert abs(yaw_error) < 0.03
    (storey,) = levelled.storeys
    assert storey.floor == pytest.approx(0.0, abs=1e-9)
    assert storey.ceiling == pytest.approx(2.7, abs=0.002)


def test_points_and_frame_agree(rng):
    cloud = Cloud(box_points(rng, 5.0, 4.0, 0.0, 2.5) @ rotation(tilt=12, azimuth=30, yaw=21).T + [100.0, 50.0, -4.0])
    levelled = level(cloud)
    np.testing.assert_allclose(levelled.frame.to_local(cloud.points), levelled.points, atol=1e-9)


def test_parts_are_floor_ceiling_and_the_rest(rng):
    levelled = level(Cloud(box_points(rng, 8.0, 6.0, 0.0, 2.7, noise=0.0)))
    z = levelled.points[:, 2]
    assert set(np.unique(levelled.part)) == {WALL, FLOOR, CEILING}
    assert (levelled.part[np.abs(z) < 0.01] == FLOOR).all()
    assert (levelled.part[np.abs(z - 2.7) < 0.01] == CEILING).all()
    assert (levelled.part[(z > 0.2) & (z < 2.5)] == WALL).all()


def test_point_order_does_not_matter(rng):
    points = box_points(rng, 8.0, 6.0, 0.0, 2.7) @ rotation(tilt=9, azimuth=120, yaw=14).T
    first = level(Cloud(points)).frame.matrix
    second = level(Cloud(points[rng.permutation(len(points))])).frame.matrix
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_two_storeys_under_a_pitched_roof(rng):
    ground = box_points(rng, 8.0, 6.0, 0.0, 2.5)
    attic = box_points(rng, 8.0, 6.0, 2.7, 4.0, sides="fxXyY")
    u, v = rng.random((2, 20_000))
    roof = np.column_stack([u * 8.0, v * 6.0, 6.5 - 2.5 * np.abs(v * 2 - 1)])
    storeys = storey_levels(thin(np.vstack([ground, attic, roof])))
    assert len(storeys) == 2
    assert storeys[0].floor == pytest.approx(0.0, abs=0.003)
    assert storeys[0].ceiling == pytest.approx(2.5, abs=0.003)
    assert storeys[1].floor == pytest.approx(2.7, abs=0.003)
    assert storeys[1].ceiling is None


def test_split_floor_is_one_storey(rng):
    low = box_points(rng, 5.0, 6.0, 0.0, 2.7)
    high = box_points(rng, 4.0, 6.0, 0.35, 2.7) + np.array([5.2, 0.0, 0.0])
    storeys = storey_levels(thin(np.vstack([low, high])))
    assert len(storeys) == 1
    assert storeys[0].floor == pytest.approx(0.0, abs=0.003)


def test_ceiling_only(rng):
    levelled = level(Cloud(box_points(rng, 8.0, 6.0, 1.2, 2.7, sides="cxXy")))
    (storey,) = levelled.storeys
    assert storey.floor is None
    assert any("floor was not seen" in w for w in levelled.warnings)


def test_density_does_not_decide(rng):
    """A thousand points on a table in one spot weigh no more than the surface that they cover."""
    points = box_points(rng, 8.0, 6.0, 0.0, 2.7)
    u, v = rng.random((2, 200_000))
    table = np.column_stack([2 + u * 1.2, 2 + v * 0.8, np.full_like(u, 0.75)])
    storeys = storey_levels(thin(np.vstack([points, table])))
    assert len(storeys) == 1
    assert storeys[0].floor == pytest.approx(0.0, abs=0.003)


def test_no_level_surface_is_said(rng):
    wall = box_points(rng, 8.0, 6.0, 0.0, 2.7, sides="x")
    with pytest.raises(NothingToReconstructError, match="up axis"):
        level(Cloud(wall))


@pytest.mark.parametrize("angle", [-44.0, -10.0, 0.0, 33.0, 44.0])
def test_main_direction(rng, angle):
    turned = box_points(rng, 8.0, 6.0, 0.0, 2.7) @ rotation(yaw=angle).T
    assert np.degrees(main_direction(thin(turned))) == pytest.approx(angle, abs=0.03)


def test_upright_is_the_smallest_rotation(rng):
    turn = rotation(tilt=10, azimuth=25)
    found = upright(thin(box_points(rng, 8.0, 6.0, 0.0, 2.7) @ turn.T))
    np.testing.assert_allclose(found, turn.T, atol=3e-4)


@pytest.mark.parametrize(("tilt", "azimuth"), [(9, 130), (17, 300)])
def test_noisy_scan_is_levelled(rng, tilt, azimuth):
    """Noise of 25 mm on every surface: short plane pieces would have no clear normal, and boxes must not cut the floor in halves."""
    turn = rotation(tilt=tilt, azimuth=azimuth, yaw=20)
    points = box_points(rng, 9.0, 7.0, 0.0, 3.0, count=400_000, noise=0.025)
    up = upright(thin(points @ turn.T)) @ turn[:, 2]
    assert np.degrees(np.arccos(min(up[2], 1.0))) < 0.015


def plate(rng, low, high, height, *, spacing=0.02, noise=0.005):
    """Points on a level rectangle."""
    (x0, y0), (x1, y1) = low, high
    count = int((x1 - x0) * (y1 - y0) / spacing**2)
    return np.column_stack([rng.uniform(x0, x1, count), rng.uniform(y0, y1, count), rng.normal(height, noise, count)])


def test_thinly_scanned_floor_is_found_below_tables(rng):
    """The scanner looked at tables and ceiling, and only now and then at the floor."""
    room = [plate(rng, (0, 0), (12, 8), 2.6), box_points(rng, 12.0, 8.0, 0.0, 2.6, sides="xXyY")]
    tables = [plate(rng, (x, 1), (x + 1.6, 2.4), 0.75) for x in (1, 4, 7, 10)]
    floor = plate(rng, (0, 3), (12, 8), 0.0, spacing=0.16)
    (storey,) = storey_levels(thin(np.vstack([*room, *tables, floor])))
    assert storey.floor == pytest.approx(0.0, abs=0.004)
    assert storey.ceiling == pytest.approx(2.6, abs=0.002)


def test_floor_between_desks_that_hide_most_of_it(rng):
    desks = [plate(rng, (x, y), (x + 1.8, y + 1.8), 0.74) for x in np.arange(0.3, 11, 2.4) for y in np.arange(0.3, 7, 2.4)]
    gaps = [plate(rng, (x + 1.8, 0), (x + 2.4, 8), 0.0) for x in np.arange(0.3, 11, 2.4)]
    room = [plate(rng, (0, 0), (12, 8), 2.6), box_points(rng, 12.0, 8.0, 0.0, 2.6, sides="xXyY")]
    (storey,) = storey_levels(thin(np.vstack([*room, *desks, *gaps])))
    assert storey.floor == pytest.approx(0.0, abs=0.003)


def test_podium_beside_the_floor_is_no_furniture(rng):
    """The larger of two halves of a storey is its floor, even 0.6 m above the other."""
    low, high = plate(rng, (0, 0), (4, 6), 0.0), plate(rng, (4, 0), (12, 6), 0.6)
    (storey,) = storey_levels(
        thin(np.vstack([low, high, plate(rng, (0, 0), (12, 6), 3.0), box_points(rng, 12.0, 6.0, 0.0, 3.0, sides="xXyY")]))
    )
    assert storey.floor == pytest.approx(0.6, abs=0.003)


def test_sloping_ground_outside_does_not_tilt_the_building(rng):
    turn = rotation(tilt=6, azimuth=40, yaw=12)
    box = box_points(rng, 9.0, 7.0, 0.0, 2.7, count=100_000, noise=0.002)
    ground = plate(rng, (-12, -12), (20, -2), -0.3, spacing=0.05)
    ground[:, 2] += 0.005 * ground[:, 0]
    up = upright(thin(np.vstack([box, ground]) @ turn.T)) @ turn[:, 2]
    assert np.degrees(np.arccos(min(up[2], 1.0))) < 0.02
