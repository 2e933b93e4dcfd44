import json
from dataclasses import replace
from pathlib import Path

import buildings
import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_bim.errors import ReadError, WriteError
from indoor_bim.export.files import replace_file
from indoor_bim.export.json import building_schema, from_json, read_json, schema_text, to_json, write_json
from indoor_bim.model import Building, Column, Storey

MODELS = [buildings.one_room, buildings.star, buildings.courtyard, buildings.two_storeys, buildings.empty]
SCHEMA = Path(__file__).parents[1] / "schemas" / "building.schema.json"


def edited(**changes: object) -> str:
    return json.dumps(json.loads(to_json(buildings.one_room())) | changes)


def edited_wall(**changes: object) -> str:
    document = json.loads(to_json(buildings.one_room()))
    document["storeys"][0]["walls"][2] |= changes
    return json.dumps(document)


@pytest.mark.parametrize("model", MODELS)
def test_there_and_back(model, tmp_path):
    building = buildings.moved(model(), yaw=31.7, shift=(500_123.4567, 5_400_765.4321, 112.3))
    write_json(building, tmp_path / "model.json")
    assert read_json(tmp_path / "model.json") == building
    assert to_json(read_json(tmp_path / "model.json")) == (tmp_path / "model.json").read_text()


@pytest.mark.parametrize("model", MODELS)
def test_documents_follow_the_schema(model):
    validator = jsonschema.Draft202012Validator(building_schema())
    validator.validate(json.loads(to_json(model())))


def test_schema_itself_is_sound_and_forbids_unknown_fields():
    jsonschema.Draft202012Validator.check_schema(building_schema())
    validator = jsonschema.Draft202012Validator(building_schema())
    assert not validator.is_valid(json.loads(edited(colour="red")))
    assert not validator.is_valid(json.loads(edited_wall(thickness=0)))
    assert not validator.is_valid({"name": "no format"})


def test_schema_file_is_in_step_with_the_model():
    assert SCHEMA.read_text(encoding="utf-8") == schema_text()


def test_head_comes_first():
    head = ["format", "version", "units", "name", "source", "method", "crs", "transform_cloud_to_model", "warnings", "storeys"]
    assert list(json.loads(to_json(buildings.star()))) == head


numbers = st.floats(allow_nan=False, allow_infinity=False)


@settings(derandomize=True)
@given(ring=st.lists(st.tuples(numbers, numbers), min_size=3, max_size=5), level=numbers, name=st.text())
def test_any_number_and_any_text_come_back(ring, level, name):
    column = Column("C", name, tuple(ring), level, 2.5)
    building = Building(name, (Storey("S", name, level, 2.5, columns=(column,)),), warnings=(name,))
    assert from_json(to_json(building)) == building


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (edited_wall(thickness=-0.2), r"storeys\[0\]\.walls\[2\]\.thickness: Input should be greater than 0"),
        (edited_wall(thickness="0.2"), r"storeys\[0\]\.walls\[2\]\.thickness: Input should be a valid number"),
        (edited_wall(thicknes=0.2), r"storeys\[0\]\.walls\[2\]\.thicknes: Unexpected"),
        (edited_wall(axis=[[0, 0], [0, float("nan")]]), r"storeys\[0\]\.walls\[2\]\.axis\[1\]\[1\]: Input should be a finite number"),
        (edited_wall(footprint=[[0, 0], [1, 1]]), r"walls\[2\]\.footprint: .*at least 3"),
        (edited_wall(id="W1"), r'identifier "W1" is used 2 times'),
        (edited_wall(id="X"), r'joints\[2\]\.walls: there is no wall "W3" in the storey'),
        (edited(name=None), "name: Input should be a valid string"),
        (edited(format="ifc"), 'expected "format": "indoor-bim-building" at the top, found "ifc"'),
        (edited(version=2), "version 2; this program reads version 1"),
        (edited(units="mm"), 'units: expected "m", found "mm"'),
        ("[]", "not a building model"),
        ("{", "is not JSON .line 1, column 2"),
    ],
)
def test_wrong_documents_name_the_field(text, message):
    with pytest.raises(ReadError, match=message):
        from_json(text)


def test_hand_edits_go_through():
    document = json.loads(to_json(buildings.one_room()))
    document["storeys"][0]["rooms"][0]["name"] = "Küche"
    document["storeys"][0]["height"] = 3
    building = from_json(json.dumps(document))
    assert building.storeys[0].rooms[0].name == "Küche"
    assert building.storeys[0].height == 3.0


def test_unreadable_files_are_named(tmp_path):
    with pytest.raises(ReadError, match=r"none\.json: cannot be read"):
        read_json(tmp_path / "none.json")
    (tmp_path / "picture.json").write_bytes(b"\x89PNG\xff")
    with pytest.raises(ReadError, match=r"picture\.json: is not text"):
        read_json(tmp_path / "picture.json")


def test_infinite_coordinates_are_not_written(tmp_path):
    building = buildings.one_room()
    storey = replace(building.storeys[0], elevation=float("inf"))
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(replace(building, storeys=(storey,)), tmp_path / "model.json")
    assert list(tmp_path.iterdir()) == []


def test_failed_write_keeps_the_old_file(tmp_path):
    target = tmp_path / "model.json"
    target.write_text("old")
    with pytest.raises(UnicodeEncodeError), replace_file(target) as draft:
        draft.write_text("half" * 10_000 + "\udc80", encoding="utf-8")
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_disk_errors_become_write_errors(tmp_path):
    with pytest.raises(WriteError, match=r"model\.json: could not be written .No space left"), replace_file(tmp_path / "model.json"):
        raise OSError(28, "No space left on device")
    assert list(tmp_path.iterdir()) == []
