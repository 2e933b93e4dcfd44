"""Structure, properties, identifiers and georeference of the written IFC."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import buildings
import ifcopenshell
import ifcopenshell.util.element
import ifcopenshell.util.geolocation
import ifcopenshell.util.pset
import ifcopenshell.util.unit
import numpy as np
import pytest
import shapely

import indoor_bim
from indoor_bim.errors import WriteError
from indoor_bim.export.ifc import to_ifc, write_ifc
from indoor_bim.export.ifc_openings import door_operation
from indoor_bim.model import Building, Opening, Storey

SCHEMAS = ["IFC4", "IFC4X3"]


def opened(building: Building, schema: str = "IFC4") -> ifcopenshell.file:
    return ifcopenshell.file.from_string(to_ifc(building, schema=schema))


def guids(file: ifcopenshell.file) -> dict[tuple[str, str], str]:
    return {(element.is_a(), element.Tag): element.GlobalId for element in file.by_type("IfcElement")}


def with_storey(building: Building, change: Callable[[Storey], Storey]) -> Building:
    return replace(building, storeys=tuple(change(storey) for storey in building.storeys))


@pytest.mark.parametrize("schema", SCHEMAS)
def test_equal_buildings_give_equal_bytes(schema: str, tmp_path: Path) -> None:
    one, two = tmp_path / "one.ifc", tmp_path / "two.ifc"
    write_ifc(buildings.four_rooms(), one, schema=schema)
    write_ifc(buildings.four_rooms(), two, schema=schema)
    assert one.read_bytes() == two.read_bytes()
    assert one.read_bytes().isascii()


def test_every_guid_is_there_once() -> None:
    for make in (buildings.four_rooms, buildings.star, buildings.two_storeys):
        file = opened(make())
        ids = [root.GlobalId for root in file.by_type("IfcRoot")]
        assert len(set(ids)) == len(ids)


def test_an_element_keeps_its_guid_when_it_is_measured_anew() -> None:
    building = buildings.two_rooms()
    moved = with_storey(
        building, lambda s: replace(s, walls=tuple(replace(w, height=w.height + 0.01, name="Other") for w in reversed(s.walls)))
    )
    before, after = opened(building), opened(moved)
    assert guids(before) == guids(after)
    assert guids(opened(building, "IFC4X3")) == guids(before)


def test_scans_do_not_share_guids() -> None:
    file, other = opened(buildings.two_rooms()), opened(replace(buildings.two_rooms(), source="other.laz"))
    assert not {root.GlobalId for root in file.by_type("IfcRoot")} & {root.GlobalId for root in other.by_type("IfcRoot")}


@pytest.mark.parametrize("schema", SCHEMAS)
def test_units_are_metres(schema: str) -> None:
    file = opened(buildings.one_room(), schema)
    assert ifcopenshell.util.unit.calculate_unit_scale(file) == 1.0
    assert {unit.Name for unit in file.by_type("IfcSIUnit")} == {"METRE", "SQUARE_METRE", "CUBIC_METRE", "RADIAN"}


def test_spatial_structure() -> None:
    building = buildings.two_storeys()
    file = opened(building)
    house = file.by_type("IfcBuilding")[0]
    assert ifcopenshell.util.element.get_aggregate(house).is_a("IfcSite")
    storeys = ifcopenshell.util.element.get_parts(house)
    assert [(s.Name, s.Elevation) for s in storeys] == [(s.name, s.elevation) for s in building.storeys]
    for storey, entity in zip(building.storeys, storeys, strict=True):
        contained = {element.Tag for element in ifcopenshell.util.element.get_contained(entity)}
        fillings = [opening for wall in storey.walls for opening in wall.openings]
        assert contained == {e.id for e in (*storey.walls, *storey.slabs, *storey.columns, *fillings)}
        spaces = ifcopenshell.util.element.get_parts(entity)
        assert [(s.Name, s.LongName) for s in spaces] == [(r.id, r.name) for r in storey.rooms]


def test_walls_have_one_type_per_thickness_with_centred_layers() -> None:
    building = buildings.two_rooms()
    file = opened(building)
    assert [(t.Name, t.PredefinedType) for t in file.by_type("IfcWallType")] == [("Wall 100", "SOLIDWALL"), ("Wall 300", "SOLIDWALL")]
    thickness = {wall.id: wall.thickness for wall in building.storeys[0].walls}
    for wall in file.by_type("IfcWall"):
        usage = ifcopenshell.util.element.get_material(wall)
        layers = ifcopenshell.util.element.get_material(ifcopenshell.util.element.get_type(wall))
        assert usage.ForLayerSet == layers
        assert sum(layer.LayerThickness for layer in layers.MaterialLayers) == pytest.approx(thickness[wall.Tag])
        assert usage.OffsetFromReferenceLine == pytest.approx(-thickness[wall.Tag] / 2)
        assert wall.PredefinedType is None


def test_nearly_equal_thicknesses_are_different_types_of_the_same_name() -> None:
    building = buildings.one_room()
    thin = {"W1": 0.2004, "W2": 0.2021}
    building = with_storey(building, lambda s: replace(s, walls=tuple(replace(w, thickness=thin.get(w.id, 0.2)) for w in s.walls)))
    file = opened(building)
    assert [(t.Name, t.Description, len(t.Types[0].RelatedObjects)) for t in file.by_type("IfcWallType")] == [
        ("Wall 200", "200 mm", 3),
        ("Wall 200", "202 mm", 1),
    ]


def connections(building: Building) -> set[frozenset[tuple[str, str]]]:
    file = opened(building)
    return {
        frozenset({(r.RelatingElement.Tag, r.RelatingConnectionType), (r.RelatedElement.Tag, r.RelatedConnectionType)})
        for r in file.by_type("IfcRelConnectsPathElements")
    }


def test_corners_and_tees_are_connected() -> None:
    found = connections(buildings.two_rooms())
    assert frozenset({("W1", "ATEND"), ("W2", "ATSTART")}) in found
    assert frozenset({("W1", "ATPATH"), ("W5", "ATSTART")}) in found
    assert len(found) == 6


def test_stubs_at_a_crossing_are_connected_to_the_through_wall_only() -> None:
    found = connections(buildings.four_rooms())
    assert frozenset({("W5", "ATPATH"), ("W6", "ATEND")}) in found
    assert frozenset({("W5", "ATPATH"), ("W7", "ATSTART")}) in found
    assert not any({tag for tag, _ in pair} == {"W6", "W7"} for pair in found)


def test_a_star_connects_all_pairs() -> None:
    found = connections(buildings.star())
    for a, b in (("W7", "W8"), ("W8", "W9"), ("W7", "W9")):
        assert frozenset({(a, "ATSTART"), (b, "ATSTART")}) in found


def test_joints_may_name_walls_that_were_removed() -> None:
    building = with_storey(buildings.two_rooms(), lambda s: replace(s, walls=s.walls[:-1], joints=s.joints * 2))
    assert len(connections(building)) == 4


def test_header_names_the_view_and_the_author() -> None:
    header = opened(buildings.one_room()).header
    assert header.file_description.description == ("ViewDefinition [DesignTransferView_V1.0]",)
    assert (header.file_name.name, header.file_name.time_stamp) == ("House.ifc", "1970-01-01T00:00:00")
    assert header.file_name.originating_system == f"indoor-bim {indoor_bim.__version__}"


def test_wall_axis_is_the_centre_line() -> None:
    building = buildings.diagonal()
    axes = {wall.id: wall.axis for wall in building.storeys[0].walls}
    file = opened(building)
    for wall in file.by_type("IfcWall"):
        shape = next(r for r in wall.Representation.Representations if r.RepresentationIdentifier == "Axis")
        assert (shape.ContextOfItems.ContextType, shape.ContextOfItems.TargetView) == ("Plan", "GRAPH_VIEW")
        placement = wall.ObjectPlacement.RelativePlacement
        origin, along = np.array(placement.Location.Coordinates[:2]), np.array(placement.RefDirection.DirectionRatios[:2])
        ends = [origin + along * point.Coordinates[0] for point in shape.Items[0].Points]
        assert np.array(ends) == pytest.approx(np.array(axes[wall.Tag]), abs=1e-9)


@pytest.mark.parametrize("schema", SCHEMAS)
def test_standard_sets_have_the_names_and_types_of_their_schema(schema: str) -> None:
    file = opened(buildings.four_rooms(), schema)
    templates = ifcopenshell.util.pset.get_template(schema)
    standard = [s for s in file.by_type("IfcPropertySet") if s.Name.startswith("Pset_")]
    assert standard
    for group in standard:
        known = {item.Name: item for item in templates.get_by_name(group.Name).HasPropertyTemplates}
        for item in group.HasProperties:
            values = item.EnumerationValues if item.is_a("IfcPropertyEnumeratedValue") else [item.NominalValue]
            assert {value.is_a() for value in values} == {known[item.Name].PrimaryMeasureType}
    for group in file.by_type("IfcElementQuantity"):
        assert {q.Name for q in group.Quantities} <= {item.Name for item in templates.get_by_name(group.Name).HasPropertyTemplates}
        assert group.MethodOfMeasurement == "BaseQuantities"


@pytest.mark.parametrize("schema", SCHEMAS)
def test_quantities_are_those_of_the_model(schema: str) -> None:
    building = buildings.two_rooms()
    file = opened(building, schema)
    storey = building.storeys[0]
    sets = {element.Tag: ifcopenshell.util.element.get_psets(element, qtos_only=True) for element in file.by_type("IfcElement")}
    spelling = "GrossFootprintArea" if schema == "IFC4" else "GrossFootPrintArea"
    for wall in storey.walls:
        quantities = sets[wall.id]["Qto_WallBaseQuantities"]
        area = shapely.Polygon(wall.footprint).area
        cut = sum(o.width * o.height for o in wall.openings)
        assert quantities["Length"] == pytest.approx(wall.length)
        assert quantities["Width"] == pytest.approx(wall.thickness)
        assert quantities["Height"] == pytest.approx(wall.height)
        assert quantities[spelling] == pytest.approx(area)
        assert quantities["NetSideArea"] == pytest.approx(wall.length * wall.height - cut)
        assert quantities["GrossVolume"] == pytest.approx(area * wall.height)
        assert quantities["NetVolume"] == pytest.approx(area * wall.height - cut * wall.thickness)
    for room, space in zip(storey.rooms, file.by_type("IfcSpace"), strict=True):
        quantities = ifcopenshell.util.element.get_psets(space)["Qto_SpaceBaseQuantities"]
        assert quantities["NetFloorArea"] == pytest.approx(room.area)
        assert quantities["NetVolume"] == pytest.approx(room.area * room.height)
    assert sets["O1"]["Qto_OpeningElementBaseQuantities"]["Volume"] == pytest.approx(1.5 * 2.2 * 0.1)
    windows = {w.Tag: ifcopenshell.util.element.get_psets(w)["Qto_WindowBaseQuantities"]["Area"] for w in file.by_type("IfcWindow")}
    assert windows == pytest.approx({"F1": 1.2 * 1.2, "F2": 2.0 * 1.2})


def test_evidence_goes_with_every_element() -> None:
    file = opened(buildings.four_rooms())
    for element in [*file.by_type("IfcBuiltElement" if file.schema == "IFC4X3" else "IfcBuildingElement"), *file.by_type("IfcSpace")]:
        assert "Support" in ifcopenshell.util.element.get_psets(element)["IndoorBim_Evidence"]
    wall = ifcopenshell.util.element.get_psets(file.by_type("IfcWall")[0])
    found = {key: wall["IndoorBim_Evidence"][key] for key in ("Support", "Coverage", "Rmse", "SidesSeen", "ThicknessMeasured")}
    assert found == {"Support": 1200, "Coverage": 0.8, "Rmse": 0.004, "SidesSeen": 2, "ThicknessMeasured": True}


def test_what_is_not_known_is_not_said() -> None:
    building = with_storey(buildings.one_room(), lambda s: replace(s, walls=tuple(replace(w, external=None) for w in s.walls)))
    file = opened(building)
    for kind in ("Wall", "Door", "Window"):
        common = ifcopenshell.util.element.get_psets(file.by_type(f"Ifc{kind}")[0])[f"Pset_{kind}Common"]
        assert "IsExternal" not in common
        assert common["Status"] == ["EXISTING"]
    known = opened(buildings.two_rooms())
    external = {w.Tag: ifcopenshell.util.element.get_psets(w)["Pset_WallCommon"]["IsExternal"] for w in known.by_type("IfcWall")}
    assert external == {"W1": True, "W2": True, "W3": True, "W4": True, "W5": False}


def test_uncertainty_has_its_standard_set_in_ifc4x3_only() -> None:
    new, old = opened(buildings.one_room(), "IFC4X3"), opened(buildings.one_room())
    found = ifcopenshell.util.element.get_psets(new.by_type("IfcWall")[0])["Pset_Uncertainty"]
    assert (found["UncertaintyBasis"], found["LinearUncertainty"]) == (["MEASUREMENT"], 0.004)
    assert "Pset_Uncertainty" not in ifcopenshell.util.element.get_psets(old.by_type("IfcWall")[0])


@pytest.mark.parametrize(
    ("hinge", "swing", "leaves", "operation"),
    [
        ("start", "left", 1, "SINGLE_SWING_LEFT"),
        ("end", "left", 1, "SINGLE_SWING_RIGHT"),
        ("start", "right", 1, "SINGLE_SWING_RIGHT"),
        ("end", "right", 1, "SINGLE_SWING_LEFT"),
        (None, "left", 2, "DOUBLE_DOOR_SINGLE_SWING"),
        ("start", None, 1, "NOTDEFINED"),
        (None, "left", 1, "NOTDEFINED"),
        (None, None, 0, "NOTDEFINED"),
    ],
)
def test_door_operation(hinge: str | None, swing: str | None, leaves: int, operation: str) -> None:
    door = Opening("D1", "Door", "door", 1.0, 0.9, 0.0, 2.1, hinge, swing, leaves)
    assert door_operation(door) == operation
    file = opened(with_storey(buildings.one_room(), lambda s: replace(s, walls=(replace(s.walls[0], openings=(door,)), *s.walls[1:]))))
    entity = file.by_type("IfcDoor")[0]
    assert entity.OperationType is None
    assert ifcopenshell.util.element.get_type(entity).OperationType == operation
    placed = ifcopenshell.util.placement.get_local_placement(entity.ObjectPlacement)
    # the wall runs along x from x = -0.1: left is +y, and the leaf opens to the door's own +y
    assert placed[:3, 1] == pytest.approx((0, -1 if swing == "right" else 1, 0), abs=1e-9)
    hinge_x = 0.9 if hinge == "start" else 1.8
    if operation.startswith("SINGLE"):
        local = 0.0 if operation.endswith("LEFT") else 0.9
        assert (placed @ (local, 0.0, 0.0, 1.0))[0] == pytest.approx(hinge_x)


def test_a_passage_is_a_void_alone() -> None:
    file = opened(buildings.two_rooms())
    voids = {void.Tag: [r.RelatedBuildingElement for r in void.HasFillings] for void in file.by_type("IfcOpeningElement")}
    assert voids["O1"] == []
    assert {tag: filled[0].is_a() for tag, filled in voids.items() if filled} == {"D1": "IfcDoor", "F1": "IfcWindow", "F2": "IfcWindow"}


def test_rooms_know_the_walls_around_them() -> None:
    building = buildings.two_rooms()
    file = opened(building)
    for room, space in zip(building.storeys[0].rooms, file.by_type("IfcSpace"), strict=True):
        bounds = [b for b in space.BoundedBy if b.RelatedBuildingElement.is_a("IfcWall")]
        assert {b.RelatedBuildingElement.Tag for b in bounds} == set(room.walls)
        inside = {b.RelatedBuildingElement.Tag for b in bounds if b.InternalOrExternalBoundary == "INTERNAL"}
        assert inside == {"W5"}


@pytest.mark.parametrize("schema", SCHEMAS)
def test_a_building_without_storeys_says_why(schema: str) -> None:
    file = opened(buildings.empty(), schema)
    house = file.by_type("IfcBuilding")[0]
    assert house.Description == "No walls were found: the scan shows a ceiling only."
    assert len(file.by_type("IfcProject")) == len(file.by_type("IfcSite")) == 1
    assert not file.by_type("IfcBuildingStorey")
    assert ifcopenshell.util.element.get_psets(house)["IndoorBim_Reconstruction"]["Warnings"] == list(buildings.empty().warnings)


def test_text_of_any_language_comes_back() -> None:
    file = opened(replace(buildings.one_room(), name="Büro 'Süd' 東", warnings=("Öffnung?",)))
    assert file.by_type("IfcBuilding")[0].Name == "Büro 'Süd' 東"


@pytest.mark.parametrize("schema", SCHEMAS)
def test_model_points_lie_where_they_were_scanned(schema: str) -> None:
    building = replace(buildings.moved(buildings.one_room(), yaw=30.0, shift=(432000.5, 5412000.25, 117.5)), crs="EPSG:25832")
    file = opened(building, schema)
    assert len(file.by_type("IfcMapConversion")) == 2
    assert {crs.Name for crs in file.by_type("IfcProjectedCRS")} == {"EPSG:25832"}
    matrix = np.array(building.transform_cloud_to_model)
    for point in ((0.0, 0.0, 0.0), (3.0, 4.0, 1.5)):
        expected = np.linalg.solve(matrix, (*point, 1.0))[:3]
        assert ifcopenshell.util.geolocation.auto_xyz2enh(file, *point) == pytest.approx(tuple(expected), abs=1e-6)
    north = np.array(file.by_type("IfcGeometricRepresentationContext", include_subtypes=False)[0].TrueNorth.DirectionRatios)
    assert matrix[:2, :2] @ (0.0, 1.0) == pytest.approx(north)


@pytest.mark.parametrize("unit", [0.3048, 1200 / 3937])
def test_scans_in_feet_keep_the_feet_of_their_map(unit: float) -> None:
    metric = np.array(buildings.moved(buildings.one_room(), yaw=-20.0, shift=(100000.0, 200000.0, 10.0)).transform_cloud_to_model)
    matrix = metric @ np.diag([unit, unit, unit, 1.0])
    building = replace(buildings.one_room(), crs="EPSG:2263", transform_cloud_to_model=tuple(map(tuple, matrix.tolist())))
    file = opened(building)
    expected = np.linalg.solve(matrix, (3.0, 4.0, 1.5, 1.0))[:3]
    conversion = file.by_type("IfcMapConversion")[0]
    assert (conversion.Eastings, conversion.Northings) == pytest.approx(tuple(np.array((100000.0, 200000.0)) / unit))
    assert conversion.Scale == pytest.approx(1 / unit)
    turn = np.array([[conversion.XAxisAbscissa, -conversion.XAxisOrdinate], [conversion.XAxisOrdinate, conversion.XAxisAbscissa]])
    found = conversion.Scale * turn @ (3.0, 4.0) + (conversion.Eastings, conversion.Northings)
    assert found == pytest.approx(expected[:2])


def test_no_map_without_a_known_reference_system() -> None:
    assert not opened(buildings.moved(buildings.one_room(), yaw=30.0, shift=(4e5, 5e6, 1.0))).by_type("IfcMapConversion")


def test_no_map_for_a_tilted_scan(caplog: pytest.LogCaptureFixture) -> None:
    c, s = math.cos(math.radians(0.5)), math.sin(math.radians(0.5))
    tilted = ((1.0, 0.0, 0.0, 0.0), (0.0, c, -s, 0.0), (0.0, s, c, 0.0), (0.0, 0.0, 0.0, 1.0))
    with caplog.at_level(logging.WARNING):
        file = opened(replace(buildings.one_room(), crs="EPSG:25832", transform_cloud_to_model=tilted))
    assert not file.by_type("IfcMapConversion")
    assert "tilted by 0.50 degrees" in caplog.text


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(WriteError):
        write_ifc(buildings.one_room(), tmp_path / "missing" / "model.ifc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("schema", SCHEMAS)
def test_doors_and_windows_share_types_of_nominal_size(schema: str) -> None:
    def openings(storey: Storey) -> Storey:
        doors = (buildings.door("D1", 0.5, 0.91), buildings.door("D2", 2.0, 0.88), buildings.window("F1", 3.2, 1.21))
        return replace(storey, walls=(replace(storey.walls[0], openings=doors), *storey.walls[1:]))

    file = opened(with_storey(buildings.one_room(), openings), schema)
    types = {door.Tag: ifcopenshell.util.element.get_type(door) for door in (*file.by_type("IfcDoor"), *file.by_type("IfcWindow"))}
    assert {tag: type.Name for tag, type in types.items()} == {
        "D1": "Door 900 x 2100 left",
        "D2": "Door 900 x 2100 left",
        "F1": "Window 1200 x 1200",
    }
    assert types["D1"] == types["D2"]
    assert {door.OverallWidth for door in file.by_type("IfcDoor")} == {0.91, 0.88}


def test_zones_are_rooms_that_doors_and_passages_join() -> None:
    file = opened(buildings.four_rooms())
    (zone,) = file.by_type("IfcZone")
    assert len(zone.IsGroupedBy[0].RelatedObjects) == 4
    assert not opened(buildings.one_room()).by_type("IfcZone")
    file = opened(buildings.two_rooms())
    (two,) = file.by_type("IfcZone")
    assert [space.Name for space in two.IsGroupedBy[0].RelatedObjects] == ["R1", "R2"]


def test_glass_is_clear_and_every_solid_has_a_colour() -> None:
    file = opened(buildings.four_rooms())
    solids = [item for shape in file.by_type("IfcShapeRepresentation") if shape.RepresentationIdentifier == "Body" for item in shape.Items]
    openings = [opening.Representation.Representations[0].Items[0] for opening in file.by_type("IfcOpeningElement")]
    painted = {styled.Item.id() for styled in file.by_type("IfcStyledItem")}
    assert painted == {solid.id() for solid in solids} - {opening.id() for opening in openings}
    window = file.by_type("IfcWindow")[0].Representation.Representations[0].Items
    clear = [item.StyledByItem[0].Styles[0].Styles[0].Transparency for item in window]
    assert max(clear) == pytest.approx(0.6)
    assert min(clear) == 0


def test_guids_of_the_model_are_kept() -> None:
    guid = "0YvctVUKr0kugbFTf53O9L"
    building = with_storey(buildings.one_room(), lambda s: replace(s, walls=(replace(s.walls[0], guid=guid), *s.walls[1:])))
    assert opened(building).by_guid(guid).Tag == building.storeys[0].walls[0].id
