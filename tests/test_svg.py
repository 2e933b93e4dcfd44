import hashlib
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import buildings
import ifcopenshell
import numpy as np
import pytest
import shapely

from indoor_bim.errors import WriteError
from indoor_bim.export.dimensions import centimetre_labels, opening_chain, wall_face_chain
from indoor_bim.export.ifc import to_ifc
from indoor_bim.export.json import to_json
from indoor_bim.export.plan_style import PlanStyle, Underlay
from indoor_bim.export.sheet import draw_plan
from indoor_bim.export.svg import plan_paths, plan_svg, write_plans, write_svg
from indoor_bim.model import Building, Evidence, Opening, Outline, Room, Storey, Wall

SVG = "{http://www.w3.org/2000/svg}"
GOLDEN = Path(__file__).parent / "golden" / "plan_two_rooms.svg"
MODELS = [
    buildings.one_room,
    buildings.two_rooms,
    buildings.four_rooms,
    buildings.star,
    buildings.diagonal,
    buildings.courtyard,
    buildings.two_storeys,
    buildings.empty,
]


def plain_wall(length: float, *, coverage: float = 0.9, measured: bool = True, openings: tuple[Opening, ...] = ()) -> Building:
    ring = ((0.0, -0.1), (length, -0.1), (length, 0.1), (0.0, 0.1))
    wall = Wall("W", "Wall", ((0.0, 0.0), (length, 0.0)), 0.2, measured, 0.0, 2.5, ring, None, openings, Evidence(9, coverage, 0.003, 1))
    return Building("Wall", (Storey("S", "Storey", 0.0, 2.5, (wall,)),))


def cabins(columns: int, rows: int, *, width: float, depth: float, name: str) -> Building:
    """Rooms in a grid without walls, names of any length."""
    rooms = tuple(
        Room(
            f"R{i}-{j}",
            f"{name} {i}.{j}",
            Outline.from_polygon(shapely.box(i * width, j * depth, (i + 1) * width - 0.1, (j + 1) * depth - 0.1)),
            0,
            2.5,
        )
        for i in range(columns)
        for j in range(rows)
    )
    return Building("Cabins", (Storey("S", "Storey", 0.0, 2.5, rooms=rooms),), warnings=("A remark that goes on and on. " * 20,))


def root_of(building: Building, **options) -> ET.Element:
    return ET.fromstring(plan_svg(building, **options))


def corners(path: ET.Element) -> np.ndarray:
    words = [word for word in path.get("d").split() if word not in ("M", "L", "Z")]
    return np.array(words, dtype=float).reshape(-1, 2)


def element(root: ET.Element, id: str) -> ET.Element:
    (found,) = [node for node in root.iter() if node.get("id") == id]
    return found


@pytest.mark.parametrize("model", MODELS)
def test_page_is_a_named_paper_in_millimetres(model):
    root = root_of(model())
    width, height = root.get("width"), root.get("height")
    assert {width, height} in [{"210mm", "297mm"}, {"297mm", "420mm"}]
    assert root.get("viewBox") == f"0 0 {width[:-2]} {height[:-2]}"


@pytest.mark.parametrize(
    ("length", "scale"), [(2.0, 20), (5.0, 25), (10.0, 50), (17.0, 50), (30.0, 100), (70.0, 100), (100.0, 200), (300.0, 500)]
)
def test_scale_is_true(length, scale):
    root = root_of(plain_wall(length))
    body = corners(element(root, "W").find(f"{SVG}path"))
    assert root.get("data-scale") == str(scale)
    assert f"1:{scale}" in [text.text for text in root.iter(f"{SVG}text")]
    np.testing.assert_allclose(np.ptp(body, axis=0), [1000 * length / scale, 200 / scale], atol=2e-3)


def test_up_in_the_building_is_up_on_paper():
    building = buildings.one_room()
    root = root_of(building)
    south, north = (corners(element(root, id).find(f"{SVG}path"))[:, 1].mean() for id in ("W1", "W3"))
    west, east = (corners(element(root, id).find(f"{SVG}path"))[:, 0].mean() for id in ("W4", "W2"))
    assert north < south
    assert west < east


