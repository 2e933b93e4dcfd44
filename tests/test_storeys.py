"""From faces to a storey: what the stages do together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from plans import box, faces_of_rooms

from indoor_bim.plan.rooms import known_rooms, reading_order
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.storeys import storey_from_plan

THREE_ROOMS = (box(0, 0, 3, 4), box(3.10, 0, 6, 4), box(6.12, 0, 9, 4))


def storey(rmse: float):
    faces = faces_of_rooms(*THREE_ROOMS)
    plan = StoreyPlan(replace(faces, rmse=np.full(len(faces), rmse)), floor=0.0, ceiling=2.5)
    return storey_from_plan(plan).storey


def test_thicknesses_that_the_scan_cannot_tell_apart_are_shared():
    assert [wall.thickness for wall in storey(0.03).walls if wall.thickness_measured] == pytest.approx([0.11, 0.11])


def test_an_accurate_scan_keeps_every_thickness():
    assert [wall.thickness for wall in storey(0.001).walls if wall.thickness_measured] == pytest.approx([0.10, 0.12])


def test_rooms_heights_and_outer_walls():
    made = storey(0.001)
    assert sorted(room.area for room in made.rooms) == pytest.approx([11.52, 11.6, 12.0], abs=0.01)
    assert made.height == 2.5
    assert sum(wall.external is True for wall in made.walls) == 4
    assert sum(wall.external is False for wall in made.walls) == 2


def test_a_room_has_no_spike_between_walls_that_all_but_touch():
    spiked = shapely.Polygon([(-0.011, 5), (0, 5), (0, 0), (8, 0), (8, 5.02)])
    (room,) = known_rooms([spiked], [shapely.box(20, 0, 21, 1)])
    assert len(room.exterior.coords) == 5
    assert room.bounds[0] == pytest.approx(0, abs=0.002)
    whole = shapely.box(0, 0, 4, 3)
    assert known_rooms([whole], [shapely.box(20, 0, 21, 1)])[0].equals(whole)


@pytest.mark.parametrize("seed", range(5))
def test_rooms_are_numbered_as_one_reads(seed):
    """Two rows of rooms on either side of a corridor, one room twice as deep as its neighbours."""
    north = [shapely.box(5 * k, 9, 5 * k + 4.8, 14 + 0.004 * k) for k in range(5)]
    south = [shapely.box(5 * k, 0 if k != 2 else 3, 5 * k + 4.8, 6) for k in range(5)]
    rooms = [*north, shapely.box(0, 6.2, 25, 8.8), *south]
    mixed = np.random.default_rng(seed).permutation(len(rooms))
    order = reading_order([rooms[k] for k in mixed])
    assert [int(mixed[k]) for k in order] == list(range(11))
    assert reading_order([]) == []
