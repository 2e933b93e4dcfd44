"""From a scan with a place on the map to all files, by the command line."""

from __future__ import annotations

import json
from pathlib import Path

import ifcopenshell
import ifcopenshell.util.geolocation
import numpy as np
import pytest
import shapely

from indoor_bim.cli import main
from indoor_bim.export.json import read_json
from indoor_bim.model import Building
from indoor_bim.outputs import failed_checks
from indoor_bim.params import SimulateParams
from indoor_bim.simulate import simulate, single_room, write_scan

ORIGIN = (500_123.0, 5_400_456.0, 210.0)
KINDS = "ifc,svg,dxf,obj,ply,gltf,geojson,pdf,png,json"


@pytest.fixture(scope="module")
def scanned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scanned")
    params = SimulateParams(map_tilt=0.0, map_yaw=30.0, map_origin=ORIGIN)
    write_scan(simulate(single_room(), profile="clean", points=40_000, seed=1, params=params), folder)
    return folder


@pytest.fixture(scope="module")
def delivered(scanned: Path) -> Path:
    arguments = ["reconstruct", str(scanned / "scan.laz"), "-o", str(scanned / "out"), "--to", KINDS, "--crs", "EPSG:25832", "-q"]
    assert main([*arguments, "--set", "drawing.underlay=true", "--set", "ifc.version=IFC4X3"]) == 0
    return scanned / "out"


def wall_corners(building: Building) -> np.ndarray:
    walls = building.storeys[0].walls
    outline = shapely.union_all([shapely.Polygon(wall.footprint) for wall in walls]).convex_hull
    return np.array(shapely.minimum_rotated_rectangle(outline).exterior.coords)


def test_every_kind_is_there(delivered: Path) -> None:
    kinds = {"model": ("ifc", "json", "obj", "mtl", "ply", "glb", "geojson"), "plan": ("svg", "dxf", "pdf", "png")}
    expected = {f"{stem}.{ending}" for stem, endings in kinds.items() for ending in endings} | {"params.toml"}
    assert {path.name for path in delivered.iterdir()} == expected


def test_the_ifc_lies_on_the_map(scanned: Path, delivered: Path) -> None:
    file = ifcopenshell.open(delivered / "model.ifc")
    assert file.schema_identifier == "IFC4X3_ADD2"
    truth, found = read_json(scanned / "truth.json"), read_json(delivered / "model.json")
    to_map = np.linalg.inv(np.array(truth.transform_cloud_to_model))
    expected = np.column_stack([wall_corners(truth), np.zeros(5), np.ones(5)]) @ to_map.T
    placed = np.array([ifcopenshell.util.geolocation.auto_xyz2enh(file, x, y, 0.0) for x, y in wall_corners(found)])
    for corner in expected[:, :2]:
        assert np.linalg.norm(placed[:, :2] - corner, axis=1).min() < 0.02
    to_scan = np.linalg.inv(np.array(found.transform_cloud_to_model))
    np.testing.assert_allclose(placed, (np.column_stack([wall_corners(found), np.zeros(5), np.ones(5)]) @ to_scan.T)[:, :3], atol=0.01)


def test_geojson_lies_at_the_same_place(delivered: Path) -> None:
    file = ifcopenshell.open(delivered / "model.ifc")
    found = read_json(delivered / "model.json")
    wall = found.storeys[0].walls[0]
    document = json.loads((delivered / "model.geojson").read_text())
    (feature,) = [f for f in document["features"] if f["id"] == wall.id]
    ring = np.array(feature["geometry"]["coordinates"][0])
    for x, y in wall.footprint:
        east, north, _ = ifcopenshell.util.geolocation.auto_xyz2enh(file, x, y, 0.0)
        assert np.hypot(*(ring - (east, north)).T).min() < 1e-3


def test_the_scan_lies_under_the_plan(delivered: Path) -> None:
    assert '<image id="underlay"' in (delivered / "plan.svg").read_text()


def test_the_model_says_nothing_against_itself(delivered: Path, tmp_path: Path) -> None:
    assert failed_checks(delivered) == ()
    assert failed_checks(tmp_path) == ()
    broken = (delivered / "model.ifc").read_text().replace("IFCSPACE('", "IFCSPACE('x", 1)
    (tmp_path / "model.ifc").write_text(broken)
    assert any("model.ifc does not keep to the rule" in doubt for doubt in failed_checks(tmp_path))


def test_a_second_run_keeps_guids_and_bytes(scanned: Path, delivered: Path) -> None:
    again = scanned / "again"
    arguments = ["reconstruct", str(scanned / "scan.laz"), "-o", str(again), "--to", "ifc,json", "--crs", "EPSG:25832", "-q"]
    assert main([*arguments, "--set", "ifc.version=IFC4X3"]) == 0
    assert (again / "model.ifc").read_bytes() == (delivered / "model.ifc").read_bytes()


def test_a_hand_edited_model_goes_through(delivered: Path, tmp_path: Path) -> None:
    document = json.loads((delivered / "model.json").read_text())
    document["storeys"][0]["rooms"][0]["name"] = "Küche"
    document["storeys"][0]["walls"][0]["external"] = False
    (tmp_path / "edited.json").write_text(json.dumps(document), encoding="utf-8")
    assert main(["export", str(tmp_path / "edited.json"), "--to", "ifc,svg,dxf,geojson", "--schema", "IFC4", "--theme", "dark", "-q"]) == 0
    file = ifcopenshell.open(tmp_path / "edited.ifc")
    assert file.by_type("IfcSpace")[0].LongName == "Küche"
    before = {wall.Tag: wall.GlobalId for wall in ifcopenshell.open(delivered / "model.ifc").by_type("IfcWall")}
    assert {wall.Tag: wall.GlobalId for wall in file.by_type("IfcWall")} == before
    for name in ("edited.svg", "edited.dxf", "edited.geojson"):
        assert "Küche" in (tmp_path / name).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--schema", "IFC2X3"], "ifc.version"),
        (["--scale", "0"], "drawing.scale"),
        (["--paper", "A7"], "drawing.paper"),
        (["--theme", "neon"], "drawing.theme"),
        (["--scale", "10", "--paper", "A4"], "does not fit 1:10 on A4"),
        (["--underlay", "none.laz"], "none.laz"),
    ],
)
def test_wrong_choices_are_named(
    delivered: Path, tmp_path: Path, arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(delivered / "model.json"), "--to", "svg", "-o", str(tmp_path), *arguments]) in (2, 3)
    assert told in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_faults_are_told_by_rule(delivered: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = ifcopenshell.open(delivered / "model.ifc")
    for wall in file.by_type("IfcWall"):
        wall.PredefinedType = "SOLIDWALL"
    file.write(str(tmp_path / "model.ifc"))
    assert main(["check", str(tmp_path / "model.ifc")]) == 5
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split() == ["count", "rule", "first"]
    (row,) = [row for row in rows if "typed_occurrences_leave_the_predefined_type" in row]
    assert row.split()[:2] == ["error", "4"]


def test_the_face_that_was_seen_looks_into_the_room(delivered: Path) -> None:
    storey = read_json(delivered / "model.json").storeys[0]
    middle = storey.rooms[0].outline.polygon.centroid
    for wall in storey.walls:
        (x0, y0), (x1, y1) = wall.axis
        room_is_left = (x1 - x0) * (middle.y - y0) - (y1 - y0) * (middle.x - x0) > 0
        assert wall.seen in ("both", "left" if room_is_left else "right")
        assert (wall.seen == "both") == wall.thickness_measured
    assert "outline unseen" in (delivered / "plan.svg").read_text()
