"""Houses as closed surfaces: PLY and OBJ."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from indoor_bim.export.files import replace_file, write_text
from indoor_bim.export.mesh import Part, closed_surface, region
from indoor_bim.export.obj import mtl_text, obj_text
from indoor_bim.export.ply import ply_bytes
from indoor_bim.outdoor.model import House, Village


def house_part(house: House) -> Part:
    """Walls from base to eave, roof and floor of a house as one closed surface, also for concave outlines.

    Parameters
    ----------
    house : House
        House, metres.
    """
    vertices, triangles = closed_surface(region(house.footprint), bottom=house.base, top=house.eave)
    return Part(house.id, "house", vertices, triangles)


def write_houses_ply(village: Village, path: str | os.PathLike[str]) -> None:
    """Write all houses as one binary PLY mesh in model coordinates: metres, z up, every house closed.

    Parameters
    ----------
    village : Village
        Houses, metres.
    path : path
        File to create or to replace.

    Raises
    ------
    WriteError
        If the file cannot be written.
    """
    with replace_file(path) as draft:
        draft.write_bytes(ply_bytes([house_part(house) for house in village.houses]))


def write_houses_obj(village: Village, path: str | os.PathLike[str]) -> None:
    """Write houses and ground as an OBJ file in model coordinates, and its materials as an MTL file beside it.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    path : path
        OBJ file to create or to replace.

    Raises
    ------
    WriteError
        If a file cannot be written.
    """
    target = Path(path)
    materials = target.with_suffix(".mtl")
    parts = [house_part(house) for house in village.houses]
    if village.ground.triangles:
        parts.append(Part("ground", "ground", np.array(village.ground.vertices), np.array(village.ground.triangles, dtype=np.int64)))
    write_text(materials, mtl_text())
    write_text(target, obj_text(parts, materials=materials.name, notes=village.warnings))
