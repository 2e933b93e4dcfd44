"""Parts of the search for openings, against plain loops and known answers."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from indoor_bim.plan import edge_fits
from indoor_bim.plan.edge_fits import fewest_wrong, frame_width
from indoor_bim.plan.holes import FULL_LINE, NARROW_BAR, THIN_BAR, Hole, _closed, _runs, find_holes
from indoor_bim.plan.labels import connected_cells
from indoor_bim.plan.relief import level_faces
from indoor_bim.plan.wall_image import png_bytes, wall_image
from indoor_bim.plan.wall_picture import WallPicture
from indoor_bim.plan.wall_points import points_around
from indoor_bim.plan.wall_rays import FRONT, MARGIN, WallBox, WallRays, rays_at_walls


def some_walls(rng, count=6):
    ends = rng.uniform(-8, 8, (count, 2, 2))
    return [WallBox(tuple(p), tuple(q), 0.1 + 0.05 * k, -0.2, 2.5) for k, (p, q) in enumerate(ends)]


def rays_by_hand(wall, point, sensor):
    """Side, depth and crossing of one ray, or None."""
    d = (np.array(wall.end) - wall.start) / wall.length
    n = np.array([-d[1], d[0]])
    half = wall.thickness / 2
    across = [float((p[:2] - wall.start) @ n) for p in (sensor, point)]
    side = 1 if across[0] > 0 else -1
    begin, end = across[0] * side, across[1] * side
    if begin <= half or end >= half + FRONT or end >= begin:
        return None
    share = (begin - half) / (begin - end)
    meets = sensor + share * (point - sensor)
    along, up = float((meets[:2] - wall.start) @ d), float(meets[2] - wall.base)
    if not (-MARGIN < along < wall.length + MARGIN and -MARGIN < up < wall.height + MARGIN):
        return None
    return side, half - end, along, up


def beside_a_wall(walls, rng):
    """Place a few decimetres before or behind the face of a wall."""
    wall = walls[rng.integers(len(walls))]
    d = (np.array(wall.end) - wall.start) / wall.length
    away = rng.choice([-1, 1]) * (wall.thickness / 2 + rng.uniform(0, 5 * FRONT))
    return wall.start + rng.uniform(0, wall.length) * d + away * np.array([-d[1], d[0]])


@pytest.mark.parametrize("wide", [16.0, 0.5, 0.1])
@pytest.mark.parametrize("seed", range(4))
def test_rays_at_walls_are_those_of_a_plain_loop(seed, wide):
    rng = np.random.default_rng(seed)
    walls, block = some_walls(rng), 256
    around = np.zeros((400, 2)) if wide > 1 else np.repeat([beside_a_wall(walls, rng) for _ in range(24)], block, axis=0)
    count = len(around)
    sensors = np.column_stack([around + rng.uniform(-1.6, 1.6, (count, 2)) * wide, rng.uniform(1, 2, count)])
    points = np.column_stack([around + rng.uniform(-0.6, 0.6, (count, 2)) * wide, rng.uniform(-0.5, 3, count)])
    found = rays_at_walls(walls, points, sensors, np.arange(count))
    for wall, rays in zip(walls, found, strict=True):
        expected = {k: ray for k in range(count) if (ray := rays_by_hand(wall, points[k], sensors[k])) is not None}
        assert sorted(rays.period.tolist()) == sorted(expected)
        for row, k in enumerate(rays.period.tolist()):
            side, depth, along, up = expected[k]
            assert rays.side[row] == side
            assert (rays.depth[row], rays.along[row], rays.up[row]) == pytest.approx((depth, along, up), abs=2e-4)


def test_points_at_walls_are_those_of_a_plain_loop():
    rng = np.random.default_rng(9)
    walls = some_walls(rng)
    points = np.column_stack([rng.uniform(-9, 9, (3000, 2)), rng.uniform(-0.5, 3, 3000)])
    for wall, around in zip(walls, points_around(walls, points, reach=0.7), strict=True):
        along, across, up = around.within()
        d = (np.array(wall.end) - wall.start) / wall.length
        u, v = (points[:, :2] - wall.start) @ d, (points[:, :2] - wall.start) @ np.array([-d[1], d[0]])
        z = points[:, 2] - wall.base
        near = (
            (np.abs(v) < wall.thickness / 2 + 0.7) & (u > -MARGIN) & (u < wall.length + MARGIN) & (z > -MARGIN) & (z < wall.height + MARGIN)
        )
        assert np.sort(along) == pytest.approx(np.sort(u[near]))
        assert np.sort(across) == pytest.approx(np.sort(v[near]))
        within = (along > 1) & (along < 2.5) & (up > 0.4) & (up < 1.9)
        assert [part.tolist() for part in around.within(1, 2.5, 0.4, 1.9)] == [part[within].tolist() for part in (along, across, up)]
        assert [len(part) for part in around.within(2, 1)] == [0, 0, 0]


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(-20, 20), min_size=1, max_size=15),
    st.lists(st.integers(-20, 20), min_size=1, max_size=15),
)
def test_the_threshold_leaves_as_few_on_the_wrong_side_as_any(inside, outside):
    low, high = np.array(inside, dtype=float), np.array(outside, dtype=float)

    def wrong(cut):
        return int((low > cut).sum() + (high < cut).sum())

    values = np.unique(np.concatenate([low, high]))
    between = (values[1:] + values[:-1]) / 2
    if len(between):
        assert wrong(float(np.mean(fewest_wrong(low, high)))) <= min(wrong(cut) for cut in between)


@pytest.mark.parametrize("step", [0.01, -0.01, 0.02])
def test_a_frame_is_told_by_its_depth(step):
    rng = np.random.default_rng(2)
    distance = rng.uniform(0, 0.25, 4000)
    depth = rng.normal(0, 0.003, 4000) + np.where(distance < 0.055, step, 0)
    assert frame_width(distance, depth) == pytest.approx(0.055, abs=0.002)


def frame_in_numpy(distance, depth, smallest_step):
    """Twin of `frame_width`: every place between two hits is tried."""
    rows = np.flatnonzero((distance > edge_fits.REVEAL_BLUR) & (distance < edge_fits.FARTHEST))
    rows = rows[np.argsort(distance[rows], kind="stable")]
    x, y = distance[rows], depth[rows]
    best = (edge_fits.SURE, 0.0)
    for n in range(edge_fits.ENOUGH, len(x) - edge_fits.ENOUGH + 1):
        width, near, far = (x[n - 1] + x[n]) / 2, y[:n], y[n:]
        step = abs(near.mean() - far.mean())
        if edge_fits.NARROWEST_FRAME <= width <= min(edge_fits.WIDEST_FRAME, x[-1] - edge_fits.LEAST_FACE) and step > smallest_step:
            spread = (near.var() * n + far.var() * len(far)) / len(x)
            score = step / np.sqrt(max(spread, 1e-8) * (1 / n + 1 / len(far)))
            best = max(best, (score, width), key=lambda found: found[0])
    return best[1]


@pytest.mark.parametrize("seed", range(20))
def test_frames_are_those_of_a_plain_search(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.choice([0, 19, 20, 60, 800]))
    distance, edge, step = rng.uniform(0, 0.3, count), rng.uniform(0.01, 0.1), rng.choice([0.0, 0.003, 0.006, -0.02])
    depth = rng.normal(0, 0.003, count) + np.where(distance < edge, step, 0)
    assert frame_width(distance, depth, smallest_step=0.004) == pytest.approx(frame_in_numpy(distance, depth, 0.004), abs=1e-12)


def test_a_plain_face_has_no_frame():
    rng = np.random.default_rng(2)
    assert frame_width(rng.uniform(0, 0.25, 4000), rng.normal(0, 0.015, 4000)) == 0.0
    assert frame_width(np.zeros(0), np.zeros(0)) == 0.0


def test_holes_are_rectangles_between_wall_cells():
    open_cells = np.zeros((26, 80), dtype=bool)
    open_cells[0:21, 5:15] = True
    open_cells[9:22, 30:45] = True
    open_cells[9:22, 47:60] = True
    open_cells[12:14, 70:72] = True
    wall_cells = ~open_cells
    wall_cells[9:22, 45:47] = False  # an unseen mullion
    assert find_holes(open_cells, wall_cells, cell=0.1) == [Hole(0.5, 1.5, 0.0, 2.1), Hole(3.0, 6.0, 0.9, 2.2)]
    wall_cells[9:22, 45:47] = True  # a pier
    assert [h.start for h in find_holes(open_cells, wall_cells, cell=0.1)] == [0.5, 3.0, 4.7]


@pytest.mark.parametrize("seed", range(5))
def test_gaps_of_open_cells_are_closed_as_by_scipy(seed):
    rng = np.random.default_rng(seed)
    cells = rng.random((rng.integers(1, 20), rng.integers(1, 30))) < 0.4
    expected = ndimage.binary_closing(np.pad(cells, 2), np.ones((3, 3)))[2:-2, 2:-2]
    np.testing.assert_array_equal(_closed(cells), expected)


def runs_in_numpy(part, wall, cell):
    """Twin of `_runs`."""
    count = part.sum(axis=0)
    if not count.any():
        return []
    full = np.diff(np.concatenate([[0], count >= FULL_LINE * np.percentile(count[count > 0], 90), [0]]).astype(int))
    solid = np.concatenate([[0], np.cumsum(wall.sum(axis=0) > count)])
    runs = []
    for begin, end in zip(np.flatnonzero(full > 0), np.flatnonzero(full < 0), strict=True):
        narrow = runs and (begin - runs[-1][1] + 1) * cell <= NARROW_BAR + cell
        if narrow and (solid[begin] - solid[runs[-1][1]]) * cell < THIN_BAR:
            runs[-1][1] = end
        else:
            runs.append([begin, end])
    return sorted(((int(a), int(b)) for a, b in runs), key=lambda run: (run[0] - run[1], run[0]))


@pytest.mark.parametrize("seed", range(30))
def test_stretches_of_open_columns_are_those_of_numpy(seed):
    rng = np.random.default_rng(seed)
    columns = int(rng.integers(1, 60))
    part = (rng.random((rng.integers(1, 12), columns)) < 0.9) & np.repeat(rng.random(60) < 0.6, rng.integers(1, 6, 60))[:columns]
    wall = ~part & (rng.random(part.shape) < 0.7) & np.repeat(rng.random(60) < 0.5, rng.integers(1, 6, 60))[:columns]
    for cell in (0.03, 0.05, 0.1):
        assert _runs(part, wall, cell=cell) == runs_in_numpy(part, wall, cell)
        assert _runs(part.T, wall.T, cell=cell) == runs_in_numpy(part.T, wall.T, cell)


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (30, 50), (7, 9, 11), (20, 1, 20)])
@pytest.mark.parametrize("filled", [0.0, 0.08, 0.3, 1.0])
def test_connected_cells_are_numbered_as_by_scipy(shape, filled):
    cells = np.random.default_rng(len(shape)).random(shape) < filled
    labels, boxes = connected_cells(cells)
    expected, count = ndimage.label(cells, np.ones((3,) * len(shape)))
    assert np.array_equal(labels, expected)
    assert len(boxes) == count
    assert [tuple(slice(a, b) for a, b in zip(*box, strict=True)) for box in boxes.tolist()] == ndimage.find_objects(expected)


def test_no_open_cell_no_hole():
    assert find_holes(np.zeros((5, 5), dtype=bool), np.ones((5, 5), dtype=bool), cell=0.1) == []


def test_drift_and_relief_are_told_apart():
    rng = np.random.default_rng(4)
    n = 40_000
    along, up = rng.uniform(0, 4, n).astype(np.float32), rng.uniform(0, 2.5, n).astype(np.float32)
    period = rng.integers(0, 30, n)
    drift = 0.03 * np.sin(np.arange(30))
    panel = (along > 1.0) & (along < 2.0) & (up < 2.0)
    depth = (drift[period] + np.where(panel, 0.02, 0) + rng.normal(0, 0.01, n)).astype(np.float32)
    ones = np.ones(n, dtype=np.float32)
    rays = WallRays(np.ones(n, dtype=np.int8), depth, along, up, along, up, along, up, ones, ones, period)
    level, scatter, (relief,) = level_faces(rays, cell=0.1, shape=(25, 40))
    assert scatter == pytest.approx(0.01, abs=0.002)
    assert np.median(level.depth[~panel]) == pytest.approx(0, abs=0.003)
    assert np.median(level.depth[panel]) == pytest.approx(0.02, abs=0.003)
    assert relief.depth[2:18, 12:18].mean() == pytest.approx(0.02, abs=0.003)
    assert relief.hits.sum() > 0.9 * n


def test_a_png_file_holds_the_image():
    image = np.random.default_rng(0).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    data = png_bytes(image)
    assert struct.unpack(">II", data[16:24]) == (5, 7)
    length = struct.unpack(">I", data[33:37])[0]
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), dtype=np.uint8).reshape(7, 16)
    assert (rows[:, 0] == 0).all()
    assert (rows[:, 1:].reshape(7, 5, 3) == image).all()


@pytest.mark.parametrize("wrong", [np.zeros((2, 2), dtype=np.uint8), np.zeros((2, 2, 3))])
def test_only_rgb_bytes_become_a_png_file(wrong):
    with pytest.raises(ValueError, match="expected an image of shape"):
        png_bytes(wrong)


def test_the_image_has_the_foot_of_the_wall_below_and_openings_outlined():
    none = np.zeros((2, 3, 4), dtype=np.int64)
    face = none.copy()
    face[0, 0, 0] = 1
    image = wall_image(WallPicture(0.1, face, none, none, none[0]), [(0.2, 0.4, 0.1, 0.3)], zoom=2)
    assert image.shape == (6, 8, 3)
    assert image[-1, 0].tolist() == [90, 90, 90]
    assert image[0, 4].tolist() == [220, 30, 30]
    assert image[0, 0].tolist() == [235, 235, 235]
