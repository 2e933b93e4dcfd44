"""Curtains, leaves and doubles before a face are dropped; pilasters, jogs and walls that are askew stay."""

from __future__ import annotations

import numpy as np
import pytest
from face_lines import lines_between

from indoor_bim.plan.hangings import hangings

FACADE = ((0, 0), (12, 0))


def dropped(*ends, showing=()):
    """Which lines hang before others, with a face that shows along `showing` only."""
    lines = lines_between(*ends)

    def evidence(row, start, end):
        at = np.arange(start, end, 0.1)
        return np.any([(at > low) & (at < high) for low, high in showing], axis=0).astype(float) if showing else np.zeros(len(at))

    return hangings(lines, evidence).tolist()


def test_a_double_before_a_face_that_shows_is_dropped():
    assert dropped(FACADE, ((1, 0.08), (3, 0.08)), showing=[(0, 12)]) == [False, True]


def test_a_curtain_that_the_face_shows_beside_is_dropped():
    assert dropped(FACADE, ((4, 0.10), (6, 0.10)), showing=[(0, 4.4), (5.6, 12)]) == [False, True]


def test_a_line_askew_before_a_face_is_dropped():
    assert dropped(FACADE, ((4, 0.04), (6, 0.11))) == [False, True]


def test_a_line_askew_between_two_pieces_of_a_face_is_dropped():
    assert dropped(((0, 0), (8, 0)), ((7.6, 0.11), (9.4, 0.04)), ((9, -0.01), (10.4, -0.01))) == [False, True, False]
    assert dropped(((0, 0), (8, 0)), ((7.6, 0.11), (9.4, 0.04))) == [False, False]


@pytest.mark.parametrize(
    "line",
    [
        ((4, 0.10), (5, 0.10)),  # a pilaster hides its wall
        ((4, 0.02), (6, 0.02)),  # the face itself
        ((4, 0.20), (6, 0.27)),  # too far before it
        ((4, -0.04), (6, -0.11)),  # behind it
        ((6, 0.04), (4, 0.11)),  # seen from the other side
        ((4, 0.0), (10, 6 * np.tan(np.radians(2.0)))),  # a long wall, 2 degrees askew
        ((12, 0.0), (14, 2 * np.tan(np.radians(2.0)))),  # 2 degrees askew, and no face behind it
    ],
)
def test_other_lines_stay(line):
    assert dropped(FACADE, line) == [False, False]


def test_a_face_little_longer_than_the_line_askew_is_no_reason():
    assert dropped(((0, 0), (5, 0)), ((1, 0.03), (3.5, 0.14))) == [False, False]


def test_order_of_lines_does_not_matter():
    ends = [FACADE, ((1, 0.08), (3, 0.08)), ((4, 0.04), (6, 0.11)), ((7, 0.1), (8, 0.1))]
    found = dropped(*ends, showing=[(0, 4)])
    assert found == [False, True, True, False]
    assert dropped(*ends[::-1], showing=[(0, 4)]) == found[::-1]
