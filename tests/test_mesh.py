from dataclasses import replace

import buildings
import numpy as np
import pytest
import shapely
import trimesh

from indoor_bim.export.mesh import Void, building_parts, closed_surface, opening_voids
from indoor_bim.model import Building, Opening, Storey, Wall

MODELS = [
    buildings.one_room,
    buildings.two_rooms,
    buildings.four_rooms,
    buildings.star,
    buildings.diagonal,
    buildings.courtyard,
    buildings.two_storeys,
]


def surface(vertices, triangles) -> trimesh.Trimesh:
    return trimesh.Trimesh(vertices, triangles, process=False, validate=False)


def wall(*openings: Opening) -> Wall:
    return Wall(
        "W", "Wall", ((0.0, 0.0), (5.0, 0.0)), 0.2, True, 1.0, 2.5, ((0.0, -0.1), (5.0, -0.1), (5.0, 0.1), (0.0, 0.1)), None, openings
    )


def parts_of(*walls: Wall):
    return building_parts(Building("B", (Storey("S", "S", 1.0, 2.5, walls),)))


@pytest.mark.parametrize("model", MODELS)
def test_every_element_is_a_closed_outward_surface(model):
    for part in building_parts(model(), spaces=True):
        mesh = surface(part.vertices, part.triangles)
        assert mesh.is_watertight, part.id
        assert mesh.is_winding_consistent, part.id
        assert mesh.volume > 0, part.id
        assert mesh.volume == pytest.approx(part.volume)
        assert mesh.area_faces.min() > 0, part.id


@pytest.mark.parametrize("model", MODELS)
def test_wall_volume_is_footprint_times_height_less_openings(model):
    for storey in model().storeys:
        volumes = {part.id: part.volume for part in building_parts(Building("B", (storey,)))}
        for wall in storey.walls:
            plan = shapely.Polygon(wall.footprint)
            cut = sum(plan.intersection(void.region).area * (void.top - void.bottom) for void in opening_voids(wall))
            assert volumes[wall.id] == pytest.approx(plan.area * wall.height - cut, abs=1e-5)


@pytest.mark.parametrize("model", MODELS)
def test_slab_and_space_volumes_are_area_times_height(model):
    building = model()
    volumes = {part.id: part.volume for part in building_parts(building, spaces=True)}
    for storey in building.storeys:
        for room in storey.rooms:
            assert volumes[room.id] == pytest.approx(room.area * room.height, abs=1e-4)
        for slab in storey.slabs:
            assert volumes[slab.id] == pytest.approx(slab.outline.area * slab.thickness, abs=1e-4)


def test_window_leaves_a_hole_through_the_wall():
    (body, pane) = parts_of(wall(Opening("F", "F", "window", 1.0, 2.0, 0.8, 1.2)))
    mesh = surface(body.vertices, body.triangles)
    assert body.volume == pytest.approx(5 * 0.2 * 2.5 - 2 * 0.2 * 1.2, abs=1e-9)
    assert mesh.euler_number == 0
    assert pane.volume == pytest.approx(2 * 0.02 * 1.2, abs=1e-9)
    assert pane.vertices[:, 2].min() == pytest.approx(1.8)


def test_no_face_lies_inside_the_wall():
    door, window = Opening("D", "D", "door", 0.5, 1.0, 0.0, 2.0), Opening("F", "F", "window", 2.5, 1.5, 0.9, 1.2)
    body = next(part for part in parts_of(wall(door, window)) if part.id == "W")
    mesh = surface(body.vertices, body.triangles)
    sides = 2 * (5 * 2.5 - 1.0 * 2.0 - 1.5 * 1.2)
    ends = 2 * 0.2 * 2.5 + 2 * 0.2 * 5 - 0.2 * 1.0
    reveals = 0.2 * (2 * 2.0 + 1.0) + 0.2 * 2 * (1.5 + 1.2)
    assert mesh.area == pytest.approx(sides + ends + reveals, abs=1e-9)


