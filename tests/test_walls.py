from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plans import FLAT, TWO_ROOMS, box, faces_of_rooms, turned

from indoor_bim.plan import walls as walls_module
from indoor_bim.plan.collinear import merge_collinear
from indoor_bim.plan.face_chains import chain_faces
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.walls import walls_from_faces


def test_two_faces_that_look_away_from_each_other_are_one_measured_wall():
    walls = walls_from_faces(faces_of_rooms(*TWO_ROOMS))
    measured = walls.take(walls.measured)
    assert len(measured) == 1
    assert measured.thickness[0] == pytest.approx(0.12)
    assert np.sort(measured.p[:, 0]) == pytest.approx([4.06])


def test_one_sided_walls_get_the_usual_thickness_behind_their_face():
    walls = walls_from_faces(faces_of_rooms(*TWO_ROOMS))
    single = walls.take(~walls.measured)
    assert single.thickness == pytest.approx(0.12)
    left = single.take(np.abs(single.direction[:, 1]) > 0.9).p[:, 0].min()
    assert left == pytest.approx(-0.06)


def test_a_building_without_any_measured_wall_gets_the_assumed_thickness():
    walls = walls_from_faces(faces_of_rooms(box(0, 0, 4, 3)))
    assert len(walls) == 4
    assert not walls.measured.any()
    assert walls.thickness == pytest.approx(0.20)


def test_an_assumed_thickness_can_be_given():
    walls = walls_from_faces(faces_of_rooms(box(0, 0, 4, 3)), usual_thickness=0.36)
    assert walls.thickness == pytest.approx(0.36)


def test_faces_that_look_at_each_other_are_a_narrow_corridor_and_no_wall():
    walls = walls_from_faces(faces_of_rooms(box(0, 0, 6, 0.5)))
    assert not walls.measured.any()


def test_faces_farther_apart_than_the_thickest_wall_are_two_walls():
    walls = walls_from_faces(faces_of_rooms(box(0, 0, 4, 3), box(4.7, 0, 9, 3)))
    assert not walls.measured.any()
    upright = walls.take(np.abs(walls.direction[:, 1]) > 0.9)
    assert np.round(upright.p[:, 0], 3).tolist() == [-0.1, 4.1, 4.6, 9.1]


def test_a_door_gap_is_part_of_the_wall():
    faces = faces_of_rooms(*TWO_ROOMS)
    at = int(np.flatnonzero((faces.p == [4, 0]).all(axis=1))[0])
    lower, upper = faces.take([at]), faces.take([at])
    lower, upper = replace(lower, q=np.array([[4.0, 1.0]])), replace(upper, p=np.array([[4.0, 2.0]]))
    rest = faces.take(np.arange(len(faces)) != at)
    cut = Segments(**{n: np.concatenate([getattr(x, n) for x in (rest, lower, upper)]) for n in Segments.__slots__})
    measured = (w := walls_from_faces(cut)).take(w.measured)
    assert measured.length == pytest.approx([3.0])


def test_a_wall_does_not_run_across_a_corridor():
    south, north, corridor = box(0, 0, 4, 3), box(0, 4.4, 4, 8), box(-3, 3.2, 9, 4.2)
    walls = walls_from_faces(faces_of_rooms(south, north, corridor))
    upright = walls.take(np.abs(walls.direction[:, 1]) > 0.9)
    assert sorted(np.round(upright.take(upright.p[:, 0] > 3).length, 2)) == pytest.approx([1.0, 3.0, 3.6])


def test_a_corridor_wall_behind_several_rooms_stays_whole():
    walls = merge_collinear(walls_from_faces(faces_of_rooms(*FLAT)))
    level = walls.take((np.abs(walls.direction[:, 0]) > 0.99) & (np.abs(walls.p[:, 1] - 3.1) < 0.05))
    assert len(level) == 1
    assert level.length == pytest.approx([9.0])
    assert level.thickness == pytest.approx([0.2])


def test_a_jog_changes_the_thickness():
    south = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 3.0), (2.0, 2.8), (0.0, 2.8)]
    walls = merge_collinear(walls_from_faces(faces_of_rooms(south, box(0, 3.2, 4, 6))))
    level = walls.take(walls.measured)
    assert sorted(np.round(level.thickness, 3)) == pytest.approx([0.2, 0.4])


def test_a_face_without_side_pairs_with_the_face_across():
    faces = faces_of_rooms(*TWO_ROOMS)
    at = int(np.flatnonzero((faces.p == [4, 0]).all(axis=1))[0])
    p, q, sided = faces.p.copy(), faces.q.copy(), faces.sided.copy()
    p[at], q[at], sided[at] = faces.q[at], faces.p[at], False
    walls = walls_from_faces(replace(faces, p=p, q=q, sided=sided))
    assert walls.take(walls.measured).thickness == pytest.approx([0.12])


def test_evidence_is_the_sum_over_both_faces():
    walls = walls_from_faces(faces_of_rooms(*TWO_ROOMS))
    measured = walls.take(walls.measured)
    assert measured.support.tolist() == [2000]
    assert measured.coverage == pytest.approx([0.9])
    assert measured.rmse == pytest.approx([0.01])
    assert measured.top == pytest.approx([2.5])


@pytest.mark.parametrize("degrees", [0.0, 33.0, 45.0, 90.0, 217.0])
def test_turning_the_plan_turns_the_walls(degrees):
    plain = merge_collinear(walls_from_faces(faces_of_rooms(*FLAT)))
    turn = merge_collinear(walls_from_faces(turned(faces_of_rooms(*FLAT), degrees, (500.0, -300.0))))
    assert len(turn) == len(plain)
    assert np.sort(turn.thickness) == pytest.approx(np.sort(plain.thickness), abs=1e-9)
    assert np.sort(turn.length) == pytest.approx(np.sort(plain.length), abs=1e-6)


def test_the_order_of_faces_does_not_matter():
    faces = faces_of_rooms(*FLAT)
    shuffled = faces.take(np.random.default_rng(1).permutation(len(faces)))
    a, b = walls_from_faces(faces), walls_from_faces(shuffled)
    for name in a.__slots__:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def test_no_faces_no_walls():
    assert len(walls_from_faces(Segments.from_ends(np.zeros((0, 2)), np.zeros((0, 2))))) == 0


@pytest.mark.parametrize("seed", range(5))
def test_no_chain_across_a_wall_is_overlooked(seed):
    rng = np.random.default_rng(seed)
    rooms = [box(x + rng.uniform(0, 0.4), y + rng.uniform(0, 0.4), x + 3.6, y + 2.6) for x in range(0, 16, 4) for y in range(0, 12, 3)]
    chains = chain_faces(turned(faces_of_rooms(*rooms), rng.uniform(0, 90)), bridged_gap=1.0, offset_tolerance=0.05)
    limits = {"min_thickness": 0.05, "max_thickness": 0.6}
    near = walls_module._across_a_wall(chains, **limits)
    found = 0
    for i, candidates in enumerate(near):
        every = walls_module._opposite(chains, i, np.flatnonzero(chains.direction @ chains.direction[i] < -0.9), **limits)
        assert walls_module._opposite(chains, i, candidates, **limits) == every
        found += len(every)
    assert found > 10
    assert sum(map(len, near)) < 0.3 * len(chains) ** 2
