"""The bend of a walked map is told from walls that stand elsewhere than modelled."""

from __future__ import annotations

import buildings
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_deviation import BAND, by_id, surface_points

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.frame import Frame
from indoor_bim.quality.against import against_scan
from indoor_bim.quality.deviation import wall_deviations
from indoor_bim.quality.path_drift import path_drift
from indoor_bim.quality.unique_rows import unique_rows
from indoor_bim.quality.wall_bodies import bodies_of_building

BUILDING = buildings.four_rooms()
DURATION = 120.0


def walk(time: np.ndarray) -> np.ndarray:
    """A path from room to room, there and back."""
    low, high = np.array(BUILDING.storeys[0].walls[0].footprint).min(axis=0) + 1.0, np.array([7.0, 6.0])
    phase = 2 * np.pi * time / DURATION
    share = np.column_stack([0.5 - 0.5 * np.cos(phase), 0.5 - 0.5 * np.cos(2 * phase)])
    return np.column_stack([low + share * (high - low), np.full(len(time), 1.5)])


def scan(*, shift: float, turn: float, moved_wall: str | None = None, by: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points that a walk sees within a few metres, bent by a slow drift; time and scanner of each."""
    rng = np.random.default_rng(4)
    surface = surface_points(BUILDING, floor=False)
    if moved_wall is not None:
        wall = next(w for w in BUILDING.storeys[0].walls if w.id == moved_wall)
        (x0, y0), (x1, y1) = wall.axis
        normal = np.array([y0 - y1, x1 - x0, 0.0]) / wall.length
        along, across = (surface[:, :2] - (x0, y0)) @ [normal[1], -normal[0]], (surface[:, :2] - (x0, y0)) @ normal[:2]
        on_it = (np.abs(across) < wall.thickness / 2 + 1e-6) & (along > 0) & (along < wall.length)
        surface = surface + np.where(on_it[:, None], by * normal, 0.0)
    surface = surface[rng.random(len(surface)) < 0.5]
    time = rng.uniform(0, DURATION, len(surface))
    place = walk(time)
    near = np.hypot(*(surface - place)[:, :2].T) < 4.5
    points, time, place = surface[near], time[near], place[near]
    drift = shift * np.column_stack([np.sin(2 * np.pi * time / 60), np.cos(2 * np.pi * time / 45)])
    angle = turn * np.sin(2 * np.pi * time / 50)
    arm = (points - place)[:, :2]
    points = points + rng.normal(0, 0.01, points.shape)
    points[:, :2] += drift + angle[:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
    place = place.copy()
    place[:, :2] += drift
    return points, time, place


def test_a_bent_map_is_straightened_and_said_to_be_bent() -> None:
    points, time, scanner = scan(shift=0.04, turn=0.004)
    model = bodies_of_building(BUILDING)
    rigid = by_id(wall_deviations(model, points, bands=BAND))
    straight = wall_deviations(model, points, bands=BAND, time=time, scanner=scanner)
    assert max(wall.p95 for wall in rigid.values()) > 0.04
    assert "bent by up to" in straight.message
    for wall in straight.walls:
        assert abs(wall.bias) < 0.003
        assert wall.p95 < 0.015
        assert wall.bias + wall.drift == pytest.approx(rigid[wall.id].bias, abs=1e-9)


@pytest.mark.parametrize("wall_id", ["W5", "W6", "W7"])
def test_a_wall_that_stands_elsewhere_is_no_drift(wall_id: str) -> None:
    points, time, scanner = scan(shift=0.012, turn=0.001, moved_wall=wall_id, by=0.03)
    found = by_id(wall_deviations(bodies_of_building(BUILDING), points, bands=BAND, time=time, scanner=scanner))
    assert found[wall_id].shift == pytest.approx(0.03, abs=0.003)
    assert max(abs(wall.bias) for wall in found.values() if wall.id != wall_id) < 0.004


def test_a_straight_map_is_left_alone() -> None:
    points, time, scanner = scan(shift=0.0, turn=0.0)
    found = wall_deviations(bodies_of_building(BUILDING), points, bands=BAND, time=time, scanner=scanner)
    assert max(abs(wall.drift) for wall in found.walls) < 0.001


def test_without_the_path_only_shifts_are_fitted() -> None:
    points, time, _ = scan(shift=0.04, turn=0.0)
    found = wall_deviations(bodies_of_building(BUILDING), points, bands=BAND, time=time)
    assert max(abs(wall.bias) for wall in found.walls) < 0.003


def test_too_little_is_no_drift() -> None:
    none = np.zeros((0, 2))
    assert path_drift(none, none, none[:, 0], none[:, 0].astype(np.int64), none[:, 0]) is None
    points, time, scanner = scan(shift=0.04, turn=0.0)
    few = wall_deviations(bodies_of_building(BUILDING), points[:40], bands=BAND, time=time[:40], scanner=scanner[:40])
    assert "bent" not in few.message


def test_clouds_bring_their_times_and_path() -> None:
    points, time, _ = scan(shift=0.04, turn=0.002)
    at = np.arange(0, DURATION, 0.2)
    cloud = Cloud(points, Frame.identity(), gps_time=time, trajectory=np.column_stack([at, walk(at)]))
    found = against_scan(bodies_of_building(BUILDING), cloud)
    assert "along the path of the scanner" in found.message
    assert max(abs(wall.bias) for wall in found.walls) < 0.004


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-(2**40), 2**40), st.integers(0, 2)), max_size=40))
def test_unique_rows_are_those_of_numpy(rows: list[tuple[int, int, int]]) -> None:
    table = np.array(rows, dtype=np.int64).reshape(-1, 3)
    expected = np.unique(table, axis=0, return_index=True, return_inverse=True, return_counts=True)
    for made, known in zip(unique_rows(table), expected, strict=True):
        assert made.tolist() == known.reshape(made.shape).tolist()
