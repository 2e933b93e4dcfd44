"""Points on rasters: many at once give what few at a time do."""

import numpy as np
import pytest
from scipy import ndimage

from indoor_bim.plan import block_image, overhead
from indoor_bim.plan import evidence as ev
from indoor_bim.plan import hit_images as hits
from indoor_bim.plan.raster import Raster


@pytest.fixture
def xy():
    return np.random.default_rng(0).uniform(-2, 12, (2 * ev.FEW_POINTS, 2))


def in_parts(function, *arrays):
    return np.concatenate(
        [function(*(values[k : k + ev.FEW_POINTS] for values in arrays)) for k in range(0, len(arrays[0]), ev.FEW_POINTS)]
    )


def test_values_under_points(xy):
    raster = Raster(np.random.default_rng(1).random((30, 40)), np.array([0.5, -0.5]), 0.2)
    assert np.array_equal(ev.clamp_sample(raster, xy), in_parts(lambda part: ev.clamp_sample(raster, part), xy))


def test_spots_towards_the_scanner(xy):
    sensor = np.random.default_rng(2).uniform(0, 10, (len(xy), 3))
    sensor[0, :2] = xy[0]
    spots = ev.towards_scanner(xy, sensor, 0.3)
    np.testing.assert_allclose(spots, in_parts(lambda *part: ev.towards_scanner(*part, 0.3), xy, sensor), rtol=0, atol=1e-12)
    assert np.array_equal(spots[0], xy[0])


def test_pixels_that_are_hit(xy):
    grid = {"low": np.array([0.0, 0.0]), "high": np.array([10.0, 9.0]), "cell": 0.1}
    parts = [hits.hit_raster(xy[k::2], **grid).image for k in range(2)]
    whole = hits.hit_raster(xy, **grid).image
    assert np.array_equal(whole, parts[0] | parts[1])
    assert 0.3 < whole.mean() < 1


def test_columns_in_which_walls_were_hit_at_several_heights(xy, monkeypatch):
    rise = np.random.default_rng(3).uniform(0.5, 1.1, len(xy))
    raster = Raster(np.zeros((90, 130)), np.array([0.0, 0.0]), 0.1)
    points = ev.WallPoints(xy, rise, 1 - rise, None)
    row, column = np.floor(xy[:, ::-1] / 0.1).astype(int).T
    layers = np.zeros((90, 130, 24), dtype=bool)
    high = (rise > 0.75) & (row >= 0) & (row < 90) & (column >= 0) & (column < 130)
    layers[row[high], column[high], np.minimum((rise[high] * 24).astype(int), 23)] = True
    assert np.array_equal(hits.wall_columns(points, raster), np.nonzero(layers.sum(axis=2) > 1))
    assert 0.1 < (layers.sum(axis=2) > 1).mean() < 0.9
    monkeypatch.setattr(block_image, "FIRST_SLOTS", 2)
    assert np.array_equal(hits.wall_columns(points, raster), np.nonzero(layers.sum(axis=2) > 1))
    few = np.arange(ev.FEW_POINTS)
    layers[:] = False
    layers[row[few][high[few]], column[few][high[few]], np.minimum((rise[few][high[few]] * 24).astype(int), 23)] = True
    assert np.array_equal(hits.wall_columns(points.take(few), raster), np.nonzero(layers.sum(axis=2) > 1))


@pytest.fixture
def points(xy):
    return np.column_stack([xy, np.random.default_rng(4).uniform(-0.1, 0.1, len(xy))])


GRID = {"low": np.array([0.0, 0.0]), "high": np.array([10.0, 9.0]), "cell": 0.1}


@pytest.mark.parametrize(("least", "most"), [(-0.06, 0.06), (0.0, np.inf)])
def test_pixels_that_are_hit_at_a_level(points, least, most):
    level = {"base": 0.02, "least": least, "most": most, **GRID}
    parts = [hits.level_raster(points[k::2], **level).image for k in range(2)]
    whole = hits.level_raster(points, **level).image
    assert np.array_equal(whole, parts[0] | parts[1])
    assert 0.2 < whole.mean() < 0.9


