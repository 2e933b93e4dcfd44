"""Compiled loops over points equal what numpy makes of them, to the bit."""

import numpy as np
import pytest

from indoor_bim.cloud.extent import bounds
from indoor_bim.cloud.point_loops import localise, place_steps
from indoor_bim.cloud.read import FEW_POINTS, as_cloud
from indoor_bim.cloud.spacing import _in_blocks, blocks_by_hashing, sample_by_hashing, sample_mask


def test_samples_of_many_points_equal_their_twin():
    points = np.random.default_rng(11).normal(size=(3 * FEW_POINTS, 3))
    points[::7, 1], points[::9, 0] = -0.0, 0.0
    chosen = sample_mask(points, 5000)
    assert np.array_equal(chosen, sample_by_hashing(points, limit=np.uint64(2**64 * (5000 / len(points)))))
    points[points == 0] = 0.0
    assert np.array_equal(sample_mask(points, 5000), chosen)
    assert 4000 < chosen.sum() < 6000


def test_whole_steps_become_coordinates_whatever_stands_between_them():
    record = np.zeros(1000, dtype=np.dtype({"names": ["xyz"], "formats": [("<i4", 3)], "offsets": [0], "itemsize": 21}))
    record["xyz"] = np.random.default_rng(12).integers(-(2**31), 2**31 - 1, (1000, 3))
    scales, offsets, out = np.array([0.001, 0.01, 0.0001]), np.array([4e5, 5.8e6, -3.7]), np.zeros((1000, 3))
    place_steps(record["xyz"], scales, offsets, out)
    assert np.array_equal(out, record["xyz"] * scales + offsets)


def test_points_are_localised_in_place():
    points = np.random.default_rng(13).normal(size=(1000, 3))
    expected = (points - np.array([1.0, 2.0, 3.0])) * 0.3048
    localise(points, np.array([1.0, 2.0, 3.0]), 0.3048, points)
    assert np.array_equal(points, expected)


@pytest.mark.parametrize("count", [FEW_POINTS // 2, 2 * FEW_POINTS])
def test_the_points_of_a_user_are_never_changed(count):
    points = np.random.default_rng(14).uniform(0, 5, (count, 3)) + np.array([5e5, 5.8e6, 30])
    before = points.copy()
    cloud = as_cloud(points)
    assert np.array_equal(points, before)
    assert np.array_equal(cloud.points, points - cloud.frame.origin)


def test_blocks_are_chosen_as_by_the_twin():
    points = np.random.default_rng(8).normal(0, 5, (50_000, 3))
    grid = {"low": points[:100].min(axis=0), "edge": 0.7, "limit": np.uint64(2**62)}
    chosen = _in_blocks(points, **grid)
    assert np.array_equal(chosen, blocks_by_hashing(points, **grid))
    assert 0.1 < chosen.mean() < 0.4


@pytest.mark.parametrize("columns", [2, 3])
@pytest.mark.parametrize("count", [1, FEW_POINTS, 3 * FEW_POINTS + 1])
def test_corners_enclose_all_points_and_no_more(count, columns):
    points = np.random.default_rng(15).normal(size=(count, columns)) - 7.0
    assert np.array_equal(bounds(points), [points.min(axis=0), points.max(axis=0)])


@pytest.mark.parametrize("count", [100, 3 * FEW_POINTS])
@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
def test_corners_tell_of_coordinates_that_are_not_finite(count, odd):
    points = np.random.default_rng(16).normal(size=(count, 3))
    points[count // 3, 1] = odd
    assert not np.isfinite(bounds(points)).all()