def test_overlapping_openings_are_cut_once():
    first, second = Opening("A", "A", "opening", 1.0, 2.0, 0.0, 2.0), Opening("B", "B", "opening", 2.0, 2.0, 1.0, 1.2)
    (body,) = parts_of(wall(first, second))
    assert surface(body.vertices, body.triangles).is_watertight
    assert body.volume == pytest.approx(0.2 * (5 * 2.5 - 2 * 2 - 2 * 1.2 + 1 * 1), abs=1e-9)


def test_opening_as_high_as_the_wall_splits_it():
    (body,) = parts_of(wall(Opening("A", "A", "opening", 2.0, 1.0, 0.0, 9.0)))
    mesh = surface(body.vertices, body.triangles)
    assert mesh.is_watertight
    assert mesh.body_count == 2
    assert body.volume == pytest.approx(4 * 0.2 * 2.5, abs=1e-9)


def test_opening_larger_than_the_wall_leaves_its_panel_only():
    ids = [part.id for part in parts_of(wall(Opening("D", "D", "door", 0.0, 6.0, 0.0, 2.5)))]
    assert ids == ["D"]


def test_void_outside_changes_nothing():
    polygon = shapely.box(0, 0, 1, 1)
    plain = closed_surface(polygon, bottom=0, top=1)
    other = closed_surface(polygon, bottom=0, top=1, voids=[Void(shapely.box(0, 0, 1, 1), 2, 3), Void(shapely.box(5, 5, 6, 6), 0, 1)])
    assert surface(*other).volume == pytest.approx(surface(*plain).volume)
    assert surface(*other).is_watertight


def test_polygon_with_hole_and_collinear_corners():
    polygon = shapely.Polygon(
        [(0, 0), (1, 0), (2, 0), (4, 0), (4, 4), (0, 4), (0, 2)], [[(1, 1), (1, 2), (2, 2), (2, 1)], [(2.5, 2.5), (3, 3), (3, 2.5)]]
    )
    mesh = surface(*closed_surface(polygon, bottom=-1, top=1))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(2 * polygon.area, abs=1e-6)
    assert mesh.euler_number == 2 - 2 * 2


def test_hole_that_touches_the_outline():
    polygon = shapely.Polygon([(0, 0), (4, 0), (4, 4), (0, 4), (0, 2)], [[(0, 2), (2, 3), (2, 1)]])
    assert polygon.is_valid
    mesh = surface(*closed_surface(polygon, bottom=0, top=1))
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(polygon.area)


def test_openings_that_touch_at_a_corner():
    lower, upper = Opening("A", "A", "opening", 1.0, 1.0, 0.5, 0.5), Opening("B", "B", "opening", 2.0, 1.0, 1.0, 0.5)
    (body,) = parts_of(wall(lower, upper))
    assert surface(body.vertices, body.triangles).is_watertight
    assert body.volume == pytest.approx(0.2 * (5 * 2.5 - 2 * 0.5), abs=1e-9)


def test_footprint_that_crosses_itself_is_closed_too():
    bow = replace(wall(), footprint=((0.0, -0.1), (5.0, 0.1), (5.0, -0.1), (0.0, 0.1)))
    (body,) = parts_of(bow)
    assert surface(body.vertices, body.triangles).is_watertight
    assert body.volume == pytest.approx(5 * 0.2 / 2 * 2.5, abs=1e-6)


def test_random_openings_keep_the_wall_closed():
    random = np.random.default_rng(3)
    for _ in range(40):
        openings = tuple(
            Opening(f"O{i}", "O", "opening", start, width, sill, height)
            for i, (start, width, sill, height) in enumerate(random.uniform((0, 0.1, 0, 0.1), (5, 2, 2, 2), size=(4, 4)).tolist())
        )
        for part in parts_of(wall(*openings)):
            assert surface(part.vertices, part.triangles).is_watertight


def test_turned_wall_has_the_same_volume():
    openings = (Opening("F", "F", "window", 1.0, 2.0, 0.8, 1.2),)
    straight = wall(*openings)
    angle = np.radians(33)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    ring, axis = (tuple(map(tuple, (np.array(p) @ turn.T + (100, -50)).tolist())) for p in (straight.footprint, straight.axis))
    turned = replace(straight, footprint=ring, axis=axis)
    assert parts_of(turned)[0].volume == pytest.approx(parts_of(straight)[0].volume, abs=1e-4)
