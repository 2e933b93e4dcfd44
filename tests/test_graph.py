from __future__ import annotations

import itertools
from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from plans import FLAT, TWO_ROOMS, faces_of_rooms, turned

from indoor_bim.plan.collinear import merge_collinear
from indoor_bim.plan.graph import _meetings, join_walls, wall_graph
from indoor_bim.plan.joints import footprints
from indoor_bim.plan.raster import Raster, count_raster
from indoor_bim.plan.rooms import known_rooms, observed_share, room_polygons
from indoor_bim.plan.walls import Walls, walls_from_faces


def wall_table(*rows: tuple[tuple[float, float], tuple[float, float], float]) -> Walls:
    n = len(rows)
    return Walls(
        p=np.array([r[0] for r in rows], dtype=float),
        q=np.array([r[1] for r in rows], dtype=float),
        thickness=np.array([r[2] for r in rows]),
        measured=np.ones(n, dtype=bool),
        seen_left=np.ones(n, dtype=bool),
        support=np.full(n, 100),
        coverage=np.ones(n),
        rmse=np.zeros(n),
        top=np.full(n, 2.5),
    )


def overlap_area(polygons: list[shapely.Polygon]) -> float:
    return sum(a.intersection(b).area for a, b in itertools.combinations(polygons, 2))


def joined(*rows):
    walls, meetings = join_walls(wall_table(*rows))
    return walls, meetings, footprints(walls, meetings)


def test_l_joint_is_mitred_at_the_axes_crossing():
    _walls, meetings, outlines = joined(((0.1, 0), (4, 0), 0.2), ((0, 0.1), (0, 3), 0.3))
    assert len(meetings) == 1
    assert meetings[0].point == pytest.approx((0, 0))
    assert sorted(meetings[0].ends) == ["start", "start"]
    expected = 4 * 0.2 + 3 * 0.3  # the square outside both axes makes up for the square inside them
    assert shapely.union_all(outlines).area == pytest.approx(expected, abs=1e-9)
    assert overlap_area(outlines) < 1e-9


def test_t_joint_leaves_the_through_wall_whole():
    walls, meetings, outlines = joined(((0, 0), (6, 0), 0.3), ((2, 0.2), (2, 3), 0.1))
    assert len(walls) == 2
    assert meetings[0].ends == ("path", "start")
    assert outlines[0].area == pytest.approx(6 * 0.3)
    assert outlines[1].area == pytest.approx((3 - 0.15) * 0.1)


def test_x_joint_cuts_the_shorter_wall():
    walls, meetings, outlines = joined(((-3, 0), (4, 0), 0.3), ((0, -2), (0, 2), 0.2))
    assert len(walls) == 3
    assert len(meetings) == 1
    assert overlap_area(outlines) < 1e-9
    assert shapely.union_all(outlines).area == pytest.approx(7 * 0.3 + 4 * 0.2 - 0.3 * 0.2)


def test_y_joint_of_three_walls_has_no_overlap_and_no_hole():
    arms = [((0.05 * np.cos(a), 0.05 * np.sin(a)), (3 * np.cos(a), 3 * np.sin(a)), 0.2) for a in np.radians([90, 210, 330])]
    _walls, _meetings, outlines = joined(*arms)
    union = shapely.union_all(outlines)
    assert overlap_area(outlines) < 1e-9
    assert union.geom_type == "Polygon"
    assert not union.interiors
    assert union.contains(shapely.Point(0, 0).buffer(0.05))


@settings(max_examples=60, deadline=None)
@given(degrees=st.floats(25, 155), first=st.floats(0.06, 0.5), second=st.floats(0.06, 0.5))
def test_any_corner_closes_without_overlap(degrees, first, second):
    a = np.radians(degrees)
    _walls, meetings, outlines = joined(((0, 0), (5, 0), first), ((0, 0), (5 * np.cos(a), 5 * np.sin(a)), second))
    assert len(meetings) == 1
    assert overlap_area(outlines) < 2e-6
    union = shapely.union_all(outlines)
    assert union.buffer(1e-6).contains(shapely.Point(0, 0))
    assert union.geom_type == "Polygon"


def test_a_gap_that_the_scan_left_is_closed():
    _walls, meetings, _ = joined(((0.3, 0), (4, 0), 0.2), ((0, 0.25), (0, 3), 0.2))
    assert meetings[0].point == pytest.approx((0, 0))


def test_ends_far_apart_stay_apart():
    walls, meetings, _ = joined(((1.0, 0), (4, 0), 0.2), ((0, 0.2), (0, 3), 0.2))
    assert not meetings
    np.testing.assert_allclose(walls.p[0], [1.0, 0])


def test_parallel_walls_never_meet():
    assert not joined(((0, 0), (4, 0), 0.2), ((4.1, 0.1), (8, 0.1), 0.2))[1]


def plan_of(faces):
    walls, meetings = join_walls(merge_collinear(walls_from_faces(faces)))
    outlines = footprints(walls, meetings)
    return walls, meetings, outlines, wall_graph(walls, meetings)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0])
def test_rooms_come_back_exactly(degrees):
    _, _, outlines, _graph = plan_of(turned(faces_of_rooms(*FLAT), degrees))
    rooms = room_polygons(outlines)
    truth = [shapely.Polygon(room) for room in FLAT]
    assert len(rooms) == len(truth)
    assert sorted(room.area for room in rooms) == pytest.approx(sorted(room.area for room in truth), abs=2e-3)
    assert overlap_area([*rooms, *outlines]) < 1e-4


