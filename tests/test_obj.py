from dataclasses import replace

import buildings
import numpy as np
import pytest
import trimesh

from indoor_bim.errors import WriteError
from indoor_bim.export.mesh import COLOURS, building_parts
from indoor_bim.export.obj import write_obj
from indoor_bim.export.ply import write_ply
from indoor_bim.export.registry import write


def groups(text: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Read an OBJ text by its definition: vertices counted from one through the file, faces in the group named last."""
    vertices, faces, name = [], {}, ""
    for line in text.splitlines():
        word, _, rest = line.partition(" ")
        if word == "v":
            vertices.append([float(x) for x in rest.split()])
        elif word == "g":
            name = rest
            assert name not in faces
            faces[name] = []
        elif word == "f":
            faces[name].append([int(i) - 1 for i in rest.split()])
    return {name: (np.array(vertices), np.array(triangles)) for name, triangles in faces.items()}


def element_ids(building) -> set[str]:
    return {part.id for part in building_parts(building)}


@pytest.mark.parametrize("model", [buildings.four_rooms, buildings.star, buildings.two_storeys])
def test_one_closed_group_per_element(model, tmp_path):
    building = model()
    write_obj(building, tmp_path / "model.obj")
    found = groups((tmp_path / "model.obj").read_text())
    assert set(found) == element_ids(building)
    volumes = {part.id: part.volume for part in building_parts(building)}
    for name, (vertices, faces) in found.items():
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        assert mesh.is_watertight, name
        assert mesh.volume == pytest.approx(volumes[name], abs=1e-4)


def test_elements_of_every_kind_are_there(tmp_path):
    building = buildings.four_rooms()
    storey = building.storeys[0]
    expected = {element.id for kind in (storey.walls, storey.columns, storey.slabs) for element in kind}
    expected |= {opening.id for wall in storey.walls for opening in wall.openings if opening.kind != "opening"}
    assert element_ids(building) == expected


def test_materials_lie_beside_and_are_all_defined(tmp_path):
    write_obj(buildings.one_room(), tmp_path / "plan of hut.obj")
    text = (tmp_path / "plan of hut.obj").read_text()
    assert "mtllib plan of hut.mtl\n" in text
    defined = {line.split()[1] for line in (tmp_path / "plan of hut.mtl").read_text().splitlines() if line.startswith("newmtl")}
    used = {line.split()[1] for line in text.splitlines() if line.startswith("usemtl")}
    assert used == {"wall", "door", "window", "floor", "ceiling"}
    assert defined == set(COLOURS)


def test_names_with_blanks_stay_one_group(tmp_path):
    building = buildings.one_room()
    storey = building.storeys[0]
    named = replace(storey, walls=(replace(storey.walls[0], id="north  wall"), *storey.walls[1:]))
    write_obj(replace(building, storeys=(named,)), tmp_path / "model.obj")
    assert "\ng north_wall\n" in (tmp_path / "model.obj").read_text()


def test_same_bytes_twice(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        for ending in ("obj", "ply"):
            write(buildings.star(), tmp_path / name / f"model.{ending}")
    for ending in ("obj", "mtl", "ply"):
        assert (tmp_path / "a" / f"model.{ending}").read_bytes() == (tmp_path / "b" / f"model.{ending}").read_bytes()


def test_empty_building_says_why(tmp_path):
    write_obj(buildings.empty(), tmp_path / "model.obj")
    assert "# No walls were found: the scan shows a ceiling only.\n" in (tmp_path / "model.obj").read_text()


def test_ply_holds_the_same_surfaces(tmp_path):
    building = buildings.four_rooms()
    write_ply(building, tmp_path / "model.ply")
    parts = building_parts(building)
    mesh = trimesh.load_mesh(tmp_path / "model.ply", process=False)
    assert len(mesh.faces) == sum(len(part.triangles) for part in parts)
    assert mesh.volume == pytest.approx(sum(part.volume for part in parts))
    assert mesh.visual.vertex_colors[0, :3].tolist() == list(COLOURS[parts[0].material])


def test_unwritable_places_are_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(WriteError, match="no folder"):
        write_obj(buildings.one_room(), tmp_path / "missing" / "model.obj")
    with pytest.raises(WriteError, match="no folder"):
        write_obj(buildings.one_room(), tmp_path / "file" / "model.obj")
    with pytest.raises(WriteError, match="is a folder"):
        write(buildings.one_room(), tmp_path / "folder.obj")
    with pytest.raises(WriteError, match=r"no writer for \"\.dwg\""):
        write(buildings.one_room(), tmp_path / "model.dwg")
