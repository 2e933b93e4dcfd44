"""GlobalIds that elements keep from run to run."""

from __future__ import annotations

import uuid
from dataclasses import replace

import buildings
import ifcopenshell.guid
import pytest

from indoor_bim.export.guids import NAMESPACE, element_guid, global_id
from indoor_bim.identity import with_guids
from indoor_bim.model import Building, Wall

MODELS = [buildings.four_rooms, buildings.star, buildings.courtyard, buildings.two_storeys, buildings.empty]


def guids(building: Building) -> list[str | None]:
    found: list[str | None] = []
    for storey in building.storeys:
        found += [element.guid for group in (storey.walls, storey.columns, storey.rooms, storey.slabs) for element in group]
        found += [opening.guid for wall in storey.walls for opening in wall.openings]
    return found


def nudged(wall: Wall, by: float) -> Wall:
    ring = tuple((x + by, y - by) for x, y in wall.footprint)
    return replace(wall, axis=tuple((x + by, y - by) for x, y in wall.axis), footprint=ring)  # type: ignore[arg-type]


@pytest.mark.parametrize("text", ["", "a", "scan.laz/Wall/W1", "ä/é"])
def test_global_ids_are_compressed_uuids(text: str) -> None:
    assert global_id(text) == ifcopenshell.guid.compress(uuid.uuid5(NAMESPACE, text).hex)


@pytest.mark.parametrize("model", MODELS)
def test_every_element_gets_its_own(model) -> None:
    found = guids(with_guids(model()))
    assert None not in found
    assert len(set(found)) == len(found)


def test_numbers_do_not_matter() -> None:
    building = buildings.four_rooms()
    storey = building.storeys[0]
    fewer = replace(building, storeys=(replace(storey, walls=tuple(replace(w, id=f"N{i}") for i, w in enumerate(storey.walls[1:]))),))
    assert [w.guid for w in with_guids(building).storeys[0].walls[1:]] == [w.guid for w in with_guids(fewer).storeys[0].walls]


def test_millimetres_hardly_matter() -> None:
    building = buildings.moved(buildings.star(), yaw=31.7, shift=(12.34, -7.1, 0.4))
    storey = building.storeys[0]
    for by in (0.001, -0.002):
        other = replace(building, storeys=(replace(storey, walls=tuple(nudged(wall, by) for wall in storey.walls)),))
        kept = [a.guid == b.guid for a, b in zip(with_guids(building).storeys[0].walls, with_guids(other).storeys[0].walls, strict=True)]
        assert sum(kept) >= len(kept) - 1


def test_the_model_may_lie_anywhere_in_the_scan() -> None:
    """A run that chooses another main direction or origin of the model does not change the GlobalIds."""
    building = buildings.moved(buildings.diagonal(), yaw=31.7, shift=(12.34, -7.1, 2.0))
    turned = buildings.moved(buildings.diagonal(), yaw=31.7, shift=(12.34, -7.1, 2.0))
    assert guids(with_guids(building)) == guids(with_guids(turned))
    assert guids(with_guids(building)) != guids(with_guids(buildings.diagonal()))


def test_those_that_are_there_stay() -> None:
    building = with_guids(buildings.two_rooms())
    assert with_guids(replace(building, source="other.laz")) == replace(building, source="other.laz")


def test_walls_at_one_place_differ() -> None:
    building = buildings.one_room()
    storey = building.storeys[0]
    twice = replace(building, storeys=(replace(storey, walls=(storey.walls[0], replace(storey.walls[0], id="twin"))),))
    one, two = with_guids(twice).storeys[0].walls
    assert one.guid != two.guid


def test_elements_without_one_are_known_by_scan_and_identifier() -> None:
    wall = buildings.one_room().storeys[0].walls[0]
    assert element_guid("a.laz", wall) != element_guid("b.laz", wall)
    assert element_guid("a.laz", replace(wall, guid="0YvctVUKr0kugbFTf53O9L")) == "0YvctVUKr0kugbFTf53O9L"