def test_graph_is_planar_and_its_edges_cover_the_axes():
    walls, _meetings, _, graph = plan_of(faces_of_rooms(*FLAT))
    assert nx.check_planarity(graph)[0]
    assert sum(data["length"] for _, _, data in graph.edges(data=True)) == pytest.approx(walls.length.sum(), abs=1e-3)
    lines = [shapely.LineString(edge) for edge in graph.edges]
    for a, b in itertools.combinations(lines, 2):
        crossing = a.intersection(b)
        assert crossing.is_empty or crossing.distance(shapely.MultiPoint([*a.coords])) < 1e-3
    assert all(degree >= 2 for _, degree in graph.degree)


def test_rooms_need_loops():
    faces = faces_of_rooms(*TWO_ROOMS)
    open_side = faces.take(~((faces.p[:, 0] == 0) & (faces.q[:, 0] == 0)))
    _, _, outlines, _graph = plan_of(open_side)
    assert [round(room.area, 2) for room in room_polygons(outlines)] == [pytest.approx(4.88 * 3, abs=0.01)]


def test_observed_share_counts_pixels_inside():
    seen = Raster(np.array([[1, 0], [1, 0]]), np.zeros(2), 1.0)
    assert observed_share(shapely.box(0, 0, 2, 2), seen) == 0.5
    assert observed_share(shapely.box(-2, 0, 0, 2), seen) == 0.0


def test_count_raster_matches_a_loop():
    xy = np.random.default_rng(0).uniform(-3, 3, (500, 2))
    raster = count_raster(xy, cell=0.5)
    assert raster.image.sum() == 500
    for point in xy[:50]:
        expected = sum((np.floor(xy / 0.5) == np.floor(point / 0.5)).all(axis=1))
        assert raster.sample(point[None])[0] == expected


def test_walls_keep_their_evidence_when_they_are_joined():
    table = wall_table(((0, 0), (2, 0), 0.2), ((2.02, 0.001), (5, 0.001), 0.2))
    one = merge_collinear(replace(table, support=np.array([10, 30])))
    assert len(one) == 1
    assert one.support.tolist() == [40]
    assert one.length == pytest.approx([5.0])


def test_known_rooms_get_the_faces_of_their_walls():
    _, _, outlines, _ = plan_of(faces_of_rooms(*TWO_ROOMS))
    known = [shapely.box(0.02, 0.01, 3.99, 3.02), shapely.box(4.1, 0, 9, 3)]
    rooms = known_rooms(known, outlines)
    assert [round(room.area, 3) for room in rooms] == [12.0, 14.64]


def test_a_known_room_that_walls_leave_open_keeps_its_outline():
    faces = faces_of_rooms(*TWO_ROOMS)
    _, _, outlines, _ = plan_of(faces.take(~((faces.p[:, 0] == 0) & (faces.q[:, 0] == 0))))
    rooms = known_rooms([shapely.box(-0.5, 0, 4, 3), shapely.box(4.12, 0, 9, 3)], outlines)
    assert rooms[0].area == pytest.approx(13.5, abs=0.1)
    assert overlap_area([*rooms, *outlines]) < 1e-4


def test_a_step_between_parallel_walls_is_closed():
    walls, meetings, outlines = joined(((0, 0), (3, 0), 0.2), ((3.3, 0.1), (6, 0.1), 0.2))
    assert not meetings
    assert shapely.union_all(outlines).geom_type == "Polygon"
    assert walls.length.sum() == pytest.approx(6.0, abs=0.31)
    assert overlap_area(outlines) < 1e-6


def test_an_end_is_prolonged_far_only_when_asked_and_no_more_than_the_wall_is_long():
    rows = ((0.6, 0), (4, 0), 0.2), ((0, 0.5), (0, 3), 0.2), ((-1.2, 5), (-1.0, 5), 0.1)
    assert not join_walls(wall_table(*rows))[1]
    walls, meetings = join_walls(wall_table(*rows), far_snap=1.5)
    assert [meeting.point for meeting in meetings] == [pytest.approx((0, 0), abs=1e-9)]
    assert walls.length.min() == pytest.approx(0.2)


@pytest.mark.parametrize("seed", range(4))
def test_observed_share_is_that_of_the_pixels_one_by_one(seed):
    rng = np.random.default_rng(seed)
    seen = Raster(rng.random((40, 50)) < 0.6, rng.uniform(-1, 1, 2), 0.1)
    hole = shapely.Point(2.0, 2.0).buffer(0.7)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
    polygon = shapely.Polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * 3.5 + 2).difference(hole)
    centres = seen.centre(np.argwhere(np.ones((140, 140))) - 50)
    centres = centres[shapely.contains_xy(polygon, *centres.T)]
    assert observed_share(polygon, seen) == pytest.approx((seen.sample(centres) != 0).mean(), abs=1e-12)


def test_incidences_within_two_centimetres_of_the_first_are_one_corner():
    walls = wall_table(((0, 0), (4, 0), 0.2), ((4, 0), (4, 3), 0.2), ((4, 3), (0, 3), 0.2))
    at = [(4.0, 0.0), (4.019, 0.0), (4.021, 0.0), (3.981, -0.001), (-0.001, 2.999), (0.001, 3.001)]
    met = _meetings(walls, [(np.array(point), 0, k, 1 + k % 2) for k, point in enumerate(at)])
    assert [meeting.point for meeting in met] == [(-0.001, 2.999), (4.0, 0.0), (4.021, 0.0)]
    assert [meeting.walls for meeting in met] == [(0, 1, 2), (0, 1, 2), (0, 1)]
