"""Footprints of houses as GeoJSON in scan coordinates."""

from __future__ import annotations

import json
import os
from typing import Any

from indoor_bim.export.files import write_text
from indoor_bim.export.scan_coordinates import to_scan
from indoor_bim.outdoor.model import House, Village


def write_footprints(village: Village, path: str | os.PathLike[str]) -> None:
    """Write the footprints as GeoJSON.

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
    write_text(path, footprints_text(village))


def footprints_text(village: Village) -> str:
    """Return the footprints as GeoJSON: one Polygon for each house, coordinates of the scan.

    RFC 7946 asks for longitude and latitude; surveyors need the coordinates of the scan. They are written as they are, and the
    member ``crs`` of GeoJSON 2008 names their reference system, or is null.
    """
    name = None if village.crs is None else "urn:ogc:def:crs:" + village.crs.replace(":", "::")
    crs = None if name is None else {"type": "name", "properties": {"name": name}}
    head = json.dumps({"type": "FeatureCollection", "name": village.name, "crs": crs}, ensure_ascii=False)
    lines = (json.dumps(_feature(house, village), ensure_ascii=False, allow_nan=False) for house in village.houses)
    return head[:-1] + ', "features": [\n' + ",\n".join(lines) + "\n]}\n"


def _feature(house: House, village: Village) -> dict[str, Any]:
    corners = [(x, y, z) for x, y in house.footprint for z in (house.base, house.eave)]
    scan = to_scan(corners, village.transform_cloud_to_model)
    ring = [[round(x, 4), round(y, 4)] for x, y in scan[::2, :2].tolist()]
    edges = [
        {
            "length_m": round(facade.length, 3),
            "seen": facade.seen,
            "points": facade.evidence.support,
            "coverage": round(facade.evidence.coverage, 3),
            "rmse_m": None if facade.evidence.rmse is None else round(facade.evidence.rmse, 4),
        }
        for facade in house.facades
    ]
    properties: dict[str, Any] = {
        "id": house.id,
        "area_m2": round(house.area, 3),
        "storeys": house.storeys,
        "base_z": round(float(scan[::2, 2].mean()), 3),
        "eave_z": round(float(scan[1::2, 2].mean()), 3),
        "height_m": round(house.height, 3),
        "material": house.material,
        "rmse_m": None if house.evidence.rmse is None else round(house.evidence.rmse, 4),
        "coverage": round(house.evidence.coverage, 3),
        "points": house.evidence.support,
        "closed_by_assumption": any(not facade.seen for facade in house.facades),
    }
    properties |= {name: value for name, value in house.attributes if name not in properties}
    properties["edges"] = edges
    return {"type": "Feature", "id": house.id, "properties": properties, "geometry": {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}}
