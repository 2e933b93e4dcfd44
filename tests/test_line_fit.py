"""Lines of faces lie where the points are, whatever their order, their density and what else is near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from face_lines import lines_between

from indoor_bim.plan import line_fit_loops as loops
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.line_fit import fit_to_points
from indoor_bim.plan.tiles import tiles_of

HEIGHT = 2.5


def wall(xy, *, sensor=None, seed=0):
    """Points at the given spots of the plan, at random heights."""
    rise = np.random.default_rng(seed).uniform(0, 1, len(xy))
    return WallPoints(np.asarray(xy, dtype=float), rise, HEIGHT * (1 - rise), sensor)


def along_x(count, *, length=5.0, seed=1):
    """Places along a wall."""
    return np.random.default_rng(seed).uniform(0, length, count)


def distances(lines, spots):
    """Distance of spots from the only line, to its left."""
    return np.asarray(spots) @ lines.normal[0] - lines.offset[0]


@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 2, 2.0, -2.6])
def test_line_is_placed_exactly(angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    x = along_x(20_000)
    points = wall(np.column_stack([x, 0.0037 + 0.002 * x]) @ turn.T)
    found = fit_to_points(lines_between((turn @ [0, 0], turn @ [5, 0.0])), points)
    np.testing.assert_allclose(distances(found, [turn @ [0, 0.0037], turn @ [5, 0.0137]]), 0, atol=2e-5)
    assert found.end[0] - found.start[0] == pytest.approx(5.0, abs=1e-4)


def test_order_of_points_changes_nothing():
    random = np.random.default_rng(2)
    x = along_x(20_000)
    xy = np.column_stack([x, random.normal(0.004, 0.008, len(x))])
    points = wall(xy, sensor=np.column_stack([x, np.full(len(x), 2.0)]))
    lines = lines_between(((0, 0), (5, 0)), ((5, 0.01), (0, 0.01)))
    first, second = fit_to_points(lines, points), fit_to_points(lines, points.take(random.permutation(len(x))))
    for name in ("angle", "offset", "start", "end"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_what_hangs_on_the_wall_does_not_move_it():
    x = along_x(20_000)
    y = np.random.default_rng(3).normal(0, 0.002, len(x))
    hung = (x > 1) & (x < 2.4)
    y[hung] += 0.03
    found = fit_to_points(lines_between(((0, 0.004), (5, 0.004))), wall(np.column_stack([x, y])))
    np.testing.assert_allclose(distances(found, [(0, 0), (5, 0)]), 0, atol=6e-4)


def test_parts_of_a_face_count_alike_however_densely_they_were_scanned():
    x = np.concatenate([along_x(40_000, length=2.5), 2.5 + along_x(4_000, length=2.5)])
    y = np.where(x < 2.5, 0.004, -0.004)
    found = fit_to_points(lines_between(((0, 0), (5, 0))), wall(np.column_stack([x, y])))
    assert distances(found, [(2.5, 0)])[0] == pytest.approx(0, abs=5e-4)


def test_only_what_was_seen_from_the_left_counts():
    x = along_x(20_000)
    y = np.where(np.arange(len(x)) % 2, 0.0, -0.02)
    sensor = np.column_stack([x, np.where(y < 0, -3.0, 3.0)])
    found = fit_to_points(lines_between(((0, -0.01), (5, -0.01))), wall(np.column_stack([x, y]), sensor=sensor))
    np.testing.assert_allclose(distances(found, [(0, 0), (5, 0)]), 0, atol=1e-5)


@pytest.mark.parametrize("spots", [np.zeros((0, 2)), np.array([[1.0, 0.01], [1.02, 0.01]]), np.array([[1.0, 2.0]])])
def test_lines_without_points_stay(spots):
    lines = lines_between(((0, 0), (5, 0)))
    found = fit_to_points(lines, wall(spots))
    assert (found.angle[0], found.offset[0], found.start[0], found.end[0]) == (0, 0, 0, 5)


def test_short_lines_keep_their_direction():
    x = along_x(4_000, length=0.5)
    found = fit_to_points(lines_between(((0, 0), (0.5, 0))), wall(np.column_stack([x, 0.006 + 0.01 * (x - 0.25)])))
    assert found.angle[0] == 0
    assert found.offset[0] == pytest.approx(0.006, abs=2e-4)


def twin(x, y, share, *, reach, finest, turn):
    """Robust line in numpy."""
    level = slope = 0.0
    width = reach
    for _ in range(loops.ROUNDS):
        residual = np.abs(y - level - slope * x)
        near = residual < width
        order = np.argsort(residual[near], kind="stable")
        total = np.cumsum(share[near][order])
        middle = residual[near][order][np.searchsorted(total, total[-1] / 2)]
        width = np.clip(loops.TUKEY * 1.4826 * middle, loops.TUKEY * finest, reach)
        weight = share * np.maximum(1 - (residual / width) ** 2, 0) ** 2
        mx, my = np.average(x, weights=weight), np.average(y, weights=weight)
        if turn:
            slope = (weight * (x - mx) * (y - my)).sum() / (weight * (x - mx) ** 2).sum()
        before, level = level, my - slope * mx
        if abs(level - before) < 1e-6:
            break
    return level, slope


@pytest.mark.parametrize("turn", [True, False])
@pytest.mark.parametrize("count", [7, 300, 5000])
def test_robust_line_is_that_of_its_twin(count, turn):
    random = np.random.default_rng(count)
    x, share = random.uniform(0, 6, count), random.uniform(0.1, 1, count)
    y = 0.005 + 0.002 * x + random.normal(0, 0.004, count)
    y[::5] = random.uniform(-0.05, 0.05, len(y[::5]))
    settings = {"reach": 0.05, "finest": 0.001, "turn": turn}
    assert loops.robust_line(x, y, share, *settings.values()) == pytest.approx((*twin(x, y, share, **settings), True), abs=1e-9)


@pytest.mark.parametrize("count", [1, 2, 999])
def test_weighted_median(count):
    random = np.random.default_rng(count)
    values, weights = np.round(random.uniform(0, 0.03, count), 3), random.uniform(0, 1, count)
    order = np.argsort(values)
    expected = values[order][np.searchsorted(np.cumsum(weights[order]), weights.sum() / 2)]
    padded = np.append(values, 0.04), np.append(weights, 9.0)
    assert loops.weighted_median(*padded, count, 0.05) == expected


def test_tiles_change_nothing():
    random = np.random.default_rng(8)
    x = along_x(20_000)
    points = wall(np.column_stack([x, random.normal(0.004, 0.008, len(x))]), sensor=np.column_stack([x, np.full(len(x), 2.0)]))
    tiles, order = tiles_of(points.xy)
    lines = lines_between(((0, 0), (5, 0)), ((4, 0.01), (1, 0.01)))
    first, second = fit_to_points(lines, points), fit_to_points(lines, replace(points.take(order), tiles=tiles))
    for name in ("angle", "offset", "start", "end"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