@pytest.mark.parametrize("model", MODELS)
def test_every_element_is_drawn_once_under_its_id(model):
    building = model()
    for storey in building.storeys:
        root = root_of(building, storey=storey.id)
        ids = [node.get("id") for node in root.iter() if node.get("id")]
        assert len(ids) == len(set(ids))
        expected = {item.id for kind in (storey.walls, storey.columns, storey.rooms) for item in kind}
        expected |= {opening.id for wall in storey.walls for opening in wall.openings}
        assert expected <= set(ids)
        for id in expected:
            assert element(root, id).find(f"{SVG}title").text


def test_layers_are_named_groups():
    root = root_of(buildings.four_rooms())
    inkscape = "{http://www.inkscape.org/namespaces/inkscape}"
    labels = [group.get(f"{inkscape}label") for group in root.findall(f"{SVG}g") if group.get(f"{inkscape}groupmode") == "layer"]
    expected = [
        "Rooms",
        "Walls",
        "Wall hatch",
        "Wall outlines",
        "Columns",
        "Doors",
        "Windows",
        "Openings",
        "Room dimensions",
        "Room tags",
        "Dimensions",
        "Notes",
    ]
    assert labels == [*expected, "Title block"]


def test_openings_are_left_out_of_the_wall():
    root = root_of(plain_wall(5.0, openings=(Opening("D", "Door", "door", 1.0, 1.0, 0.0, 2.0),)))
    x = np.unique(corners(element(root, "W").find(f"{SVG}path"))[:, 0])
    np.testing.assert_allclose(np.diff(x), [40, 40, 120], atol=2e-3)


@pytest.mark.parametrize(
    ("hinge", "swing", "tip"),
    [("start", "left", (1.0, 1.1)), ("end", "left", (2.0, 1.1)), ("start", "right", (1.0, -1.1)), ("end", "right", (2.0, -1.1))],
)
def test_leaf_hangs_on_its_hinge_and_opens_to_its_side(hinge, swing, tip):
    building = plain_wall(5.0, openings=(Opening("D", "Door", "door", 1.0, 1.0, 0.0, 2.0, hinge, swing),))
    view = draw_plan(building).view
    door = element(root_of(building), "D")
    (leaf,) = [path for path in door if path.get("class") == "leaf"]
    (swung,) = [path for path in door if path.get("class") == "swing"]
    jamb = (tip[0], 0.1 if swing == "left" else -0.1)
    np.testing.assert_allclose(corners(leaf), [view.point(jamb), view.point(tip)], atol=1e-3)
    words = swung.get("d").split()
    start, end = np.array(words[1:3], dtype=float), np.array(words[9:11], dtype=float)
    radius, sweep = float(words[4]), int(words[8])
    assert words[3] == "A"
    assert radius == pytest.approx(np.hypot(*(start - corners(leaf)[0])), abs=2e-3)
    # SVG draws with increasing angle (y down) when the sweep flag is 1: the centre then lies on that side
    chord = end - start
    middle = (start + end) / 2 + (1 if sweep else -1) * 0.5 * np.array([-chord[1], chord[0]])
    np.testing.assert_allclose(middle, view.point(jamb), atol=2e-3)


def test_door_of_unknown_hinge_has_a_neutral_symbol():
    door = element(root_of(plain_wall(5.0, openings=(Opening("D", "Door", "door", 1.0, 1.0, 0.0, 2.0),))), "D")
    assert [path.get("class") for path in door.findall(f"{SVG}path")] == ["threshold", "closed-leaf"]


def test_unsupported_walls_are_dashed_and_explained():
    classes = [path.get("class") for path in root_of(plain_wall(5.0, coverage=0.05)).iter(f"{SVG}path")]
    assert "outline unsupported" in classes
    assert "outline" not in classes
    assert "outline unsupported" not in [path.get("class") for path in root_of(plain_wall(5.0)).iter(f"{SVG}path")]
    assert "Dashed walls" in plan_svg(plain_wall(5.0, coverage=0.05))
    assert "Wide hatch" in plan_svg(plain_wall(5.0, measured=False))
    assert "Wide hatch" not in plan_svg(plain_wall(5.0))


