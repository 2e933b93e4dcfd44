"""Levels of rooms and the underside of roofs, on surfaces with exact answers."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from plans import box, faces_of_rooms
from test_auto import scan_of_two_rooms

from indoor_bim.auto import storey_plans
from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.levels import level
from indoor_bim.pipeline import reconstruct
from indoor_bim.plan.roof import ridge_height, roof_surface, under_the_eaves
from indoor_bim.plan.room_levels import room_levels
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.storeys import storey_from_plan

ROOM = shapely.box(0, 0, 5, 4)


def plate(low, high, height, *, step=0.05):
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])


def levels_of(*plates, **limits):
    (found,) = room_levels(np.vstack(plates), [ROOM], floor=0.0, ceiling=2.6, **limits)
    return found


def test_lowered_ceiling_below_the_slab():
    assert levels_of(plate((0, 0), (5, 4), 0.0), plate((0, 0), (5, 4), 2.3), plate((0, 0), (2, 4), 2.6)) == pytest.approx((0.0, 2.3))


def test_podium_of_half_the_room_leaves_the_floor():
    assert levels_of(plate((0, 0), (2.5, 4), -0.3), plate((2.5, 0), (5, 4), 0.0), plate((0, 0), (5, 4), 2.6)) == pytest.approx((-0.3, 2.6))


def test_a_table_and_a_cupboard_are_no_levels():
    furniture = plate((1, 1), (3, 3), 0.75), plate((0, 0), (1, 2), 2.0)
    assert levels_of(plate((0, 0), (5, 4), 0.2), plate((0, 0), (5, 4), 2.6), *furniture) == pytest.approx((0.2, 2.6))


def test_drift_is_no_step():
    assert levels_of(plate((0, 0), (5, 4), 0.03), plate((0, 0), (5, 4), 2.57)) == (0.0, 2.6)


def test_storeys_below_and_above_are_not_looked_at():
    neighbours = plate((0, 0), (5, 4), -0.3), plate((0, 0), (5, 4), 2.9)
    assert levels_of(*neighbours, plate((0, 0), (1, 1), 0.0), low=-0.3, high=2.9) == (0.0, 2.6)


def gable_roof(rng, *, ridge=4.0, eaves=0.4, width=8.0, depth=6.0, count=120_000):
    """Points on the floor and under a roof whose ridge runs along x."""
    x, y = rng.uniform(0, width, count), rng.uniform(0, depth, count)
    z = ridge - (ridge - eaves) * np.abs(2 * y / depth - 1)
    points = np.vstack([np.column_stack([x, y, z]), plate((0, 0), (width, depth), 0.0)])
    return points + rng.normal(0, 0.003, points.shape)


def test_roof_is_followed_between_its_cells():
    roof = roof_surface(gable_roof(np.random.default_rng(5)), floor=0.0, top=6.0)
    y = np.array([1.03, 1.58, 2.11, 4.44, 4.91])
    expected = 4.0 - 3.6 * np.abs(y / 3 - 1)
    np.testing.assert_allclose(roof.sample(np.column_stack([np.full(5, 4.0), y]), outside=np.nan), expected, atol=0.04)
    assert ridge_height(roof) == pytest.approx(4.0, abs=0.12)


def test_no_roof_over_a_fraction_of_the_floor():
    points = gable_roof(np.random.default_rng(5))
    assert roof_surface(points[(points[:, 2] < 0.1) | (points[:, 0] < 2)], floor=0.0, top=6.0) is None


def test_walls_under_the_eaves_are_too_low():
    roof = roof_surface(gable_roof(np.random.default_rng(5)), floor=0.0, top=6.0)
    p, q = np.array([[0.0, 0.05], [8.0, 0.0]]), np.array([[8.0, 0.05], [8.0, 6.0]])
    assert under_the_eaves(p, q, roof, floor=0.0).tolist() == [True, False]


@pytest.fixture(scope="module")
def attic():
    """Attic with gable walls, knees of 60 cm and a ridge at 4 m."""
    rng = np.random.default_rng(6)
    points = [gable_roof(rng, eaves=0.6)]
    for x in (0.0, 8.0):
        y, z = rng.uniform(0, 6, 40_000), rng.uniform(0, 4, 40_000)
        under = z < 4.0 - 3.4 * np.abs(y / 3 - 1)
        points.append(np.column_stack([np.full(under.sum(), x), y[under], z[under]]) + rng.normal(0, 0.003, (under.sum(), 3)))
    for y in (0.0, 6.0):
        points.append(np.column_stack([rng.uniform(0, 8, 5_000), np.full(5_000, y), rng.uniform(0, 0.6, 5_000)]))
    return np.vstack(points)


def test_attic_is_one_room_between_gable_walls(attic):
    (plan,) = storey_plans(level(Cloud(attic)))
    (room,) = plan.rooms
    assert room.area == pytest.approx(48.0, abs=0.5)
    made = storey_from_plan(plan).storey
    assert len(made.walls) == 2
    assert made.height == pytest.approx(4.0, abs=0.12)
    assert [slab.kind for slab in made.slabs] == ["floor"]


def test_rooms_carry_their_levels_into_the_model():
    outlines = (box(0, 0, 4, 4), box(4.1, 0, 8, 4))
    rooms = tuple(shapely.Polygon(outline) for outline in outlines)
    plan = StoreyPlan(faces_of_rooms(*outlines), 0.0, 2.6, rooms=rooms, room_levels=((0.0, 2.6), (0.35, 2.4)))
    made = storey_from_plan(plan).storey
    assert [(room.floor, round(room.height, 6)) for room in made.rooms] == [(0.0, 2.6), (0.35, 2.05)]
    plates = {(slab.kind, slab.level): slab.outline.polygon for slab in made.slabs}
    assert sorted(plates) == [("ceiling", 2.4), ("ceiling", 2.6), ("floor", 0.0), ("floor", 0.35)]
    assert plates["floor", 0.35].area == pytest.approx(made.rooms[1].area)
    assert plates["floor", 0.0].intersection(plates["floor", 0.35]).area < 1e-6


def test_ground_under_the_eaves_is_no_storey():
    rng = np.random.default_rng(3)
    house, _, _ = scan_of_two_rooms()
    ground = plate((-2.0, -3.0), (9.0, -0.5), -3.2), plate((-2.0, -2.0), (9.0, -0.5), 0.8)
    outside = np.vstack(ground) + rng.normal(0, 0.003, (sum(map(len, ground)), 3))
    points = np.vstack([house, outside])
    assert len(level(Cloud(points)).storeys) == 2
    (storey,) = reconstruct(points).building.storeys
    assert (storey.elevation, len(storey.rooms)) == (pytest.approx(0.0, abs=1e-6), 2)
