"""A good file has no findings; every defect is found by the rule it breaks."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import buildings
import ifcopenshell
import pytest
from ifctester import ids

from indoor_bim.errors import ReadError
from indoor_bim.export.ifc import to_ifc, write_ifc
from indoor_bim.quality.check import CheckReport, check_ifc
from indoor_bim.quality.deliverable import deliverable_xml
from indoor_bim.quality.ifc_rules import RULES

Damage = Callable[[ifcopenshell.file], object]


def report_after(damage: Damage, tmp_path: Path, *, schema: str = "IFC4", rules: bool = False) -> CheckReport:
    file = ifcopenshell.file.from_string(to_ifc(buildings.two_rooms(), schema=schema))
    damage(file)
    path = tmp_path / "model.ifc"
    file.write(str(path))
    return check_ifc(path, rules=rules)


def first(file: ifcopenshell.file, kind: str) -> ifcopenshell.entity_instance:
    return file.by_type(kind)[0]


def assign(kind: str, attribute: str, value: object) -> Damage:
    return lambda file: setattr(first(file, kind), attribute, value)


def add_georeference_to_one_context(file: ifcopenshell.file) -> None:
    crs = file.create_entity("IfcProjectedCRS", Name="EPSG:25832")
    context = file.by_type("IfcGeometricRepresentationContext", include_subtypes=False)[0]
    file.create_entity("IfcMapConversion", context, crs, 0.0, 0.0, 0.0)


def remove(kind: str) -> Damage:
    return lambda file: file.remove(first(file, kind))


def add_context(file: ifcopenshell.file) -> None:
    context = file.by_type("IfcGeometricRepresentationContext", include_subtypes=False)[0]
    new = file.create_entity("IfcGeometricRepresentationContext", None, "Model", 3, 1e-5, context.WorldCoordinateSystem)
    project = first(file, "IfcProject")
    project.RepresentationContexts = [*project.RepresentationContexts, new]


def double_the_body(file: ifcopenshell.file) -> None:
    shape = first(file, "IfcSpace").Representation
    shape.Representations = [*shape.Representations, *shape.Representations]


def give_the_storey_a_shape(file: ifcopenshell.file) -> None:
    first(file, "IfcBuildingStorey").Representation = first(file, "IfcSpace").Representation


def repeat_a_point(file: ifcopenshell.file) -> None:
    line = next(curve for curve in file.by_type("IfcPolyline") if len(curve.Points) > 3)
    line.Points = [*line.Points[:2], line.Points[1], *line.Points[2:]]


def cross_an_outline(file: ifcopenshell.file) -> None:
    line = next(curve for curve in file.by_type("IfcPolyline") if len(curve.Points) == 5)
    a, b, c, d, e = line.Points
    line.Points = [a, c, b, d, e]


DAMAGE: dict[str, Damage] = {
    "contexts_have_subcontexts": add_context,
    "spaces_have_one_body": double_the_body,
    "spatial_structure_has_no_shape": give_the_storey_a_shape,
    "elements_stand_in_the_spatial_structure": remove("IfcRelContainedInSpatialStructure"),
    "openings_cut_something": remove("IfcRelVoidsElement"),
    "typed_occurrences_leave_the_predefined_type": assign("IfcWall", "PredefinedType", "SOLIDWALL"),
    "standard_sets_are_standard": assign("IfcPropertySet", "Name", "Pset_IndoorBim"),
    "base_quantities_name_their_method": assign("IfcElementQuantity", "MethodOfMeasurement", "guess"),
    "contexts_share_the_map": add_georeference_to_one_context,
    "spaces_are_not_deprecated": assign("IfcSpace", "PredefinedType", "INTERNAL"),
    "geometry_is_used": lambda file: file.create_entity("IfcDirection", (0.0, 1.0, 0.0)),
    "polylines_repeat_no_point": repeat_a_point,
    "profiles_do_not_cross_themselves": cross_an_outline,
    "units_are_given": lambda file: setattr(first(file, "IfcUnitAssignment"), "Units", file.by_type("IfcSIUnit")[:3]),
}


def test_every_rule_has_a_defect_that_breaks_it() -> None:
    assert set(DAMAGE) == {rule.__name__ for rule in RULES}


@pytest.mark.parametrize("rule", DAMAGE)
def test_a_defect_is_found_by_its_rule(rule: str, tmp_path: Path) -> None:
    report = report_after(DAMAGE[rule], tmp_path, schema="IFC4X3")
    assert rule in {finding.rule for finding in report.findings}
    assert not report.ok


@pytest.mark.parametrize("schema", ["IFC4", "IFC4X3"])
@pytest.mark.parametrize("make", [buildings.four_rooms, buildings.star, buildings.courtyard, buildings.two_storeys, buildings.empty])
def test_written_files_have_no_findings(make: Callable[[], buildings.Building], schema: str, tmp_path: Path) -> None:
    path = tmp_path / "model.ifc"
    write_ifc(make(), path, schema=schema)
    report = check_ifc(path)
    assert report.findings == ()
    assert report.checked == ("schema", "rules", "buildingSMART", "deliverable")
    assert report.schema == {"IFC4": "IFC4", "IFC4X3": "IFC4X3_ADD2"}[schema]


def test_schema_and_express_rules_are_told_apart(tmp_path: Path) -> None:
    missing = report_after(assign("IfcRelFillsElement", "RelatedBuildingElement", None), tmp_path)
    assert {finding.rule for finding in missing.findings} >= {"schema"}
    quick = report_after(assign("IfcWallType", "PredefinedType", "USERDEFINED"), tmp_path)
    assert quick.ok
    full = report_after(assign("IfcWallType", "PredefinedType", "USERDEFINED"), tmp_path, rules=True)
    assert [finding.rule for finding in full.findings] == ["IfcWallType.CorrectPredefinedType"]
    assert "Wall 100" in full.findings[0].entity


def test_the_deliverable_asks_for_evidence_and_names(tmp_path: Path) -> None:
    report = report_after(assign("IfcSpace", "LongName", None), tmp_path)
    assert [(finding.severity, finding.rule) for finding in report.findings] == [
        ("warning", "Spaces are named, measured and belong to a storey")
    ]


def test_the_published_deliverable_is_the_one_that_is_checked() -> None:
    path = Path(__file__).parents[1] / "schemas" / "deliverable.ids"
    assert path.read_text() == deliverable_xml()
    assert len(ids.open(str(path), validate=True).specifications) == 5


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89PNG\r\n" * 50, b"ISO-10303-21;\nHEADER;\n"])
def test_other_files_are_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "other.ifc"
    path.write_bytes(content)
    with pytest.raises(ReadError, match=r"other\.ifc"):
        check_ifc(path)


def test_a_cut_off_file_is_refused(tmp_path: Path) -> None:
    text = to_ifc(buildings.one_room())
    path = tmp_path / "half.ifc"
    path.write_text(text[: text.rindex("\n", 0, len(text) // 2) + 1])
    with pytest.raises(ReadError, match="cut off"):
        check_ifc(path)


@pytest.mark.parametrize("name", ["missing.ifc", "."])
def test_missing_files_and_folders_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="cannot be read"):
        check_ifc(tmp_path / name)


def test_express_rules_need_no_test_framework(tmp_path: Path) -> None:
    path = tmp_path / "model.ifc"
    write_ifc(buildings.one_room(), path)
    code = (
        "import sys; sys.modules['pytest'] = None; sys.modules['_pytest'] = None\n"
        "from indoor_bim.quality.check import check_ifc\n"
        f"print(check_ifc({str(path)!r}).findings, sys.modules['_pytest'])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.stdout == "() None\n", run.stderr
