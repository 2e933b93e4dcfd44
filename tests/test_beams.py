"""A beam between two rooms is no wall; a lintel over a door, a window and a wall behind cupboards are."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from indoor_bim.plan.beams import without_beams
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_loops import hit_beside
from indoor_bim.plan.raster import Raster

THICKNESS = 0.24
ROOMS = shapely.union_all([shapely.box(0, -3, 8, 0), shapely.box(0, THICKNESS, 8, 3)])
P, Q = np.array([[8.0, 0.0], [0.0, THICKNESS]]), np.array([[0.0, 0.0], [8.0, THICKNESS]])  # faces of the wall between them


def scan(opening, *, curtain=False, filled=False, seed=0):
    """Points on a wall along x whose opening reaches up to a beam, or is filled by glass, or has a curtain on one side."""
    random = np.random.default_rng(seed)
    x, rise = random.uniform(0, 8, 60_000), random.uniform(0, 1, 60_000)
    y = np.where(random.uniform(size=len(x)) < 0.5, 0.0, THICKNESS)
    stays = (x < opening[0]) | (x > opening[1]) | (rise > 0.88) | filled
    reveal = random.uniform(0, 1, (2_000, 2))
    xy = [np.column_stack([x, y])[stays], np.column_stack([np.where(np.arange(2_000) % 2, *opening), reveal[:, 0] * THICKNESS])]
    heights = [rise[stays], reveal[:, 1]]
    if curtain:
        xy.append(np.column_stack([random.uniform(*opening, 5_000), np.full(5_000, THICKNESS + 0.02)]))
        heights.append(random.uniform(0, 1, 5_000))
    rise = np.concatenate(heights)
    return WallPoints(np.vstack(xy), rise, 2.5 * (1 - rise), None)


def floor(opening, *, seen=True):
    """Where the floor was hit: in both rooms, and in the opening unless something hid it."""
    raster = Raster(np.zeros((240, 340), dtype=np.float32), np.array([-0.2, -3.0]), 0.025)
    rows, columns = np.indices(raster.image.shape)
    xy = raster.centre(np.column_stack([rows.ravel(), columns.ravel()]))
    below_wall = (xy[:, 1] > 0) & (xy[:, 1] < THICKNESS)
    through = (xy[:, 0] > opening[0]) & (xy[:, 0] < opening[1]) & seen
    raster.image[...] = (~below_wall | through).reshape(raster.image.shape)
    return raster


def left_over(opening, points=None, rooms=ROOMS, **floor_options):
    """Extents along x of what is left of each face."""
    p, q = without_beams(P, Q, scan(opening) if points is None else points, floor(opening, **floor_options), rooms)
    extents = np.sort(np.column_stack([p[:, 0], q[:, 0]]), axis=1)
    return [sorted(map(tuple, extents[np.isclose(p[:, 1], y)].tolist())) for y in (0.0, THICKNESS)]


@pytest.mark.parametrize("opening", [(2.0, 5.5), (2.03, 5.47), (1.0, 3.4)])
def test_no_face_is_left_below_a_beam(opening):
    for face in left_over(opening):
        np.testing.assert_allclose(face, [(0, opening[0]), (opening[1], 8)], atol=1e-3)


def test_beam_from_end_to_end_leaves_nothing():
    assert left_over((-0.1, 8.1)) == [[], []]


WHOLE = [[(0.0, 8.0)], [(0.0, 8.0)]]


def test_lintel_over_a_double_door_is_wall():
    assert left_over((3.0, 5.0)) == WHOLE


def test_where_the_floor_was_not_seen_the_wall_goes_on():
    assert left_over((2.0, 5.5), seen=False) == WHOLE


def test_glass_is_wall():
    assert left_over((2.0, 5.5), points=scan((2.0, 5.5), filled=True)) == WHOLE


def test_opening_to_the_outside_is_in_a_wall():
    opening = (2.0, 5.5)
    kept = without_beams(P[:1], Q[:1], scan(opening), floor(opening), shapely.box(0, -3, 8, 0))
    np.testing.assert_array_equal(kept, (P[:1], Q[:1]))


def test_beam_that_shows_from_one_side_has_two_faces():
    for face in left_over((2.0, 5.5), points=scan((2.0, 5.5), curtain=True)):
        np.testing.assert_allclose(face, [(0, 2.0), (5.5, 8)], atol=1e-3)


def test_order_of_points_and_faces_changes_nothing():
    opening = (2.0, 5.5)
    points = scan(opening)
    shuffled = points.take(np.random.default_rng(1).permutation(len(points)))
    first = without_beams(P, Q, points, floor(opening), ROOMS)
    second = without_beams(P[::-1], Q[::-1], shuffled, floor(opening), ROOMS)
    np.testing.assert_array_equal(sorted(np.hstack(first).tolist()), sorted(np.hstack(second).tolist()))


def test_short_faces_and_no_faces_stay():
    p, q = np.array([[1.0, 1.0]]), np.array([[1.05, 1.0]])
    kept = without_beams(p, q, scan((2.0, 5.5)), floor((2.0, 5.5)), ROOMS)
    np.testing.assert_array_equal(kept, (p, q))
    assert len(without_beams(p[:0], q[:0], scan((2.0, 5.5)), floor((2.0, 5.5)), ROOMS)[0]) == 0


def test_spots_beside_which_the_floor_was_hit():
    rng = np.random.default_rng(2)
    raster = Raster(rng.random((60, 80)) < 0.01, np.array([-0.3, 0.1]), 0.025)
    spots = rng.uniform([-1, -0.5], [2.5, 2.5], (500, 2))
    left, shifts, depths = np.array([0.6, 0.8]), np.linspace(-0.1, 0.1, 9), np.arange(0.06, 0.2, 0.02)
    along, hit = np.array([left[1], -left[0]]), np.arange(500) % 5 > 0
    expected = hit & np.any([raster.sample(spots + s * along - t * left) > 0 for s in shifts for t in depths], axis=0)
    hit_beside(raster.image, -0.3, 0.1, 0.025, spots, left, shifts, depths, hit)
    assert np.array_equal(hit, expected)
    assert 50 < hit.sum() < 350
