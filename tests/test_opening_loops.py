"""Compiled loops over the rays at openings, against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_bim.plan import door_leaves, opening_loops, wall_loops
from indoor_bim.plan.edge_fits import fewest_wrong
from indoor_bim.plan.opening_edges import BEYOND


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def float32s(rng, low, high, count=3000):
    return rng.uniform(low, high, count).astype(np.float32)


def test_kinds_of_rays(rng):
    depth, slant, along, up = float32s(rng, -0.2, 0.6), float32s(rng, 0, 1), float32s(rng, -1, 5), float32s(rng, -1, 3)
    kinds = np.zeros(3000, dtype=np.uint8)
    opening_loops.kinds_of_rays(depth, slant, along, up, 0.05, 0.2, 0.3, 0.0, 4.0, 0.1, 2.5, kinds)
    face = (np.abs(depth) <= 0.05) & (along > 0) & (along < 4) & (up > 0.1) & (up < 2.5)
    went_in = (depth > 0.05) & (slant > 0.2)
    np.testing.assert_array_equal(kinds & opening_loops.FACE != 0, face)
    np.testing.assert_array_equal(kinds & opening_loops.WENT_IN != 0, went_in)
    np.testing.assert_array_equal(kinds & opening_loops.THROUGH != 0, went_in & (depth > 0.3))


def test_rays_into_a_rectangle(rng):
    along, up, depth = float32s(rng, 0, 4), float32s(rng, 0, 3), float32s(rng, -0.2, 0.6)
    rows = np.zeros(3000, dtype=np.int64)
    found = opening_loops.rays_into(along, up, depth, 0.1, 1.0, 2.0, 0.5, 2.0, rows)
    inside = (depth > 0.1) & (along > 1) & (along < 2) & (up > 0.5) & (up < 2)
    np.testing.assert_array_equal(rows[:found], np.flatnonzero(inside))


def test_counts_and_rows_by_side(rng):
    along, up = rng.uniform(0, 4, (2, 3000))
    side = rng.choice([-1.0, 1.0], 3000)
    inside = (along > 1) & (along < 2) & (up > 0.5) & (up < 2)
    assert opening_loops.count_within(along, up, side, 1.0, 2.0, 0.5, 2.0) == ((inside & (side > 0)).sum(), (inside & (side < 0)).sum())
    rows = np.zeros(3000, dtype=np.int64)
    lefts, rights = opening_loops.rows_at_edge(along, up, side, 1.0, 2.0, 1.5, 0.25, rows)
    near = (along > 1) & (along < 2) & (np.abs(up - 1.5) < 0.25)
    np.testing.assert_array_equal(rows[:lefts], np.flatnonzero(near & (side == 1)))
    np.testing.assert_array_equal(rows[3000 - rights :][::-1], np.flatnonzero(near & (side == -1)))


def best_gap_by_numpy(inside, outside):
    low, high = np.sort(inside), np.sort(outside)
    cuts = np.unique(np.concatenate([low, high]))
    middles = (cuts[1:] + cuts[:-1]) / 2
    if not len(middles):
        return cuts[0], cuts[0]
    wrong = (len(low) - np.searchsorted(low, middles)) + np.searchsorted(high, middles)
    best = np.flatnonzero(wrong == wrong.min())
    runs = np.split(best, np.flatnonzero(np.diff(best) > 1) + 1)
    return max(((cuts[run[0]], cuts[run[-1] + 1]) for run in runs), key=lambda gap: gap[1] - gap[0])


values = st.lists(st.integers(-8, 8), min_size=1, max_size=12)


@settings(max_examples=300, deadline=None)
@given(values, values)
def test_the_widest_best_gap(inside, outside):
    low, high = np.array(inside, dtype=float), np.array(outside, dtype=float)
    assert fewest_wrong(low, high) == best_gap_by_numpy(low, high)


def test_what_lies_close_beyond_an_edge_is_counted_as_by_a_histogram(rng):
    distance = rng.uniform(-0.1, 0.2, 3000)
    across = np.concatenate([rng.uniform(0.3, 2.1, 2000), rng.integers(3, 22, 1000) / 10])
    across = across[(across > 0.3) & (across < 2.1)]
    distance = distance[: len(across)]
    bounds = np.linspace(0.3, 2.1, 19)
    counts = np.zeros(18, dtype=np.int64)
    opening_loops.count_close(distance, across, *BEYOND, bounds, counts)
    close = across[(distance > BEYOND[0]) & (distance < BEYOND[1])]
    np.testing.assert_array_equal(counts, np.histogram(close, 18, (0.3, 2.1))[0])


def best_fill_by_numpy(x, y, z, *, length):
    leaves = door_leaves
    reach = np.hypot(x, y) < length + leaves.SLACK
    x, y, z = x[reach], y[reach], z[reach]
    layers = round((leaves.HIGH - leaves.LOW) / leaves.PATCH)
    layer = np.minimum(((z - leaves.LOW) / leaves.PATCH).astype(np.int64), layers - 1)
    best = 0.0
    for pivot in (0.0, leaves.HINGE_SLACK / 2):
        for angle in leaves.ANGLES:
            c, s = np.cos(angle), np.sin(angle)
            out, off = (x - pivot) * c + y * s, y * c - (x - pivot) * s
            on = (np.abs(off) < leaves.THICKEST) & (out > 0)
            first = max(2 * leaves.THICKEST / s, leaves.NEAREST)
            patches = max(int((length - 0.1 - first) / leaves.PATCH), 1)
            column = np.floor((out[on] - first) / leaves.PATCH).astype(np.int64)
            near = (column >= 0) & (column < patches + 4)
            hit = np.bincount(column[near] * layers + layer[on][near], minlength=(patches + 4) * layers) > 0
            best = max(best, float(hit[: patches * layers].mean()) - float(hit[(patches + 2) * layers :].mean()))
    return best


@pytest.mark.parametrize("length", [0.55, 0.9, 1.2])
@pytest.mark.parametrize("angle", [45.0, 90.0, 133.0])
def test_the_best_filled_leaf(rng, length, angle):
    leaves = door_leaves
    along = rng.uniform(0, 0.9, 1500)
    turn = np.radians(angle)
    leaf = np.column_stack([along * np.cos(turn), along * np.sin(turn)]) + rng.normal(0, 0.01, (1500, 2))
    plan = np.vstack([leaf, rng.uniform([-1.5, 0], [1.5, 1.5], (300, 2))])
    x, y, z = *plan.T, rng.uniform(leaves.LOW, leaves.HIGH, len(plan))
    constants = (leaves.THICKEST, leaves.PATCH, leaves.NEAREST, leaves.LOW, leaves.HIGH)
    directions = (np.cos(leaves.ANGLES), np.sin(leaves.ANGLES))
    found = opening_loops.best_fill(x, y, z, length, leaves.SLACK, leaves.HINGE_SLACK / 2, *directions, *constants)
    assert found == pytest.approx(best_fill_by_numpy(x, y, z, length=length), abs=1e-12)
    assert found > 0.3


def test_rows_are_sorted_by_wall(rng):
    rows, names = np.arange(500, dtype=np.int32), rng.integers(0, 7, 500).astype(np.int16)
    first, grouped = np.zeros(8, dtype=np.int64), np.zeros(500, dtype=np.int32)
    wall_loops.sort_by_wall(rows, names, 1000, first, grouped)
    np.testing.assert_array_equal(grouped, np.argsort(names, kind="stable") + 1000)
    np.testing.assert_array_equal(first, np.searchsorted(np.sort(names), np.arange(8)))