CROWDED = [
    cabins(6, 4, width=1.2, depth=1.0, name="Conference and meeting room of the department"),
    cabins(20, 12, width=3.0, depth=3.3, name="Office"),
    cabins(30, 2, width=1.0, depth=6.0, name="Store room"),
    replace(cabins(1, 1, width=0.6, depth=0.6, name="Shaft"), crs="EPSG:25832"),
    replace(cabins(1, 20, width=1.1, depth=1.1, name="Meeting room of the department"), crs="EPSG:25832"),
    cabins(1, 1, width=60.0, depth=40.0, name="Hall"),
    replace(buildings.two_rooms(), name="A very long name of a project " * 5, source="scan " * 40, method="m" * 200),
]


@pytest.mark.parametrize("building", [*(model() for model in MODELS), *CROWDED])
def test_text_never_covers_text_and_stays_on_the_page(building):
    plan = draw_plan(building)
    frame = shapely.Polygon(plan.page.frame.ring)
    boxes = [(text.text, text.box) for text in plan.texts]
    for text, box in boxes:
        assert frame.covers(box), text
    for (one, box), (other, other_box) in combinations(boxes, 2):
        assert not box.intersects(other_box), (one, other)


@pytest.mark.parametrize("building", [*(model() for model in MODELS), *CROWDED])
def test_tags_lie_in_their_rooms(building):
    plan = draw_plan(building)
    for layer in plan.layers:
        if layer.name == "room-tags":
            rooms = shapely.STRtree([plan.view.shape(room.outline.polygon) for room in building.storeys[0].rooms])
            for text in layer.texts:
                assert len(rooms.query(text.box, predicate="covered_by")) == 1, text.text


def test_names_that_do_not_fit_are_numbered_in_the_notes():
    plan = draw_plan(cabins(20, 1, width=0.9, depth=0.9, name="Conference and meeting room"))
    texts = [text.text for text in plan.texts]
    assert {"1", "2", "3"} <= set(texts)
    assert any(text.startswith("1 Conference") for text in texts)


@pytest.mark.parametrize(("count", "above"), [(1, True), (60, False)])
def test_remarks_stand_above_the_scale_bar_and_beside_it_only_when_many(count, above):
    remarks = tuple(f"Remark {k} about what is missing or doubtful in this model" for k in range(count))
    texts = {text.text: text for text in draw_plan(replace(buildings.four_rooms(), warnings=remarks), style=PlanStyle(paper="A2")).texts}
    first = next(text for line, text in texts.items() if line.startswith("Remark 0"))
    assert (abs(first.at[0] - texts["0"].at[0]) < 0.1) == above


def test_dimensions_tell_the_building():
    layer = next(layer for layer in draw_plan(buildings.two_rooms()).layers if layer.name == "dimensions")
    chains = [sorted(mark.text for mark in item.marks if hasattr(mark, "text")) for item in layer.items]
    assert chains == [
        sorted(["1.15", "0.90", "3.10", "1.20", "1.35"]),
        sorted(["0.30", "4.00", "0.10", "3.00", "0.30"]),
        ["7.70"],
        sorted(["0.30", "4.00", "0.30"]),
        ["4.60"],
        sorted(["1.15", "2.00", "4.55"]),
    ]


def test_dimensions_tell_the_inner_width_without_rooms():
    building = buildings.one_room()
    walls = tuple(replace(wall, openings=()) for wall in building.storeys[0].walls)
    bare = replace(building, storeys=(replace(building.storeys[0], rooms=(), walls=walls),))
    layer = next(layer for layer in draw_plan(bare).layers if layer.name == "dimensions")
    chains = [sorted(mark.text for mark in item.marks if hasattr(mark, "text")) for item in layer.items]
    assert chains == [["0.20", "0.20", "5.00"], ["5.40"], ["0.20", "0.20", "4.00"], ["4.40"]]


def test_dimensions_leave_out_what_lies_behind_other_rooms():
    chains = {side: wall_face_chain(buildings.courtyard().storeys[0], side) for side in ("bottom", "left", "top", "right")}
    assert chains["bottom"] == chains["top"] == pytest.approx([-0.1, 0.1, 9.9, 10.1])
    assert chains["left"] == chains["right"] == pytest.approx([-0.1, 0.1, 7.9, 8.1])


