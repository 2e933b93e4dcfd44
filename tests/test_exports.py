"""DXF, GeoJSON, glTF, PDF and PNG: what other programs find in them."""

from __future__ import annotations

import io
import json
import struct
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import buildings
import ezdxf
import numpy as np
import pytest
import shapely
import trimesh

from indoor_bim.errors import WriteError
from indoor_bim.export.dxf import APP, LAYERS, dxf_text
from indoor_bim.export.geojson import geojson_text
from indoor_bim.export.gltf import gltf_document
from indoor_bim.export.guids import storey_guids
from indoor_bim.export.mesh import building_parts
from indoor_bim.export.plan_style import PlanStyle
from indoor_bim.export.registry import KINDS, WRITERS, write
from indoor_bim.model import Building

MODELS = [buildings.one_room, buildings.four_rooms, buildings.star, buildings.diagonal, buildings.courtyard, buildings.empty]


def drawing(building: Building, **options) -> ezdxf.document.Drawing:
    return ezdxf.read(io.StringIO(dxf_text(building, **options)))


def features(building: Building) -> dict[str, dict]:
    return {feature["id"]: feature for feature in json.loads(geojson_text(building))["features"]}


def flat(point: ezdxf.math.Vec3) -> tuple[float, float]:
    return point.x, point.y


@pytest.mark.parametrize("model", MODELS)
def test_dxf_passes_its_audit(model: Callable[[], Building]) -> None:
    auditor = drawing(model()).audit()
    assert auditor.errors == []
    assert auditor.fixes == []


def test_dxf_is_in_metres_on_named_layers() -> None:
    doc = drawing(buildings.four_rooms())
    assert doc.header["$INSUNITS"] == 6
    assert {entity.dxf.layer for entity in doc.modelspace()} == {
        "A-WALL",
        "A-WALL-PATT",
        "A-COLS",
        "A-DOOR",
        "A-GLAZ",
        "A-AREA",
        "A-AREA-IDEN",
        "A-ANNO-DIMS",
    }
    assert set(LAYERS) <= {layer.dxf.name for layer in doc.layers}


def test_dxf_hatches_are_the_walls() -> None:
    building = buildings.two_rooms()
    hatched = dict.fromkeys((wall.id for wall in building.storeys[0].walls), 0.0)
    for hatch in drawing(building).modelspace().query("HATCH"):
        id = hatch.get_xdata(APP)[0].value.removeprefix("id=")
        hatched[id] += shapely.Polygon([corner[:2] for corner in hatch.paths[0].vertices]).area
    for wall in building.storeys[0].walls:
        cut = sum(opening.width for opening in wall.openings) * wall.thickness
        assert hatched[wall.id] == pytest.approx(shapely.Polygon(wall.footprint).area - cut, abs=1e-9)


@pytest.mark.parametrize("model", [buildings.two_rooms, buildings.diagonal, buildings.star])
def test_dxf_blocks_stand_in_their_openings(model: Callable[[], Building]) -> None:
    storey = model().storeys[0]
    inserts = {i.get_xdata(APP)[0].value.removeprefix("id="): i for i in drawing(model()).modelspace().query("INSERT")}
    openings = {opening.id: (wall, opening) for wall in storey.walls for opening in wall.openings}
    assert set(inserts) == set(openings)
    for id, (wall, opening) in openings.items():
        start, end = np.asarray(wall.axis)
        along = (end - start) / wall.length
        np.testing.assert_allclose(flat(inserts[id].dxf.insert), start + opening.start * along, atol=1e-9)
        jamb = start + (opening.start + opening.width) * along
        ends = [line.dxf.end for line in inserts[id].virtual_entities() if line.dxftype() == "LINE"]
        np.testing.assert_allclose(np.mean([flat(end) for end in ends[:2]], axis=0), jamb, atol=1e-9)
        assert inserts[id].get_xdata(APP)[1].value == "guid=" + storey_guids("house.laz", storey)[id]


@pytest.mark.parametrize(("hinge", "swing"), [("start", "left"), ("end", "left"), ("start", "right"), ("end", "right")])
def test_dxf_doors_swing_to_their_side(hinge: str, swing: str) -> None:
    building = buildings.one_room()
    storey = building.storeys[0]
    door = replace(storey.walls[0].openings[0], hinge=hinge, swing=swing)
    walls = (replace(storey.walls[0], openings=(door,)), *storey.walls[1:])
    space = drawing(replace(building, storeys=(replace(storey, walls=walls),))).modelspace()
    (insert,) = [i for i in space.query("INSERT") if i.dxf.layer == "A-DOOR"]
    (arc,) = [entity for entity in insert.virtual_entities() if entity.dxftype() == "ARC"]
    assert (arc.dxf.end_angle - arc.dxf.start_angle) % 360 == pytest.approx(90)
    assert arc.dxf.radius == pytest.approx(door.width)
    (x0, y0), _ = storey.walls[0].axis
    side = 1 if swing == "left" else -1
    hinge_at = (x0 + door.start + (door.width if hinge == "end" else 0.0), y0 + side * 0.1)
    assert flat(arc.dxf.center) == pytest.approx(hinge_at)
    tip = (hinge_at[0], hinge_at[1] + side * door.width)
    assert min(np.hypot(point[0] - tip[0], point[1] - tip[1]) for point in (arc.start_point, arc.end_point)) < 1e-9


