"""Known buildings: exact tiling of walls and rooms, joints, walks and furniture."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely

from indoor_bim.model import Building, Storey
from indoor_bim.simulate.building import demo_house, office_floor, rounded_house, single_room, two_storeys
from indoor_bim.simulate.furnish import furnish
from indoor_bim.simulate.layout import CurvedPartition, Partition, arc, lay_out_storey
from indoor_bim.simulate.mesh import door_leaves, glass_triangles, shell_triangles
from indoor_bim.simulate.walk import stairs, stations, walk_path

BUILDINGS = [
    demo_house(),
    single_room(),
    single_room(cut_corner=1.5),
    office_floor(),
    office_floor(offices=9, seed=4),
    two_storeys(),
    rounded_house(),
]
each_building = pytest.mark.parametrize("building", BUILDINGS, ids=lambda b: b.name)


def outline(storey: Storey) -> shapely.Polygon:
    return shapely.Polygon(max((slab.outline for slab in storey.slabs), key=lambda o: o.area).exterior)


def openings_area(storey: Storey, *, walkable: bool) -> shapely.Geometry:
    holes = []
    for wall in storey.walls:
        axis = shapely.LineString(wall.axis)
        for o in wall.openings:
            if not walkable or o.kind == "opening" or o.hinge:
                jambs = [axis.interpolate(o.start), axis.interpolate(o.start + o.width)]
                holes.append(shapely.LineString(jambs).buffer(wall.thickness / 2 + 1e-6, cap_style="flat"))
    return shapely.union_all(holes)


@each_building
def test_walls_and_rooms_tile_the_outline(building: Building) -> None:
    for storey in building.storeys:
        walls = [shapely.Polygon(wall.footprint) for wall in storey.walls]
        rooms = [room.outline.polygon for room in storey.rooms]
        assert all(polygon.is_valid for polygon in walls + rooms)
        parts = walls + rooms + [shapely.Polygon(column.footprint) for column in storey.columns]
        for k, part in enumerate(parts):
            assert all(part.intersection(other).area < 1e-9 for other in parts[k + 1 :])
        assert shapely.union_all(parts).symmetric_difference(outline(storey)).area < 1e-9


@each_building
def test_walls_are_as_thick_as_they_say(building: Building) -> None:
    for storey in building.storeys:
        for wall in storey.walls:
            along, across = np.subtract(*wall.axis[::-1]) / wall.length, wall.thickness
            offsets = np.subtract(wall.footprint, wall.axis[0]) @ [-along[1], along[0]]
            assert np.ptp(offsets) == pytest.approx(across, abs=1e-8)
            assert offsets.max() == pytest.approx(across / 2, abs=1e-8)


@each_building
def test_identifiers_are_unique_and_references_hold(building: Building) -> None:
    ids = [s.id for s in building.storeys]
    for storey in building.storeys:
        walls = {wall.id for wall in storey.walls}
        ids += [e.id for group in (storey.walls, storey.rooms, storey.slabs, storey.columns) for e in group]
        ids += [o.id for wall in storey.walls for o in wall.openings]
        assert all(set(joint.walls) <= walls for joint in storey.joints)
        assert all(set(room.walls) <= walls and len(room.walls) >= 3 for room in storey.rooms)
    assert len(ids) == len(set(ids))


@each_building
def test_every_wall_end_is_in_one_joint(building: Building) -> None:
    for storey in building.storeys:
        ends = [(wall, end) for joint in storey.joints for wall, end in zip(joint.walls, joint.ends, strict=True) if end != "path"]
        assert sorted(ends) == sorted((wall.id, end) for wall in storey.walls for end in ("start", "end"))


@each_building
def test_openings_lie_in_their_walls_clear_of_each_other_and_of_other_walls(building: Building) -> None:
    for storey in building.storeys:
        for wall in storey.walls:
            spans = sorted((o.start, o.start + o.width) for o in wall.openings)
            assert all(a[1] <= b[0] for a, b in itertools.pairwise(spans))
            assert all(o.sill + o.height < wall.height for o in wall.openings)
            axis = shapely.LineString(wall.axis)
            for start, end in spans:
                hole = shapely.LineString([axis.interpolate(start), axis.interpolate(end)]).buffer(
                    wall.thickness / 2 + 0.01, cap_style="flat"
                )
                others = [shapely.Polygon(other.footprint) for other in storey.walls if other.id != wall.id]
                assert not any(hole.intersection(other).area > 1e-9 for other in others)
                assert shapely.Polygon(wall.footprint).intersection(hole).area == pytest.approx((end - start) * wall.thickness)


def test_seeds_of_the_office_floor() -> None:
    assert office_floor(seed=7) == office_floor(seed=7)
    assert office_floor(seed=7) != office_floor(seed=8)


def test_corner_of_partitions_is_filled_once() -> None:
    storey = lay_out_storey(
        1,
        [(0, 0), (6, 0), (6, 5), (0, 5)],
        0.3,
        [[], [], [], []],
        [Partition((4, 0), (4, 2), 0.1), Partition((4, 2), (6, 2), 0.2)],
        [("Store", (5, 1)), ("Room", (2, 2))],
    )
    areas = [shapely.Polygon(wall.footprint).area for wall in storey.walls[4:]]
    assert areas == pytest.approx([0.1 * (2 - 0.15 + 0.1), 0.2 * (2 - 0.15 - 0.05)])


def test_layout_refuses_what_does_not_close() -> None:
    ring = [(0.0, 0.0), (6.0, 0.0), (6.0, 5.0), (0.0, 5.0)]
    crossing = [Partition((3, 0), (3, 5), 0.1), Partition((0, 2), (6, 2), 0.1)]
    with pytest.raises(ValueError, match="partition 1 falls apart"):
        lay_out_storey(1, ring, 0.3, [[], [], [], []], crossing, [("Room", (1, 1))])
    with pytest.raises(ValueError, match="2 rooms, 1 names"):
        lay_out_storey(1, ring, 0.3, [[], [], [], []], crossing[:1], [("Room", (1, 1))])


def is_solid(storey: Storey, points: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) lie in a wall and in none of its openings: straight from the model."""
    solid = np.zeros(len(points), dtype=bool)
    for wall in storey.walls:
        u = np.subtract(points[:, :2], wall.axis[0]) @ np.subtract(*wall.axis[::-1]) / wall.length
        inside = shapely.contains_xy(shapely.Polygon(wall.footprint), points[:, :2])
        for o in wall.openings:
            z = points[:, 2] - wall.base
            inside &= ~((u > o.start) & (u < o.start + o.width) & (z > o.sill) & (z < o.sill + o.height))
        solid |= inside
    for column in storey.columns:
        solid |= shapely.contains_xy(shapely.Polygon(column.footprint), points[:, :2])
    return solid


