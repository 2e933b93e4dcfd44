"""Lines of faces run on to the next line, to the next piece of their face, or end with a cut behind them."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from face_lines import lines_between

from indoor_bim.plan.line_ends import end_cuts, gap_cuts, prolong


def turned(ends, angle):
    """Ends turned about the origin."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return [(tuple(turn @ a), tuple(turn @ b)) for a, b in ends]


ANGLES = pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, 2.5, -2.0])


@ANGLES
def test_line_runs_on_to_the_next_line_and_no_farther(angle):
    lines = lines_between(*turned([((0, 0), (4, 0)), ((7, -1), (7, 1)), ((9, -1), (9, 1))], angle))
    start, end = prolong(lines)
    assert end[0] - lines.end[0] == pytest.approx(3.01)
    assert lines.start[0] - start[0] == pytest.approx(1.5)


def test_line_beyond_the_longest_prolongation_is_not_met():
    start, end = prolong(lines_between(((0, 0), (4, 0)), ((12.5, -1), (12.5, 1))))
    assert (start[0], end[0]) == pytest.approx((-1.5, 5.5))


@ANGLES
@pytest.mark.parametrize("step", [0.04, -0.04, 0.0])
def test_pieces_of_one_face_are_joined_halfway(angle, step):
    lines = lines_between(*turned([((0, 0), (4, 0)), ((10, step), (15, step))], angle))
    joined, p, q = gap_cuts(lines)
    assert len(p) == 1
    assert joined.end[0] - lines.end[0] == pytest.approx(3.01)
    assert lines.start[1] - joined.start[1] == pytest.approx(3.01)
    pieces = shapely.linestrings(np.stack(joined.ends(), axis=1))
    cut = shapely.LineString([p[0], q[0]])
    assert all(cut.crosses(piece) for piece in pieces)
    assert cut.length == pytest.approx(abs(step) + 0.02)


@pytest.mark.parametrize(
    "second",
    [
        ((13, 0.04), (15, 0.04)),  # too far on
        ((5, 0.09), (9, 0.09)),  # too far across
        ((9, 0.04), (5, 0.04)),  # seen from the other side
        ((5, 0.04), (9, 0.34)),  # turned too far
        ((1, 0.04), (9, 0.04)),  # runs along the first
        ((3.6, 0.04), (3.9, 0.04)),  # does not lead on
    ],
)
def test_other_lines_are_not_joined(second):
    lines = lines_between(((0, 0), (4, 0)), second)
    joined, p, _ = gap_cuts(lines)
    assert len(p) == 0
    np.testing.assert_array_equal(joined.end, lines.end)
    np.testing.assert_array_equal(joined.start, lines.start)


def test_a_piece_is_joined_to_the_nearest_of_those_that_lead_on():
    _, p, q = gap_cuts(lines_between(((0, 0), (4, 0)), ((9, 0.02), (11, 0.02)), ((5, 0.03), (7, 0.03))))
    np.testing.assert_allclose(np.sort((p + q)[:, 0] / 2), [4.5, 8.0])


def test_cuts_do_not_depend_on_the_order_of_lines():
    lines = lines_between(((0, 0), (4, 0)), ((9, 0.02), (11, 0.02)), ((5, 0.03), (7, 0.03)), ((6, 4), (6, 9)), ((6.05, 12), (6.05, 13)))
    _, p, q = gap_cuts(lines)
    _, again_p, again_q = gap_cuts(lines.take(np.array([3, 2, 4, 0, 1])))
    assert sorted(map(tuple, np.hstack([p, q]))) == sorted(map(tuple, np.hstack([again_p, again_q])))


def test_face_that_ends_free_is_cut_behind_both_ends():
    p, q = end_cuts(lines_between(((0, 0), (4, 0))))
    np.testing.assert_allclose(sorted(map(tuple, np.hstack([p, q]))), [(0, 0.02, 0, -1), (4, 0.02, 4, -1)], atol=1e-12)


@pytest.mark.parametrize("other", [((4.1, -2), (4.1, 2)), ((5, -0.2), (3, -0.2))])
def test_no_cut_where_a_line_runs_on_from_the_end_or_along_the_back(other):
    lines = lines_between(((0, 0), (4, 0)), other)
    p, _ = end_cuts(lines)
    assert not any(np.allclose(spot, [4, 0.02]) for spot in p)