def test_pixels_that_are_hit_on_a_surface(points):
    rng = np.random.default_rng(5)
    surface, slack = (Raster(rng.uniform(*ends, (30, 40)), np.array([0.5, -0.5]), 0.2) for ends in ((-0.05, 0.05), (0.01, 0.04)))
    parts = [hits.surface_raster(points[k::2], surface, slack, **GRID).image for k in range(2)]
    whole = hits.surface_raster(points, surface, slack, **GRID).image
    assert np.array_equal(whole, parts[0] | parts[1])
    assert 0.1 < whole.mean() < 0.8


@pytest.mark.parametrize("shape", [(300, 400), (11, 90), (90, 7), (25, 25), (128, 256), (129, 3)])
def test_density_of_large_images_is_that_of_small_ones(shape, monkeypatch):
    rng = np.random.default_rng(6)
    known = ndimage.uniform_filter(rng.random(shape), 9) > 0.48
    seen = (rng.random(shape) < 0.3) & known
    seen[:, : shape[1] // 2] &= rng.random(shape[0])[:, None] < 0.1
    monkeypatch.setattr(hits, "FEW_PIXELS", 0)
    large = hits.local_density(seen, known, cell=0.025)
    monkeypatch.setattr(hits, "FEW_PIXELS", seen.size)
    assert np.array_equal(large, hits.local_density(seen, known, cell=0.025))
    assert large.max() > 0


@pytest.mark.parametrize("place", [(127, 128), (128, 255), (140, 10), (0, 0), (299, 399)])
def test_a_single_hit_shows_in_all_tiles_around(place, monkeypatch):
    seen, known = np.zeros((300, 400), dtype=bool), np.ones((300, 400), dtype=bool)
    seen[place] = True
    large = hits.local_density(seen, known, cell=0.025)
    monkeypatch.setattr(hits, "FEW_PIXELS", seen.size)
    assert np.array_equal(large, hits.local_density(seen, known, cell=0.025))
    reached = np.argwhere(large)
    assert (reached.max(axis=0) == np.minimum(np.array(place) + 20, [299, 399])).all()


def test_the_upper_ends_of_walls_and_what_touches_them_are_no_ceiling():
    ground = (np.argwhere(np.ones((9, 9))) + 0.5) * 0.1
    ceiling = np.column_stack([ground, np.full(81, 2.5)])
    wall = ev.WallPoints(np.tile([0.45, 0.25], (2, 1)), np.array([0.8, 0.95]), np.array([0.5, 0.1]), None)
    overhead_raster = Raster(np.full((9, 9), 2.5), np.zeros(2), 0.1)
    seen, column = hits.overhead_hits(ceiling, wall, overhead_raster, low=np.zeros(2), high=np.full(2, 0.9), cell=0.1)
    expected = np.zeros((9, 9), dtype=bool)
    expected[1:4, 3:6] = True
    assert np.array_equal(column, expected)
    assert np.array_equal(seen.image, ~expected)


def test_rows_within_a_box(points):
    low, high = np.array([0.0, 1.0, -0.05]), np.array([8.0, 9.0, 0.06])
    rows = ev.rows_within(points, low, high)
    assert np.array_equal(ev.points_at(points, rows), points[rows])
    assert np.array_equal(ev.points_at(points, np.arange(len(points))), points)
    assert len(points) > ev.FEW_POINTS > len(rows[:9])
    assert np.array_equal(rows, np.flatnonzero(((points > low) & (points < high)).all(axis=1)))
    few = points[: ev.FEW_POINTS]
    assert np.array_equal(ev.rows_within(few, low, high), rows[rows < len(few)])


@pytest.mark.parametrize("sloped", [True, False])
def test_surface_overhead_of_many_points_is_that_of_few(sloped, monkeypatch):
    rng = np.random.default_rng(8)
    points = rng.uniform([0, 0, 0], [8, 5, 3], (60_000, 3))
    points[:30_000, 2] = 2.5 + rng.normal(0, 0.004, 30_000) + (0.7 * points[:30_000, 0] if sloped else 0.0)
    surface = {"floor": 0.0, "top": 9.0, "sloped": sloped}
    many = overhead.overhead_surface(points, **surface)
    monkeypatch.setattr(overhead, "FEW_POINTS", len(points))
    few = overhead.overhead_surface(points, **surface)
    np.testing.assert_allclose(many.image, few.image, rtol=0, atol=1e-12)
    assert np.isfinite(few.image).mean() > 0.5
