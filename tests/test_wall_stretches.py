"""Walls seen in parts, beams, furniture and passages, told by the columns of hits along a face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plans import turned

from indoor_bim.plan.segments import Segments
from indoor_bim.plan.selection import seen_in_parts, typical_coverage, wall_like, walls_in_line
from indoor_bim.plan.wall_stretches import columns_of, wall_share, wall_stretches

HEIGHT = 2.8
ONE = np.array([True])
NONE = np.array([False])


def surface(x: tuple[float, float], z: tuple[float, float], step: float = 0.05) -> np.ndarray:
    along, up = np.meshgrid(np.arange(x[0] + step / 2, x[1], step), np.arange(z[0] + step / 2, z[1], step))
    return np.column_stack([along.ravel(), np.zeros(along.size), up.ravel()])


def face(*ends: tuple[float, float, float, float], coverage: float = 0.2) -> Segments:
    table = np.array(ends, dtype=float)
    faces = Segments.from_ends(table[:, :2], table[:, 2:])
    n = len(faces)
    return replace(faces, sided=np.full(n, True), support=np.full(n, 1000), coverage=np.full(n, coverage), top=np.full(n, HEIGHT))


FLOOR = surface((-1.0, 7.0), (-0.05, 0.05))[:, :2]
WALL = surface((0, 6), (0, 2.6))
PARTS = np.vstack([surface((0.5, 1.1), (0.3, 2.6)), surface((1.5, 2.2), (0.6, 2.5)), surface((5, 5.3), (0.3, 2.6))])
BEAM = surface((0, 6), (2.3, 2.8))
CUPBOARD = surface((0, 6), (0, 2.1))


def kept(points: np.ndarray, *, known: bool, degrees: float = 0.0, floor: np.ndarray = FLOOR) -> list[tuple[float, float]]:
    """Stretches of a face from (0, 0) to (6, 0) that are wall, after turning everything."""
    a = np.radians(degrees)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    faces = turned(face((0, 0, 6, 0)), degrees)
    columns = columns_of(faces, np.column_stack([points[:, :2] @ turn, points[:, 2]]), floor @ turn, reach=0.05, height=HEIGHT)
    out = turned(wall_stretches(faces, columns, known=ONE & known, doubtful=ONE & (not known)), -degrees)
    assert np.abs(out.p[:, 1]).max(initial=0) < 1e-9
    return [(round(float(p), 2), round(float(q), 2)) for p, q in zip(out.p[:, 0], out.q[:, 0], strict=True)]


@pytest.mark.parametrize("degrees", [0.0, 90.0, 200.0])
def test_what_of_a_doubtful_face_is_wall(degrees):
    assert kept(WALL, known=False, degrees=degrees) == [(0.0, 6.0)]
    assert kept(PARTS, known=False, degrees=degrees) == [(0.5, 2.2)]  # the last bit is short and far away
    assert kept(BEAM, known=False, degrees=degrees) == []
    assert kept(CUPBOARD, known=False, degrees=degrees) == []


def test_lines_of_a_scanner_right_below_and_above_are_no_wall():
    assert kept(np.vstack([surface((0, 6), (0.5, 0.6)), surface((0, 6), (2.5, 2.6))]), known=False) == []


def test_a_known_wall_ends_where_one_walks_through_below_a_beam():
    corridor = np.vstack([BEAM, surface((2.4, 6), (0, 2.6))])
    assert kept(corridor, known=True) == [(2.4, 6.0)]
    assert kept(corridor, known=True, floor=np.zeros((0, 2))) == [(0.0, 6.0)]  # hidden, not open
    door = np.vstack([BEAM, surface((0, 2), (0, 2.6)), surface((3, 6), (0, 2.6))])
    assert kept(door, known=True) == [(0.0, 6.0)]
    pier = np.vstack([corridor, surface((0, 0.3), (0, 2.6))])
    assert kept(pier, known=True) == [(2.4, 6.0)]


def test_a_wall_of_which_nothing_is_known_stays():
    assert kept(BEAM, known=True) == [(0.0, 6.0)]


def test_parts_carry_their_share_of_the_points():
    columns = columns_of(face((0, 0, 6, 0)), np.vstack([BEAM, surface((3, 6), (0, 2.6))]), FLOOR, reach=0.05, height=HEIGHT)
    assert wall_share(columns) == pytest.approx([0.5])
    assert wall_stretches(face((0, 0, 6, 0)), columns, known=ONE, doubtful=NONE).support.tolist() == [500]


def test_faces_are_walls_furniture_or_seen_in_parts():
    faces = face((0, 0, 6, 0), (0, 3, 6, 3), (0, 5, 6, 5))
    faces = replace(faces, coverage=np.array([0.9, 0.2, 0.9]), top=np.array([2.8, 2.8, 1.2]))
    assert wall_like(faces, storey_height=HEIGHT).tolist() == [True, False, False]
    assert seen_in_parts(faces, storey_height=HEIGHT).tolist() == [False, True, False]
    assert typical_coverage(faces, storey_height=HEIGHT) == 0.9


@pytest.mark.parametrize(
    ("other", "goes_on"),
    [
        ((6.5, 0.0, 8.0, 0.0), True),  # a parapet behind a gap
        ((6.0, 0.02, 7.0, 0.02), True),
        ((6.5, 0.1, 8.0, 0.1), False),  # before the line
        ((8.0, 0.0, 6.5, 0.0), False),  # looks the other way
        ((7.5, 0.0, 9.0, 0.0), False),  # too far
        ((6.5, 0.0, 6.9, 0.0), False),  # too short
        ((6.5, 0.0, 6.5, 2.0), False),  # across
    ],
)
def test_what_goes_on_in_line_with_a_wall_is_wall(other, goes_on):
    found = walls_in_line(face((0, 0, 6, 0)), face(other), typical_coverage=0.8, tolerance=0.03)
    assert len(found) == 1 + goes_on
    empty = walls_in_line(face((0, 0, 6, 0)), face(other, coverage=0.1), typical_coverage=0.8, tolerance=0.03)
    assert len(empty) == 1


def test_walls_go_on_through_each_other_in_any_order():
    chain = [(13.0, 0.0, 14.0, 0.0), (10.5, 0.0, 12.5, 0.0), (7.0, 0.0, 10.0, 0.0)]
    for others in (chain, chain[::-1]):
        assert len(walls_in_line(face((0, 0, 6, 0)), face(*others), typical_coverage=0.8, tolerance=0.03)) == 4
