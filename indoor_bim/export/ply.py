"""PLY mesh: every element's surface in one file, coloured, each face knowing its element."""

from __future__ import annotations

import os

import numpy as np

from indoor_bim.export.files import replace_file
from indoor_bim.export.mesh import COLOURS, Part, building_parts
from indoor_bim.model import Building

_VERTEX = np.dtype([("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("red", "u1"), ("green", "u1"), ("blue", "u1")])
_FACE = np.dtype([("count", "u1"), ("vertex_indices", "<i4", 3), ("element", "<i4")])


def write_ply(building: Building, path: str | os.PathLike[str]) -> None:
    """Write the building as a binary PLY mesh in model coordinates: metres, z up.

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
    with replace_file(path) as draft:
        draft.write_bytes(ply_bytes(building_parts(building)))


def ply_bytes(parts: list[Part]) -> bytes:
    """Return parts as a binary little-endian PLY document.

    Parameters
    ----------
    parts : list of Part
        Closed surfaces, metres.

    Returns
    -------
    bytes
        PLY document; the face property ``element`` counts through the ``comment element`` lines of the head.
    """
    vertices = np.zeros(sum(len(part.vertices) for part in parts), dtype=_VERTEX)
    faces = np.zeros(sum(len(part.triangles) for part in parts), dtype=_FACE)
    faces["count"] = 3
    first_vertex = first_face = 0
    for number, part in enumerate(parts):
        corners = vertices[first_vertex : first_vertex + len(part.vertices)]
        triangles = faces[first_face : first_face + len(part.triangles)]
        for axis, name in enumerate("xyz"):
            corners[name] = part.vertices[:, axis]
        for channel, value in zip(("red", "green", "blue"), COLOURS[part.material], strict=True):
            corners[channel] = value
        triangles["vertex_indices"] = part.triangles + first_vertex
        triangles["element"] = number
        first_vertex += len(corners)
        first_face += len(triangles)
    head = [
        "ply",
        "format binary_little_endian 1.0",
        "comment indoor_bim: metres, z up",
        *(f"comment element {number} {part.material} {' '.join(part.id.split())}" for number, part in enumerate(parts)),
        f"element vertex {len(vertices)}",
        *(f"property double {name}" for name in "xyz"),
        *(f"property uchar {name}" for name in ("red", "green", "blue")),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "property int element",
        "end_header",
    ]
    return ("\n".join(head) + "\n").encode("utf-8") + vertices.tobytes() + faces.tobytes()
