"""The building model as a JSON document, to and fro without loss."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from indoor_bim.errors import ReadError
from indoor_bim.export.files import write_text
from indoor_bim.model import FORMAT, UNITS, VERSION, Building

if TYPE_CHECKING:
    from pydantic import TypeAdapter

SCHEMA_ID = "https://indoor-bim.invalid/schemas/building.schema.json"
_HEAD = ("format", "version", "units", "name", "source", "method", "crs", "transform_cloud_to_model", "warnings", "storeys")
_MOST_COMPLAINTS = 10


def to_json(building: Building) -> str:
    """Write a building as indented JSON text; equal buildings give equal text.

    Parameters
    ----------
    building : Building
        Model, metres.

    Returns
    -------
    str
        JSON document; every number has as many digits as it takes to read back the same number.

    Examples
    --------
    >>> from_json(to_json(Building("hut"))) == Building("hut")
    True
    """
    fields = _adapter().dump_python(building, mode="json")
    document = {name: fields[name] for name in _HEAD} | fields
    return "".join(_chunks(document, indent="")) + "\n"


def from_json(text: str, *, name: str = "building model") -> Building:
    """Read a building from JSON text.

    Parameters
    ----------
    text : str
        JSON document.
    name : str
        What error messages call the document.

    Returns
    -------
    Building
        Model, metres.

    Raises
    ------
    ReadError
        If the text is not JSON or not a building model; the message names each field that is wrong.
    """
    from pydantic import ValidationError

    _check_kind(text, name=name)
    try:
        building = _adapter().validate_json(text, strict=True)
    except ValidationError as error:
        raise ReadError(_report(name, [f"{_field_path(fault['loc'])}: {fault['msg']}" for fault in error.errors()])) from None
    complaints = list(_dangling(building))
    if complaints:
        raise ReadError(_report(name, complaints))
    return building


def write_json(building: Building, path: str | os.PathLike[str]) -> None:
    """Write a building to a JSON file.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File to create or to replace.

    Raises
    ------
    WriteError
        If the file cannot be written.
    """
    write_text(path, to_json(building))


def read_json(path: str | os.PathLike[str]) -> Building:
    """Read a building from a JSON file.

    Parameters
    ----------
    path : path
        File written by `write_json`, or edited by hand.

    Returns
    -------
    Building
        Model, metres.

    Raises
    ------
    ReadError
        If the file is missing, not JSON or not a building model; the message names each field that is wrong.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise ReadError(f"{path}: cannot be read ({error.strerror}).") from error
    except UnicodeDecodeError as error:
        raise ReadError(f"{path}: is not text in UTF-8; expected a building model in JSON.") from error
    return from_json(text, name=str(path))


def building_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the building model.

    Returns
    -------
    dict
        Schema that every document of `to_json` follows.
    """
    schema = _adapter().json_schema()
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA_ID}
    required = ["format", "version", "units", *schema["required"]]
    return head | schema | {"title": "Building model", "required": required}


def schema_text() -> str:
    """Return the text of the file ``schemas/building.schema.json``."""
    return json.dumps(building_schema(), indent=2, ensure_ascii=False) + "\n"


@cache
def _adapter() -> TypeAdapter[Building]:
    from pydantic import TypeAdapter

    return TypeAdapter(Building)


def _chunks(value: object, *, indent: str) -> Iterator[str]:
    """JSON text with one field or object a line and plain lists on one line."""
    deeper = indent + "  "
    if isinstance(value, dict) and value:
        for i, (key, item) in enumerate(value.items()):
            yield f"{',' if i else '{'}\n{deeper}{json.dumps(key)}: "
            yield from _chunks(item, indent=deeper)
        yield f"\n{indent}}}"
    elif isinstance(value, list) and value and isinstance(value[0], dict | str):
        for i, item in enumerate(value):
            yield f"{',' if i else '['}\n{deeper}"
            yield from _chunks(item, indent=deeper)
        yield f"\n{indent}]"
    else:
        yield json.dumps(value, ensure_ascii=False, allow_nan=False)


def _check_kind(text: str, *, name: str) -> None:
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise ReadError(f"{name}: is not JSON (line {error.lineno}, column {error.colno}: {error.msg}).") from None
    found = document.get("format") if isinstance(document, dict) else None
    if found != FORMAT:
        raise ReadError(f'{name}: is not a building model: expected "format": "{FORMAT}" at the top, found {json.dumps(found)}.')
    version = document.get("version")
    if version != VERSION:
        raise ReadError(f"{name}: is a building model of version {json.dumps(version)}; this program reads version {VERSION}.")
    if document.get("units") != UNITS:
        raise ReadError(f'{name}: units: expected "{UNITS}", found {json.dumps(document.get("units"))}.')


def _field_path(location: tuple[int | str, ...]) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location).lstrip(".") or "document"


def _dangling(building: Building) -> Iterator[str]:
    """Yield a complaint for each identifier used twice or leading nowhere."""
    used: Counter[str] = Counter()
    for i, storey in enumerate(building.storeys):
        walls = {wall.id for wall in storey.walls}
        used.update([storey.id])
        used.update(element.id for group in (storey.walls, storey.curves, storey.columns, storey.rooms, storey.slabs) for element in group)
        used.update(opening.id for wall in storey.walls for opening in wall.openings)
        for j, joint in enumerate(storey.joints):
            if len(joint.walls) != len(joint.ends):
                yield f"storeys[{i}].joints[{j}].ends: expected one for each of the {len(joint.walls)} walls, found {len(joint.ends)}"
            for missing in sorted(set(joint.walls) - walls):
                yield f'storeys[{i}].joints[{j}].walls: there is no wall "{missing}" in the storey'
        for j, curve in enumerate(storey.curves):
            for missing in sorted(set(curve.walls) - walls):
                yield f'storeys[{i}].curves[{j}].walls: there is no wall "{missing}" in the storey'
        for j, room in enumerate(storey.rooms):
            for missing in sorted(set(room.walls) - walls):
                yield f'storeys[{i}].rooms[{j}].walls: there is no wall "{missing}" in the storey'
    for name in sorted(name for name, count in used.items() if count > 1):
        yield f'the identifier "{name}" is used {used[name]} times; identifiers are unique in a building'


def _report(name: str, complaints: list[str]) -> str:
    shown = complaints[:_MOST_COMPLAINTS]
    more = [f"... and {len(complaints) - len(shown)} more"] if len(complaints) > len(shown) else []
    return "\n  ".join([f"{name}: is not a valid building model:", *shown, *more])
