"""Split-and-merge, merging by chi square, and completed contours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from indoor_bim.plan.boxes import without_boxes
from indoor_bim.plan.chi_square_merge import chi_square, chi_square_limit, merge_lines, with_map_noise
from indoor_bim.plan.contour_completion import CLOSED, CORNER, GAP, STEP, Contour, complete_contour, interrupted
from indoor_bim.plan.contour_rooms import contour_rooms
from indoor_bim.plan.doubles import without_doubles
from indoor_bim.plan.local_lines import draw_to_lines, wall_scatter
from indoor_bim.plan.polar_fit import PolarLines, fit_lines, project_ends
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.split_and_merge import chain_points, drop_small, split_and_merge
from indoor_bim.plan.wall_contour import with_bridges

NOISE = 0.003


def side(p, q, *, spacing=0.004, noise=NOISE, seed=0):
    rng = np.random.default_rng(seed)
    p, q = np.array(p, dtype=float), np.array(q, dtype=float)
    d = (q - p) / np.hypot(*(q - p))
    t = np.arange(0, np.hypot(*(q - p)), spacing)
    return p + t[:, None] * d + noise * rng.standard_normal((len(t), 1)) * [-d[1], d[0]]


def room(corners, **options):
    return np.concatenate([side(a, b, seed=k, **options) for k, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1], strict=True))])


L_SHAPE = [(0, 0), (4, 0), (4, 2), (2.5, 2), (2.5, 3), (0, 3)]


def sets(points, *, distance=0.02, gap=0.06):
    chains = chain_points(points, pixel=0.015)
    return drop_small(split_and_merge(chains, distance=distance, gap=gap)[chains.member], points, min_length=0.05, min_points=5)


def lines_of(points, group):
    covariance = np.broadcast_to(NOISE**2 * np.eye(2), (len(points), 2, 2))
    lines = fit_lines(points, group, covariance)
    return lines, *project_ends(points, group, lines)


def test_every_wall_of_a_room_is_one_set():
    points = room(L_SHAPE)
    group = merge_lines(points, sets(points), np.broadcast_to(NOISE**2 * np.eye(2), (len(points), 2, 2)), farthest=0.02)
    lines, p, q = lines_of(points, group)
    length = np.hypot(*(q - p).T)
    assert np.sort(length[length > 0.2]) == pytest.approx([1.0, 1.5, 2.0, 2.5, 3.0, 4.0], abs=0.08)  # corners take a few centimetres
    assert np.abs(np.sin(2 * lines.alpha[length > 0.2])).max() < 0.02
    assert length[length <= 0.2].size <= 1  # what is left over at a corner


def test_points_of_a_set_are_near_its_line_and_without_gaps():
    points = np.concatenate([room(L_SHAPE), side((0.5, 1), (1.0, 1)), side((1.2, 1), (2.0, 1.3))])
    group = sets(points)
    lines, _, _ = lines_of(points, group)
    on = group >= 0
    off = np.abs((points[on] * lines.normal[group[on]]).sum(axis=1) - lines.radius[group[on]])
    assert np.quantile(off, 0.99) < 0.02
    for k in range(len(lines)):
        along = np.sort(points[group == k] @ lines.along[k])
        assert np.diff(along).max() < 0.06


def test_sets_do_not_depend_on_the_order_of_the_points():
    points = room(L_SHAPE)
    order = np.random.default_rng(2).permutation(len(points))
    assert (sets(points[order]) == sets(points)[order]).all()


@pytest.mark.parametrize(("length", "points", "kept"), [(0.04, 30, 0), (0.2, 4, 0), (0.2, 30, 1)])
def test_short_and_thin_sets_are_dropped(length, points, kept):
    xy = np.column_stack([np.linspace(0, length, points), np.zeros(points)])
    assert len(np.unique(drop_small(np.zeros(points, dtype=np.int64), xy, min_length=0.05, min_points=5))) == 1
    assert drop_small(np.zeros(points, dtype=np.int64), xy, min_length=0.05, min_points=5).max() == kept - 1


def test_a_wide_wall_becomes_thin_and_stays_in_place():
    points = np.concatenate([side((0, 0), (3, 0), noise=0.02), side((0, 0.2), (3, 0.2), noise=0.02, seed=1)])
    thin = draw_to_lines(draw_to_lines(points, radius=0.06), radius=0.06)
    inner = (points[:, 0] > 0.2) & (points[:, 0] < 2.8)
    assert wall_scatter(points) == pytest.approx(0.02, rel=0.25)
    for y in (0.0, 0.2):
        near = inner & (np.abs(points[:, 1] - y) < 0.06)
        assert np.abs(thin[near, 1] - y).mean() < 0.008


def test_the_gate_is_that_of_three_standard_deviations():
    rng = np.random.default_rng(4)
    matrix = np.array([[4e-6, 1e-6], [1e-6, 9e-6]])
    draw = rng.multivariate_normal([0.3, 2.0], matrix, (20_000, 2))
    first, second = (PolarLines(draw[:, k, 0], draw[:, k, 1], np.broadcast_to(matrix, (20_000, 2, 2))) for k in (0, 1))
    assert (chi_square(first, second) > chi_square_limit(3.0)).mean() == pytest.approx(0.0027, abs=0.0012)


def test_unsided_lines_may_have_opposite_normals():
    matrix = 1e-4 * np.eye(2)[None]
    a, b = PolarLines(np.array([0.1]), np.array([2.0]), matrix), PolarLines(np.array([0.1 - np.pi]), np.array([-2.0]), matrix)
    assert chi_square(a, b, sided=False)[0] == pytest.approx(0.0, abs=1e-12)
    assert chi_square(a, b, sided=True)[0] > 1e4


def test_map_noise_moves_a_line_as_a_whole():
    line = PolarLines(np.array([np.pi / 2]), np.array([3.0]), np.zeros((1, 2, 2)))
    noisy = with_map_noise(line, np.array([[10.0, 3.0]]), np.array([[14.0, 3.0]]), noise=0.01).moved(np.array([12.0, 3.0]))
    assert np.sqrt(noisy.covariance[0, 1, 1]) == pytest.approx(0.01)
    assert noisy.covariance[0, 0, 1] == pytest.approx(0.0, abs=1e-12)


PIECES = [((0, 0), (1, 0)), ((1.2, 0), (3, 0)), ((0, 0.1), (2, 0.1)), ((3.9, 0), (6, 0)), ((0, 1), (0, 3)), ((0.0, 3.1), (0.0, 4))]


def merged(order, *, front=None, **options):
    points = np.concatenate([side(*piece, seed=k) for k, piece in enumerate(PIECES)])
    group = np.concatenate([np.full(len(side(*piece)), k) for k, piece in enumerate(PIECES)])
    rank = np.argsort(order)
    shuffle = np.random.default_rng(int(rank[0]) + 10).permutation(len(points))
    covariance = np.broadcast_to(NOISE**2 * np.eye(2), (len(points), 2, 2))
    found = merge_lines(points[shuffle], rank[group][shuffle], covariance, front=None if front is None else front[order], **options)
    back = np.zeros(len(points), dtype=np.int64)
    back[shuffle] = found
    return points, group, back


def test_parts_of_one_line_are_merged_and_parallel_or_distant_ones_are_not():
    _, group, found = merged(np.arange(6))
    assert [np.unique(found[group == k]).size for k in range(6)] == [1] * 6
    names = [int(found[group == k][0]) for k in range(6)]
    assert names[0] == names[1]
    assert names[4] == names[5]
    assert len(set(names)) == 4


@pytest.mark.parametrize("seed", range(5))
def test_merging_does_not_depend_on_the_order_of_sets_or_points(seed):
    order = np.random.default_rng(seed).permutation(6)
    assert (merged(order)[2] == merged(np.arange(6))[2]).all()


def test_merged_lines_are_fitted_to_all_their_points():
    points, _, found = merged(np.arange(6))
    lines, p, q = lines_of(points, found)
    longest = int(np.argmax(np.hypot(*(q - p).T)))
    assert np.hypot(*(q - p)[longest]) == pytest.approx(3.0, abs=0.02)
    alone, _, _ = lines_of(points[:250], np.zeros(250, dtype=np.int64))
    assert lines.covariance[longest, 0, 0] < 0.1 * alone.covariance[0, 0, 0]


def test_faces_that_look_to_opposite_sides_are_not_merged():
    front = np.array([[0, 1.0], [0, -1.0], [0, 1], [5, 1], [1, 2], [1, 3]])
    _, group, found = merged(np.arange(6), front=front)
    assert found[group == 0][0] != found[group == 1][0]


def test_a_partition_keeps_the_walls_on_both_sides_of_it_apart():
    pieces = [((0, 0), (2, 0)), ((2.1, 0), (4, 0)), ((2, 0.0), (2, -2)), ((2.1, 0.0), (2.1, -2))]
    points = np.concatenate([side(*piece, seed=k) for k, piece in enumerate(pieces)])
    group = np.concatenate([np.full(len(side(*piece)), k) for k, piece in enumerate(pieces)])
    found = merge_lines(points, group, np.broadcast_to(NOISE**2 * np.eye(2), (len(points), 2, 2)))
    assert len(np.unique(found)) == 4


def sided(p, q):
    return replace(Segments.from_ends(p, q), sided=np.ones(len(p), dtype=bool))


@pytest.mark.parametrize(("degrees", "linked"), [(90, True), (46, True), (44, False), (20, False)])
def test_ends_become_corners_from_45_degrees_on(degrees, linked):
    a = np.radians(degrees)
    far = [2.1 + 2 * np.cos(a), 0.1 + 2 * np.sin(a)]
    contour = complete_contour(Segments.from_ends([[0, 0], [2.1, 0.1]], [[2, 0], far]))
    assert (contour.kind[0, 1] == CORNER) == linked
    if linked:
        assert contour.segments.q[0] == pytest.approx([2.1 - 0.1 / np.tan(a), 0.0])
        assert contour.segments.p[1] == pytest.approx(contour.segments.q[0])


@pytest.mark.parametrize(("gap", "kind"), [(0.3, CLOSED), (0.49, CLOSED), (0.51, GAP), (1.2, GAP), (3.5, 0)])
def test_gaps_below_half_a_metre_are_closed_at_the_mean_and_wider_ones_left(gap, kind):
    contour = complete_contour(sided([[0, 0], [2 + gap, 0.02]], [[2, 0], [5 + gap, 0.02]]))
    assert contour.kind[0, 1] == kind
    assert len(contour.pairs(GAP)) == (kind == GAP)
    if kind == CLOSED:
        assert contour.segments.q[0] == pytest.approx([2 + gap / 2, 0.01])
    else:
        assert contour.segments.q[0].tolist() == [2.0, 0.0]


def test_ends_beside_one_another_make_a_step():
    contour = complete_contour(sided([[0, 0], [2.1, 0.2]], [[2, 0], [5, 0.2]]))
    assert contour.kind[0, 1] == STEP
    assert contour.segments.q[0] == pytest.approx([2.05, 0.0])
    assert contour.segments.p[1] == pytest.approx([2.05, 0.2])


def test_the_two_faces_of_a_wall_are_left_alone():
    contour = complete_contour(sided([[0, 0], [4, 0.02]], [[2, 0], [2.2, 0.02]]))  # the second one looks to the other side
    assert (contour.kind == 0).all()


def test_each_end_is_linked_once_and_to_the_nearest():
    contour = complete_contour(Segments.from_ends([[0, 0], [2.02, 0.1], [2.3, 0.1]], [[2, 0], [2.02, 2], [2.3, 2]]))
    assert contour.follows[0, 1] == 2
    assert contour.kind[2].tolist() == [0, 0]


def test_completion_does_not_depend_on_the_order_of_the_segments():
    p, q = [[0.1, 0], [4, 0.2], [3.8, 3], [0, 2.9]], [[3.9, 0], [4, 2.9], [0.1, 3], [0, 0.1]]
    straight = complete_contour(sided(p, q)).segments
    order = np.array([2, 0, 3, 1])
    shuffled = complete_contour(sided(np.array(p)[order], np.array(q)[order])).segments
    assert shuffled.p == pytest.approx(straight.p[order])
    rooms, _ = contour_rooms(complete_contour(sided(p, q)))
    assert rooms[0].area == pytest.approx(12.0)


def test_a_column_is_a_closed_contour_seen_from_outside():
    corners = np.array([[0, 0], [0, 0.4], [0.4, 0.4], [0.4, 0]], dtype=float)
    rooms, columns = contour_rooms(complete_contour(sided(corners, np.roll(corners, -1, axis=0))))
    assert not rooms
    assert columns[0].area == pytest.approx(0.16)


def test_wardrobes_are_left_out_and_pilasters_stay():
    def faces(depth):
        return sided([[0, 0], [2, 0], [2, depth], [3.4, depth], [3.4, 0]], [[2, 0], [2, depth], [3.4, depth], [3.4, 0], [6, 0]])

    assert (len(without_boxes(faces(0.6))), len(without_boxes(faces(0.3)))) == (2, 5)


def test_doubles_are_left_out_and_the_other_face_of_the_wall_stays():
    wall, picture, other = ([0, 0], [4, 0]), ([1, 0.05], [2, 0.05]), ([4, -0.1], [0, -0.1])
    kept = without_doubles(sided([wall[0], picture[0], other[0]], [wall[1], picture[1], other[1]]))
    assert kept.length.tolist() == [4.0, 4.0]


@pytest.mark.parametrize(("end", "behind", "corner"), [(5.0, 0.2, 3.5), (2.0, 0.2, 1.0), (5.0, 0.7, 1.0), (5.0, -0.2, 1.0)])
def test_a_hidden_stretch_of_wall_is_drawn_where_its_other_face_goes_along(end, behind, corner):
    contour = complete_contour(sided([[0, 0], [end, -behind], [3.5, 0.2]], [[1, 0], [-1, -behind], [3.5, 3]]))
    assert contour.segments.q[0] == pytest.approx((corner, 0))


def beside_a_door(*, jamb, width=1.0):
    """A wall seen up to a door, and from its other jamb on; the face at the jamb goes into the wall or into the room."""
    return sided(
        [[0, 0], [2 + width, 0], [2 + width, jamb]], [[2, 0], [6, 0], [2 + width, 0]] if jamb < 0 else [[2, 0], [6, 0], [2 + width, 3]]
    )


@pytest.mark.parametrize(("jamb", "width", "goes_on"), [(-0.12, 1.0, True), (0.02, 1.0, False), (0.02, 0.15, True), (-0.12, 3.5, False)])
def test_a_wall_goes_on_behind_a_jamb_and_behind_what_ends_at_it(jamb, width, goes_on):
    faces = beside_a_door(jamb=jamb, width=width)
    follows, kind = np.full((3, 2), -1), np.zeros((3, 2), dtype=np.int8)
    follows[1, 0], kind[1, 0] = 5 if jamb < 0 else 4, CORNER
    follows.ravel()[follows[1, 0]], kind.ravel()[follows[1, 0]] = 2, CORNER
    contour = Contour(faces, follows, kind)
    assert interrupted(contour).tolist() == ([[1, 2]] if goes_on else [])
    bridges = with_bridges(contour, gap=0.5)
    assert len(bridges) == 3 + goes_on
    if goes_on:
        ends = (0.0, 6.0) if width < 0.5 else (2.0, 3.0)
        assert (bridges.p[3, 0], bridges.q[3, 0]) == pytest.approx(ends)
        assert bridges.sided[3]


@pytest.mark.parametrize(("rise", "goes_on"), [(0.0, True), (0.05, False)])
def test_a_wall_does_not_go_on_in_one_that_is_turned(rise, goes_on):
    faces = sided([[0, -3 * rise], [3, 0], [3, 0]], [[2, -rise], [6, 0], [3, -0.12]])
    contour = Contour(faces, np.array([[-1, -1], [4, -1], [2, -1]]), np.array([[0, 0], [CORNER, 0], [CORNER, 0]], dtype=np.int8))
    assert len(interrupted(contour)) == goes_on
