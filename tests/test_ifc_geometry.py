"""The IFC holds the geometry of the model: read back through a geometry kernel that knows nothing of the model."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import buildings
import ifcopenshell
import ifcopenshell.geom
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from indoor_bim.export.ifc import to_ifc
from indoor_bim.model import Building, Wall

FIXTURES = [
    buildings.one_room,
    buildings.two_rooms,
    buildings.four_rooms,
    buildings.star,
    buildings.diagonal,
    buildings.courtyard,
    buildings.two_storeys,
]
Make = Callable[[], Building]
Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


def opened(building: Building, schema: str = "IFC4") -> ifcopenshell.file:
    return ifcopenshell.file.from_string(to_ifc(building, schema=schema))


def mesh(element: ifcopenshell.entity_instance, *, cut: bool = True) -> Mesh:
    settings = ifcopenshell.geom.settings()
    settings.set("use-world-coords", True)
    settings.set("disable-opening-subtractions", not cut)
    shape = ifcopenshell.geom.create_shape(settings, element).geometry
    return np.array(shape.verts).reshape(-1, 3), np.array(shape.faces).reshape(-1, 3)


def volume(solid: Mesh) -> float:
    corners = solid[0][solid[1]]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def by_tag(file: ifcopenshell.file, kind: str) -> dict[str, ifcopenshell.entity_instance]:
    return {element.Tag: element for element in file.by_type(kind)}


def plan(solid: Mesh, z: float) -> shapely.Geometry:
    """Section of a prism at height z: union of its triangles that lie flat at its foot, when z is within it."""
    vertices, faces = solid
    if not vertices[:, 2].min() < z < vertices[:, 2].max():
        return shapely.Polygon()
    flat = [shapely.Polygon(t[:, :2]) for t in vertices[faces] if np.ptp(t[:, 2]) < 1e-6 and t[0, 2] < z]
    return shapely.union_all([t for t in flat if t.area > 1e-9], grid_size=1e-7)


def opening_volume(wall: Wall) -> float:
    return sum(o.width * o.height * wall.thickness for o in wall.openings)


@pytest.mark.parametrize("make", FIXTURES)
def test_wall_volumes_are_footprint_times_height_less_openings(make: Make) -> None:
    building = make()
    walls = [wall for storey in building.storeys for wall in storey.walls]
    file = opened(building)
    found = {tag: volume(mesh(entity)) for tag, entity in by_tag(file, "IfcWall").items()}
    expected = {w.id: shapely.Polygon(w.footprint).area * w.height - opening_volume(w) for w in walls}
    assert found == pytest.approx(expected, rel=1e-6)
    assert sum(found.values()) == pytest.approx(sum(expected.values()), rel=1e-6)


@pytest.mark.parametrize("make", FIXTURES)
def test_no_two_walls_overlap(make: Make) -> None:
    building = make()
    file = opened(building)
    solids = {tag: mesh(entity, cut=False) for tag, entity in by_tag(file, "IfcWall").items()}
    for storey in building.storeys:
        sections = {wall.id: plan(solids[wall.id], storey.elevation + 1.0) for wall in storey.walls}
        assert all(section.area > 0 for section in sections.values())
        for a, b in combinations(sections, 2):
            assert sections[a].intersection(sections[b]).area * storey.height < 1e-6, f"{a} and {b}"


@pytest.mark.parametrize("make", FIXTURES)
def test_walls_stand_where_the_model_has_them(make: Make) -> None:
    building = make()
    file = opened(building)
    for storey in building.storeys:
        for wall in storey.walls:
            solid = mesh(by_tag(file, "IfcWall")[wall.id], cut=False)
            assert solid[0][:, 2].min() == pytest.approx(wall.base, abs=1e-6)
            assert solid[0][:, 2].max() == pytest.approx(wall.base + wall.height, abs=1e-6)
            footprint = shapely.Polygon(wall.footprint)
            assert plan(solid, wall.base + 1.0).symmetric_difference(footprint).area < 1e-5 * footprint.area


@pytest.mark.parametrize("make", FIXTURES)
def test_every_opening_cuts_through_and_is_where_the_model_has_it(make: Make) -> None:
    building = make()
    file = opened(building)
    hosts, voids = by_tag(file, "IfcWall"), by_tag(file, "IfcOpeningElement")
    for wall in (wall for storey in building.storeys for wall in storey.walls):
        (x0, y0), (x1, y1) = wall.axis
        along = np.array([x1 - x0, y1 - y0]) / wall.length
        assert volume(mesh(hosts[wall.id], cut=False)) - volume(mesh(hosts[wall.id])) == pytest.approx(opening_volume(wall), rel=1e-6)
        for opening in wall.openings:
            corners = mesh(voids[opening.id])[0]
            s = (corners[:, :2] - (x0, y0)) @ along
            across = (corners[:, :2] - (x0, y0)) @ (-along[1], along[0])
            assert (s.min(), s.max()) == pytest.approx((opening.start, opening.start + opening.width), abs=1e-6)
            z = corners[:, 2] - wall.base
            assert (z.min(), z.max()) == pytest.approx((opening.sill, opening.sill + opening.height), abs=1e-6)
            assert across.min() < -wall.thickness / 2 - 0.01
            assert across.max() > wall.thickness / 2 + 0.01


@pytest.mark.parametrize("make", FIXTURES)
def test_spaces_slabs_and_columns_are_their_outlines_swept(make: Make) -> None:
    building = make()
    file = opened(building)
    spaces = {space.Name: mesh(space) for space in file.by_type("IfcSpace")}
    slabs = {tag: mesh(slab) for tag, slab in by_tag(file, "IfcSlab").items()}
    columns = {tag: mesh(column) for tag, column in by_tag(file, "IfcColumn").items()}
    for storey in building.storeys:
        for room in storey.rooms:
            assert volume(spaces[room.id]) == pytest.approx(room.area * room.height, rel=1e-6)
            assert spaces[room.id][0][:, 2].min() == pytest.approx(room.floor, abs=1e-6)
        for slab in storey.slabs:
            heights = slabs[slab.id][0][:, 2]
            assert volume(slabs[slab.id]) == pytest.approx(slab.outline.area * slab.thickness, rel=1e-6)
            assert (heights.max() if slab.kind == "floor" else heights.min()) == pytest.approx(slab.level, abs=1e-6)
        for column in storey.columns:
            area = shapely.Polygon(column.footprint).area
            assert volume(columns[column.id]) == pytest.approx(area * column.height, rel=1e-6)


def boundary_area_and_normal(boundary: ifcopenshell.entity_instance) -> tuple[float, tuple[float, ...]]:
    plane = boundary.ConnectionGeometry.SurfaceOnRelatingElement
    outer, *inner = [shapely.Polygon([p.Coordinates for p in ring.Points]) for ring in (plane.OuterBoundary, *plane.InnerBoundaries)]
    return outer.area - sum(hole.area for hole in inner), plane.BasisSurface.Position.Axis.DirectionRatios


@pytest.mark.parametrize("make", FIXTURES)
def test_boundaries_close_every_space(make: Make) -> None:
    """Floor, ceiling and wall surfaces add up to the surface of the space, and all normals point out of it."""
    building = make()
    file = opened(building)
    spaces = {space.Name: space for space in file.by_type("IfcSpace")}
    for room in (room for storey in building.storeys for room in storey.rooms):
        polygon = room.outline.polygon
        wall_area = floor_area = ceiling_area = 0.0
        for boundary in spaces[room.id].BoundedBy:
            area, normal = boundary_area_and_normal(boundary)
            if boundary.RelatedBuildingElement.is_a("IfcWall"):
                wall_area += area
                position = boundary.ConnectionGeometry.SurfaceOnRelatingElement.BasisSurface.Position
                x, y, _ = position.Location.Coordinates
                u, v, _ = position.RefDirection.DirectionRatios
                assert not polygon.contains(shapely.Point(x + 0.01 * u + 0.005 * normal[0], y + 0.01 * v + 0.005 * normal[1]))
                assert polygon.contains(shapely.Point(x + 0.01 * u - 0.005 * normal[0], y + 0.01 * v - 0.005 * normal[1]))
            elif normal[2] < 0:
                floor_area += area
            else:
                ceiling_area += area
        assert wall_area == pytest.approx(polygon.length * room.height)
        assert (floor_area, ceiling_area) == pytest.approx((room.area, room.area))


def test_doors_stay_within_their_openings() -> None:
    file = opened(buildings.four_rooms())
    voids = by_tag(file, "IfcOpeningElement")
    fillings = by_tag(file, "IfcDoor") | by_tag(file, "IfcWindow")
    assert len(fillings) == 5
    for tag, filling in fillings.items():
        body, void = mesh(filling)[0], mesh(voids[tag])[0]
        assert (body.min(0) >= void.min(0) - 1e-6).all()
        assert (body.max(0) <= void.max(0) + 1e-6).all()


def test_a_file_read_back_from_disk_holds_the_same_entities(tmp_path: Path) -> None:
    path = tmp_path / "model.ifc"
    text = to_ifc(buildings.two_rooms())
    path.write_text(text)
    assert len(list(ifcopenshell.open(str(path)))) == len(list(ifcopenshell.file.from_string(text)))
