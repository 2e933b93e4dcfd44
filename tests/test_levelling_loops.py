"""The compiled sums that levelling rests on, beside their twins in numpy."""

import numpy as np
import pytest

from indoor_bim.cloud.box_moments import FEW_POINTS, box_moments, box_moments_by_sorting
from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, StoreyLevels
from indoor_bim.cloud.heights import LEVEL_TOLERANCE, height_peaks, nearest_peak
from indoor_bim.cloud.levels import _parts
from indoor_bim.cloud.main_direction import energy_by_bincount
from indoor_bim.cloud.motion import moved
from indoor_bim.cloud.point_loops import histogram_energy


@pytest.fixture
def points():
    rng = np.random.default_rng(3)
    return np.vstack([rng.uniform(-4, 4, (FEW_POINTS, 3)), np.round(rng.uniform(-4, 4, (FEW_POINTS, 3)), 1)])


@pytest.mark.parametrize("sides", [(0.3, 0.3, 0.3), (0.3, 0.3, 0.1), (7.0, 0.5, 3.0)])
def test_box_moments_equal_their_twin(points, sides):
    found, twin = box_moments(points, sides=sides), box_moments_by_sorting(points, sides=np.array(sides))
    assert np.array_equal(found.count, twin.count)
    assert np.array_equal(found.index, twin.index)
    np.testing.assert_allclose(found.mean, twin.mean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.covariance, twin.covariance, rtol=0, atol=1e-12)


@pytest.mark.parametrize("count", [FEW_POINTS, FEW_POINTS + 1])
def test_merged_moments_are_those_of_wider_boxes(count):
    points = np.random.default_rng(4).uniform(-4, 4, (count, 3))
    found, wide = box_moments(points, sides=(0.3, 0.3, 0.1)).merged((2, 2, 6)), box_moments(points, sides=(0.6, 0.6, 0.6))
    assert np.array_equal(found.count, wide.count)
    assert np.array_equal(found.index, wide.index)
    np.testing.assert_allclose(found.mean, wide.mean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.covariance, wide.covariance, rtol=0, atol=1e-12)


def test_moved_points_are_those_of_the_matrix(points):
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    for part in (points, points[:7]):
        np.testing.assert_allclose(moved(part, turn, (1, 2, 3)), part @ turn.T + [1, 2, 3], rtol=0, atol=1e-13)
    assert np.array_equal(moved(points, turn, (1, 2, 3))[:7], moved(points[:7], turn, (1, 2, 3)))


def test_energy_equals_its_twin(points):
    xy, weight = np.ascontiguousarray(points[:, :2]), np.abs(points[:, 2])
    for angle in (0.0, 0.4, 2.0):
        line = (np.cos(angle), np.sin(angle), 0.05)
        assert histogram_energy(xy, weight, *line) == pytest.approx(energy_by_bincount(xy, weight, *line), rel=1e-12)


def test_parts_of_many_and_few_points_agree(points):
    storeys = (StoreyLevels(-3.0, 0.0), StoreyLevels(0.05, None))
    part = _parts(points, storeys)
    assert np.array_equal(part, np.concatenate([_parts(points[:FEW_POINTS], storeys), _parts(points[FEW_POINTS:], storeys)]))
    assert set(np.unique(part)) == {WALL, FLOOR, CEILING}
    assert (part[np.abs(points[:, 2] - 0.05) < LEVEL_TOLERANCE] == FLOOR).all()


def test_nearest_peak_is_the_nearest():
    rng = np.random.default_rng(5)
    heights, peaks = rng.uniform(-1, 4, 500), rng.uniform(0, 3, 9)
    assert np.array_equal(nearest_peak(heights, peaks), np.argmin(np.abs(heights[:, None] - peaks), axis=1))


def test_peaks_are_the_medians_of_what_is_near():
    rng = np.random.default_rng(6)
    heights = np.concatenate([rng.normal(1.0, 0.01, 301), rng.normal(2.5, 0.01, 100)])
    first, second = height_peaks(heights, share=0.1)
    assert first == np.median(heights[:301])
    assert second == np.median(heights[301:])


def test_only_peaks_with_a_share_of_the_largest_count_and_the_largest_comes_first():
    rng = np.random.default_rng(7)
    heights = np.concatenate([rng.normal(4.0, 0.01, 60), rng.normal(1.0, 0.01, 100), rng.normal(2.5, 0.01, 30)])
    assert np.round(height_peaks(heights, share=0.2), 1).tolist() == [1.0, 4.0, 2.5]
    assert np.round(height_peaks(heights, share=0.5), 1).tolist() == [1.0, 4.0]
    assert height_peaks(np.zeros(0), share=0.5) == []
    assert height_peaks(np.array([3.0]), share=0.5) == [3.0]


def peaks_in_numpy(heights, share):
    """Twin of `height_peaks`: what is within 12 cm of a peak is no other."""
    ordered = np.sort(heights)
    low = ordered[0] - 1.0
    histogram = np.pad(np.bincount(((ordered - low) / 0.01).astype(int)).astype(float), (0, 100))
    smooth = np.convolve(histogram, np.maximum(1 - (np.arange(-6, 7) / 7) ** 2, 0), mode="same")
    least, peaks = max(share * smooth.max(), 1.0), []
    while smooth.max() >= least:
        top = int(np.argmax(smooth))
        near = ordered[np.abs(ordered - (low + (top + 0.5) * 0.01)) < LEVEL_TOLERANCE]
        peaks.append(np.median(near))
        smooth[max(top - 12, 0) : top + 13] = 0
    return peaks


@pytest.mark.parametrize("seed", range(10))
def test_peaks_are_those_of_numpy(seed):
    rng = np.random.default_rng(seed)
    levels = rng.choice(rng.uniform(-1, 4, 12), 3000)
    heights = levels + rng.normal(0, 0.01, 3000)
    assert height_peaks(heights, share=0.02) == peaks_in_numpy(heights, 0.02)
