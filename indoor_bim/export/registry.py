"""One writer for each kind of file, found by the ending of the file's name."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path

from indoor_bim.errors import WriteError
from indoor_bim.model import Building

WRITERS = {
    ".ifc": ("indoor_bim.export.ifc", "write_ifc"),
    ".json": ("indoor_bim.export.json", "write_json"),
    ".obj": ("indoor_bim.export.obj", "write_obj"),
    ".ply": ("indoor_bim.export.ply", "write_ply"),
    ".svg": ("indoor_bim.export.svg", "write_plans"),
}


def write(building: Building, path: str | os.PathLike[str]) -> None:
    """Write a building in the format that the ending of the file's name asks for.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File to create or to replace; its ending is a key of `WRITERS`.

    Raises
    ------
    WriteError
        If no writer knows the ending, or if the file cannot be written.

    Examples
    --------
    >>> write(Building("hut"), "hut.doc")
    Traceback (most recent call last):
        ...
    indoor_bim.errors.WriteError: hut.doc: no writer for ".doc"; expected one of .ifc, .json, .obj, .ply, .svg.
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise WriteError(f'{path}: no writer for "{ending}"; expected one of {", ".join(sorted(WRITERS))}.')
    module, name = WRITERS[ending]
    getattr(import_module(module), name)(building, path)
