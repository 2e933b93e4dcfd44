"""The main direction of a building."""

from itertools import pairwise

import numpy as np
import pytest

from indoor_bim.plan.directions import main_direction


def walls(angle, noise=0.01, seed=0):
    """Plan points of an L-shaped building with one wall at 30 degrees, turned by `angle` degrees."""
    rng = np.random.default_rng(seed)
    corners = np.array([[0, 0], [20, 0], [20, 6], [8, 6], [8, 12], [0, 12], [0, 0]], dtype=float)
    ends = [*pairwise(corners), (np.array([12.0, 1.0]), np.array([12 + 2.598, 2.5]))]
    xy = np.concatenate([p + np.linspace(0, 1, int(np.hypot(*(q - p)) * 100))[:, None] * (q - p) for p, q in ends])
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return (xy + rng.normal(scale=noise, size=xy.shape)) @ np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("angle", [0.0, 0.3, 7.77, 33.3, 44.0, -44.0, -12.34])
def test_within_a_twentieth_of_a_degree(angle):
    assert np.degrees(main_direction(walls(angle))) == pytest.approx(angle, abs=0.05)


@pytest.mark.parametrize("quarter", [90.0, 180.0, 270.0])
def test_quarter_turns_are_equivalent(quarter):
    assert np.degrees(main_direction(walls(10.0 + quarter))) == pytest.approx(10.0, abs=0.05)


def test_order_and_place_do_not_matter():
    xy = walls(5.0)
    order = np.random.default_rng(1).permutation(len(xy))
    assert main_direction(xy[order]) == main_direction(xy)
    assert main_direction(xy + np.array([1000.0, -2000.0])) == pytest.approx(main_direction(xy), abs=1e-4)


def test_no_points():
    assert main_direction(np.zeros((0, 2))) == 0.0
