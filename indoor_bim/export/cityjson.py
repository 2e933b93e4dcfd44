"""Houses as CityJSON 2.0, level of detail 1: footprints raised to the eave, in scan coordinates."""

from __future__ import annotations

import json
import os
from math import floor
from typing import Any

import numpy as np

from indoor_bim.export.files import write_text
from indoor_bim.export.guids import NAMESPACE
from indoor_bim.export.scan_coordinates import to_scan
from indoor_bim.outdoor.model import House, Village

STEP = 0.001


def write_cityjson(village: Village, path: str | os.PathLike[str]) -> None:
    """Write the houses as CityJSON.

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
    write_text(path, cityjson_text(village))


def cityjson_text(village: Village) -> str:
    """Return the houses as CityJSON 2.0 (OGC 20-072r5): one Building with a Solid of LoD 1.2 each, ground as a TINRelief.

    Coordinates are those of the scan in whole millimetres from its lower corner. Walls, roof and floor carry their semantics.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    """
    corners = [_corners(house, village) for house in village.houses]
    ground = to_scan(village.ground.vertices or np.zeros((0, 3)), village.transform_cloud_to_model)
    everything = np.concatenate([*corners, ground]) if corners or len(ground) else np.zeros((1, 3))
    origin = np.floor(everything.min(axis=0))
    vertices = _Vertices(origin)
    objects: dict[str, Any] = {}
    for house, own in zip(village.houses, corners, strict=True):
        objects[house.id] = _building(house, [vertices.index(corner) for corner in own])
    if village.ground.triangles:
        indices = [vertices.index(corner) for corner in ground]
        surfaces = [[[indices[i] for i in triangle]] for triangle in village.ground.triangles]
        surfaces = [surface for surface in surfaces if len(set(surface[0])) == 3]
        objects["ground"] = {"type": "TINRelief", "geometry": [{"type": "CompositeSurface", "lod": "1", "boundaries": surfaces}]}
    metadata: dict[str, Any] = {"identifier": str(_identifier(village)), "title": village.name}
    bounds = np.array(vertices.integers or [(0, 0, 0)])
    low, high = bounds.min(axis=0) * STEP + origin, bounds.max(axis=0) * STEP + origin
    metadata["geographicalExtent"] = [round(float(x), 3) for x in (*low, *high)]
    if village.crs is not None:
        metadata["referenceSystem"] = "https://www.opengis.net/def/crs/EPSG/0/" + village.crs.partition(":")[2]
    document = {
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [STEP] * 3, "translate": [float(x) for x in origin]},
        "metadata": metadata,
        "CityObjects": objects,
        "vertices": vertices.integers,
    }
    return json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


class _Vertices:
    """Shared corners in whole steps from the origin."""

    def __init__(self, origin: Any) -> None:
        self.origin = origin
        self.integers: list[tuple[int, int, int]] = []
        self._known: dict[tuple[int, int, int], int] = {}

    def index(self, point: Any) -> int:
        """Return the number of a corner; equal corners have one."""
        x, y, z = (floor(value / STEP + 0.5) for value in point - self.origin)
        key = (int(x), int(y), int(z))
        if key not in self._known:
            self._known[key] = len(self.integers)
            self.integers.append(key)
        return self._known[key]


def _corners(house: House, village: Village) -> Any:
    """Corners of the floor, then of the roof, in scan coordinates."""
    low = [(x, y, house.base) for x, y in house.footprint]
    high = [(x, y, house.eave) for x, y in house.footprint]
    return to_scan([*low, *high], village.transform_cloud_to_model)


def _building(house: House, corners: list[int]) -> dict[str, Any]:
    count = len(house.footprint)
    floor_ring, roof_ring = corners[:count], corners[count:]
    walls = []
    for i in range(count):
        j = (i + 1) % count
        walls.append([[floor_ring[i], floor_ring[j], roof_ring[j], roof_ring[i]]])
    shell = [[floor_ring[::-1]], [roof_ring], *walls]
    attributes: dict[str, Any] = {
        "measuredHeight": round(house.height, 3),
        "storeysAboveGround": house.storeys,
        "area": round(house.area, 3),
        "closedByAssumption": any(not facade.seen for facade in house.facades),
    }
    if house.material is not None:
        attributes["material"] = house.material
    attributes |= {name: value for name, value in house.attributes if name not in attributes}
    semantics = {
        "surfaces": [{"type": "GroundSurface"}, {"type": "RoofSurface"}, {"type": "WallSurface"}],
        "values": [[0, 1, *[2] * count]],
    }
    geometry = {"type": "Solid", "lod": "1.2", "boundaries": [shell], "semantics": semantics}
    return {"type": "Building", "attributes": attributes, "geometry": [geometry]}


def _identifier(village: Village) -> Any:
    import uuid

    return uuid.uuid5(NAMESPACE, f"{village.source}/CityJSON")
