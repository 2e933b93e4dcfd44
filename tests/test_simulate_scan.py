"""Virtual scans: points on the true surfaces, errors of the stated size, equal bytes from equal seeds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import laspy
import numpy as np
import open3d as o3d
import pytest
import shapely

from indoor_bim.errors import ConfigError, WriteError
from indoor_bim.export.json import read_json
from indoor_bim.frame import Frame
from indoor_bim.model import Building
from indoor_bim.params import SimulateParams
from indoor_bim.simulate import SimulatedScan, demo_house, profile_params, simulate, single_room, two_storeys, write_scan
from indoor_bim.simulate.drift import Drift, best_rigid_fit
from indoor_bim.simulate.mesh import box_triangles, door_leaves, shell_triangles, window_frames

ERRORLESS = profile_params("clean").model_copy(update={"movement": "walk", "sensor_height": 1.75, "map_tilt": 9.0, "map_yaw": 25.0})
STANDING = ERRORLESS.model_copy(update={"movement": "stations"})
UTM = (691000.0, 5336000.0, 520.0)


def in_model(scan: SimulatedScan) -> np.ndarray:
    return Frame.from_matrix(scan.truth.transform_cloud_to_model).to_local(scan.points)


def distance_to_room_faces(points: np.ndarray, *, width: float = 7.0, depth: float = 5.0, height: float = 3.0) -> np.ndarray:
    """Distance to the nearest face of the plain single room."""
    low, high = np.array([0.15, 0.15, 0.0]), np.array([0.15 + width, 0.15 + depth, height])
    return np.minimum(np.abs(points - low), np.abs(points - high)).min(axis=1)


@pytest.mark.parametrize("params", [ERRORLESS, STANDING.model_copy(update={"map_origin": UTM})])
def test_errorless_points_lie_on_the_surfaces(params: SimulateParams) -> None:
    scan = simulate(single_room(), points=4000, params=params)
    points = in_model(scan)
    inside = np.all((points > [0.14, 0.14, -0.01]) & (points < [7.16, 5.16, 3.01]), axis=1)
    room = shapely.box(0.2, 0.2, 7.1, 5.1)
    free = inside & ~((points[:, 0] < 2.8) & (points[:, 1] < 1.3))
    assert inside.mean() > 0.85
    assert distance_to_room_faces(points[free]).max() < 2e-5
    assert shapely.contains_xy(room, points[free & (points[:, 2] > 0.01) & (points[:, 2] < 2.99), :2]).sum() == 0


def test_range_noise_has_the_stated_size() -> None:
    params = STANDING.model_copy(update={"range_noise": 0.02})
    noisy, exact = (
        in_model(simulate(single_room(), points=20000, params=p)) for p in (params, params.model_copy(update={"range_noise": 0.0}))
    )
    assert np.linalg.norm(noisy - exact, axis=1).std() == pytest.approx(0.02 * np.sqrt(1 - 2 / np.pi), rel=0.05)
    assert np.sqrt(np.mean(np.sum((noisy - exact) ** 2, axis=1))) == pytest.approx(0.02, rel=0.03)


def test_equal_seeds_give_equal_points_whatever_the_threads() -> None:
    program = (
        "import hashlib; from indoor_bim.simulate import *\n"
        "s = simulate(demo_house(), points=20000, seed=5)\n"
        "print(hashlib.sha256(s.points.tobytes() + s.gps_time.tobytes() + s.trajectory.tobytes() + repr(s.truth).encode()).hexdigest())"
    )
    answers = []
    for threads in ("1", "4"):
        environment = {"OMP_NUM_THREADS": threads, "PATH": ""}
        answers.append(subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True).stdout)
    assert answers[0] == answers[1]
    assert len(answers[0].strip()) == 64


def test_other_seeds_give_other_scans() -> None:
    a, b = (simulate(single_room(), points=2000, seed=seed) for seed in (1, 2))
    assert not np.allclose(a.points, b.points)
    assert a.truth.transform_cloud_to_model != b.truth.transform_cloud_to_model


def test_scan_has_as_many_points_as_asked_for_in_order_of_time() -> None:
    scan = simulate(demo_house(), points=12345, seed=3)
    assert scan.points.shape == (12345, 3)
    assert scan.gps_time.shape == (12345,)
    assert np.all(np.diff(scan.gps_time) >= 0)
    assert np.all(np.diff(scan.trajectory[:, 0]) > 0)
    assert scan.trajectory[0, 0] <= scan.gps_time[0]
    assert scan.gps_time[-1] <= scan.trajectory[-1, 0] + 0.1
    assert np.isfinite(scan.points).all()


def test_trajectory_runs_at_sensor_height_through_the_rooms() -> None:
    scan = simulate(demo_house(), points=1000, seed=3, params=ERRORLESS)
    path = Frame.from_matrix(scan.truth.transform_cloud_to_model).to_local(scan.trajectory[:, 1:])
    assert path[:, 2] == pytest.approx(np.full(len(path), 1.75), abs=1e-9)
    speed = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1) / 0.1
    assert np.median(speed) == pytest.approx(0.8, rel=0.1)
    assert scan.trajectory[0, 1:] == pytest.approx(np.zeros(3), abs=1e-12)


def test_map_is_tilted_and_turned_as_asked_for() -> None:
    scan = simulate(single_room(), points=1000, params=ERRORLESS)
    to_model = np.asarray(scan.truth.transform_cloud_to_model)
    assert np.degrees(np.arccos(to_model[2, 2])) == pytest.approx(9.0, abs=1e-6)
    drawn = [np.asarray(simulate(single_room(), points=100, seed=s).truth.transform_cloud_to_model)[2, 2] for s in range(8)]
    tilts = np.degrees(np.arccos(drawn))
    assert tilts.max() <= 15.0
    assert np.ptp(tilts) > 2.0


def test_truth_is_where_the_drifted_points_are_on_average() -> None:
    params = ERRORLESS.model_copy(update={"drift": 0.05, "drift_yaw": 0.2})
    drifted, exact = (simulate(demo_house(), points=20000, params=p) for p in (params, ERRORLESS))
    moved, true = in_model(drifted), in_model(exact)
    turn, shift = best_rigid_fit(moved, true)
    assert shift == pytest.approx(np.zeros(3), abs=1e-9)
    assert turn == pytest.approx(np.eye(3), abs=1e-9)
    error = np.sqrt(np.mean(np.sum((moved - true)[:, :2] ** 2, axis=1)))
    assert 0.01 < error < 0.12


def test_drift_is_smooth_and_of_the_stated_size() -> None:
    drift = Drift.draw(200.0, position=0.03, yaw=0.05, rng=np.random.Generator(np.random.PCG64(4)))
    assert np.sqrt(np.mean(drift.error[:, :2] ** 2, axis=0)) == pytest.approx([0.03, 0.03])
    assert np.degrees(np.sqrt(np.mean(drift.error[:, 3] ** 2))) == pytest.approx(0.05)
    time = np.linspace(0, 200, 2001)
    path = drift.apply(time, np.zeros((2001, 3)), np.zeros((2001, 3)))
    assert np.abs(np.diff(path, axis=0)).max() < 0.005


def test_glass_lets_most_rays_through() -> None:
    opaque = STANDING.model_copy(update={"furniture": True, "glass_return": 1.0})
    partial = opaque.model_copy(update={"glass_return": 0.1})
    points = [in_model(simulate(single_room(), points=20000, params=p)) for p in (opaque, partial)]
    behind = [np.sum((p[:, 0] < -0.5) & (p[:, 1] > 0.5)) for p in points]
    assert behind[0] == 0
    assert behind[1] > 100


def test_glass_mirrors_the_room() -> None:
    params = STANDING.model_copy(update={"glass_reflection": 0.5})
    points = in_model(simulate(single_room(), points=20000, params=params))
    ghosts = points[points[:, 0] < -0.5]
    assert len(ghosts) > 100
    mirrored = ghosts * [-1, 1, 1]
    assert np.quantile(distance_to_room_faces(mirrored), 0.9) < 1e-4


def test_people_walk_along() -> None:
    params = ERRORLESS.model_copy(update={"people": 2})
    with_person, alone = (in_model(simulate(single_room(), points=20000, params=p)) for p in (params, ERRORLESS))
    middle = [np.sum(np.all((p > [0.4, 1.2, 0.1]) & (p < [6.9, 4.9, 1.7]), axis=1)) for p in (with_person, alone)]
    assert middle[1] == 0
    assert middle[0] > 150


def distance_to_surfaces(points: np.ndarray, building: Building, seed: int) -> np.ndarray:
    leaves = door_leaves(building, rng=np.random.Generator(np.random.PCG64(seed)))
    triangles = np.concatenate([shell_triangles(building), box_triangles([*leaves, *window_frames(building)])])
    scene = o3d.t.geometry.RaycastingScene()
    vertices = o3d.core.Tensor.from_numpy(triangles.reshape(-1, 3).astype(np.float32))
    scene.add_triangles(vertices, o3d.core.Tensor.from_numpy(np.arange(3 * len(triangles), dtype=np.uint32).reshape(-1, 3)))
    return scene.compute_distance(o3d.core.Tensor.from_numpy(points.astype(np.float32))).numpy()


def test_mixed_pixels_float_at_edges() -> None:
    exact = in_model(simulate(demo_house(), points=20000, seed=2, params=STANDING))
    assert distance_to_surfaces(exact, demo_house(), 2).max() < 1e-4
    mixed = in_model(simulate(demo_house(), points=20000, seed=2, params=STANDING.model_copy(update={"mixed_pixels": 0.5})))
    floating = np.sum(distance_to_surfaces(mixed, demo_house(), 2) > 0.02)
    assert 10 < floating < 400


def test_two_storeys_are_both_scanned() -> None:
    points = in_model(simulate(two_storeys(), points=20000, profile="clean"))
    for level in (0.0, 2.5, 2.8, 5.2):
        assert np.sum(np.abs(points[:, 2] - level) < 1e-4) > 500


@pytest.mark.parametrize("profile", ["backpack", "static", "clean"])
def test_profiles_run(profile: str) -> None:
    scan = simulate(demo_house(), profile=profile, points=5000)  # type: ignore[arg-type]
    settings = profile_params(profile)  # type: ignore[arg-type]
    assert len(scan.points) == 5000
    assert settings.furniture == (profile != "clean")
    assert (settings.movement == "walk") == (profile == "backpack")


def test_wrong_requests_are_refused() -> None:
    with pytest.raises(ConfigError, match="profile 'drone'"):
        simulate(single_room(), profile="drone")  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="0 points"):
        simulate(single_room(), points=0)
    with pytest.raises(ConfigError, match="rays hit"):
        simulate(single_room(), points=100, params=ERRORLESS.model_copy(update={"max_range": 0.2}))


def test_files_hold_the_scan_and_are_equal_on_a_second_run(tmp_path: Path) -> None:
    params = ERRORLESS.model_copy(update={"map_origin": UTM})
    for name in ("a", "b"):
        write_scan(simulate(single_room(), points=3000, params=params), tmp_path / name)
    scan = simulate(single_room(), points=3000, params=params)
    for file in ("scan.laz", "trajectory.csv", "truth.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    las = laspy.read(tmp_path / "a" / "scan.laz")
    assert np.abs(las.xyz - scan.points).max() < 1e-4
    assert np.array_equal(las.gps_time, scan.gps_time)
    table = np.loadtxt(tmp_path / "a" / "trajectory.csv", delimiter=",", skiprows=1)
    assert np.abs(table - scan.trajectory).max() < 1e-3
    assert read_json(tmp_path / "a" / "truth.json") == scan.truth
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["scan.laz", "trajectory.csv", "truth.json"]


def test_unwritable_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(WriteError, match="file"):
        write_scan(simulate(single_room(), points=100), tmp_path / "file" / "below")
