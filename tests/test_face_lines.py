"""Faces in strips become lines: where they are, as long as they are, on the side that they were seen from."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import connected, face_lines, join_lines, straight_pieces
from indoor_bim.plan.strips import sweep

HEIGHT = 2.5


def face(start, end, offset, *, slope=0.0, side=1.0, noise=0.003, count=40_000, seed=0):
    """Points on a face along x, and scanner positions on one side of it."""
    random = np.random.default_rng(seed)
    x, rise = random.uniform(start, end, count), random.uniform(0.02, 0.97, count)
    y = offset + slope * x + random.normal(0, noise, count)
    sensor = np.column_stack([random.uniform(start, end, count), np.full(count, offset + 2.0 * side)])
    return WallPoints(np.column_stack([x, y]), rise, HEIGHT * (1 - rise), sensor)


def together(*parts):
    """Points of several faces."""
    return WallPoints(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("xy", "rise", "depth", "sensor")))


@pytest.mark.parametrize(("side", "angle", "sign"), [(1.0, 0.0, 1), (-1.0, np.pi, -1)])
def test_face_is_found_on_the_side_that_it_was_seen_from(side, angle, sign):
    lines = face_lines(sweep(face(0, 5, 1.237, side=side), 0.0), family=3)
    assert len(lines) == 1
    assert np.cos(lines.angle[0] - angle) > np.cos(0.002)
    assert lines.offset[0] * sign == pytest.approx(1.237, abs=0.004)
    assert sorted([lines.start[0] * sign, lines.end[0] * sign]) == pytest.approx([0, 5], abs=0.15)
    assert lines.family.tolist() == [3]


@pytest.mark.parametrize("slope", [0.0, 0.01, -0.05])
def test_direction_is_that_of_the_points(slope):
    lines = face_lines(sweep(face(0, 8, 0.3, slope=slope), 0.0), family=0)
    assert len(lines) == 1
    assert np.tan(lines.angle[0]) == pytest.approx(slope, abs=0.001)
    assert np.array([4.0, 0.3 + 4 * slope]) @ lines.normal[0] == pytest.approx(lines.offset[0], abs=0.004)


def test_two_faces_of_a_wall_are_two_lines():
    points = together(face(0, 6, 0.0, side=-1.0), face(0, 6, 0.12, side=1.0, seed=1))
    lines = face_lines(sweep(points, 0.0), family=0)
    assert np.sort(lines.offset * np.cos(lines.angle)) == pytest.approx([0.0, 0.12], abs=0.005)
    assert sorted(np.cos(lines.angle)) == pytest.approx([-1, 1], abs=1e-4)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.05, 0.3])
def test_strips_on_crests_are_grouped_as_in_an_image(share):
    crest = np.random.default_rng(3).random((2, 30, 90)) < share
    crest[:, :, [0, -1]] = False
    expected = []
    for side in (0, 1):
        labels, number = ndimage.label(ndimage.binary_dilation(crest[side], np.ones((1, 3))), np.ones((3, 3)))
        expected += [[(side, *strip) for strip in np.argwhere(crest[side] & (labels == k + 1)).tolist()] for k in range(number)]
    groups = connected(np.argwhere(crest), crest.shape)
    assert [[tuple(strip) for strip in group.tolist()] for group in groups] == expected


def test_crest_that_steps_from_a_leaf_to_the_wall_beside_it_is_cut_at_the_step():
    u = np.arange(25)
    v = np.concatenate([np.full(8, 43), [45, 48], np.full(15, 50)])
    first, second = straight_pieces(u, v)
    assert first.stop == second.start
    assert 8 <= first.stop <= 10


@pytest.mark.parametrize("slope", [0.0, 0.35, 1.0])
def test_crest_along_one_line_stays_whole(slope):
    u = np.arange(25)
    assert straight_pieces(u, np.rint(43 + slope * u).astype(np.int64)) == [slice(0, 25)]


def test_crest_that_bends_stays_whole():
    u = np.arange(60)
    assert straight_pieces(u, np.rint(43 + 0.3 * np.abs(u - 30)).astype(np.int64)) == [slice(0, 60)]


def test_crest_that_is_too_short_to_be_cut_stays_whole():
    assert straight_pieces(np.arange(7), np.array([43, 43, 43, 50, 50, 50, 50])) == [slice(0, 7)]


@pytest.mark.parametrize("degrees", [0.5, 2.0, 5.0])
def test_wall_that_is_askew_is_one_piece(degrees):
    lines = face_lines(sweep(face(0, 2.6, 0.43, slope=np.tan(np.radians(degrees)), count=26_000), 0.0), family=0)
    assert np.degrees(lines.angle) == pytest.approx([degrees], abs=0.15)


def test_short_bits_and_steep_faces_are_no_lines():
    steep = face(0, 5, 0.0, slope=np.tan(np.radians(30)))
    assert len(face_lines(sweep(face(0, 0.15, 1.0, count=4_000), 0.0), family=0)) == 0
    assert len(face_lines(sweep(steep, 0.0), family=0)) == 0


def test_order_of_points_changes_nothing():
    points = together(face(0, 6, 0.0, side=-1.0, noise=0.01), face(1, 3, 1.2, seed=1, slope=0.02))
    shuffled = points.take(np.random.default_rng(5).permutation(len(points)))
    first, second = (face_lines(sweep(some, 0.0), family=0) for some in (points, shuffled))
    for name in first.__slots__:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_joined_lines_keep_their_rows():
    lines = face_lines(sweep(together(face(0, 6, 0.0), face(0, 6, 1.0, seed=1)), 0.0), family=0)
    joined = join_lines([lines, lines.take(np.array([1]))])
    assert joined.offset.tolist() == [*lines.offset.tolist(), float(lines.offset[1])]