def test_dimension_labels_add_up():
    random = np.random.default_rng(7)
    for count in (1, 2, 5, 20):
        chain = np.cumsum([0.0, *random.uniform(0.05, 4, count)]).tolist()
        labels = [float(label) for label in centimetre_labels(chain)]
        assert sum(labels) == pytest.approx(chain[-1], abs=0.00501)
        np.testing.assert_allclose(labels, np.diff(chain), atol=0.01)


def test_title_block_tells_accuracy_and_source():
    texts = [text.text for text in draw_plan(buildings.four_rooms()).texts]
    for expected in ("House", "Storey 0", "1:50", "A3, metres", "house.laz", "test", "4 mm", "80%", "0 of 7"):
        assert expected in texts


def test_empty_building_says_what_is_missing():
    texts = [text.text for text in draw_plan(buildings.empty()).texts]
    assert "No floor plan" in texts
    assert "No walls were found: the scan shows a ceiling only." in texts
    bare = Building("Bare", (Storey("S", "Attic", 0.0, 2.5),))
    assert "Attic has no walls, columns or rooms." in [text.text for text in draw_plan(bare).texts]


def test_north_is_drawn_only_when_known():
    building = buildings.one_room()
    assert 'class="north"' not in plan_svg(building)
    turned = buildings.moved(replace(building, crs="EPSG:25832"), yaw=90.0, shift=(0.0, 0.0, 0.0))
    arrow = next(path for path in root_of(turned).iter(f"{SVG}path") if path.get("class") == "north")
    tip, wing, notch, other = corners(arrow)
    rows = np.array(turned.transform_cloud_to_model)
    north = rows[:2, 1] * (1, -1)
    np.testing.assert_allclose((tip - notch) / np.hypot(*(tip - notch)), north, atol=1e-3)
    assert np.hypot(*(tip - wing)) == pytest.approx(np.hypot(*(tip - other)), abs=5e-3)


def test_themes_differ_in_colours_only():
    light, dark = (root_of(buildings.star(), style=PlanStyle(theme=theme)) for theme in ("print", "dark"))
    assert light.find(f"{SVG}style").text != dark.find(f"{SVG}style").text
    for root in (light, dark):
        root.find(f"{SVG}style").text = ""
    assert ET.tostring(light) == ET.tostring(dark)
    with pytest.raises(ValueError, match='no theme "neon"'):
        plan_svg(buildings.star(), style=PlanStyle(theme="neon"))


def test_underlay_lies_at_its_place_below_everything():
    building = buildings.one_room()
    root = root_of(building, style=PlanStyle(underlays={building.storeys[0].id: Underlay(b"\x89PNG", (0.0, 1.0, 4.0, 3.0))}))
    view = draw_plan(building).view
    image = root.find(f"{SVG}image")
    place = [float(image.get(name)) for name in ("x", "y", "width", "height")]
    np.testing.assert_allclose(place, [*view.point((0.0, 3.0)), 80, 40], atol=1e-3)
    assert list(root).index(image) < list(root).index(root.find(f"{SVG}g"))


def test_footprint_that_crosses_itself_is_drawn():
    building = plain_wall(5.0)
    storey = building.storeys[0]
    bow = replace(storey.walls[0], footprint=((0.0, -0.1), (5.0, 0.1), (5.0, -0.1), (0.0, 0.1)))
    root = root_of(replace(building, storeys=(replace(storey, walls=(bow,)),)))
    assert len(corners(element(root, "W").find(f"{SVG}path"))) == 6


def test_special_characters_survive():
    building = replace(buildings.one_room(), name='Café <"A" & B> \x00\x07')
    texts = [text.text for text in root_of(building).iter(f"{SVG}text")]
    assert 'Café <"A" & B> ' in texts


def test_several_storeys_get_a_plan_each(tmp_path):
    building = buildings.two_storeys()
    paths = write_plans(building, tmp_path / "plan.svg")
    assert [path.name for path in paths] == ["plan.svg", "plan-1.ST.svg"]
    assert paths == list(plan_paths(building, tmp_path / "plan.svg"))
    upper = ET.parse(paths[1]).getroot()
    assert element(upper, "1.W1") is not None
    assert upper.find(f"{SVG}title").text == "House - Storey 1."


