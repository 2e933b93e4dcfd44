"""Points in tiles: nothing near a line is missed, and many points are sorted as few are."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan import evidence as ev
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.tiles import TILE, tiles_of


@pytest.fixture
def xy():
    return np.random.default_rng(0).uniform([-3.3, 2.1], [4.4, 6.6], (20_000, 2))


def away_from(spots, p, q):
    """Distances of spots from the line from p to q."""
    d = (q - p) / np.hypot(*(q - p))
    along = np.clip((spots - p) @ d, 0, np.hypot(*(q - p)))
    return np.hypot(*(spots - p - along[:, None] * d).T)


@pytest.mark.parametrize(
    ("p", "q"),
    [
        ((-3, 3), (4, 3)),
        ((0, 6), (0, 3)),
        ((-2.9, 2.2), (4.1, 6.4)),
        ((3, 6), (-3, 5.97)),
        ((1, 3), (1.02, 3)),
        ((-9, 4), (9, 4.4)),
        ((0.5, 9), (2, -9)),
    ],
)
@pytest.mark.parametrize("reach", [0.05, 0.25])
def test_all_points_near_a_line_are_in_its_ranges(xy, p, q, reach):
    tiles, order = tiles_of(xy)
    p, q = np.array(p, dtype=float), np.array(q, dtype=float)
    rows = np.concatenate([np.arange(*ends) for ends in tiles.along(p, q, reach)])
    near = np.flatnonzero(away_from(xy[order], p, q) < reach)
    assert len(near) > 20 or np.hypot(*(q - p)) < 0.1
    assert np.isin(near, rows).all()
    assert len(np.unique(rows)) == len(rows)
    assert away_from(xy[order][rows], p, q).max() < 3 * TILE


@pytest.mark.parametrize(("p", "q"), [((20, 3), (30, 3)), ((0, -5), (1, -9)), ((-20, 4), (-10, 4))])
def test_far_from_all_points_there_are_no_ranges(xy, p, q):
    assert len(tiles_of(xy)[0].along(np.array(p, dtype=float), np.array(q, dtype=float), 0.1)) == 0


def test_points_of_a_tile_are_together_in_their_order(xy):
    tiles, order = tiles_of(xy)
    assert sorted(order) == list(range(len(xy)))
    for first, last in zip(tiles.first[:-1], tiles.first[1:], strict=True):
        assert len(np.unique(np.floor(xy[order[first:last]] / TILE), axis=0)) <= 1
        assert (np.diff(order[first:last]) > 0).all()


def test_corners_are_around_all_points(xy):
    tiles, _ = tiles_of(xy)
    assert (tiles.corners[0] <= xy.min(axis=0)).all()
    assert (tiles.corners[1] > xy.max(axis=0)).all()
    assert (np.ptp(tiles.corners, axis=0) < np.ptp(xy, axis=0) + 2 * TILE).all()
    points = ev.WallPoints(xy, xy[:, 0], xy[:, 0], None)
    assert np.array_equal(points.corners, [xy.min(axis=0), xy.max(axis=0)])
    assert points.along(xy[0], xy[1], 0.1).tolist() == [[0, len(xy)]]


def test_no_points_are_in_no_tile():
    tiles, order = tiles_of(np.zeros((0, 2)))
    assert len(order) == 0
    assert len(tiles.along(np.zeros(2), np.ones(2), 0.1)) == 0


@pytest.mark.parametrize("sided", [True, False])
def test_candidates_of_many_points_are_those_of_few(sided):
    rng = np.random.default_rng(5)
    count = 60_000
    points = rng.uniform([0, 0, -0.2], [9, 7, 3.0], (count, 3))
    sensor = rng.uniform(1, 6, (count, 3)) if sided else None
    rows, columns = np.indices((30, 40))
    overhead = Raster(2.2 + 0.01 * rows + (columns > 20), np.array([0.5, 0.5]), 0.2)
    found = ev.wall_points(points, sensor, overhead, floor=0.1)
    parts = [slice(k, k + ev.FEW_POINTS) for k in range(0, count, ev.FEW_POINTS)]
    few = [ev.wall_points(points[part], None if sensor is None else sensor[part], overhead, floor=0.1) for part in parts]
    xy = np.concatenate([part.xy for part in few])
    assert 0.5 * count < len(found) == len(xy)
    tiles, _ = tiles_of(found.xy)
    assert np.array_equal(tiles.first, found.tiles.first)
    assert np.array_equal(tiles.low, found.tiles.low)
    assert tiles.columns == found.tiles.columns
    assert tiles_of(found.xy)[1].tolist() == list(range(len(xy)))
    order, twin_order = (np.lexsort(spots.T) for spots in (found.xy, xy))
    assert np.array_equal(found.xy[order], xy[twin_order])
    for name in ("rise", "depth", *(("sensor",) if sided else ())):
        assert np.array_equal(getattr(found, name)[order], np.concatenate([getattr(part, name) for part in few])[twin_order])
    assert sided or found.sensor is None
