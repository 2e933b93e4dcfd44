"""Wavefront OBJ: one named group per element, with materials."""

from __future__ import annotations

import os
import re
from pathlib import Path

from indoor_bim.export.files import write_text
from indoor_bim.export.mesh import COLOURS, OPACITY, Part, building_parts
from indoor_bim.model import Building


def write_obj(building: Building, path: str | os.PathLike[str]) -> None:
    """Write the building as an OBJ file and the materials as an MTL file beside it.

    Coordinates are model coordinates: metres, z up. Each element is one group and one object, named after its identifier.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        OBJ file to create or to replace; the materials go to the same name with the suffix ``.mtl``.

    Raises
    ------
    WriteError
        If a file cannot be written.
    """
    target = Path(path)
    materials = target.with_suffix(".mtl")
    write_text(materials, mtl_text())
    write_text(target, obj_text(building_parts(building), materials=materials.name, notes=building.warnings))


def obj_text(parts: list[Part], *, materials: str, notes: tuple[str, ...] = ()) -> str:
    """Return parts as OBJ text.

    Parameters
    ----------
    parts : list of Part
        Closed surfaces, metres.
    materials : str
        Name of the MTL file.
    notes : tuple of str
        Sentences for the head of the file.

    Returns
    -------
    str
        OBJ document; coordinates are rounded to micrometres.
    """
    lines = ["# indoor_bim: metres, z up", *(f"# {' '.join(note.split())}" for note in notes), f"mtllib {materials}"]
    first = 1
    for part in parts:
        name = group_name(part.id)
        lines += [f"o {name}", f"g {name}", f"usemtl {part.material}"]
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in part.vertices.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (part.triangles + first).tolist()]
        first += len(part.vertices)
    return "\n".join(lines) + "\n"


def mtl_text() -> str:
    """Return the materials of all kinds of elements as MTL text."""
    lines = ["# indoor_bim"]
    for material, (red, green, blue) in COLOURS.items():
        lines += [f"newmtl {material}", f"Kd {red / 255:.4f} {green / 255:.4f} {blue / 255:.4f}", f"d {OPACITY.get(material, 1.0):.2f}", ""]
    return "\n".join(lines)


def group_name(id: str) -> str:
    """Return an identifier without the blanks that would split an OBJ name in two.

    Examples
    --------
    >>> group_name("north wall 3")
    'north_wall_3'
    """
    return re.sub(r"\s+", "_", id.strip())
