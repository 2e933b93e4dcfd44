"""Points in tiles: every point once where it belongs, and once more in each tile whose margin it lies in."""

import numpy as np
import pytest

from indoor_bim.cloud import margins, tiles
from indoor_bim.cloud.margins import CELL, TILE, sort_with_margins
from indoor_bim.cloud.tiles import FIRST_RUN, sort_into_tiles

SIDE = CELL * TILE


def members(sorted_tiles):
    """Steps and rows of the points of each tile, by its indices; the runs are followed one by one."""
    found = {}
    for tile, key in enumerate(sorted_tiles.keys):
        records = []
        for chain in range(sorted_tiles.first_chain[tile], sorted_tiles.first_chain[tile + 1]):
            run, length, left = sorted_tiles.first_run[chain], FIRST_RUN, sorted_tiles.count[chain]
            while left:
                here = min(left, length)
                records.append(sorted_tiles.records[run : run + here])
                left -= here
                if left:
                    run, length = (int(word) for word in sorted_tiles.records[run + length])
        first, second = np.concatenate(records).astype(np.int64).T
        steps = np.stack([first & 0xFFFFFFFF, first >> 32, second & 0xFFFFFFFF], axis=1)
        order = np.argsort(second >> 32)
        found[(key >> 42, key >> 21 & 0x1FFFFF, key & 0x1FFFFF)] = (steps[order], (second >> 32)[order])
    return found


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("spread", [0.01, 3, 40])
def test_every_point_lies_in_its_tile_and_in_the_margins_around(spread, threads):
    rng = np.random.default_rng(4)
    points = np.vstack([rng.uniform(-spread, spread, (4000, 3)), rng.normal(0, 0.05, (3000, 3))])
    per_unit = SIDE / 1.5
    sorted_tiles = sort_into_tiles(points, sort_with_margins, (points[0], per_unit), threads=threads)
    places = np.floor((points - points[0]) * per_unit + (2.0**43 + SIDE / 2)).astype(np.int64)
    found = members(sorted_tiles)
    assert list(found) == sorted(found)
    own = np.zeros(len(points), dtype=int)
    for index, (steps, rows) in found.items():
        low = np.array(index) * SIDE - CELL
        inside = ((places >= low) & (places < low + SIDE + 2 * CELL)).all(axis=1)
        assert np.array_equal(rows, np.flatnonzero(inside))
        assert np.array_equal(steps, places[rows] - low)
        own[rows] += ((steps >= CELL) & (steps < CELL + SIDE)).all(axis=1)
    assert (own == 1).all()


def test_shares_cover_all_tiles_once():
    points = np.random.default_rng(5).uniform(-9, 9, (20_000, 3))
    sorted_tiles = sort_into_tiles(points, sort_with_margins, (points[0], SIDE / 1.5), threads=2)
    shares = sorted_tiles.shares(2)
    assert 8 < len(shares) <= 32
    assert np.array_equal(np.concatenate([np.arange(len(sorted_tiles.keys))[share] for share in shares]), np.arange(len(sorted_tiles.keys)))


def test_points_that_do_not_suit_the_grid():
    points = np.random.default_rng(6).uniform(-9, 9, (100, 3))
    points[50, 1] = np.nan
    assert sort_into_tiles(points, sort_with_margins, (points[0], 1.0), threads=1) is None
    points[50, 1] = points[0, 1] + margins.MOST_STEPS
    assert sort_into_tiles(points, sort_with_margins, (points[0], 1.0), threads=1) is None
    points[50, 1] = points[0, 1] + np.nextafter(margins.MOST_STEPS, 0) - 1
    assert sort_into_tiles(points, sort_with_margins, (points[0], 1.0), threads=1) is not None


def test_there_is_room_for_sparse_points():
    points = np.random.default_rng(7).integers(0, 1000, (20_000, 3)) * 1.0
    sorted_tiles = sort_into_tiles(points, sort_with_margins, (points[0], SIDE * 1.0), threads=1)
    assert len(sorted_tiles.keys) > 10 * tiles.FIRST_TILES
    assert sorted_tiles.count.sum() == len(points)