def test_unknown_storey_is_refused(tmp_path):
    with pytest.raises(WriteError, match=r'no storey "9" to draw; the building has: 0\.ST, 1\.ST'):
        write_svg(buildings.two_storeys(), tmp_path / "plan.svg", storey="9")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("model", MODELS)
def test_same_bytes_twice(model):
    assert plan_svg(model()) == plan_svg(model())


def test_golden_plan():
    assert plan_svg(buildings.two_rooms()) == GOLDEN.read_text(encoding="utf-8")


def test_elements_carry_the_guids_of_the_ifc():
    building = buildings.four_rooms()
    root = root_of(building)
    file = ifcopenshell.file.from_string(to_ifc(building))
    tags = {entity.Tag: entity.GlobalId for kind in ("IfcWall", "IfcDoor", "IfcWindow", "IfcColumn") for entity in file.by_type(kind)}
    tags |= {space.Name: space.GlobalId for space in file.by_type("IfcSpace")}
    assert {node.get("id"): node.get("data-guid") for node in root.iter() if node.get("data-guid")} == tags


def test_metadata_names_the_model():
    building = buildings.two_storeys()
    (model,) = root_of(building, storey="1.ST").find(f"{SVG}metadata")
    assert model.get("format") == "indoor-bim-building"
    assert model.get("storey") == "1.ST"
    assert model.get("model-sha256") == hashlib.sha256(to_json(building).encode()).hexdigest()


@pytest.mark.parametrize(("scale", "paper"), [(100, "A3"), (200, None), (None, "A2"), (50, "A1")])
def test_scale_and_paper_may_be_chosen(scale, paper):
    plan = draw_plan(buildings.four_rooms(), style=PlanStyle(scale=scale, paper=paper))
    assert plan.view.scale == (scale or 25)
    assert plan.page.paper == (paper or "A4")


def test_a_plan_that_does_not_fit_is_refused():
    with pytest.raises(WriteError, match=r"a plan of 8\.2 x 6\.2 m does not fit 1:20 on A4; ask for a smaller scale or larger paper\."):
        draw_plan(buildings.four_rooms(), style=PlanStyle(scale=20, paper="A4"))


def test_the_face_that_was_not_seen_is_dashed():
    building = plain_wall(5.0, measured=False)
    storey = building.storeys[0]
    for seen, side in (("left", -0.1), ("right", 0.1)):
        wall = replace(storey.walls[0], seen=seen)
        shown = replace(building, storeys=(replace(storey, walls=(wall,)),))
        (dashed,) = [path for path in root_of(shown).iter(f"{SVG}path") if path.get("class") == "outline unseen"]
        view = draw_plan(shown).view
        faces = corners(dashed)
        long = faces[np.abs(faces[:, 1] - view.point((0.0, side))[1]) < 1e-6]
        assert np.ptp(long[:, 0]) == pytest.approx(5.0 * view.mm_per_metre, abs=2e-3)
        assert all(np.abs(faces[:, 1] - view.point((0.0, side))[1]) <= 0.01 * view.mm_per_metre + 1e-6)
    measured = replace(building, storeys=(replace(storey, walls=(replace(storey.walls[0], seen="both"),)),))
    assert "outline unseen" not in [path.get("class") for path in root_of(measured).iter(f"{SVG}path")]


def test_rooms_are_dimensioned_from_wall_to_wall():
    plan = draw_plan(buildings.two_rooms())
    layer = next(layer for layer in plan.layers if layer.name == "room-dimensions")
    assert sorted(text.text for text in layer.texts) == ["3.00", "4.00", "4.00", "4.00"]
    tags = next(layer for layer in plan.layers if layer.name == "room-tags")
    assert not any("×" in text.text for text in tags.texts)


def test_jambs_of_outer_openings_are_dimensioned():
    storey = buildings.two_rooms().storeys[0]
    assert opening_chain(storey, "bottom") == pytest.approx([-0.3, 0.85, 1.75, 4.85, 6.05, 7.4])
    assert opening_chain(storey, "top") == pytest.approx([-0.3, 4.25, 6.25, 7.4])
    assert opening_chain(storey, "left") == opening_chain(storey, "right") == []
