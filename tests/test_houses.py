"""Houses from scan to files: GeoJSON, IFC, CityJSON, meshes, map sheet; attributes, accuracy, command line."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

from indoor_bim.cli import main
from indoor_bim.cloud.write import write_las
from indoor_bim.errors import ConfigError, NothingToReconstructError, ReadError, WriteError
from indoor_bim.export.cityjson import cityjson_text
from indoor_bim.export.footprints import footprints_text
from indoor_bim.export.house_meshes import house_part, write_houses_obj, write_houses_ply
from indoor_bim.export.ifc_houses import house_storey, houses_ifc
from indoor_bim.export.map_dxf import map_dxf
from indoor_bim.export.map_sheet import draw_map
from indoor_bim.export.map_svg import map_svg
from indoor_bim.frame import Frame
from indoor_bim.houses import houses
from indoor_bim.model import Evidence
from indoor_bim.outdoor.accuracy import measure, read_corners, wall_distances
from indoor_bim.outdoor.attributes import join_attributes, read_attributes
from indoor_bim.outdoor.footprint import WallPoints
from indoor_bim.outdoor.heights import eave_height
from indoor_bim.outdoor.model import Facade, Ground, House, Village
from indoor_bim.outdoor.outputs import FILES, write_outputs
from indoor_bim.params import Params
from indoor_bim.simulate.village import sample_village, scan_village, true_village

UTM = ((1.0, 0.0, 0.0, -500000.0), (0.0, 1.0, 0.0, -5800000.0), (0.0, 0.0, 1.0, -100.0), (0.0, 0.0, 0.0, 1.0))
Captured = pytest.CaptureFixture[str]


@cache
def known() -> Village:
    village = true_village(sample_village())
    first = village.houses[0]
    facades = (replace(first.facades[0], seen=False, evidence=Evidence()), *first.facades[1:])
    first = replace(first, facades=facades, material="brick", attributes=(("owner", "Müller"),))
    ground = Ground(((-5, -5, 0), (80, -5, 0), (80, 60, 0.5), (-5, 60, 0.5)), ((0, 1, 2), (0, 2, 3)))
    spots = ((-3.0, -3.0, 0.1), (20.0, 14.0, 0.2), (5.0, 4.0, 9.9))
    return replace(village, houses=(first, *village.houses[1:]), ground=ground, spot_heights=spots, transform_cloud_to_model=UTM)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("village")
    write_outputs(known(), folder, formats=tuple(FILES), params=Params())
    return folder


def test_every_file_is_written(results: Path) -> None:
    names = {path.name for path in results.iterdir()}
    assert names == {file for file, _, _ in FILES.values()} | {"village.mtl", "params.toml"}


def test_geojson_is_in_scan_coordinates() -> None:
    document = json.loads(footprints_text(known()))
    assert document["crs"] is None
    for feature, house in zip(document["features"], known().houses, strict=True):
        polygon, properties = shapely.geometry.shape(feature["geometry"]), feature["properties"]
        moved = shapely.transform(house.polygon, lambda xy: xy + np.array([5e5, 5.8e6]))
        assert polygon.exterior.is_ccw
        assert polygon.hausdorff_distance(moved) < 1e-4
        assert polygon.area == pytest.approx(properties["area_m2"], abs=0.01)
        assert properties["base_z"] == pytest.approx(house.base + 100, abs=1e-3)
        assert properties["eave_z"] == pytest.approx(house.eave + 100, abs=1e-3)
        assert properties["storeys"] == house.storeys
        assert len(properties["edges"]) == len(house.footprint)
    first = document["features"][0]["properties"]
    assert (first["material"], first["owner"], first["closed_by_assumption"]) == ("brick", "Müller", True)


def test_geojson_names_the_reference_system() -> None:
    document = json.loads(footprints_text(replace(known(), crs="EPSG:25832")))
    assert document["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::25832"


def test_ply_is_watertight(results: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.load(results / "village.ply")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == len(known().houses)
    assert mesh.volume == pytest.approx(sum(house.area * house.height for house in known().houses), rel=1e-5)


def test_roofs_of_concave_houses_are_triangulated_inside() -> None:
    for house in known().houses:
        part = house_part(house)
        corners = part.vertices[part.triangles]
        roof = corners[(corners[:, :, 2] == house.eave).all(axis=1)]
        triangles = shapely.polygons(roof[:, :, :2])
        assert shapely.area(triangles).sum() == pytest.approx(house.area, rel=1e-5)
        assert shapely.union_all(triangles).symmetric_difference(house.polygon).area < 1e-4


def test_obj_has_a_group_for_each_house_and_the_ground(results: Path) -> None:
    groups = [line[2:] for line in (results / "village.obj").read_text().splitlines() if line.startswith("g ")]
    assert groups == [house.id for house in known().houses] + ["ground"]


def test_cityjson_solids_are_closed_and_face_outwards() -> None:
    document = json.loads(cityjson_text(known()))
    assert (document["type"], document["version"]) == ("CityJSON", "2.0")
    transform = document["transform"]
    vertices = np.array(document["vertices"]) * transform["scale"] + transform["translate"]
    assert len(np.unique(vertices, axis=0)) == len(vertices)
    for house in known().houses:
        building = document["CityObjects"][house.id]
        (solid,) = building["geometry"]
        (shell,) = solid["boundaries"]
        edges = Counter((ring[i], ring[(i + 1) % len(ring)]) for (ring,) in shell for i in range(len(ring)))
        assert all(count == 1 and edges[(b, a)] == 1 for (a, b), count in edges.items())
        volume = 0.0
        for (ring,) in shell:
            points = vertices[ring] - vertices[shell[0][0][0]]
            volume += sum(np.dot(points[0], np.cross(points[i], points[i + 1])) for i in range(1, len(points) - 1)) / 6
        assert volume == pytest.approx(house.area * house.height, rel=1e-3)
        assert len(solid["semantics"]["values"][0]) == len(shell)
        assert building["attributes"]["storeysAboveGround"] == house.storeys
    low, high = np.array(document["metadata"]["geographicalExtent"]).reshape(2, 3)
    assert np.allclose(low, vertices.min(axis=0), atol=1e-3)
    assert np.allclose(high, vertices.max(axis=0), atol=1e-3)


def test_ifc_is_valid(results: Path) -> None:
    from indoor_bim.quality.check import check_ifc

    report = check_ifc(results / "village.ifc")
    assert not report.findings


@pytest.mark.parametrize("schema", ["IFC4", "IFC4X3"])
def test_ifc_holds_terrain_and_a_building_for_each_house(schema: str) -> None:
    import ifcopenshell

    file = ifcopenshell.file.from_string(houses_ifc(known(), schema=schema))  # type: ignore[arg-type]
    buildings = file.by_type("IfcBuilding")
    assert [building.Name for building in buildings] == [house.id for house in known().houses]
    assert len(file.by_type("IfcWall")) == sum(len(house.footprint) for house in known().houses)
    assert Counter(slab.PredefinedType for slab in file.by_type("IfcSlab")) == {"FLOOR": 6, "ROOF": 6}
    (terrain,) = file.by_type("IfcGeographicElement")
    assert terrain.PredefinedType == "TERRAIN"
    assert houses_ifc(known(), schema=schema) == houses_ifc(known(), schema=schema)  # type: ignore[arg-type]


def test_walls_stand_inside_the_measured_faces() -> None:
    for house in known().houses:
        storey = house_storey(house)
        bodies = [shapely.Polygon(wall.footprint) for wall in storey.walls]
        union = shapely.union_all(bodies)
        assert sum(body.area for body in bodies) == pytest.approx(union.area, rel=1e-6)
        assert union.difference(house.polygon.buffer(1e-6)).area < 1e-6
        assert house.polygon.difference(union).area == pytest.approx(house.polygon.buffer(-0.3, join_style="mitre").area, rel=1e-3)


def test_walls_of_a_hut_too_small_for_them_get_thinner() -> None:
    hut = House("H1", ((0, 0), (0.5, 0), (0.5, 4), (0, 4)), 0.0, 2.5, 1, true_village(sample_village()).houses[5].facades)
    assert {wall.thickness for wall in house_storey(hut).walls} == {0.15}


@pytest.mark.parametrize("scale", [500, 1000])
def test_map_sheet_is_at_true_scale(scale: int) -> None:
    sheet = draw_map(known(), scale=scale)
    assert sheet.view.scale == scale
    root = ElementTree.fromstring(map_svg(known(), scale=scale))
    paths = {group.get("id"): group for group in root.iter("{http://www.w3.org/2000/svg}g")}
    for house in known().houses:
        body = paths[house.id].find("{http://www.w3.org/2000/svg}path")
        assert body is not None
        numbers = np.array([float(word) for word in (body.get("d") or "").split() if word not in "MLZ"]).reshape(-1, 2)
        assert shapely.Polygon(numbers).area == pytest.approx(house.area * (1000 / scale) ** 2, rel=2e-3)


def test_map_sheet_says_what_it_shows() -> None:
    svg = map_svg(known())
    assert "brick 2" in svg
    assert "100.10" in svg
    assert "109.90" not in svg  # that spot lies in a house
    assert "house-wall unseen" in svg
    assert map_svg(known()) == svg


def test_labels_stand_in_their_houses() -> None:
    sheet = draw_map(known())
    (layer,) = [layer for layer in sheet.layers if layer.name == "labels"]
    for item, house in zip(layer.items, known().houses, strict=True):
        body = sheet.view.shape(house.polygon)
        for mark in item.marks:
            assert body.contains(mark.box)  # type: ignore[union-attr]


def test_a_village_too_large_for_the_scale_is_refused() -> None:
    far = replace(known().houses[1], id="far", footprint=tuple((x + 5000, y) for x, y in known().houses[1].footprint))
    with pytest.raises(WriteError, match="does not fit"):
        draw_map(replace(known(), houses=(*known().houses, far)), scale=500)
    assert draw_map(replace(known(), houses=(*known().houses, far))).view.scale == 5000


def test_dxf_is_in_scan_coordinates(tmp_path: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    (tmp_path / "map.dxf").write_text(map_dxf(known()), encoding="utf-8")
    document = ezdxf.readfile(tmp_path / "map.dxf")
    assert not document.audit().errors
    outlines = document.modelspace().query("LWPOLYLINE[layer=='HOUSE']")
    for outline, house in zip(outlines, known().houses, strict=True):
        ring = np.array([point[:2] for point in outline.get_points()]) - [5e5, 5.8e6]
        assert np.abs(ring - np.array(house.footprint)).max() < 1e-6
        assert outline.closed
    assert len(document.modelspace().query("LINE[layer=='HOUSE-UNSEEN']")) == 1
    assert len(document.modelspace().query("POINT")) == 3
    assert map_dxf(known()) == map_dxf(known())


def test_a_failed_write_leaves_nothing(tmp_path: Path) -> None:
    for write in (write_houses_ply, write_houses_obj):
        with pytest.raises(WriteError):
            write(known(), tmp_path / "missing" / "village.out")
    assert list(tmp_path.iterdir()) == []


def table(folder: Path, text: str) -> Path:
    (folder / "table.csv").write_text(text, encoding="utf-8")
    return folder / "table.csv"


def test_attributes_join_by_id_or_by_place(tmp_path: Path) -> None:
    x, y = known().houses[2].centroid
    rows = read_attributes(table(tmp_path, f"id;x;y;material;owner\nH2;;;stone;Li\n;{x + 5e5};{y + 5.8e6};wood;\nH99;;;clay;\n"))
    found, warnings = join_attributes(known().houses, rows, Frame.from_matrix(UTM))
    assert [house.material for house in found[:3]] == ["brick", "stone", "wood"]
    assert dict(found[1].attributes) == {"owner": "Li"}
    assert warnings == ["Line 4 of the table of attributes belongs to no house."]


@pytest.mark.parametrize("text", ["", "name,material\na,b\n", "x,y,material\nleft,3,b\n"])
def test_a_table_that_says_not_which_house_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(ReadError, match=r"table\.csv"):
        read_attributes(table(tmp_path, text))


def test_accuracy_is_that_of_the_published_table(tmp_path: Path) -> None:
    x, y = known().houses[0].footprint[0]
    u, v = known().houses[1].footprint[2]
    corners = f"id,x,y\na,{x + 5e5 + 0.03},{y + 5.8e6 - 0.04}\nb,{u + 5e5},{v + 5.8e6 + 0.01}\nc,0,0\n"
    walls = WallPoints(np.zeros((0, 3)))
    accuracy = measure(known(), walls, Frame.from_matrix(UTM), read_corners(table(tmp_path, corners)))
    assert accuracy.distances == pytest.approx([0.05, 0.01], abs=1e-6)
    assert [corner.found is None for corner in accuracy.corners] == [False, False, True]
    assert "2 of 3 corners: mean 0.030 m, s.d. 0.028, max 0.050, min 0.010" in accuracy.table()


def test_distance_of_wall_points_has_the_sign_of_their_side() -> None:
    ring = ((0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0))
    sides = zip(ring, (*ring[1:], ring[0]), strict=True)
    village = Village("v", (House("H1", ring, 0.0, 6.0, 2, tuple(Facade(a, b, True) for a, b in sides)),))
    points = np.array([[0.05, 4.0, 2.0], [5.0, -0.07, 2.0], [5.0, 4.0, 2.0], [5.0, -0.07, 7.0]])
    assert wall_distances(village, WallPoints(points)) == pytest.approx([-0.05, 0.07])


def test_corners_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    for text in ("", "x,y\n", "x,y\n1,two\n", "a,b\n1,2\n"):
        with pytest.raises(ReadError, match=r"table\.csv"):
            read_corners(table(tmp_path, text))


def test_eave_of_most_walls() -> None:
    assert eave_height(np.zeros(0), np.zeros(0)) is None


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    cloud = scan_village(sample_village()[4:], density=80)
    path = tmp_path_factory.mktemp("scan") / "village.laz"
    write_las(path, cloud.points, classification=cloud.classification)
    return path


def test_command_line(scan: Path, tmp_path: Path, capsys: Captured) -> None:
    x, y = sample_village()[4].footprint[0]
    corners = table(tmp_path, f"id,x,y\n1,{x},{y}\n")
    arguments = ["houses", str(scan), "-o", str(tmp_path / "out"), "--crs", "EPSG:25832", "--corners", str(corners), "--json"]
    assert main(arguments) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [house["corners"] for house in answer["houses"]] == [4, 4]
    document = json.loads((tmp_path / "out" / "footprints.geojson").read_text())
    assert document["crs"]["properties"]["name"].endswith("25832")
    assert "1 of 1 corners: mean 0.00" in (tmp_path / "out" / "accuracy.md").read_text()
    assert "storey_height = 3.0" in (tmp_path / "out" / "params.toml").read_text()


def test_command_line_options(scan: Path, tmp_path: Path, capsys: Captured) -> None:
    assert main(["houses", str(scan), "-o", str(tmp_path), "--storey-height", "2", "--to", "geojson"]) == 0
    assert "3 storeys" in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["accuracy.md", "footprints.geojson", "params.toml"]


@pytest.mark.parametrize(
    ("arguments", "code"),
    [(["--method", "magic"], 2), (["--to", "shp"], 2), (["--attributes", "none.csv"], 3), (["--corners", "none.csv"], 3)],
)
def test_wrong_arguments_stop_early(arguments: list[str], code: int, scan: Path, tmp_path: Path, capsys: Captured) -> None:
    assert main(["houses", str(scan), "-o", str(tmp_path / "out"), *arguments]) == code
    assert "error:" in capsys.readouterr().err


def test_unknown_methods_are_named() -> None:
    with pytest.raises(ConfigError, match="lines, topology"):
        houses(np.zeros((3, 3)), method="magic")


def test_nothing_to_reconstruct(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(NothingToReconstructError):
        houses(np.column_stack([rng.uniform(0, 20, (5000, 2)), np.zeros(5000)]), tmp_path)
