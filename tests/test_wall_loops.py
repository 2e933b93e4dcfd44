"""Compiled loops over the rays and points of walls, against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan import relief_loops, wall_loops


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def float32s(rng, low, high, count=4000):
    return rng.uniform(low, high, count).astype(np.float32)


def test_hits_on_a_face(rng):
    sides = rng.choice([-1, 1], 4000).astype(np.int8)
    depth, slant = float32s(rng, -0.3, 0.3), float32s(rng, 0, 1)
    rows = np.zeros(4000, dtype=np.int64)
    found = relief_loops.hits_on_face(sides, depth, slant, -1, 0.1, 0.2, rows)
    expected = np.flatnonzero((sides == -1) & (np.abs(depth) < 0.1) & (slant > 0.2))
    np.testing.assert_array_equal(rows[:found], expected)


@pytest.mark.parametrize("width", [0.0, 0.5, 3.0, 100.0])
def test_the_densest_interval(rng, width):
    ordered = np.sort(np.round(rng.normal(0, 3, 500), 1))
    counts = ((ordered >= ordered[:, None]) & (ordered <= ordered[:, None] + width)).sum(axis=1)
    counts -= np.array([int((ordered[:i] == ordered[i]).sum()) for i in range(500)])
    assert relief_loops.densest(ordered, width) == (int(np.argmax(counts)), int(counts.max()))


def test_no_values_have_no_densest_interval():
    assert relief_loops.densest(np.zeros(0), 1.0) == (0, 0)


def test_sums_of_pairs(rng):
    period, place = rng.integers(0, 6, 3000), rng.integers(0, 40, 3000)
    steps = rng.integers(-50, 50, 3000).astype(np.float64)
    out = [np.zeros(3000, dtype=np.int64) for _ in range(3)]
    total = np.zeros(3000)
    pairs = relief_loops.pair_sums(period, 6, place, 40, steps, *out, total)
    names, number = np.unique(period * 40 + place, return_inverse=True)
    np.testing.assert_array_equal(out[0][:pairs] * 40 + out[1][:pairs], names)
    np.testing.assert_array_equal(out[2][:pairs], np.bincount(number))
    np.testing.assert_array_equal(total[:pairs], np.bincount(number, weights=steps))


def test_alternate_means(rng):
    period, place = (index.ravel() for index in np.meshgrid(np.arange(5), np.arange(30), indexing="ij"))
    count, total = rng.integers(1, 9, 150), rng.normal(0, 1, 150)
    sums = [np.bincount(key, weights=count, minlength=n) for key, n in ((period, 5), (place, 31))]
    offset, face = np.zeros(5), np.zeros(31)
    relief_loops.alternate_means(total, count, period, place, *sums, 3, offset, face)
    expected, faces = np.zeros(5), np.zeros(31)
    for _ in range(3):
        expected = np.bincount(period, weights=total - count * faces[place]) / sums[0]
        faces = np.bincount(place, weights=total - count * expected[period], minlength=31) / np.maximum(sums[1], 1)
    np.testing.assert_allclose(offset, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(face, faces, rtol=0, atol=1e-12)


@pytest.mark.parametrize("names", [[4], [2, 3, 7, 11]])
def test_offsets_are_taken_off(rng, names):
    sides, period = rng.choice([-1, 1], 4000).astype(np.int8), rng.integers(0, 15, 4000)
    known, offset, depth = np.array(names), rng.normal(0, 1, len(names)), rng.normal(0, 1, 4000)
    expected = depth - np.where(sides == 1, np.interp(period, known, offset), 0.0)
    relief_loops.take_off(sides, 1, period, known, offset, depth)
    np.testing.assert_allclose(depth, expected, rtol=0, atol=1e-12)


def counted(along, up, rows, *, cell, shape):
    """Numbers of points in cells."""
    edges = [np.arange(n + 1) * cell for n in shape]
    return np.histogram2d(up[rows], along[rows], edges)[0]


def test_rays_are_counted_in_cells(rng):
    sides = rng.choice([-1, 1], 4000).astype(np.int8)
    depth, slant = float32s(rng, -0.3, 0.5), float32s(rng, 0, 1)
    along, up, along_end, up_end = (float32s(rng, -0.5, 3.5) for _ in range(4))
    shape, cell = (10, 12), 0.25
    images = [np.zeros((2, *shape), dtype=np.int64) for _ in range(3)]
    wall_loops.count_rays(sides, depth, slant, along, up, along_end, up_end, 0.05, 0.2, 0.3, cell, *images)
    for k, side in enumerate((1, -1)):
        mine, into = sides == side, (depth > 0.05) & (slant > 0.3)
        np.testing.assert_array_equal(images[0][k], counted(along_end, up_end, mine & (np.abs(depth) <= 0.05), cell=cell, shape=shape))
        np.testing.assert_array_equal(images[1][k], counted(along, up, mine & into, cell=cell, shape=shape))
        np.testing.assert_array_equal(images[2][k], counted(along, up, mine & into & (depth > 0.2), cell=cell, shape=shape))


def test_points_ahead_are_counted_in_cells(rng):
    along, across, up = rng.uniform(-0.5, 3.5, (3, 4000))
    front = np.zeros((10, 12), dtype=np.int64)
    wall_loops.count_ahead(along, across, up, 0.4, 0.25, front)
    np.testing.assert_array_equal(front, counted(along, up, np.abs(across) > 0.4, cell=0.25, shape=(10, 12)))
