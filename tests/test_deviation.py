"""Walls against scans and other models: distances, missing walls, extra surfaces, placement."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import buildings
import ifcopenshell
import ifcopenshell.guid
import numpy as np
import pytest

from indoor_bim.cli import main
from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.write import write_las
from indoor_bim.errors import NothingToReconstructError, ReadError
from indoor_bim.export.ifc import write_ifc
from indoor_bim.export.json import write_json
from indoor_bim.frame import Frame
from indoor_bim.model import Building
from indoor_bim.quality.against import against_model, against_scan, read_wall_model
from indoor_bim.quality.deviation import Deviations, WallDeviation, wall_deviations
from indoor_bim.quality.deviation_report import colours, deviation_data, deviation_plan, deviation_table
from indoor_bim.quality.extra_surfaces import extra_surfaces
from indoor_bim.quality.ifc_bodies import bodies_of_ifc
from indoor_bim.quality.wall_bodies import bodies_of_building, face_cells, upright_faces

BAND = [(0.0, buildings.HEIGHT)]


def surface_points(building: Building, *, spacing: float = 0.03, floor: bool = True) -> np.ndarray:
    """Points on the wall faces and floors of a building."""
    points, _, _ = face_cells(upright_faces(bodies_of_building(building).walls), cell=spacing)
    if not floor:
        return points
    rooms = [room.outline.polygon.bounds for room in building.storeys[0].rooms]
    grids = [
        np.stack(np.meshgrid(np.arange(x0, x1, 0.05), np.arange(y0, y1, 0.05), (0.0, buildings.HEIGHT)), -1) for x0, y0, x1, y1 in rooms
    ]
    return np.concatenate([points, *(grid.reshape(-1, 3) for grid in grids)])


def without(building: Building, *ids: str) -> Building:
    storey = building.storeys[0]
    walls = tuple(wall for wall in storey.walls if wall.id not in ids)
    return replace(building, storeys=(replace(storey, walls=walls, joints=()),))


def by_id(deviations: Deviations) -> dict[str, WallDeviation]:
    return {wall.id: wall for wall in deviations.walls}


def turned(points: np.ndarray, degrees: float, shift: tuple[float, float, float]) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]) + shift


def moved(points: np.ndarray, *, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    return points + np.array([0.0, y, z])


def test_a_scan_of_the_model_itself_does_not_deviate() -> None:
    building = buildings.four_rooms()
    deviations = wall_deviations(bodies_of_building(building), surface_points(building), bands=BAND)
    assert len(deviations.walls) == 7
    for wall in deviations.walls:
        assert wall.status == "seen"
        assert wall.covered > 0.97
        assert wall.bias == pytest.approx(0.0, abs=1e-6)
        assert wall.p95 == pytest.approx(0.0, abs=1e-6)
    assert deviations.extra == ()


def test_thickness_and_place_are_told_apart() -> None:
    storey = buildings.one_room().storeys[0]
    (x0, y0), (x1, y1) = storey.walls[0].axis
    model = bodies_of_building(buildings.one_room())
    outer = (x0 + np.arange(0.1, x1 - x0, 0.03))[:, None] * [1, 0, 0]
    heights = np.arange(0.05, 2.45, 0.03)
    grid = np.concatenate([moved(outer, z=z) for z in heights])
    for front, back, thicker, shift in ((0.01, 0.01, 0.02, 0.0), (0.02, -0.02, 0.0, 0.02), (0.03, 0.0, 0.03, 0.015)):
        inside, outside = moved(grid, y=y0 + 0.1 + front), moved(grid, y=y0 - 0.1 - back)
        wall = by_id(wall_deviations(model, np.concatenate([inside, outside]), bands=BAND))["W1"]
        assert wall.thicker == pytest.approx(thicker, abs=1e-4)
        assert wall.shift == pytest.approx(shift, abs=1e-4)
    assert y1 == y0


def test_dense_parts_do_not_outvote_sparse_ones() -> None:
    building = buildings.one_room()
    points = surface_points(building, floor=False)
    near = points[np.hypot(points[:, 0] - 4.0, points[:, 2] - 1.0) < 0.3]
    crowd = np.concatenate([points, *[moved(near, y=0.05)] * 50])
    for wall in wall_deviations(bodies_of_building(building), crowd, bands=BAND).walls:
        assert wall.bias == pytest.approx(0.0, abs=1e-6)


def test_a_wall_that_is_not_there_is_missing_when_its_floor_is_seen() -> None:
    model, built = buildings.two_rooms(), without(buildings.two_rooms(), "W5")
    points = surface_points(built)
    strip = np.stack(np.meshgrid(np.arange(3.95, 4.15, 0.03), np.arange(0, 4, 0.03), [0.0]), -1).reshape(-1, 3)
    seen = by_id(wall_deviations(bodies_of_building(model), np.concatenate([points, strip]), bands=BAND))
    assert seen["W5"].status == "missing"
    assert seen["W1"].status == "seen"
    assert by_id(wall_deviations(bodies_of_building(model), points, bands=BAND))["W5"].status == "not seen"


def test_a_wall_that_the_model_lacks_is_extra() -> None:
    model, built = without(buildings.two_rooms(), "W5"), buildings.two_rooms()
    deviations = wall_deviations(bodies_of_building(model), surface_points(built), bands=BAND)
    assert [wall.status for wall in deviations.walls] == ["seen"] * 4
    assert {round(surface.start[0], 1) for surface in deviations.extra} <= {4.0, 4.1}
    assert sum(surface.length for surface in deviations.extra) == pytest.approx(4.0 - 1.5, abs=0.4)


def test_low_and_short_things_are_no_extra_walls() -> None:
    grid = np.stack(np.meshgrid(np.arange(0, 2, 0.03), [1.0], np.arange(0, 1.8, 0.03)), -1).reshape(-1, 3)
    assert extra_surfaces(grid, floor=0.0, ceiling=2.5) == ()
    assert extra_surfaces(np.zeros((0, 3)), floor=0.0, ceiling=2.5) == ()
    tall = np.stack(np.meshgrid(np.arange(0, 2, 0.03), [1.0], np.arange(0, 2.5, 0.03)), -1).reshape(-1, 3)
    (surface,) = extra_surfaces(tall, floor=0.0, ceiling=2.5)
    assert surface.length == pytest.approx(1.95, abs=0.06)


@pytest.mark.parametrize("degrees", [0.0, 27.0, 143.0, -95.0])
def test_a_scan_in_its_own_frame_is_laid_over_the_model(degrees: float, tmp_path: Path) -> None:
    building = buildings.four_rooms()
    path = tmp_path / "model.ifc"
    write_ifc(building, path)
    file = ifcopenshell.open(path)
    for pset in file.by_type("IfcPropertySet"):
        if pset.Name == "IndoorBim_Reconstruction":
            pset.Name = "Other"
    file.write(str(path))
    scan = turned(surface_points(building), degrees, (31.0, -12.0, 4.0))
    deviations = against_scan(bodies_of_ifc(path), Cloud(scan, Frame.identity()))
    assert "laid over the model by plan" in deviations.message
    assert [wall.status for wall in deviations.walls] == ["seen"] * 7
    assert max(abs(wall.bias) for wall in deviations.walls) < 0.004
    assert deviations.extra == ()


def test_the_matrix_of_the_model_is_believed_where_it_fits() -> None:
    building = buildings.moved(buildings.two_rooms(), yaw=40.0, shift=(100.0, 50.0, 3.0))
    to_scan = np.linalg.inv(np.array(building.transform_cloud_to_model))
    scan = surface_points(buildings.two_rooms()) @ to_scan[:3, :3].T + to_scan[:3, 3]
    deviations = against_scan(bodies_of_building(building), Cloud(scan, Frame.identity()))
    assert deviations.message == "The scan is placed by the matrix of the model."
    assert max(abs(wall.bias) for wall in deviations.walls) < 1e-6


def test_another_building_is_refused() -> None:
    rng = np.random.default_rng(3)
    columns = rng.uniform(0, 30, (60, 2))
    z = np.arange(0, 2.5, 0.03)
    posts = np.concatenate([np.column_stack([np.full_like(z, x), np.full_like(z, y), z]) for x, y in columns])
    floor = np.stack(np.meshgrid(np.arange(0, 30, 0.1), np.arange(0, 30, 0.1), (0.0, 2.5)), -1).reshape(-1, 3)
    model = replace(bodies_of_building(buildings.four_rooms()), scan_to_model=None)
    with pytest.raises(NothingToReconstructError, match="does not fit"):
        against_scan(model, Cloud(np.concatenate([posts, floor]), Frame.identity()))


def test_a_model_against_itself_and_against_a_changed_one() -> None:
    building = buildings.four_rooms()
    one = bodies_of_building(building)
    same = against_model(one, one)
    assert max(abs(wall.bias) for wall in same.walls) < 1e-6
    fewer = against_model(one, bodies_of_building(without(building, "W6")))
    assert {wall.id for wall in fewer.walls if wall.status == "missing"} == {"W6"}
    more = against_model(bodies_of_building(without(building, "W6")), one)
    assert more.extra
    assert not any(wall.status == "missing" for wall in more.walls)


def test_models_in_different_frames_are_brought_together() -> None:
    building = buildings.four_rooms()
    one = bodies_of_building(building)
    bodies = [replace(body, vertices=turned(body.vertices, 61.0, (9.0, -3.0, 0.0))) for body in one.walls]
    other = replace(one, walls=tuple(bodies), others=(), scan_to_model=None)
    deviations = against_model(one, other)
    assert "by plan" in deviations.message
    assert max(abs(wall.bias) for wall in deviations.walls) < 0.004


@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4"])
@pytest.mark.parametrize("unit", ["METRE", "MILLI"])
def test_walls_of_foreign_files_in_any_unit(schema: str, unit: str, tmp_path: Path) -> None:
    path = tmp_path / "foreign.ifc"
    one_wall(schema, milli=unit == "MILLI").write(str(path))
    model = bodies_of_ifc(path)
    (wall,) = model.walls
    np.testing.assert_allclose(wall.vertices.min(axis=0), [0.0, -0.1, 3.0], atol=1e-9)
    np.testing.assert_allclose(wall.vertices.max(axis=0), [4.0, 0.1, 5.5], atol=1e-9)
    assert wall.storey == "Upper"
    assert model.storeys == (("Upper", 3.0),)
    assert model.scan_to_model is None


def one_wall(schema: str, *, milli: bool) -> ifcopenshell.file:
    f = ifcopenshell.file(schema=schema)
    k = 1000.0 if milli else 1.0
    person = f.create_entity("IfcPersonAndOrganization", f.create_entity("IfcPerson"), f.create_entity("IfcOrganization", None, "O"))
    program = f.create_entity("IfcApplication", person.TheOrganization, "1", "A", "A")
    history = f.create_entity("IfcOwnerHistory", person, program, None, "NOCHANGE", None, None, None, 0)

    def root(kind: str, **values: object) -> ifcopenshell.entity_instance:
        return f.create_entity(kind, GlobalId=ifcopenshell.guid.new(), OwnerHistory=history, **values)

    def placement(z: float, relative_to: object = None) -> ifcopenshell.entity_instance:
        return f.create_entity("IfcLocalPlacement", relative_to, f.create_entity("IfcAxis2Placement3D", point(0.0, 0.0, z)))

    def point(*c: float) -> ifcopenshell.entity_instance:
        return f.create_entity("IfcCartesianPoint", tuple(v * k for v in c))

    context = f.create_entity("IfcGeometricRepresentationContext", None, "Model", 3, 1e-5, placement(0.0).RelativePlacement)
    units = [f.create_entity("IfcSIUnit", None, "LENGTHUNIT", "MILLI" if milli else None, "METRE")]
    project = root("IfcProject", Name="P", RepresentationContexts=[context], UnitsInContext=f.create_entity("IfcUnitAssignment", units))
    building = root("IfcBuilding", Name="B", ObjectPlacement=placement(0.0))
    storey = root("IfcBuildingStorey", Name="Upper", Elevation=3.0 * k, ObjectPlacement=placement(3.0, building.ObjectPlacement))
    root("IfcRelAggregates", RelatingObject=project, RelatedObjects=[building])
    root("IfcRelAggregates", RelatingObject=building, RelatedObjects=[storey])
    flat = f.create_entity("IfcAxis2Placement2D", point(2.0, 0.0))
    profile = f.create_entity("IfcRectangleProfileDef", "AREA", None, flat, 4.0 * k, 0.2 * k)
    up = f.create_entity("IfcDirection", (0.0, 0.0, 1.0))
    solid = f.create_entity("IfcExtrudedAreaSolid", profile, placement(0.0).RelativePlacement, up, 2.5 * k)
    shape = f.create_entity("IfcShapeRepresentation", context, "Body", "SweptSolid", [solid])
    body = f.create_entity("IfcProductDefinitionShape", None, None, [shape])
    wall = root("IfcWallStandardCase", Name="W", ObjectPlacement=placement(0.0, storey.ObjectPlacement), Representation=body)
    root("IfcRelContainedInSpatialStructure", RelatedElements=[wall], RelatingStructure=storey)
    return f


def test_files_without_walls_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "empty.ifc"
    write_ifc(buildings.empty(), path)
    with pytest.raises(ReadError, match=r"empty\.ifc: holds no walls"):
        read_wall_model(path)
    with pytest.raises(ReadError, match=r"none\.ifc"):
        read_wall_model(tmp_path / "none.ifc")
    write_json(buildings.empty(), tmp_path / "empty.json")
    with pytest.raises(NothingToReconstructError, match="no walls to measure"):
        against_model(read_wall_model(tmp_path / "empty.json"), bodies_of_building(buildings.one_room()))


@pytest.mark.parametrize("make", [buildings.four_rooms, buildings.star, buildings.diagonal])
def test_faces_of_ifc_and_model_are_the_same(make: Callable[[], Building], tmp_path: Path) -> None:
    path = tmp_path / "model.ifc"
    write_ifc(make(), path)
    deviations = against_model(bodies_of_ifc(path), bodies_of_building(make()))
    assert all(wall.status == "seen" for wall in deviations.walls)
    assert max(wall.p95 for wall in deviations.walls) < 1e-4
    assert {wall.id for wall in deviations.walls} == {wall.id for wall in make().storeys[0].walls}


def test_reports_tell_the_same(tmp_path: Path) -> None:
    building = buildings.two_rooms()
    model = bodies_of_building(building)
    deviations = against_model(model, bodies_of_building(without(building, "W5")))
    data = deviation_data(deviations)
    assert data["summary"]["missing"] == 1
    assert "walls: 4 seen, 0 not seen, 1 missing" in deviation_table(deviations)
    plan = deviation_plan(deviations, model)
    assert plan.count("data-guid") == 5
    assert "Wall W5: missing" in plan


def test_colours_run_from_blue_over_light_to_red() -> None:
    blue, light, red, grey = colours(np.array([-0.2, 0.0, 0.2, np.nan])).astype(int)
    assert blue[2] > blue[0] + 100
    assert red[0] > red[2] + 100
    assert light.min() > 200
    assert np.ptp(grey) == 0


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    building = buildings.two_rooms()
    write_json(building, tmp_path / "model.json")
    write_las(tmp_path / "scan.laz", surface_points(building))
    out = tmp_path / "out"
    assert main(["compare", str(tmp_path / "model.json"), str(tmp_path / "scan.laz"), "-o", str(out), "--json"]) == 0
    captured = capsys.readouterr()
    data = json.loads(captured.out)
    assert data["summary"] == {"seen": 5, "not seen": 0, "missing": 0} | {k: data["summary"][k] for k in ("median_bias", "largest_bias")}
    assert data["summary"]["largest_bias"] < 0.001
    assert sorted(path.name for path in out.iterdir()) == ["deviations.json", "deviations.ply", "deviations.svg"]
    assert json.loads((out / "deviations.json").read_text()) == data
    write_ifc(building, tmp_path / "model.ifc")
    assert main(["compare", str(tmp_path / "model.ifc"), str(tmp_path / "model.json")]) == 0
    assert "5 seen" in capsys.readouterr().out
