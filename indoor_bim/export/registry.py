"""One writer for each kind of file, found by the ending of the file's name."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from indoor_bim.errors import WriteError
from indoor_bim.export.plan_style import USUAL, PlanStyle
from indoor_bim.model import Building


class Writer(NamedTuple):
    """Where a writer is found, and which of the options of `write` it takes."""

    module: str
    function: str
    options: tuple[str, ...] = ()


WRITERS = {
    ".dxf": Writer("indoor_bim.export.dxf", "write_dxf", ("style",)),
    ".geojson": Writer("indoor_bim.export.geojson", "write_geojson"),
    ".glb": Writer("indoor_bim.export.gltf", "write_gltf"),
    ".gltf": Writer("indoor_bim.export.gltf", "write_gltf"),
    ".ifc": Writer("indoor_bim.export.ifc", "write_ifc", ("schema",)),
    ".json": Writer("indoor_bim.export.json", "write_json"),
    ".obj": Writer("indoor_bim.export.obj", "write_obj"),
    ".pdf": Writer("indoor_bim.export.rendered_plan", "write_pdf", ("style",)),
    ".ply": Writer("indoor_bim.export.ply", "write_ply"),
    ".png": Writer("indoor_bim.export.rendered_plan", "write_png", ("style",)),
    ".svg": Writer("indoor_bim.export.svg", "write_plans", ("style",)),
}
KINDS = {ending[1:]: ending for ending in WRITERS} | {"gltf": ".glb"}


def write(building: Building, path: str | os.PathLike[str], *, schema: str = "IFC4", style: PlanStyle = USUAL) -> None:
    """Write a building in the format that the ending of the file's name asks for.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File to create or to replace; its ending is a key of `WRITERS`.
    schema : {"IFC4", "IFC4X3"}
        Schema of IFC files.
    style : PlanStyle
        Scale, paper, colours and underlays of plans.

    Raises
    ------
    WriteError
        If no writer knows the ending, if what a writer needs is not installed, or if the file cannot be written.

    Examples
    --------
    >>> write(Building("hut"), "hut.doc")
    Traceback (most recent call last):
        ...
    indoor_bim.errors.WriteError: hut.doc: no writer for ".doc"; there are dxf, geojson, glb, gltf, ifc, json, obj, pdf, ply, png, svg.
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise WriteError(f'{path}: no writer for "{ending}"; there are {", ".join(sorted(KINDS))}.')
    writer = WRITERS[ending]
    options = {name: value for name, value in (("schema", schema), ("style", style)) if name in writer.options}
    getattr(import_module(writer.module), writer.function)(building, path, **options)
