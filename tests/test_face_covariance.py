"""How surely the line of a face is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_accuracy import face_accuracy
from indoor_bim.plan.face_support import COLUMN, STRETCH, measure, measure_by_sorting
from indoor_bim.plan.polar_fit import fit_lines
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.walls import Walls

SIGMA = 0.012


def scanned(p, q, *, noise=SIGMA, points=40, seed=0):
    """Evenly scanned wall, seen from its left."""
    rng = np.random.default_rng(seed)
    p, q = np.asarray(p, float), np.asarray(q, float)
    length = np.hypot(*(q - p))
    d = (q - p) / length
    normal = np.array([-d[1], d[0]])
    count = round(length / COLUMN)
    along = np.repeat((np.arange(count) + 0.5) * COLUMN, points)
    xy = p + along[:, None] * d + rng.normal(0, noise, len(along))[:, None] * normal
    rise = np.tile((np.arange(points) + 0.5) / points, count)
    return WallPoints(xy, rise, 2.5 * (1 - rise), xy + 2 * normal)


BOTH = pytest.mark.parametrize("how", [measure, measure_by_sorting])


@pytest.mark.parametrize(("p", "q"), [((0, 0), (6, 0)), ((12, 5), (9, 9)), ((-7, 3), (-7, -5))])
@BOTH
def test_the_covariance_is_that_of_a_least_squares_line_through_the_stretches(p, q, how):
    points = scanned(p, q, points=400)
    face = how(Segments.from_ends(np.array([p], float), np.array([q], float)), points)
    length = float(face.length[0])
    stretches = (np.arange(round(length / STRETCH)) + 0.5)[:, None] * STRETCH * face.direction + face.p
    alike = np.tile(np.eye(2) * SIGMA**2, (len(stretches), 1, 1))
    exact = fit_lines(stretches, np.zeros(len(stretches), dtype=np.int64), alike)
    if exact.normal[0] @ face.normal[0] < 0:
        exact = exact.facing(stretches[:1] + face.normal)
    np.testing.assert_allclose(face.covariance[0], exact.covariance[0], rtol=0.08)


@BOTH
def test_what_stands_before_a_wall_is_none_of_its_noise(how):
    wall = scanned((0, 0), (6, 0), noise=0.002, points=200)
    leaf = wall.take((wall.xy[:, 0] < 1.0) & (wall.rise < 0.75))
    before = WallPoints(leaf.xy + np.array([0, 0.04]), leaf.rise, leaf.depth, leaf.sensor)
    both = WallPoints(*(np.concatenate([getattr(part, name) for part in (wall, before)]) for name in ("xy", "rise", "depth", "sensor")))
    face = how(Segments.from_ends(np.array([[0.0, 0.0]]), np.array([[6.0, 0.0]])), both)
    assert face.rmse[0] > 0.01
    assert face.deviation[0] < 0.002
    assert np.sqrt(face.covariance[0, 0, 0] / 12) * 6 * np.sqrt(24) == pytest.approx(0.002, rel=0.1)


@pytest.mark.parametrize("bow", [0.0, 0.01, 0.03])
@BOTH
def test_the_deviation_of_a_bowed_wall_is_its_bow(bow, how):
    wall = scanned((0, 0), (6, 0), noise=0.002, points=200)
    bowed = WallPoints(
        wall.xy + np.column_stack([0 * wall.rise, bow * (1 - (wall.xy[:, 0] / 3 - 1) ** 2)]), wall.rise, wall.depth, wall.sensor
    )
    face = how(Segments.from_ends(np.array([[0.0, 0.0]]), np.array([[6.0, 0.0]])), bowed)
    assert face.deviation[0] == pytest.approx(bow, abs=0.0015)


def walls_of(p, q, thickness, *, measured=True, seen_left=True):
    one = np.zeros(1)
    return Walls(np.array([p], float), np.array([q], float), one + thickness, one < measured, one < seen_left, one, one, one, one)


def sure(p, q, *, offset, turn, deviation=0.0):
    """Face with standard deviations of its offset and direction."""
    face = Segments.from_ends(np.array([p], float), np.array([q], float))
    lever = -float(((face.p + face.q) / 2 * face.direction).sum())
    covariance = np.array([[[turn**2, turn**2 * lever], [turn**2 * lever, offset**2 + (turn * lever) ** 2]]])
    return replace(face, covariance=covariance, deviation=np.array([deviation]), sided=np.array([True]))


def together(*faces):
    return Segments(**{name: np.concatenate([getattr(face, name) for face in faces]) for name in Segments.__slots__})


def test_the_less_certain_face_of_a_wall_counts():
    left = sure((0, 0.1), (4, 0.1), offset=0.001, turn=0.002, deviation=0.004)
    right = sure((4, -0.1), (0, -0.1), offset=0.003, turn=0.001, deviation=0.002)
    aside = sure((0, 0.9), (4, 0.9), offset=0.1, turn=0.1, deviation=0.1)
    found = face_accuracy(walls_of((0, 0), (4, 0), 0.2), together(left, right, aside))
    assert [found.position[0], found.direction[0], found.deviation[0]] == pytest.approx([0.003, 0.002, 0.004])
    one = face_accuracy(walls_of((0, 0), (4, 0), 0.2, measured=False), together(left, right, aside))
    assert [one.position[0], one.direction[0], one.deviation[0]] == pytest.approx([0.001, 0.002, 0.004])


def test_pieces_of_a_face_know_its_direction_by_their_distance():
    pieces = [sure((x, 0.1), (x + 1, 0.1), offset=0.002, turn=0.01) for x in (0.0, 9.0)]
    found = face_accuracy(walls_of((0, 0), (10, 0), 0.2, measured=False), together(*pieces))
    assert found.position[0] == pytest.approx(0.002 / np.sqrt(2))
    assert found.direction[0] == pytest.approx((2 / 0.01**2 + 2 * 4.5**2 / 0.002**2) ** -0.5)


def test_what_moved_a_face_from_its_points_adds_to_its_deviation():
    face = sure((0, 0.113), (4, 0.113), offset=0.001, turn=0.002, deviation=0.004)
    found = face_accuracy(walls_of((0, 0), (4, 0), 0.2, measured=False), face)
    assert found.deviation[0] == pytest.approx(0.017)


def test_a_wall_whose_faces_have_no_covariance_has_no_accuracy():
    found = face_accuracy(walls_of((0, 0), (4, 0), 0.2), Segments.from_ends(np.array([[0.0, 0.1]]), np.array([[4.0, 0.1]])))
    assert np.isnan([found.position, found.direction, found.deviation]).all()


def test_a_face_that_nobody_saw_has_no_covariance():
    points = scanned((0, 0), (6, 0))
    face = measure(Segments.from_ends(np.array([[0.0, 9.0]]), np.array([[6.0, 9.0]])), points)
    assert np.isnan(face.covariance).all()