def test_dxf_dimensions_measure_the_building() -> None:
    space = drawing(buildings.two_rooms()).modelspace()
    measured = sorted(round(dimension.get_measurement(), 3) for dimension in space.query("DIMENSION"))
    outside = [1.15, 0.9, 3.1, 1.2, 1.35, 0.3, 4.0, 0.1, 3.0, 0.3, 7.7, 0.3, 4.0, 0.3, 4.6, 4.55, 2.0, 1.15]
    assert measured == sorted([*outside, 4.0, 4.0, 3.0, 4.0])


def test_dxf_layout_shows_the_plan_at_its_scale() -> None:
    doc = drawing(buildings.two_rooms(), style=PlanStyle(scale=100, paper="A3"))
    layout = doc.layout("Layout1")
    viewport = layout.query("VIEWPORT")[-1]
    assert viewport.dxf.height / viewport.dxf.view_height == pytest.approx(10.0)
    assert "1:100" in [text.dxf.text for text in layout.query("TEXT")]


@pytest.mark.parametrize("kind", ["dxf", "gltf", "geojson", "pdf", "svg"])
def test_same_bytes_twice(kind: str, tmp_path: Path) -> None:
    first, second = (tmp_path / folder / f"plan{KINDS[kind]}" for folder in ("a", "b"))
    for path in (first, second):
        path.parent.mkdir()
        write(buildings.four_rooms(), path)
    assert first.read_bytes() == second.read_bytes()


def test_geojson_tells_every_element() -> None:
    building = buildings.two_storeys()
    found = features(building)
    for storey in building.storeys:
        guids = storey_guids(building.source, storey)
        assert {id for id, feature in found.items() if feature["properties"]["storey"] == storey.id} == set(guids)
        for id, guid in guids.items():
            assert found[id]["properties"]["guid"] == guid
        for wall in storey.walls:
            assert shapely.geometry.shape(found[wall.id]["geometry"]).area == pytest.approx(shapely.Polygon(wall.footprint).area, abs=1e-3)


def test_geojson_rings_turn_as_the_rfc_asks() -> None:
    for feature in features(buildings.courtyard()).values():
        outer, *holes = feature["geometry"]["coordinates"]
        assert shapely.LinearRing(outer).is_ccw
        assert not any(shapely.LinearRing(hole).is_ccw for hole in holes)


def test_geojson_lies_on_the_map_when_the_system_is_known() -> None:
    building = buildings.moved(buildings.one_room(), yaw=30.0, shift=(500_000.0, 5_400_000.0, 100.0))
    assert json.loads(geojson_text(building))["crs"] is None
    on_map = replace(building, crs="EPSG:25832")
    assert json.loads(geojson_text(on_map))["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::25832"
    wall = shapely.geometry.shape(features(on_map)["W1"]["geometry"])
    assert wall.centroid.x == pytest.approx(500_000 + 2.5 * np.cos(np.radians(30)) + 0.1 * 0.5, abs=0.01)
    assert wall.area == pytest.approx(shapely.Polygon(building.storeys[0].walls[0].footprint).area, abs=1e-3)


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
@pytest.mark.parametrize("model", [buildings.four_rooms, buildings.star, buildings.two_storeys])
def test_gltf_holds_the_same_bodies(model: Callable[[], Building], ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"model{ending}"
    write(model(), path)
    scene = trimesh.load_scene(path)
    parts = {part.id: part for part in building_parts(model())}
    assert set(scene.geometry) == set(parts)
    for id, part in parts.items():
        mesh = scene.geometry[id]
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(part.volume, rel=1e-4)
        placed = trimesh.transform_points(part.vertices, scene.graph[id][0])
        np.testing.assert_allclose(placed[:, 1], part.vertices[:, 2], atol=1e-6)


def test_glb_is_laid_out_as_the_standard_says(tmp_path: Path) -> None:
    path = tmp_path / "model.glb"
    write(buildings.one_room(), path)
    data = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    document = json.loads(data[20 : 20 + size])
    assert document["buffers"][0]["byteLength"] == len(data) - 28 - size


def test_gltf_nodes_know_their_elements() -> None:
    building = buildings.one_room()
    document, _ = gltf_document(building)
    extras = {node["name"]: node.get("extras") for node in document["nodes"]}
    assert extras["W1"] == {"id": "W1", "kind": "wall", "guid": storey_guids(building.source, building.storeys[0])["W1"]}
    glass = next(material for material in document["materials"] if material["name"] == "window")
    assert glass["alphaMode"] == "BLEND"


def test_pdf_and_png_are_drawn_for_each_storey(tmp_path: Path) -> None:
    from PIL import Image

    for kind in ("pdf", "png"):
        write(buildings.two_storeys(), tmp_path / f"plan.{kind}", style=PlanStyle(paper="A4"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan-1.ST.pdf", "plan-1.ST.png", "plan.pdf", "plan.png"]
    assert (tmp_path / "plan.pdf").read_bytes().startswith(b"%PDF-1.")
    with Image.open(tmp_path / "plan.png") as picture:
        assert sorted(picture.size) == [1654, 2339]


@pytest.mark.parametrize(
    ("ending", "package", "extra"), [(".dxf", "ezdxf", "dxf"), (".pdf", "cairosvg", "pdf"), (".png", "cairosvg", "pdf")]
)
def test_missing_packages_are_named(ending: str, package: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(WriteError, match=rf"pip install 'indoor-bim\[{extra}\]'"):
        write(buildings.one_room(), tmp_path / f"plan{ending}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", WRITERS)
def test_every_writer_takes_a_building_without_anything(ending: str, tmp_path: Path) -> None:
    write(buildings.empty(), tmp_path / f"model{ending}")
    assert (tmp_path / f"model{ending}").stat().st_size > 0
