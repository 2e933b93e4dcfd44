"""The published way: slice, grid, chain, simplification, storeys; exact on small cases."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoor_bim.outdoor.model import shoelace
from indoor_bim.outdoor.topology import chains, corner_angle, grid_centroids, outlines, simplify, slice_points, whole_storeys
from indoor_bim.params import HousesParams


def wall_ring(width: float, depth: float, step: float) -> np.ndarray:
    corners = np.array([[0, 0], [width, 0], [width, depth], [0, depth], [0, 0]], dtype=float)
    return np.concatenate([a + np.arange(0, 1, step / np.hypot(*(b - a)))[:, None] * (b - a) for a, b in pairwise(corners)])


def test_defaults_are_the_values_of_the_paper() -> None:
    params = HousesParams()
    assert (params.slice_low, params.slice_high, params.grid_size, params.angle_threshold) == (1.5, 1.7, 0.2, 179.5)


def test_slice_is_above_the_local_ground() -> None:
    points = np.array([[0, 0, 11.6], [1, 0, 1.6], [2, 0, 1.8]])
    assert slice_points(points, np.array([1.6, 1.6, 1.8])).tolist() == [[0, 0], [1, 0]]


def test_grid_counts_from_the_least_coordinates() -> None:
    """Equations 1 to 3 of the paper, point by point."""
    rng = np.random.default_rng(0)
    xy = rng.uniform(-3, 5, (500, 2))
    cells: dict[tuple[int, int], list[np.ndarray]] = {}
    for point in xy:
        i, j = (int(np.floor((point[k] - xy[:, k].min()) / 0.2)) for k in (0, 1))
        cells.setdefault((i, j), []).append(point)
    expected = np.array([np.mean(cells[key], axis=0) for key in sorted(cells)])
    assert grid_centroids(xy, cell=0.2) == pytest.approx(expected, abs=1e-12)


def brute_chain(points: np.ndarray, neighbours: int) -> list[int]:
    """Literal reading of step 4, for the first outline."""
    chain = [0]
    while True:
        distance = np.hypot(*(points - points[chain[-1]]).T)
        order = [int(j) for j in np.argsort(distance, kind="stable") if j != chain[-1]][:neighbours]
        free = [j for j in order if j not in chain or (j == 0 and len(chain) > neighbours)]
        if not free or free[0] == 0:
            return chain
        chain.append(free[0])


def test_chain_is_the_literal_one() -> None:
    ring = wall_ring(7.0, 5.0, 0.31)
    ring += np.random.default_rng(5).normal(0, 0.02, ring.shape)
    assert chains(ring, neighbours=6)[0].tolist() == brute_chain(ring, 6)


def test_two_houses_are_two_outlines() -> None:
    ring = wall_ring(6.0, 6.0, 0.25)
    found = chains(np.concatenate([ring, ring + np.array([20.0, 0.0])]), neighbours=8)
    assert [len(chain) for chain in found] == [len(ring), len(ring)]


def test_chains_of_few_points() -> None:
    assert chains(np.zeros((0, 2))) == []
    assert [chain.tolist() for chain in chains(np.array([[1.0, 2.0]]))] == [[0]]


@pytest.mark.parametrize(("angle", "kept"), [(179.9, 5), (178.0, 4)])
def test_simplification_keeps_what_bends(angle: float, kept: int) -> None:
    bend = np.array([[0, 0], [5, 0.03], [10, 0], [10, 8], [0, 8]], dtype=float)
    assert len(simplify(bend, angle=angle)) == kept


def test_simplification_judges_the_first_corner() -> None:
    assert simplify(np.array([[5.0, 0.0], [10, 0], [10, 8], [0, 8], [0, 0]])).tolist() == [[10, 0], [10, 8], [0, 8], [0, 0]]


@given(st.floats(0, 6.28), st.floats(-100, 100), st.floats(0.5, 40))
def test_angle_does_not_depend_on_place_or_size(turn: float, shift: float, size: float) -> None:
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    a, b, c = (tuple(rotation @ (size * np.array(p)) + shift) for p in ((0, 0), (1, 0), (2, 1)))
    assert corner_angle(a, b, c) == pytest.approx(135.0, abs=1e-6)


def test_storeys_round_down() -> None:
    assert [whole_storeys(top, 0.2) for top in (3.1, 3.3, 6.19, 6.21)] == [0, 1, 1, 2]


def test_outline_of_a_house() -> None:
    ring = wall_ring(10.0, 8.0, 0.02)
    z = np.linspace(0, 3, 31)
    points = np.column_stack([np.repeat(ring, len(z), axis=0), np.tile(z, len(ring))])
    (found,) = outlines(points, points[:, 2])
    area, centre = shoelace(tuple(map(tuple, found.tolist())))
    assert area == pytest.approx(80.0, rel=0.02)
    assert centre == pytest.approx((5.0, 4.0), abs=0.05)


def test_shoelace_far_from_the_origin() -> None:
    area, centre = shoelace(tuple((x + 5e5, y + 5.8e6) for x, y in ((0.0, 0.0), (0.0, 3.0), (4.0, 0.0))))
    assert area == pytest.approx(-6.0, abs=1e-12)
    assert centre == pytest.approx((5e5 + 4 / 3, 5.8e6 + 1.0), abs=1e-6)
