"""Outlines behind built-in furniture: exact answers."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import shapely.affinity

from indoor_bim.auto import _behind_built_ins
from indoor_bim.plan.built_in import without_built_ins
from indoor_bim.plan.room_outlines import OutlineRing, RoomOutline

ROOM = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))


def box_at_wall(depth, width):
    return ((0.0, 0.0), (1.0, 0.0), (1.0, depth), (1.0 + width, depth), (1.0 + width, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))


def box_in_corner(depth, width):
    return ((0.0, 0.0), (4.0 - width, 0.0), (4.0 - width, depth), (4.0, depth), (4.0, 3.0), (0.0, 3.0))


@pytest.mark.parametrize("outline", [box_at_wall(0.6, 1.2), box_in_corner(0.6, 1.2), box_in_corner(1.2, 0.6)])
@pytest.mark.parametrize("first", range(6))
def test_wall_goes_on_behind_furniture(outline, first):
    turned = (*outline[first:], *outline[:first])
    assert shapely.Polygon(without_built_ins(turned)).equals_exact(shapely.Polygon(ROOM), 1e-9) or shapely.Polygon(
        without_built_ins(turned)
    ).equals(shapely.Polygon(ROOM))


@pytest.mark.parametrize("outline", [box_at_wall(1.2, 1.2), box_at_wall(0.15, 1.2), box_at_wall(0.6, 2.9), box_in_corner(1.5, 1.5), ROOM])
def test_other_shapes_stay(outline):
    assert without_built_ins(outline) == outline


def test_only_scattered_points_close_to_the_wall_are_a_curtain():
    outline = box_at_wall(0.12, 1.5)
    folded = [k == 2 for k in range(len(outline))]
    assert shapely.Polygon(without_built_ins(outline, folded=folded)).equals(shapely.Polygon(ROOM))


def test_a_room_does_not_run_into_the_closet_in_its_corner():
    rings = [box_at_wall(0.6, 1.2), tuple((x + 20, y) for x, y in box_at_wall(0.6, 1.2)), ((1.1, 0.1), (2.0, 0.1), (2.0, 0.5), (1.1, 0.5))]
    rooms = [RoomOutline(OutlineRing(ring, (0,) * len(ring))) for ring in rings]
    with_closet, without, closet = _behind_built_ins(rooms, np.zeros(1, dtype=bool))
    assert with_closet.exterior.corners == rings[0]
    assert without.polygon.equals(shapely.affinity.translate(shapely.Polygon(ROOM), 20))
    assert closet.exterior.corners == rings[2]


def test_other_rooms_stay():
    outline = box_at_wall(0.6, 1.2)
    assert without_built_ins(outline, others=shapely.box(1.1, 0.1, 2.0, 0.5)) == outline
