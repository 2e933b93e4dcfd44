"""The default method on synthetic buildings with exact answers."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from indoor_bim.auto import storey_plans
from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.levels import level
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.cells import close_corners, cut_into_cells

ROOMS = (((0.0, 0.0), (4.0, 3.0)), ((4.2, 0.0), (7.2, 3.0)))
CEILING = 2.6


def scan_of_two_rooms(*, noise=0.003, spacing=0.03, seed=1):
    """Two rooms with a door between them (2.0 m high), seen from the middle of each."""
    rng = np.random.default_rng(seed)
    points, times = [], []
    for number, ((x0, y0), (x1, y1)) in enumerate(ROOMS):
        area = (x1 - x0) * (y1 - y0)
        count = int(area / spacing**2)
        floor = np.column_stack([rng.uniform(x0, x1, count), rng.uniform(y0, y1, count), np.zeros(count)])
        ceiling = np.column_stack([rng.uniform(x0, x1, count), rng.uniform(y0, y1, count), np.full(count, CEILING)])
        parts = [floor, ceiling]
        for a, b in (((x0, y0), (x1, y0)), ((x1, y0), (x1, y1)), ((x1, y1), (x0, y1)), ((x0, y1), (x0, y0))):
            count = int(np.hypot(b[0] - a[0], b[1] - a[1]) * CEILING / spacing**2)
            t, z = rng.random(count), rng.uniform(0, CEILING, count)
            wall = np.column_stack([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), z])
            between = (np.abs(wall[:, 0] - 4.1) < 0.11) & (np.abs(wall[:, 1] - 1.5) < 0.45) & (z < 2.0)
            parts.append(wall[~between])
        room = np.vstack(parts)
        points.append(room)
        times.append(np.full(len(room), 10.0 * number + 5.0))
    xyz = np.vstack(points) + rng.normal(0, noise, (sum(map(len, points)), 3))
    path = np.array([[10.0 * k, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, 1.5] for k, (a, b) in enumerate(ROOMS)])
    return xyz, np.concatenate(times), path


def rooms_of(xyz, times, path, *, turn=None, shift=(0.0, 0.0, 0.0)):
    """Room polygons in the coordinates of the untouched scan."""
    turn = np.eye(3) if turn is None else turn
    move = np.asarray(shift)
    moved = np.column_stack([path[:, 0], path[:, 1:] @ turn.T + move])
    cloud = Cloud(xyz @ turn.T + move, gps_time=times, trajectory=moved)
    levelled = level(cloud)
    (plan,) = storey_plans(levelled, gps_time=times)
    back = np.linalg.inv(levelled.frame.matrix)

    def to_scan(xy):
        local = np.column_stack([xy, np.zeros(len(xy)), np.ones(len(xy))]) @ back.T
        return ((local[:, :3] - move) @ turn)[:, :2]

    rooms = [shapely.transform(room, to_scan) for room in plan.rooms]
    return sorted(rooms, key=lambda room: room.centroid.x), plan


def corner_error(rooms):
    """Largest distance of a true corner from the nearest corner of its room."""
    worst = 0.0
    for room, ((x0, y0), (x1, y1)) in zip(rooms, ROOMS, strict=True):
        corners = np.asarray(room.exterior.coords)
        for corner in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)):
            worst = max(worst, float(np.hypot(*(corners - corner).T).min()))
    return worst


@pytest.fixture(scope="module")
def scan():
    return scan_of_two_rooms()


def yaw(degrees):
    w = np.radians(degrees)
    return np.array([[np.cos(w), -np.sin(w), 0], [np.sin(w), np.cos(w), 0], [0, 0, 1]])


def tilt(degrees):
    w = np.radians(degrees)
    return np.array([[1, 0, 0], [0, np.cos(w), -np.sin(w)], [0, np.sin(w), np.cos(w)]])


def test_rooms_are_parted_at_the_door_and_exact(scan):
    rooms, plan = rooms_of(*scan)
    assert len(rooms) == 2
    assert all(len(room.exterior.coords) == 5 for room in rooms)
    assert corner_error(rooms) < 0.004
    assert plan.ceiling == pytest.approx(CEILING, abs=0.003)


def test_room_corners_are_ends_of_faces(scan):
    _, plan = rooms_of(*scan)
    ends = {tuple(p) for p in plan.faces.p.tolist()}
    assert all(tuple(corner) in ends for room in plan.rooms for corner in room.exterior.coords)
    assert plan.faces.sided.all()


@pytest.mark.parametrize("turn", [yaw(33), yaw(45), yaw(180), tilt(15), tilt(-10) @ yaw(71)])
def test_yaw_and_tilt_do_not_matter(scan, turn):
    rooms, _ = rooms_of(*scan, turn=turn)
    assert len(rooms) == 2
    assert corner_error(rooms) < 0.005


def test_shuffled_points_give_the_same_rooms(scan):
    xyz, times, path = scan
    order = np.random.default_rng(3).permutation(len(xyz))
    first, _ = rooms_of(xyz, times, path)
    second, _ = rooms_of(xyz[order], times[order], path)
    for a, b in zip(first, second, strict=True):
        assert a.symmetric_difference(b).area < 1e-6


def test_half_the_points_give_the_same_rooms_within_10_mm(scan):
    xyz, times, path = scan
    half = np.random.default_rng(4).random(len(xyz)) < 0.5
    rooms, _ = rooms_of(xyz[half], times[half], path)
    assert corner_error(rooms) < 0.010


def test_same_scan_same_result(scan):
    first, _ = rooms_of(*scan)
    second, _ = rooms_of(*scan)
    assert [room.wkb for room in first] == [room.wkb for room in second]


def test_without_trajectory(scan):
    (plan,) = storey_plans(level(Cloud(scan[0])))
    assert len(plan.rooms) == 2


def test_a_scan_without_wall_points_is_said(scan):
    points = scan[0]
    flat = points[(points[:, 2] < 0.02) | (points[:, 2] > CEILING - 0.02)]
    with pytest.raises(NothingToReconstructError, match="expected walls"):
        storey_plans(level(Cloud(flat)))


def test_walls_between_rooms_without_ceiling(scan):
    points = scan[0]
    (plan,) = storey_plans(level(Cloud(points[points[:, 2] < CEILING - 0.03])))
    assert len(plan.rooms) == 2
    assert plan.ceiling is None


def test_hidden_end_of_a_face_is_closed_up_to_the_next_wall():
    p = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [2.0, -0.5]])
    q = np.array([[4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0], [2.0, 3.5]])
    cells = cut_into_cells(np.vstack([p, [[1.5, 2.7]]]), np.vstack([q, [[2.5, 2.7]]]))
    middle = (cells.edge_start + cells.edge_end) / 2
    seen = np.where((cells.edge_line == 4) & (middle[:, 1] > 2.7), 0.0, 0.9)
    closed = close_corners(cells, seen)
    end = (cells.edge_line == 4) & (middle[:, 1] > 2.7) & (middle[:, 1] < 3.0)
    assert end.sum() == 1
    assert closed[end].tolist() == [0.9]
    assert close_corners(cells, seen, gap=0.1)[end].tolist() == [0.0]
