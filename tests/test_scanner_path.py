"""Where the scanner was."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan.scanner_path import DRIFT_PERIOD, known_positions, path_periods, sensor_positions

TRIPOD = np.array([[0.0, 1, 1, 1], [120.0, 5, 1, 1], [240.0, 9, 9, 1]])
WALK = np.column_stack([np.arange(11) * 0.1, np.arange(11) * 0.08, np.zeros(11), np.ones(11)])


def test_a_scanner_on_a_tripod_does_not_move_between_its_standpoints():
    at = sensor_positions(TRIPOD, np.array([0.0, 60.0, 119.9, 120.0, 300.0]))
    assert at[:, 0].tolist() == [1, 1, 1, 5, 9]
    assert path_periods(TRIPOD, np.array([1.0, 50.0, 119.0, 121.0, 999.0])).tolist() == [0, 0, 0, 1, 2]


def test_one_standpoint():
    assert sensor_positions(TRIPOD[:1], np.array([7.0])).tolist() == [[1, 1, 1]]
    assert path_periods(TRIPOD[:1], np.array([-7.0, 7.0])).tolist() == [0, 0]


def test_stations_may_be_given_by_the_middle_of_their_time():
    path, times = TRIPOD + np.array([60, 0, 0, 0]), np.array([10.0, 110.0, 130.0, 230.0, 250.0])
    assert sensor_positions(path, times)[:, 0].tolist() == [1, 1, 5, 5, 9]
    assert path_periods(path, times).tolist() == [0, 0, 1, 1, 2]


def test_a_walk_is_interpolated():
    np.testing.assert_allclose(sensor_positions(WALK, np.array([0.05])), [[0.04, 0, 1]])


def test_a_slowly_recorded_walk_is_interpolated():
    np.testing.assert_allclose(sensor_positions(WALK * np.array([20, 1, 1, 1]), np.array([1.0])), [[0.04, 0, 1]])


def test_two_walks_are_not_joined():
    both = np.vstack([WALK, WALK + np.array([31, 5, 0, 0])])
    assert sensor_positions(both, np.array([15.0, 31.0]))[:, 0].tolist() == [0.8, 5.0]
    assert path_periods(both, np.array([0.9, 15.0, 30.9, 31.0])).tolist() == [0, 0, 0, 15]


@pytest.mark.parametrize("shuffled", [False, True])
def test_many_points_at_once_are_interpolated_as_by_numpy(shuffled):
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.choice([0.0, 0.05, 0.1, 0.3], 400))
    path = np.column_stack([time, np.cumsum(rng.normal(0, 0.1, (400, 3)), axis=0)])
    times = np.sort(np.concatenate([rng.uniform(time[0] - 1, time[-1] + 1, 120_000), time, [np.nan]]))
    times = rng.permutation(times) if shuffled else times
    expected = np.column_stack([np.interp(times, time, path[:, k]) for k in (1, 2, 3)])
    np.testing.assert_array_equal(sensor_positions(path, times), expected)
    some = np.flatnonzero(rng.uniform(size=len(times)) < 0.3)
    np.testing.assert_array_equal(known_positions(path, times, some), expected[some])
    known = times[np.isfinite(times)]
    np.testing.assert_array_equal(path_periods(path, known), np.floor((known - time[0]) / DRIFT_PERIOD))


def test_standpoints_of_some_points_are_those_of_all():
    """Points before the first row of the path tell that its times are those of the middles of the stands."""
    times = np.array([-20.0, 0.0, 60.0, 119.9, 120.0, 300.0])
    rows = np.array([1, 3, 4])
    np.testing.assert_array_equal(known_positions(TRIPOD, times, rows), sensor_positions(TRIPOD, times)[rows])
