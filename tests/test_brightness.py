"""What differs from a wall in brightness only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scanned_wall import LENGTH, Hole, Scan, Screen, scan

from indoor_bim.openings import find_openings
from indoor_bim.plan.brightness import with_brightness
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.plan.wall_rays import WallBox, rays_at_walls

LEAF = Screen(1.213, 2.118, 0.0, 2.087, 0.0)
WINDOW = Hole(3.407, 4.791, 0.913, 2.204, pane=0.1)
WALL_REFLECTANCE, PAINTED_REFLECTANCE = 0.7, 0.5


def intensity(measured: Scan, painted: list[Screen], *, noise: float = 0.1) -> np.ndarray:
    """Returns by the radar equation of a scanner that dims near targets."""
    ray = measured.points - sensor_positions(measured.trajectory, measured.gps_time)
    length = np.linalg.norm(ray, axis=1)
    on_paint = np.zeros(len(length), dtype=bool)
    x, y, z = measured.points.T
    for patch in painted:
        on_paint |= (x > patch.start) & (x < patch.end) & (z > patch.bottom) & (z < patch.top) & (np.abs(np.abs(y) - 0.1) < 0.02)
    reflectance = np.where(on_paint, PAINTED_REFLECTANCE, WALL_REFLECTANCE)
    strength = 40000 * reflectance * np.abs(ray[:, 1]) / length / (1 + 0.02 * length**2)
    return (strength * np.random.default_rng(8).normal(1, noise, len(length))).astype(np.uint16)


def openings(measured: Scan, strength: np.ndarray | None, **options):
    return find_openings(measured.storey, measured.points, **measured.given(), intensity=strength, **options).walls[0].openings


@pytest.fixture(scope="module")
def plain() -> Scan:
    return scan()


def test_a_closed_leaf_in_the_plane_of_the_face_is_a_door(plain):
    assert openings(plain, None) == ()
    (door,) = openings(plain, intensity(plain, [LEAF]))
    assert (door.kind, door.hinge, door.swing, door.sill) == ("door", None, None, 0.0)
    assert (door.start, door.start + door.width, door.height) == pytest.approx((LEAF.start, LEAF.end, LEAF.top), abs=0.01)
    assert door.confidence <= 0.5


@pytest.mark.parametrize(
    "painted",
    [
        pytest.param([], id="plain wall"),
        pytest.param([Screen(1.0, 2.0, 0.9, 2.1, 0.0)], id="poster"),
        pytest.param([Screen(0.5, 5.5, 0.0, 2.1, 0.0)], id="panelling"),
        pytest.param([Screen(2.0, 3.0, 0.0, 2.6, 0.0)], id="stripe up to the ceiling"),
        pytest.param([Screen(0.0, 1.0, 0.0, 2.1, 0.0)], id="paint up to the end of the wall"),
    ],
)
def test_other_paint_is_no_door(plain, painted):
    assert openings(plain, intensity(plain, painted)) == ()


def test_a_curtain_before_the_wall_is_no_door():
    measured = scan(screens=[Screen(2.0, 3.0, 0.0, 2.1, 0.10)])
    curtain = np.abs(measured.points[:, 1] - 0.2) < 0.02
    strength = intensity(measured, [])
    assert openings(measured, np.where(curtain, strength // 2, strength).astype(np.uint16)) == ()


def test_a_window_frame_in_the_plane_of_the_face_belongs_to_the_window():
    measured = scan([WINDOW])
    frame = Screen(WINDOW.start - 0.05, WINDOW.end + 0.05, WINDOW.bottom - 0.05, WINDOW.top + 0.05, 0.0)
    (clear,) = openings(measured, intensity(measured, []))
    (framed,) = openings(measured, intensity(measured, [frame]))
    assert clear.width == pytest.approx(WINDOW.end - WINDOW.start, abs=0.008)
    assert framed.width == pytest.approx(frame.end - frame.start, abs=0.012)
    assert framed.height == pytest.approx(frame.top - frame.bottom, abs=0.012)
    assert framed.sill == pytest.approx(frame.bottom, abs=0.008)


def rays(measured: Scan, strength: np.ndarray):
    wall = WallBox((0.0, 0.0), (LENGTH, 0.0), 0.2, 0.0, 2.6)
    sensors = sensor_positions(measured.trajectory, measured.gps_time)
    return rays_at_walls([wall], measured.points, sensors, np.zeros(len(strength), dtype=np.int64), strength)


def test_brightness_is_free_of_distance_and_angle(plain):
    (found,) = with_brightness(rays(plain, intensity(plain, [LEAF], noise=0.0)))
    on_leaf = (found.along_end > LEAF.start) & (found.along_end < LEAF.end) & (found.up_end < LEAF.top)
    assert np.median(found.brightness[~on_leaf]) == pytest.approx(0, abs=0.01)
    assert np.std(found.brightness[~on_leaf]) < 0.02
    assert np.median(found.brightness[on_leaf]) == pytest.approx(np.log(PAINTED_REFLECTANCE / WALL_REFLECTANCE), abs=0.02)


def test_the_unit_of_the_intensity_does_not_matter(plain):
    strength = intensity(plain, [LEAF])
    (one,), (other,) = (with_brightness(rays(plain, scale * strength.astype(np.float64))) for scale in (1.0, 0.01))
    np.testing.assert_allclose(one.brightness, other.brightness, atol=1e-3)


def test_no_intensity_no_brightness(plain):
    assert with_brightness([replace(rays(plain, np.zeros(len(plain.points)))[0], intensity=None)])[0].brightness is None
    assert with_brightness(rays(plain, np.zeros(len(plain.points))))[0].brightness is None
    assert openings(plain, np.zeros(len(plain.points), dtype=np.uint16)) == ()
