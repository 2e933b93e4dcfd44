"""GeoJSON: every element as a polygon in plan with its properties, for GIS and web maps."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.export.files import write_text
from indoor_bim.export.guids import Identified, element_guid
from indoor_bim.export.mesh import opening_region, region
from indoor_bim.model import Building, Column, Evidence, Opening, Room, Slab, Storey, Wall

DECIMALS = 4


def write_geojson(building: Building, path: str | os.PathLike[str]) -> None:
    """Write the building as GeoJSON; see `geojson_text`.

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
    write_text(path, geojson_text(building))


def geojson_text(building: Building) -> str:
    """Return the building as GeoJSON text, one feature a line.

    RFC 7946 asks for longitudes and latitudes; a building needs better. Where the scan's coordinate reference system is known,
    coordinates are those of that system and the member ``crs`` names it, as GDAL and QGIS read it; else they are model
    coordinates and ``crs`` is null. All lengths are metres, rounded to a tenth of a millimetre.

    Parameters
    ----------
    building : Building
        Model, metres.

    Returns
    -------
    str
        FeatureCollection of slabs, rooms, walls, openings and columns, storey by storey.

    Examples
    --------
    >>> json.loads(geojson_text(Building("hut")))["features"]
    []
    """
    head: dict[str, Any] = {"type": "FeatureCollection", "name": building.name, "crs": None, "units": "m"}
    if building.crs:
        authority, code = building.crs.split(":", 1)
        head |= {"crs": {"type": "name", "properties": {"name": f"urn:ogc:def:crs:{authority}::{code}"}}}
        head["units"] = "unit of the coordinate reference system; lengths in properties are metres"
    to_map = np.linalg.inv(np.array(building.transform_cloud_to_model)) if building.crs else np.eye(4)
    lines = [_line(feature) for storey in building.storeys for feature in _features(building, storey, to_map)]
    start = json.dumps(head, ensure_ascii=False)[:-1]
    return start + ', "features": [' + ",".join(f"\n{line}" for line in lines) + ("\n" if lines else "") + "]}\n"


def _features(building: Building, storey: Storey, to_map: NDArray[np.float64]) -> Iterator[dict[str, Any]]:
    import shapely

    def feature(kind: str, element: Identified, shape: shapely.Geometry, at: float, /, **properties: object) -> dict[str, Any]:
        geometry = shapely.orient_polygons(shapely.transform(shape, lambda xy: _moved(xy, at, to_map)))
        return {
            "type": "Feature",
            "id": element.id,
            "geometry": json.loads(shapely.to_geojson(geometry)),
            "properties": {"kind": kind, "storey": storey.id, "guid": element_guid(building.source, element)} | properties,
        }

    for slab in storey.slabs:
        yield feature(f"{slab.kind} slab", slab, slab.outline.polygon, slab.level, **_slab(slab))
    for room in storey.rooms:
        yield feature("room", room, room.outline.polygon, room.floor, **_room(room))
    for wall in storey.walls:
        curve = next((curve.id for curve in storey.curves if wall.id in curve.walls), None)
        yield feature("wall", wall, region(wall.footprint), wall.base, curve=curve, **_wall(wall))
        for opening in wall.openings:
            shape = shapely.Polygon(opening_region(wall, opening)).intersection(region(wall.footprint))
            yield feature(opening.kind, opening, shape, wall.base + opening.sill, **_opening(opening, wall))
    for column in storey.columns:
        yield feature("column", column, region(column.footprint), column.base, **_column(column))


def _slab(slab: Slab) -> dict[str, object]:
    return {"name": slab.name, "level": slab.level, "thickness": slab.thickness, "area": round(slab.outline.area, DECIMALS)}


def _room(room: Room) -> dict[str, object]:
    area = {"area": round(room.area, DECIMALS)}
    return {"name": room.name, "floor": room.floor, "height": room.height, "walls": list(room.walls)} | area | _evidence(room.evidence)


def _wall(wall: Wall) -> dict[str, object]:
    return {
        "name": wall.name,
        "axis": [list(point) for point in wall.axis],
        "length": round(wall.length, DECIMALS),
        "thickness": wall.thickness,
        "thickness_measured": wall.thickness_measured,
        "base": wall.base,
        "height": wall.height,
        "external": wall.external,
        "seen": wall.seen,
    } | _evidence(wall.evidence)


def _opening(opening: Opening, wall: Wall) -> dict[str, object]:
    return {
        "name": opening.name,
        "wall": wall.id,
        "width": opening.width,
        "height": opening.height,
        "sill": opening.sill,
        "hinge": opening.hinge,
        "swing": opening.swing,
        "leaves": opening.leaves,
        "confidence": opening.confidence,
    }


def _column(column: Column) -> dict[str, object]:
    return {"name": column.name, "base": column.base, "height": column.height} | _evidence(column.evidence)


def _evidence(evidence: Evidence) -> dict[str, object]:
    return asdict(evidence)


def _moved(xy: NDArray[np.float64], level: float, to_map: NDArray[np.float64]) -> NDArray[np.float64]:
    points = np.column_stack([xy, np.full(len(xy), level), np.ones(len(xy))])
    return np.asarray(np.round((points @ to_map.T)[:, :2], DECIMALS) + 0.0)


def _line(feature: dict[str, Any]) -> str:
    return json.dumps(feature, ensure_ascii=False, allow_nan=False)
