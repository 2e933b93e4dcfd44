from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plans import faces_of_rooms, turned

from indoor_bim.plan.back_to_back import turn_back_to_back
from indoor_bim.plan.curtains import draw_curtains
from indoor_bim.plan.raster import count_raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.selection import wall_like


def faces_of(*ends: tuple[float, float, float, float], sided: bool = True) -> Segments:
    table = np.array(ends, dtype=float)
    return replace(Segments.from_ends(table[:, :2], table[:, 2:]), sided=np.full(len(table), sided), support=np.full(len(table), 10))


WALL_WITH_CURTAIN = [(0, 0, 2, 0), (2.05, 0.08, 4.95, 0.08), (5, 0, 8, 0)]


@pytest.mark.parametrize("degrees", [0.0, 30.0])
def test_the_wall_behind_a_curtain_runs_on(degrees):
    faces = draw_curtains(turned(faces_of(*WALL_WITH_CURTAIN), degrees))
    straight = turned(faces, -degrees)
    assert straight.p[:, 1] == pytest.approx([0, 0, 0], abs=1e-9)
    assert sorted(straight.length) == pytest.approx([2, 3, 3])
    assert sorted(straight.support) == [0, 10, 10]


def test_a_curtain_seen_from_both_sides_is_one_too():
    faces = faces_of(*WALL_WITH_CURTAIN)
    backwards = replace(faces, p=faces.p.copy(), q=faces.q.copy(), sided=np.array([True, False, True]))
    backwards.p[1], backwards.q[1] = faces.q[1], faces.p[1]
    out = draw_curtains(backwards)
    assert out.p[:, 1] == pytest.approx([0, 0, 0])
    assert out.sided.all()


@pytest.mark.parametrize(
    "faces",
    [
        faces_of((0, 0, 2, 0), (2, 0.3, 5, 0.3), (5, 0, 8, 0)),  # a cupboard or a pier, too deep for a curtain
        faces_of((0, 0, 2, 0), (2, 0.08, 5, 0.08)),  # a step in the wall
        faces_of((0, 0, 2, 0), (2, -0.08, 5, -0.08), (5, 0, 8, 0)),  # a niche
        faces_of((0, 0, 2, 0), (2, 0.08, 5, 0.08), (5, 0.05, 8, 0.05)),  # walls that are not in line
    ],
)
def test_what_is_no_curtain_stays(faces):
    out = draw_curtains(faces)
    np.testing.assert_array_equal(out.p, faces.p)
    np.testing.assert_array_equal(out.support, faces.support)


def seen_raster(*boxes: tuple[float, float, float, float]):
    rng = np.random.default_rng(0)
    return count_raster(np.concatenate([rng.uniform(b[:2], b[2:], (20_000, 2)) for b in boxes]), cell=0.02)


@pytest.mark.parametrize("thickness", [0.08, 0.12, 0.30])
def test_two_faces_with_nothing_seen_between_look_away_from_each_other(thickness):
    faces = faces_of((0, 0, 4, 0), (0, thickness, 4, thickness), sided=False)
    out = turn_back_to_back(faces, seen_raster((0, -2, 4, 0), (0, thickness, 4, 2)))
    assert out.sided.all()
    assert out.normal[:, 1].tolist() == pytest.approx([-1, 1])


def test_two_faces_with_a_floor_between_stay_as_they_are():
    faces = faces_of((0, 0, 4, 0), (0, 0.5, 4, 0.5), sided=False)
    assert not turn_back_to_back(faces, seen_raster((0, -2, 4, 2))).sided.any()


def test_furniture_is_short_and_clutter_is_sparse():
    faces = faces_of((0, 0, 4, 0), (0, 3, 4, 3), (1, 1, 2, 1), (2, 2, 3, 2), (0, 0, 0.1, 0))
    faces = replace(faces, coverage=np.array([0.9, 0.7, 0.9, 0.2, 0.9]), top=np.array([2.5, 2.4, 1.2, 2.5, 2.5]))
    assert wall_like(faces, storey_height=2.5).tolist() == [True, True, False, False, False]


def test_a_sparse_scan_is_judged_by_its_own_walls():
    faces = faces_of((0, 0, 4, 0), (0, 3, 4, 3), (2, 2, 3, 2))
    faces = replace(faces, coverage=np.array([0.3, 0.25, 0.1]), top=np.full(3, np.nan))
    assert wall_like(faces, storey_height=2.5).tolist() == [True, True, False]


def test_nothing_tall_no_walls():
    faces = replace(faces_of_rooms([(0, 0), (1, 0), (1, 1)]), top=np.full(3, 0.4))
    assert not wall_like(faces, storey_height=2.5).any()
