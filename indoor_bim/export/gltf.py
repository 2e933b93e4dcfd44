"""glTF 2.0: one named mesh per element with its material, storeys as nodes; what web viewers and game engines load."""

from __future__ import annotations

import base64
import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from indoor_bim import __version__
from indoor_bim.export.files import replace_file
from indoor_bim.export.guids import storey_guids
from indoor_bim.export.mesh import COLOURS, OPACITY, Material, Part, storey_parts
from indoor_bim.model import Building

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_Z_UP = [-0.7071067811865476, 0.0, 0.0, 0.7071067811865476]


def write_gltf(building: Building, path: str | os.PathLike[str]) -> None:
    """Write the building as glTF: binary for names that end in ``.glb``, else JSON with the data inside.

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
    document, data = gltf_document(building)
    binary = Path(path).suffix.lower() == ".glb"
    with replace_file(path) as draft:
        draft.write_bytes(glb_bytes(document, data) if binary else _embedded(document, data))


def glb_bytes(document: dict[str, Any], data: bytes) -> bytes:
    """Return a document and its data as a binary glTF file.

    Parameters
    ----------
    document : dict
        glTF document.
    data : bytes
        Its buffer, a multiple of 4 long.
    """
    text = _text(document)
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), _JSON) + text
    if data:
        chunks += struct.pack("<II", len(data), _BIN) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def gltf_document(building: Building) -> tuple[dict[str, Any], bytes]:
    """Return the building as a glTF document and its buffer.

    Coordinates are model coordinates, z up, under a root node that turns them into glTF's y up. Nodes carry the identifier, the
    kind and the GlobalId of their element as extras.

    Parameters
    ----------
    building : Building
        Model, metres.

    Returns
    -------
    document : dict
        glTF 2.0 document.
    data : bytes
        Corners as float32 and triangles as uint32.

    Examples
    --------
    >>> document, data = gltf_document(Building("hut"))
    >>> document["nodes"][0]["name"], data
    ('hut', b'')
    """
    materials: dict[Material, int] = {}
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": f"indoor-bim {__version__}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": building.name, "rotation": _Z_UP}],
    }
    chunks: list[bytes] = []
    storeys = []
    for storey in building.storeys:
        guids = storey_guids(building.source, storey)
        members = []
        for part in storey_parts(storey):
            mesh = _add_mesh(document, part, materials.setdefault(part.material, len(materials)), chunks)
            extras = {"id": part.id, "kind": part.material, "guid": guids[part.id]}
            members.append(_add(document, "nodes", {"name": part.id, "mesh": mesh, "extras": extras}))
        node = {"name": storey.name, "extras": {"id": storey.id, "kind": "storey"}}
        storeys.append(_add(document, "nodes", node | ({"children": members} if members else {})))
    if storeys:
        document["nodes"][0]["children"] = storeys
    if materials:
        document["materials"] = [_material(name) for name in materials]
    data = b"".join(chunks)
    if data:
        document["buffers"] = [{"byteLength": len(data)}]
    return document, data


def _add(document: dict[str, Any], list_name: str, entry: dict[str, Any]) -> int:
    document.setdefault(list_name, []).append(entry)
    return len(document[list_name]) - 1


def _add_mesh(document: dict[str, Any], part: Part, material: int, chunks: list[bytes]) -> int:
    corners = part.vertices.astype("<f4")
    triangles = part.triangles.astype("<u4")

    def accessor(values: np.ndarray, target: int, entry: dict[str, Any]) -> int:
        start = _end(document)
        chunks.append(values.tobytes())
        view = _add(document, "bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": values.nbytes, "target": target})
        return _add(document, "accessors", {"bufferView": view} | entry)

    bounds = {"min": corners.min(axis=0).tolist(), "max": corners.max(axis=0).tolist()}
    place = accessor(corners, _VERTICES, {"componentType": _FLOAT, "count": len(corners), "type": "VEC3"} | bounds)
    index = accessor(triangles, _INDICES, {"componentType": _UNSIGNED, "count": triangles.size, "type": "SCALAR"})
    primitive = {"attributes": {"POSITION": place}, "indices": index, "material": material}
    return _add(document, "meshes", {"name": part.id, "primitives": [primitive]})


def _end(document: dict[str, Any]) -> int:
    views = document.get("bufferViews")
    return int(views[-1]["byteOffset"] + views[-1]["byteLength"]) if views else 0


def _material(name: Material) -> dict[str, Any]:
    opacity = OPACITY.get(name, 1.0)
    colour = [round(_linear(channel / 255), 6) for channel in COLOURS[name]]
    material: dict[str, Any] = {
        "name": name,
        "pbrMetallicRoughness": {"baseColorFactor": [*colour, opacity], "metallicFactor": 0.0, "roughnessFactor": 0.9},
    }
    return material | ({"alphaMode": "BLEND", "doubleSided": True} if opacity < 1 else {})


def _linear(channel: float) -> float:
    """Take a channel of sRGB to the linear one that glTF asks for."""
    return channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4


def _text(document: dict[str, Any]) -> bytes:
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode("utf-8")


def _embedded(document: dict[str, Any], data: bytes) -> bytes:
    if data:
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode("ascii")
        document = document | {"buffers": [{"byteLength": len(data), "uri": uri}]}
    return _text(document) + b"\n"
