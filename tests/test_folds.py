"""Curtains hang in folds before a wall, and maps that drift show a face twice: both are told on the points."""

from __future__ import annotations

import numpy as np
import pytest
from face_lines import lines_between

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.folds import folds_along, without_curtains
from indoor_bim.plan.map_drift import largest_double

FACADE = ((0, 0), (6, 0))
CURTAIN = ((6, 0.1), (10, 0.1))


def surface(start, end, depth, *, density=600.0, noise=0.012, seed=0):
    """Points on an upright surface along x, `depth` a number or a function of x."""
    rng = np.random.default_rng(seed)
    count = int(density * 2.4 * (end - start))
    x = rng.uniform(start, end, count)
    away = depth(x) if callable(depth) else np.full(count, depth)
    return np.column_stack([x, away + rng.normal(0, noise, count), rng.uniform(0.05, 0.95, count)])


def candidates(*surfaces):
    table = np.vstack(surfaces)
    return WallPoints(table[:, :2], table[:, 2], 2.5 * (1 - table[:, 2]), None)


def folds(x):
    return 0.1 + 0.035 * np.sin(2 * np.pi * x / 0.22)


def extents(lines):
    return sorted(
        (round(float(a), 2), round(float(b), 2), round(float(o), 2)) for a, b, o in zip(lines.start, lines.end, lines.offset, strict=True)
    )


def test_the_face_goes_on_behind_a_curtain_that_hides_it():
    lines = lines_between(FACADE, CURTAIN)
    points = candidates(surface(0, 6, 0.0), surface(6, 10, folds))
    assert extents(without_curtains(lines, points)) == [(0.0, 6.0, 0.0), (6.0, 10.0, 0.0)]


def test_a_part_of_a_line_that_is_a_curtain_is_cut_out():
    lines = lines_between(((0, 0), (12, 0)), ((2, 0.1), (10, 0.1)))
    points = candidates(surface(0, 2, 0.0), surface(10, 12, 0.0), surface(2, 4.5, folds), surface(4.5, 10, 0.1))
    whole, rest = sorted(extents(without_curtains(lines, points)), key=lambda row: row[2])
    assert whole == (0.0, 12.0, 0.0)
    assert 4.4 < rest[0] < 5.1
    assert rest[1] == 10.0


@pytest.mark.parametrize(
    "before",
    [
        0.1,  # a lining
        lambda x: np.where((x > 7) & (x < 7.5), 0.13, 0.1),  # with a pilaster
        lambda x: 0.1 + 0.03 * np.sin(2 * np.pi * x / 4.0),  # bowed
    ],
)
def test_a_wall_before_a_wall_stays(before):
    lines = lines_between(FACADE, CURTAIN)
    points = candidates(surface(0, 6, 0.0), surface(6, 10, before))
    assert extents(without_curtains(lines, points)) == extents(lines)


def test_folds_stay_where_no_face_is_near():
    points = candidates(surface(6, 10, folds))
    assert folds_along(lines_between(CURTAIN), 0, points).mean() > 0.9
    for other in (((0, -0.6), (6, -0.6)), ((6, 0), (0, 0)), ((0, 0.3), (6, 0.3))):  # too deep, looking away, before it
        lines = lines_between(other, CURTAIN)
        assert extents(without_curtains(lines, points)) == extents(lines)


def test_rough_points_are_no_folds():
    points = candidates(surface(0, 4, 0.0, noise=0.03, density=60.0))
    assert not folds_along(lines_between(((0, 0), (4, 0))), 0, points).any()


@pytest.mark.parametrize(
    ("first", "second", "found"),
    [
        ((0, 10), (4, 12), 0.05),  # one face at two times
        ((0, 10), (10, 14), 0.0),  # a step
        ((0, 5), (4, 12), 0.0),  # hardly any overlap
    ],
)
def test_two_images_of_one_face(first, second, found):
    lines = lines_between(((first[0], 0), (first[1], 0)), ((second[0], 0.05), (second[1], 0.05)))
    points = candidates(surface(*first, 0.0), surface(*second, 0.05, seed=1))
    assert largest_double(lines, points) == pytest.approx(found, abs=1e-9)


def test_a_lining_that_hides_the_wall_behind_is_no_double():
    lines = lines_between(((0, 0), (12, 0)), ((4, 0.05), (8, 0.05)))
    points = candidates(surface(0, 4, 0.0), surface(8, 12, 0.0), surface(4, 8, 0.05))
    assert largest_double(lines, points) == 0.0


def test_what_stands_low_before_a_wall_is_no_double():
    lines = lines_between(((0, 0), (12, 0)), ((4, 0.05), (8, 0.05)))
    rail = surface(4, 8, 0.05) * [1, 1, 0.4]
    assert largest_double(lines, candidates(surface(0, 12, 0.0), rail)) == 0.0


def test_a_few_points_before_a_wall_are_no_double():
    lines = lines_between(((0, 0), (12, 0)), ((4, 0.05), (8, 0.05)))
    strays = surface(4, 8, 0.05, density=90.0, seed=1)
    assert largest_double(lines, candidates(surface(0, 12, 0.0), strays)) == 0.0
