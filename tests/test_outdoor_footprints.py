"""Footprints: exact corners, gaps, unseen sides, houses that touch; turned, moved, shuffled, without classes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.houses import HousesResult, houses
from indoor_bim.model import Ring
from indoor_bim.outdoor.edges import fit_edges
from indoor_bim.outdoor.wall_lines import main_direction
from indoor_bim.simulate.village import CLUTTER, Plot, placed, sample_village, scan_village


def box(width: float, depth: float, *, x: float = 0.0, y: float = 0.0, turn: float = 20.0) -> Ring:
    return placed(((x, y), (x + width, y), (x + width, y + depth), (x, y + depth)), at=(0, 0), turn=turn)


@cache
def village_cloud() -> Cloud:
    return scan_village(sample_village())


@cache
def village() -> HousesResult:
    return houses(village_cloud())


def corners(result: HousesResult) -> np.ndarray:
    return np.concatenate([np.array(house.footprint) for house in result.village.houses])


def corner_errors(result: HousesResult, plots: Sequence[Plot]) -> np.ndarray:
    distance = cdist(np.concatenate([np.array(plot.footprint) for plot in plots]), corners(result))
    assert distance.shape[0] == distance.shape[1]
    rows, columns = linear_sum_assignment(distance)
    return distance[rows, columns]


def test_every_house_is_found_with_every_corner() -> None:
    plots = sample_village()
    result = village()
    assert len(result.village.houses) == len(plots)
    assert corner_errors(result, plots).max() < 0.005
    for plot in plots:
        polygon = shapely.Polygon(plot.footprint)
        (house,) = [house for house in result.village.houses if house.polygon.intersects(polygon)]
        assert house.storeys == plot.storeys
        assert house.height == pytest.approx(plot.height, abs=0.06)
        assert house.area == pytest.approx(polygon.area, rel=0.002)
        assert all(facade.seen and facade.evidence.coverage > 0.8 for facade in house.facades)


def test_without_class_codes() -> None:
    result = houses(replace(village_cloud(), classification=None))
    assert corner_errors(result, sample_village()).max() < 0.005
    assert any("no classes" in warning for warning in result.warnings)


def test_the_order_of_points_changes_nothing() -> None:
    cloud = village_cloud()
    assert cloud.classification is not None
    order = np.random.default_rng(1).permutation(len(cloud))
    shuffled = houses(replace(cloud, points=cloud.points[order], classification=cloud.classification[order]))
    assert shuffled.village.houses == village().village.houses


@pytest.mark.parametrize("turn", [31.7, 180.0])
def test_turned_and_moved(turn: float) -> None:
    angle = np.radians(turn)
    rotation = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    shift = np.array([13.37, -4.21, 0.0])
    result = houses(replace(village_cloud(), points=village_cloud().points @ rotation.T + shift))
    back = (np.column_stack([corners(result), np.zeros(len(corners(result)))]) - shift) @ rotation
    assert cdist(corners(village()), back[:, :2]).min(axis=1).max() < 0.005


def test_far_coordinates_come_back() -> None:
    far = village_cloud().points[::2] + np.array([5e5, 5.8e6, 100.0])
    result = houses(far)
    frame = result.stages["read"].frame
    made = frame.to_scan(np.column_stack([corners(result), np.zeros(len(corners(result)))]))[:, :2] - [5e5, 5.8e6]
    true = np.concatenate([np.array(plot.footprint) for plot in sample_village()])
    assert cdist(true, made).min(axis=1).max() < 0.01


@pytest.mark.parametrize(
    ("hidden", "tolerance"),
    [
        (((0, 3.0, 7.0),), 0.01),
        (((0, 6.5, 10.0), (1, 0.0, 3.0)), 0.02),
        (((2, 0.0, 10.0),), 0.08),
        (((2, 0.0, 10.0), (1, 0.0, 8.0)), 0.08),
        (((1, 0.0, 8.0), (3, 0.0, 8.0)), 0.08),
    ],
    ids=["gap", "corner", "one side", "two sides", "opposite sides"],
)
def test_what_was_hidden_is_closed(hidden: tuple[tuple[int, float, float], ...], tolerance: float) -> None:
    plots = [Plot(box(10, 8), storeys=2, hidden=hidden)]
    result = houses(scan_village(plots, trees=3, cars=2))
    assert corner_errors(result, plots).max() < tolerance
    whole_sides = {side for side, low, high in hidden if high - low >= 8.0}
    unseen = [facade for facade in result.village.houses[0].facades if not facade.seen]
    assert len(unseen) == len(whole_sides)
    assert any("closed by assumption" in warning for warning in result.warnings) == bool(whole_sides)


def test_houses_that_touch_are_told_apart_by_their_eaves() -> None:
    plots = [Plot(box(8, 9, x=8.0 * i), storeys=storeys) for i, storeys in enumerate((1, 2, 1, 3))]
    result = houses(scan_village(plots))
    assert sorted(house.storeys for house in result.village.houses) == [1, 1, 2, 3]
    assert corner_errors(result, plots).max() < 0.02


def test_houses_that_touch_at_one_height_are_one() -> None:
    plots = [Plot(box(10, 8)), Plot(box(8, 8, x=10, y=2))]
    (house,) = houses(scan_village(plots)).village.houses
    assert house.area == pytest.approx(144.0, rel=0.002)


def test_a_narrow_alley_stays_open() -> None:
    plots = [Plot(box(10, 8)), Plot(box(8, 8, x=11.0))]
    assert corner_errors(houses(scan_village(plots)), plots).max() < 0.01


def test_garden_walls_trees_and_cars_are_no_houses() -> None:
    rng = np.random.default_rng(2)
    cloud = scan_village([Plot(box(10, 8))], trees=20, cars=8)
    wall = np.column_stack([rng.uniform(-14, 14, 6000), np.full(6000, -9.0), rng.uniform(-0.5, 2.2, 6000)])
    assert cloud.classification is not None
    classes = np.append(cloud.classification, np.full(len(wall), CLUTTER, dtype=np.uint8))
    points = np.concatenate([cloud.points, wall])
    for codes in (classes, None):
        (house,) = houses(replace(cloud, points=points, classification=codes)).village.houses
        assert house.area == pytest.approx(80.0, rel=0.002)


def test_a_field_without_houses_says_so() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(NothingToReconstructError, match="found no house"):
        houses(np.column_stack([rng.uniform(0, 30, (20000, 2)), rng.normal(0, 0.02, 20000)]))


def test_the_published_way_is_selectable() -> None:
    result = houses(village_cloud(), method="topology")
    assert result.village.method == "topology"
    true = np.concatenate([np.array(plot.footprint) for plot in sample_village()])
    assert np.median(cdist(true, corners(result)).min(axis=1)) < 0.1


def ring_points(ring: Ring, noise: float) -> np.ndarray:
    rng = np.random.default_rng(6)
    sides = zip(ring, (*ring[1:], ring[0]), strict=True)
    points = np.concatenate([np.asarray(a) + rng.random((1500, 1)) * np.subtract(b, a) for a, b in sides])
    return points + rng.normal(0, noise, points.shape)


def test_right_angles_only_where_the_points_say_so() -> None:
    square, oblique = box(10, 8), ((0.0, 0.0), (10.0, 1.0), (9.5, 9.0), (-1.0, 8.0))
    for ring, right in ((square, True), (oblique, False)):
        edges = fit_edges(np.array(ring) + 0.03, ring_points(ring, 0.02))
        cross = np.array([(edge.angle - edges[0].angle + np.pi / 4) % (np.pi / 2) - np.pi / 4 for edge in edges])
        assert (np.abs(cross).max() < 1e-9) == right
        assert np.abs(np.array([edge.start for edge in edges]) - ring).max() < 0.01


def test_a_close_look_at_one_end_does_not_turn_a_wall() -> None:
    """Points lie 2 cm inwards over a metre of the wall that was scanned a hundred times as densely.

    Counted by length, the first 4 or 5 of 39 stretches turn the line by about 0.001; counted by points, they would own its start.
    """
    ring = box(10, 8, turn=0)
    dense = np.column_stack([np.random.default_rng(0).uniform(0, 1, 60000), np.full(60000, 0.02)])
    edges = fit_edges(np.array(ring), np.concatenate([ring_points(ring, 0.01), dense]), right_angles=False)
    assert edges[0].start[1] < 0.012
    assert abs(edges[0].angle) < 0.0015


def test_main_direction_is_that_of_most_walls() -> None:
    angles = np.radians([10, 100, 11, 99, 45])
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    assert main_direction(normals, np.array([9, 9, 1, 1, 2.0])) == pytest.approx(np.radians(10), abs=0.02)
