"""Lines that continue one another become one, exactly and in any order."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from face_lines import lines_between

from indoor_bim.plan import line_merging
from indoor_bim.plan.line_merging import merge_lines


def ends(lines):
    """Ends of lines, sorted."""
    return sorted(np.round(np.hstack(lines.ends()), 9).tolist())


def test_pieces_of_one_line_become_one():
    lines = lines_between(((0, 0), (4, 0)), ((6, 0), (9, 0)), ((12, 0), (13, 0)))
    np.testing.assert_allclose(ends(merge_lines(lines)), [[0, 0, 13, 0]], atol=1e-9)


@pytest.mark.parametrize("angle", [0.4, np.pi / 2, np.pi, -2.2])
def test_merging_turns_with_the_lines(angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    lines = lines_between((turn @ [0, 0.01], turn @ [4, 0.01]), (turn @ [6, 0.03], turn @ [8, 0.03]))
    straight = merge_lines(lines_between(((0, 0.01), (4, 0.01)), ((6, 0.03), (8, 0.03))))
    (merged,) = ends(merge_lines(lines))
    expected = np.hstack([end @ turn.T for end in straight.ends()])[0]
    np.testing.assert_allclose(merged, expected, atol=1e-8)


@pytest.mark.parametrize(
    "second",
    [
        ((8.1, 0), (9, 0)),  # too far on
        ((5, 0.05), (9, 0.05)),  # too far across
        ((9, 0), (5, 0)),  # seen from the other side
        ((4.2, 0), (8.2, 0.15)),  # turned too far for their lengths
        ((6, -2), (6, 2)),  # across
    ],
)
def test_other_lines_stay(second):
    lines = lines_between(((0, 0), (4, 0)), second)
    assert ends(merge_lines(lines)) == ends(lines)


def test_common_line_is_the_least_squares_line_of_the_pieces():
    pieces = [((0, 0.00), (4, 0.01)), ((4, 0.02), (6, 0.03)), ((7, 0.01), (10, 0.01))]
    share = (np.arange(20_000) + 0.5) / 20_000
    x = np.concatenate([a[0] + share * (b[0] - a[0]) for a, b in pieces])
    y = np.concatenate([a[1] + share * (b[1] - a[1]) for a, b in pieces])
    weight = np.repeat([b[0] - a[0] for a, b in pieces], 20_000)
    slope, level = np.polyfit(x, y, 1, w=np.sqrt(weight))
    merged = merge_lines(lines_between(*pieces))
    assert len(merged) == 1
    np.testing.assert_allclose(np.tan(merged.angle[0]), slope, rtol=1e-3)
    np.testing.assert_allclose(merged.offset[0] / np.cos(merged.angle[0]), level, atol=1e-6)


def test_spread_is_weighted_by_length_and_the_longest_piece_gives_the_sweep():
    first, second = lines_between(((0, 0), (6, 0)), spread=0.01, family=1), lines_between(((7, 0), (9, 0)), spread=0.03, family=2)
    both = type(first)(*(np.concatenate([getattr(second, name), getattr(first, name)]) for name in first.__slots__))
    merged = merge_lines(both)
    assert merged.spread.tolist() == pytest.approx([0.015])
    assert merged.family.tolist() == [1]


def test_order_of_lines_changes_nothing():
    random = np.random.default_rng(0)
    parts = [((x, y), (x + 1.5, y)) for x, y in zip(np.arange(12) * 2.0, random.uniform(-0.02, 0.02, 12), strict=True)]
    parts += [((3, y), (9, y + 0.01)) for y in (1.0, 1.02, 1.2)]
    lines = lines_between(*parts)
    first = merge_lines(lines)
    assert 1 < len(first) < len(lines)
    for _ in range(5):
        assert ends(merge_lines(lines.take(random.permutation(len(lines))))) == ends(first)


@pytest.mark.parametrize("seed", range(6))
def test_pairs_are_merged_in_the_order_of_a_plain_search(seed):
    random = np.random.default_rng(seed)
    tails = np.column_stack([random.uniform(0, 20, 60), random.integers(0, 4, 60) * 0.2 + random.normal(0, 0.012, 60)])
    heads = tails + np.column_stack([random.choice([0.4, 1, 3, -2], 60), random.normal(0, 0.01, 60)])
    lines = lines_between(*zip(tails, heads, strict=True))
    lines = lines.take(np.lexsort((lines.start, lines.offset, -np.round(lines.end - lines.start, 6))))
    rows = np.column_stack([lines.angle, lines.offset, lines.start, lines.end]).tolist()
    groups, limits = [[k] for k in range(len(rows))], {"gap": 4.0, "apart": 0.035, "turn": np.radians(1.5)}
    while True:
        pairs = itertools.combinations(range(len(rows)), 2)
        pair = next((pair for pair in pairs if continues(*(rows[k] for k in pair), **limits)), None)
        if pair is None:
            break
        groups[pair[0]] += groups.pop(pair[1])
        rows.pop(pair[1])
        rows[pair[0]] = line_merging.common_line(lines, groups[pair[0]])
    merged = merge_lines(lines)
    assert 4 < len(merged) < 40
    assert np.column_stack([merged.angle, merged.offset, merged.start, merged.end]).tolist() == [list(row) for row in rows]


def continues(first, second, *, gap, apart, turn):
    """Whether the shorter of two lines (angle, offset, start, end) continues the longer one, by the ends of the one seen from the other."""
    if second[3] - second[2] > first[3] - first[2]:
        first, second = second, first
    angle, offset, start, end = second
    difference = angle - first[0]
    if abs(np.mod(difference + np.pi, 2 * np.pi) - np.pi) > max(turn, min(apart / (end - start), np.radians(8.0))):
        return False
    turned = np.array([[np.cos(difference), -np.sin(difference)], [np.sin(difference), np.cos(difference)]])
    p, q = turned @ [start, offset], turned @ [end, offset]
    near = abs(p[1] - first[1]) <= apart and abs(q[1] - first[1]) <= apart
    return near and max(p[0], first[2]) - min(q[0], first[3]) <= gap


def test_no_lines_stay_none():
    assert len(merge_lines(lines_between(((0, 0), (1, 0))).take(np.zeros(0, dtype=np.int64)))) == 0
