"""Thinning to boxes."""

import numpy as np
import pytest

from indoor_bim.cloud.thinning import FEW_POINTS, MICROMETRE, thin_by_sorting, thin_evenly
from indoor_bim.cloud.voxel_sums import sum_boxes


def rough_points(count, seed=0):
    rng = np.random.default_rng(seed)
    return np.vstack([rng.uniform(-3, 3, (count, 3)) ** 3, np.round(rng.uniform(-3, 3, (count, 3)), 2)])


@pytest.mark.parametrize(("cell", "layer"), [(0.05, None), (0.015, 0.1), (3.0, 0.01)])
def test_many_points_equal_their_twin_to_the_bit(cell, layer):
    points = rough_points(FEW_POINTS)
    sides = np.rint(np.array([cell, cell, layer or cell]) / MICROMETRE)
    assert np.array_equal(thin_evenly(points, cell=cell, layer=layer), thin_by_sorting(points, sides=sides))


def test_neither_order_nor_threads_matter():
    points = rough_points(FEW_POINTS, seed=1)
    thin = thin_evenly(points, cell=0.3)
    assert np.array_equal(thin_evenly(points[np.random.default_rng(2).permutation(len(points))], cell=0.3), thin)
    grid = {"unit": MICROMETRE, "sides": np.full(3, 300_000.0), "first": np.full(3, -90), "size": np.array([200, 200, 200])}
    for threads in (1, 2, 5):
        assert np.array_equal(sum_boxes(points, **grid, threads=threads), thin)


def test_every_box_is_the_mean_of_its_points():
    points = np.round(rough_points(500), 4)
    thin = thin_evenly(points, cell=1.0)
    boxes = np.unique(np.floor(points), axis=0)
    assert len(thin) == len(boxes)
    for box, mean in zip(boxes, thin, strict=True):
        assert mean == pytest.approx(points[(np.floor(points) == box).all(axis=1)].mean(axis=0), abs=2e-6)
