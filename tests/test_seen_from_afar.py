"""Walls that hold few points: where the scan is thin, the lines that are found there, the faces of places that were only looked into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from face_lines import lines_between

from indoor_bim.auto import _entered
from indoor_bim.plan import local_density
from indoor_bim.plan.cells import cut_into_cells
from indoor_bim.plan.evidence import FEW_POINTS, WallPoints
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.free_space import FreeSpace, extent, in_front, roofed, usual_density
from indoor_bim.plan.line_search import AFAR, beside, edge_evidence, find_lines
from indoor_bim.plan.local_density import thinly_scanned
from indoor_bim.plan.loose_faces import attached, joined_pieces, opaque, points_outside, reach_out, without_doubles
from indoor_bim.plan.oblique import unexplained
from indoor_bim.plan.passing_rays import Rays
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.room_outlines import OutlineRing, RoomOutline

HEIGHT = 2.5
NOTHING_OVERHEAD = Raster(np.zeros((1, 1)), np.array([-50.0, -50.0]), 100.0)


def wall(p, q, *, density, seen_from, low=0.06, high=HEIGHT - 0.06, noise=0.008, seed=0):
    """Points on a wall from p to q, so many per square metre."""
    rng = np.random.default_rng(seed)
    p, q = np.asarray(p, float), np.asarray(q, float)
    length = np.hypot(*(q - p))
    count = int(density * length * (high - low))
    d = (q - p) / length
    xy = p + rng.random(count)[:, None] * (q - p) + rng.normal(0, noise, count)[:, None] * np.array([-d[1], d[0]])
    z = rng.uniform(low, high, count)
    return WallPoints(xy, z / HEIGHT, HEIGHT - z, np.tile(np.asarray(seen_from, float), (count, 1)))


def together(*parts):
    return WallPoints(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("xy", "rise", "depth", "sensor")))


def line(angle, offset, start, end):
    """One line from its angle in degrees."""
    one = [np.array([v], float) for v in (np.radians(angle), offset, start, end, 0.01)]
    return FaceLines(*one, np.zeros(1, dtype=np.int64))


def test_the_far_side_of_a_dense_wall_is_thinly_scanned():
    near = wall((0, 0), (5, 0), density=2000, seen_from=(2.5, -2))
    far = wall((5, 0.2), (0, 0.2), density=50, seen_from=(2.5, 6), seed=1)
    thin = thinly_scanned(together(near, far), NOTHING_OVERHEAD, sparse=300)
    assert not thin[: len(near)].any()
    assert thin[len(near) :].mean() > 0.95


def test_below_a_densely_scanned_ceiling_nothing_counts_as_thin():
    points = wall((0, 0), (5, 0), density=50, seen_from=(2.5, -2))
    dense = Raster(np.full((1, 1), 400.0), np.array([-50.0, -50.0]), 100.0)
    assert thinly_scanned(points, NOTHING_OVERHEAD, sparse=300).all()
    assert not thinly_scanned(points, dense, sparse=300).any()


def test_a_cupboard_with_few_points_above_it_was_not_seen_from_afar():
    cupboard = wall((0, 0), (2, 0), density=900, seen_from=(1, -2), high=2.0)
    assert thinly_scanned(cupboard, NOTHING_OVERHEAD, sparse=AFAR).all()
    middle = (cupboard.xy[:, 0] > 0.4) & (cupboard.xy[:, 0] < 1.6)
    assert not thinly_scanned(cupboard, NOTHING_OVERHEAD, sparse=AFAR, whole=True)[middle].any()


@pytest.mark.parametrize("sided", [True, False])
@pytest.mark.parametrize("whole", [True, False])
def test_many_points_are_thin_where_few_are(whole, sided, monkeypatch):
    parts = [wall((0, k), (6 - k, k), density=20 * 6**k, seen_from=(3 + k, 2), seed=k, low=0.4 * k) for k in range(4)]
    points = together(*parts)
    if not sided:
        points = replace(points, sensor=None)
    assert len(points) > FEW_POINTS
    overhead = Raster(np.random.default_rng(3).uniform(0, 600, (20, 30)), np.array([0.5, -1.0]), 0.25)
    found = [thinly_scanned(points, overhead, sparse=sparse, whole=whole) for sparse in (40, 400)]
    monkeypatch.setattr(local_density, "FEW_POINTS", len(points))
    for thin, sparse in zip(found, (40, 400), strict=True):
        assert np.array_equal(thin, thinly_scanned(points, overhead, sparse=sparse, whole=whole))
        assert 0 < thin.mean() < 1


@pytest.mark.parametrize("density", [12, 40, 150])
def test_a_thin_wall_is_found_where_it_is(density):
    dense = wall((0, 0), (8, 0), density=3000, seen_from=(4, 2))
    thin = wall((8, 9.0), (0, 9.0), density=density, seen_from=(4, 2), seed=3)
    points = together(dense, thin)
    lines, _ = find_lines(points, NOTHING_OVERHEAD)
    (far,) = np.flatnonzero(np.abs(lines.offset * lines.normal[:, 1] - 9.0) < 0.1)
    assert abs(lines.offset[far] * lines.normal[far, 1] - 9.0) < 0.006
    assert lines.normal[far, 1] == pytest.approx(-1, abs=1e-3)
    assert lines.end[far] - lines.start[far] > 6.5


def test_edges_that_were_seen_from_afar_only_were_not_seen_from_nearby():
    points = together(
        wall((0, 0), (8, 0), density=3000, seen_from=(4, 2)),
        wall((8, 0), (8, 9), density=3000, seen_from=(4, 2), seed=1),
        wall((8, 9.0), (0, 9.0), density=6, seen_from=(4, 2), seed=3),
    )
    lines, sweeps = find_lines(points, NOTHING_OVERHEAD)
    p, q = lines.ends(2.5)
    left = np.array([[0.0, -0.5], [0.0, 9.5]])
    cells = cut_into_cells(np.vstack([p, left[:1]]), np.vstack([q, left[1:]]))
    seen, nearby = edge_evidence(cells, lines, sweeps)
    height = (cells.edge_start + cells.edge_end)[:, 1] / 2
    near, far = (cells.edge_line < len(lines)) & (np.abs(height) < 0.1), (cells.edge_line < len(lines)) & (np.abs(height - 9) < 0.1)
    long = np.hypot(*(cells.edge_end - cells.edge_start).T) > 6
    assert (near & long).any()
    assert (far & long).any()
    assert (np.minimum(seen, nearby)[near & long & (seen > 0)] > 0.8).all()
    assert seen[far & long].max() > 0.7
    assert nearby[far & long].max() == 0


def test_scattered_points_are_no_wall():
    rng = np.random.default_rng(5)
    count = 1200
    z = rng.uniform(0.06, 2.44, count)
    scattered = WallPoints(rng.uniform(0, 10, (count, 2)), z / HEIGHT, HEIGHT - z, np.tile([5.0, -3.0], (count, 1)))
    lines, _ = find_lines(scattered, NOTHING_OVERHEAD)
    assert len(lines) == 0


def test_lines_do_not_depend_on_the_order_of_points():
    points = together(wall((0, 0), (8, 0), density=800, seen_from=(4, 2)), wall((8, 9), (0, 9), density=15, seen_from=(4, 2), seed=3))
    order = np.random.default_rng(0).permutation(len(points))
    first, second = (find_lines(p, NOTHING_OVERHEAD)[0] for p in (points, points.take(order)))
    np.testing.assert_array_equal(first.offset, second.offset)
    np.testing.assert_array_equal(first.start, second.start)


def test_a_pane_runs_beside_its_wall_and_a_wall_goes_on_in_itself():
    certain = line(0, 1.0, 0.0, 6.0)
    assert beside(line(0, 0.85, 2.0, 4.0), certain).all()
    assert not beside(line(0, 0.98, 2.0, 4.0), certain).any()
    assert not beside(line(0, 0.5, 2.0, 4.0), certain).any()
    assert not beside(line(180, -0.85, -4.0, -2.0), certain).any()
    assert not beside(line(0, 0.85, 5.5, 9.0), certain).any()


def test_of_two_pieces_side_by_side_the_longer_stays():
    p = np.array([[0.0, 0.0], [1.0, -0.2], [3.0, 0.2], [0.0, 1.0]])
    q = np.array([[5.0, 0.0], [4.0, -0.2], [1.0, 0.2], [5.0, 1.0]])
    assert without_doubles(p, q).tolist() == [True, False, True, True]


def test_pieces_meet_in_a_corner_and_reach_the_room():
    room = shapely.box(0, 0, 10, 5)
    p = np.array([[4.0, 9.0], [9.5, 10.0]])
    q = np.array([[4.0, 6.0], [6.0, 10.0]])
    a, b = reach_out(p, q, room)
    np.testing.assert_allclose(b[0], [4.0, 5.0])
    np.testing.assert_allclose(a[0], [4.0, 10.0])
    np.testing.assert_allclose(b[1], [4.0, 10.0])
    np.testing.assert_allclose(a[1], [9.5, 10.0])
    assert attached(a, b, room).all()


def test_the_end_past_a_crossing_is_cut_off():
    _, b = reach_out(np.array([[0.0, 0.0], [3.0, -4.0]]), np.array([[3.6, 0.0], [3.0, -0.5]]), shapely.Polygon())
    np.testing.assert_allclose(b[0], [3.0, 0.0])
    np.testing.assert_allclose(b[1], [3.0, 0.0])


def test_a_reflection_lets_rays_pass():
    rng = np.random.default_rng(2)
    p, q = np.array([[5.0, 3.0]]), np.array([[0.0, 3.0]])
    on = np.column_stack([rng.uniform(0.5, 4.5, 90), rng.normal(3.0, 0.01, 90), rng.uniform(0.5, 2.0, 90)])
    beyond = np.column_stack([rng.uniform(0.5, 4.5, 60), np.full(60, 8.0), rng.uniform(0.5, 2.0, 60)])
    over = beyond + np.array([0, 0, 40.0])
    hits = np.vstack([on, beyond[:20]])
    scanner = np.array([2.5, 0.0, 1.4])

    def kept(hits):
        return opaque(p, q, Rays(hits, np.tile(scanner, (len(hits), 1)), low=0.0, high=2.5)).item()

    assert kept(hits)
    assert not kept(np.vstack([on, beyond]))
    assert kept(np.vstack([hits, over])), "rays above the wall do not count"


def space(ceiling, *, cell=0.05):
    return FreeSpace(ceiling, np.zeros_like(ceiling), ceiling * 0.5, np.zeros(ceiling.shape), np.zeros(2), cell)


def test_a_roof_is_hit_here_and_there_the_top_of_a_wall_along_a_line():
    ceiling = np.zeros((200, 200), dtype=bool)
    ceiling[5, :] = True
    ceiling[120::9, 100::13] = True
    seen = roofed(space(ceiling))
    along_the_wall = seen.sample(np.array([[5.0, 0.25], [7.0, 0.6]]))
    below_the_roof = seen.sample(np.array([[7.0, 8.0], [8.0, 7.5]]))
    assert not along_the_wall.any()
    assert below_the_roof.all()


def test_a_tenth_of_the_pixels_of_five_centimetres_is_forty_points_per_square_metre():
    tenth, none = np.full((100, 100), 0.1, dtype=np.float32), np.zeros((100, 100), dtype=bool)
    found = usual_density(shapely.box(1, 1, 4, 4), FreeSpace(none, none, tenth, tenth * 0, np.zeros(2), 0.05))
    assert found == pytest.approx(40.0, rel=1e-3)


def test_in_front_of_faces_is_free_up_to_half_a_cell():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    cells = cut_into_cells(square, np.roll(square, -1, axis=0))
    seen = (cells.edge_line == 0).astype(float)
    assert in_front(cells, seen, depth=0.6) == pytest.approx([2.4])
    assert in_front(cells, np.ones(4), depth=0.6) == pytest.approx([6.0])


def test_a_storey_reaches_as_far_as_its_ceiling_and_not_to_a_facade_across_the_street():
    rng = np.random.default_rng(4)
    ceiling = np.column_stack([rng.uniform(0, 6, 3000), rng.uniform(0, 5, 3000), np.full(3000, 2.5)])
    glimpsed = np.column_stack([rng.uniform(6, 12, 400), rng.uniform(0, 5, 400), np.full(400, 2.5)])
    facade = np.column_stack([np.full(500, 30.5), rng.uniform(0, 5, 500), rng.uniform(2.45, 2.55, 500)])
    overhead = Raster(np.full((25, 30), 2.5), np.zeros(2), 0.2)
    low, high = extent(overhead, np.vstack([ceiling, glimpsed, facade]), floor=0.0, top=2.7)
    assert np.allclose(low, [-1.2, -1.2], atol=0.2)
    assert np.allclose(high, [13.2, 6.2], atol=0.2)


def test_many_points_off_the_lines_are_told_as_few_are():
    rng = np.random.default_rng(4)
    xy, rise = rng.uniform(0, 3, (30_000, 2)), rng.uniform(0.5, 1, 30_000)
    points = WallPoints(xy, rise, np.full(30_000, 0.3), None)
    angle = np.array([0.0, 1.1, 2.0])
    lines = FaceLines(angle, np.array([1.0, 0.5, -2.0]), np.full(3, -0.5), np.full(3, 1.5), np.full(3, 0.01), np.arange(3))
    few = np.vstack([unexplained(points.take(part), lines).xy for part in np.array_split(np.arange(30_000), 4)])
    assert 0 < len(few) < (rise > 0.8).sum()
    assert np.array_equal(unexplained(points, lines).xy, few)


def test_low_walls_leave_nothing_unexplained():
    low = wall((0, 0), (5, 0), density=500, seen_from=(2.5, -2), high=1.2)
    assert len(unexplained(low, FaceLines.none())) == 0
    assert len(find_lines(low, NOTHING_OVERHEAD)[0]) == 0


def test_points_outside_of_an_area():
    area = shapely.Polygon([(0, 0), (6, 1), (5, 4), (2, 3.5), (1, 6)], [[(2, 1.5), (4, 1.5), (3, 3)]])
    xy = np.random.default_rng(9).uniform(-2, 8, (30_000, 2))
    outside = points_outside(area, xy)
    assert np.array_equal(outside, np.flatnonzero(~shapely.contains_xy(area, *xy.T)))
    assert np.array_equal(points_outside(area.buffer(-0.6), xy[:50]), np.flatnonzero(~shapely.contains_xy(area.buffer(-0.6), *xy[:50].T)))
    assert len(points_outside(shapely.Polygon(), xy)) == len(xy)


def looked_into(*, through_the_gap, seed=4):
    """Rays from a corridor that were stopped by a wall along x = 5, y from 1 to 4, and by what is behind its line from y = 4 on."""
    rng = np.random.default_rng(seed)
    on = np.column_stack([np.full(60, 5.0), rng.uniform(1, 4, 60), rng.uniform(0.5, 2.0, 60)])
    beyond = np.column_stack([np.full(through_the_gap, 8.0), rng.uniform(8, 14, through_the_gap), rng.uniform(0.5, 2.0, through_the_gap)])
    hits = np.vstack([on, beyond])
    return Rays(hits, np.tile([1.0, 1.0, 1.4], (len(hits), 1)), 0.2, 2.4)


@pytest.mark.parametrize(("through_the_gap", "reached"), [(0, 9.0), (40, 4.0)])
def test_a_piece_runs_on_far_only_where_nothing_was_seen_through_it(through_the_gap, reached):
    p, q = np.array([[5.0, 1.0]]), np.array([[5.0, 4.0]])
    room = shapely.box(0, 9, 10, 10)
    rays = looked_into(through_the_gap=through_the_gap)
    assert reach_out(p, q, room, rays)[1][0, 1] == pytest.approx(reached)
    assert reach_out(p, q, room)[1][0, 1] == 4.0, "without rays only what is near counts"
    assert reach_out(p, q, shapely.box(0, 12.5, 10, 15), rays)[1][0, 1] == 4.0, "too far for so short a piece"


def test_what_a_pane_mirrors_is_not_joined_to_the_room():
    p, q = np.array([[0.0, 9.0]]), np.array([[0.0, 7.0]])
    assert reach_out(p, q, shapely.box(0, 0, 8, 6))[1][0, 1] == 7.0
    assert reach_out(p, q, shapely.box(-4, 0, 4, 6))[1][0, 1] == pytest.approx(6.0)
    assert reach_out(p, q, shapely.box(0, 0, 8, 6.5))[1][0, 1] == pytest.approx(6.5), "the side itself, beyond the end of the room"
    assert reach_out(p, q, shapely.box(1e-6, 0, 8, 6.5), near=9.0)[1][0, 1] == 7.0, "which it may just miss"


@pytest.mark.parametrize(("through_the_gap", "pieces"), [(0, 1), (40, 2)])
def test_pieces_of_one_face_are_joined_where_nothing_was_seen_through_the_gap(through_the_gap, pieces):
    p, q = np.array([[5.02, 8.0], [5.0, 1.0]]), np.array([[5.02, 10.0], [5.0, 4.0]])
    rays = looked_into(through_the_gap=through_the_gap)
    aside = np.array([[0.1, 0.0], [0.0, 0.0]])
    a, b = joined_pieces(p, q, shapely.Polygon(), rays)
    assert len(a) == pieces
    assert len(joined_pieces(p, q, shapely.box(4, 5, 6, 6), rays)[0]) == 2, "no face runs through a room"
    assert len(joined_pieces(p + aside, q + aside, shapely.Polygon(), rays)[0]) == 2, "too far aside"
    if pieces == 1:
        np.testing.assert_allclose([a[0, 1], b[0, 1]], [1.0, 10.0], atol=1e-3)
        assert 4.99 < a[0, 0] < b[0, 0] < 5.03


@pytest.mark.parametrize(("stood", "entered"), [(None, 1), ([6.0, 2.0], 2), ([4.1, 2.0], 1), ([2.0, 2.0], 1)])
def test_a_room_with_few_points_was_entered_where_the_scanner_stood_in_it(stood, entered):
    """Of two rooms, x from 0 to 4 and from 4 to 8, the second holds few points of floor and ceiling."""
    ceiling = np.zeros((160, 80), dtype=bool)
    ceiling[:80] = True
    ceiling[80::20, ::20] = True
    density = ceiling.astype(np.float32)
    seen = FreeSpace(ceiling, ceiling, density, density, np.zeros(2), 0.05)
    rooms = [
        RoomOutline(OutlineRing(tuple(map(tuple, np.array(shapely.box(x, 0, x + 4, 4).exterior.coords)[:4])), (0,) * 4)) for x in (0, 4)
    ]
    sensor = None if stood is None else np.array([[1.0, 1.0, 1.5], [*stood, 1.5]])
    assert [room.polygon.bounds[0] for room in _entered(rooms, seen, sensor)] == [0.0, 4.0][:entered]


def test_what_lines_leave_over_does_not_depend_on_the_order_of_the_points():
    table = np.vstack([wall((0, y), (4, y), density=400, seen_from=(2, 2)).xy for y in (0, 0.09)])
    points = WallPoints(table, np.full(len(table), 0.9), np.full(len(table), 0.25), None)
    turned = WallPoints(table[::-1], points.rise, points.depth, None)
    lines = lines_between(((0, 0), (4, 0)))
    left, other = (unexplained(given, lines).xy for given in (points, turned))
    assert 0 < len(left) < len(table)
    np.testing.assert_array_equal(left[np.lexsort(left.T)], other[np.lexsort(other.T)])