def is_enclosed(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether an upright ray from each point (n, 3) leaves the surface an odd number of times, triangle by triangle."""
    crossings = np.zeros(len(points), dtype=np.int64)
    for a, b, c in triangles:
        (x1, y1), (x2, y2), offset = (b - a)[:2], (c - a)[:2], points[:, :2] - a[:2]
        area = x1 * y2 - x2 * y1
        if abs(area) > 1e-12:
            u, v = (offset[:, 0] * y2 - offset[:, 1] * x2) / area, (offset[:, 1] * x1 - offset[:, 0] * y1) / area
            crossings += (u > 0) & (v > 0) & (u + v < 1) & (a[2] + u * (b - a)[2] + v * (c - a)[2] > points[:, 2])
    return crossings % 2 == 1


@each_building
def test_mesh_is_solid_where_the_model_is(building: Building) -> None:
    triangles = shell_triangles(building)
    rng = np.random.default_rng(0)
    for storey in building.storeys:
        low, high = np.reshape(outline(storey).bounds, (2, 2))
        points = rng.uniform([*low, storey.elevation], [*high, storey.elevation + storey.height], size=(5000, 3))
        solid = is_solid(storey, points)
        assert solid.sum() > 400
        assert np.array_equal(is_enclosed(triangles, points), solid)


def test_glass_fills_the_windows() -> None:
    for building in BUILDINGS:
        a, b, c = np.moveaxis(glass_triangles(building), 1, 0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        windows = [o for s in building.storeys for w in s.walls for o in w.openings if o.kind == "window"]
        assert area == pytest.approx(sum(o.width * o.height for o in windows))


@each_building
def test_walk_goes_through_all_reachable_rooms_and_through_no_wall(building: Building) -> None:
    path = walk_path(building)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps.max() < 0.06
    for storey in building.storeys:
        here = path[np.abs(path[:, 2] - storey.elevation) < 1e-3]
        solid = shapely.union_all([shapely.Polygon(wall.footprint) for wall in storey.walls]).difference(
            openings_area(storey, walkable=True)
        )
        assert shapely.distance(solid, shapely.points(here[:, :2])).min() > 0.15
        visited = {room.name for room in storey.rooms if shapely.contains_xy(room.outline.polygon, here[:, :2]).any()}
        assert visited == {room.name for room in storey.rooms}


def test_walk_climbs_the_stair() -> None:
    (flight,) = stairs(two_storeys())
    path = walk_path(two_storeys())
    climbing = path[(path[:, 2] > 0.3) & (path[:, 2] < 2.5)]
    line = shapely.LineString([flight.foot, flight.head])
    assert len(climbing) > 40
    assert shapely.distance(line, shapely.points(climbing[:, :2])).max() < 0.05


def test_stations_stand_in_every_room() -> None:
    for building in BUILDINGS:
        tripods = stations(building)
        for storey in building.storeys:
            here = tripods[tripods[:, 2] == storey.elevation][:, :2]
            counts = [shapely.contains_xy(room.outline.polygon, here).sum() for room in storey.rooms]
            assert min(counts) >= 1
    corridor = office_floor(offices=9).storeys[0].rooms[0].outline.polygon
    assert shapely.contains_xy(corridor, stations(office_floor(offices=9))[:, :2]).sum() >= 5


@each_building
def test_furniture_stands_in_rooms_clear_of_doors_and_walk(building: Building) -> None:
    path = walk_path(building)
    leaves = door_leaves(building, rng=np.random.Generator(np.random.PCG64(0)))
    boxes = furnish(building, path, leaves, rng=np.random.Generator(np.random.PCG64(1)))
    assert boxes == furnish(building, path, leaves, rng=np.random.Generator(np.random.PCG64(1)))
    assert boxes
    for storey in building.storeys:
        feet = shapely.points(path[np.abs(path[:, 2] - storey.elevation) < 1e-3, :2])
        solid = shapely.union_all([shapely.Polygon(wall.footprint) for wall in storey.walls])
        for box in boxes:
            if storey.elevation - 1e-6 <= box.bottom and box.top <= storey.elevation + storey.height:
                assert not box.outline.intersects(solid)
                assert shapely.distance(box.outline, feet).min() > 0.15
                assert not any(box.outline.intersects(leaf.outline) for leaf in leaves if abs(leaf.bottom - storey.elevation) < 0.1)


@pytest.mark.parametrize("radius", [0.8, 2.5, 12.0])
def test_the_points_of_an_arc_keep_to_it(radius: float) -> None:
    points = np.array(arc((1.0, 1.0), (1.5, 2.2), radius, sagitta=0.002))
    middle = (points[1:] + points[:-1]) / 2
    chord = np.hypot(*np.subtract((1.5, 2.2), (1.0, 1.0)))
    centre = (points[0] + points[-1]) / 2 + np.array([-1.2, 0.5]) / chord * np.sqrt(radius**2 - chord**2 / 4)
    assert np.hypot(*(points - centre).T) == pytest.approx(np.full(len(points), radius), abs=1e-8)
    assert radius - 0.002 <= np.hypot(*(middle - centre).T).min() < radius
    with pytest.raises(ValueError, match="does not reach"):
        arc((0.0, 0.0), (3.0, 0.0), 1.0)


def test_a_round_room_in_a_square_one() -> None:
    ring = [(0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0)]
    circle = [*arc((6.0, 4.0), (2.0, 4.0), 2.0), *arc((2.0, 4.0), (6.0, 4.0), 2.0)[1:]]
    rooms = [("Hall", (1.0, 1.0)), ("Round room", (4.0, 4.0))]
    storey = lay_out_storey(1, ring, 0.3, [[]] * 4, [CurvedPartition(tuple(circle), 0.2)], rooms)
    assert storey.rooms[1].area == pytest.approx(np.pi * 1.9**2, rel=0.002)
    assert storey.rooms[0].area == pytest.approx(7.7**2 - np.pi * 2.1**2, rel=0.002)
    assert {len(joint.walls) for joint in storey.joints} == {2}


def test_tripods_stand_all_around_a_room_within_another() -> None:
    building = rounded_house()
    hall = building.storeys[0].rooms[0].outline.polygon
    inside = [shapely.Point(xy) for xy in stations(building)[:, :2] if hall.contains(shapely.Point(xy))]
    assert len(inside) >= 4
    assert shapely.MultiPoint(inside).convex_hull.contains(shapely.Point(4.6, 4.6))
