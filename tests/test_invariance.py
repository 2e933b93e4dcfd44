"""Whatever is done to a scan, the walls of the default method stay where they are."""

from __future__ import annotations

import laspy
import numpy as np
import pytest
import shapely
from clouds import tilted
from test_auto import scan_of_two_rooms

from indoor_bim.pipeline import reconstruct

UTM = (691_000.0, 5_334_000.0, 520.0)
LEAST_MOVED = 0.005
LEAST_MOVED_THINNED = 0.010


def motion(*, tilt=0.0, yaw=0.0, shift=(0.0, 0.0, 0.0)):
    """Matrix that takes the untouched scan to the moved one."""
    ends = tilted(np.vstack([np.zeros(3), np.eye(3)]), tilt=tilt, yaw=yaw, shift=shift)
    matrix = np.eye(4)
    matrix[:3, 3] = ends[0]
    matrix[:3, :3] = (ends[1:] - ends[0]).T
    return matrix


def footprints(building, moved_by):
    """Outlines of the walls in coordinates of the untouched scan."""
    to_scan = np.linalg.inv(moved_by) @ np.linalg.inv(np.array(building.transform_cloud_to_model))
    walls = building.storeys[0].walls
    corners = [
        np.column_stack([wall.footprint, np.full((len(wall.footprint), 1), wall.base), np.ones(len(wall.footprint))]) for wall in walls
    ]
    return [shapely.Polygon((ring @ to_scan.T)[:, :2]) for ring in corners]


def largest_move(before, after):
    """Largest distance by which a wall's outline differs from that of the wall nearest to it."""
    assert len(before) == len(after)
    return max(min(wall.exterior.hausdorff_distance(other.exterior) for other in after) for wall in before)


def write_scan(folder, points, times, path):
    """Scan with times and the path of the scanner beside it."""
    header = laspy.LasHeader(version="1.2", point_format=1)
    header.scales, header.offsets = [0.0001] * 3, np.floor(points.min(axis=0))
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.gps_time = times
    las.write(folder / "scan.las")
    np.savetxt(folder / "trajectory.csv", path, delimiter=",", header="t,x,y,z", comments="", fmt="%.4f")
    return folder / "scan.las"


@pytest.fixture(scope="module")
def scan():
    return scan_of_two_rooms(noise=0.005, seed=8)


@pytest.fixture(scope="module")
def walls(scan, tmp_path_factory):
    return footprints(reconstruct(write_scan(tmp_path_factory.mktemp("still"), *scan)).building, np.eye(4))


@pytest.mark.parametrize(
    "moved",
    [{"yaw": 33.0}, {"yaw": 190.0}, {"tilt": 15.0}, {"shift": UTM}, {"tilt": 15.0, "yaw": 71.0, "shift": UTM}],
    ids=["yaw 33", "yaw 190", "tilt 15", "UTM", "all"],
)
def test_moved_scan(scan, walls, moved, tmp_path):
    points, times, path = scan
    moved_path = np.column_stack([path[:, 0], tilted(path[:, 1:], **{"tilt": 0.0, "yaw": 0.0, "shift": (0, 0, 0)} | moved)])
    file = write_scan(tmp_path, tilted(points, **{"tilt": 0.0, "yaw": 0.0, "shift": (0, 0, 0)} | moved), times, moved_path)
    assert largest_move(walls, footprints(reconstruct(file).building, motion(**moved))) < LEAST_MOVED


def test_shuffled_scan(scan, walls, tmp_path):
    points, times, path = scan
    order = np.random.default_rng(2).permutation(len(points))
    shuffled = footprints(reconstruct(write_scan(tmp_path, points[order], times[order], path)).building, np.eye(4))
    assert largest_move(walls, shuffled) < 1e-6


def test_thinned_scan(scan, walls, tmp_path):
    points, times, path = scan
    half = np.random.default_rng(3).random(len(points)) < 0.5
    thinned = footprints(reconstruct(write_scan(tmp_path, points[half], times[half], path)).building, np.eye(4))
    assert largest_move(walls, thinned) < LEAST_MOVED_THINNED


def test_scan_without_path(scan, walls):
    assert largest_move(walls, footprints(reconstruct(scan[0]).building, np.eye(4))) < LEAST_MOVED
