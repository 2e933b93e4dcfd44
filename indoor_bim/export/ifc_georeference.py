"""Where the model lies on the map."""

from __future__ import annotations

import logging
from math import acos, degrees, hypot

from indoor_bim.export.ifc_file import IfcFile
from indoor_bim.model import Building

MAX_TILT_DEGREES = 0.1
_FEET = {"FOOT": 0.3048, "US SURVEY FOOT": 1200 / 3937}
_log = logging.getLogger(__name__)


def add_georeference(ifc: IfcFile, building: Building) -> None:
    """Add a map conversion for both contexts when the scan's coordinate reference system is known.

    Scan coordinates are map coordinates then, in metres or feet; scans in other units are taken to metres. A tilted model gets none;
    the slight tilt that levelling leaves is laid about the middle of the building, where it does least.
    """
    if building.crs is None:
        _log.info("The coordinate reference system of the scan is not known: the IFC has local coordinates.")
        return
    linear = [row[:3] for row in building.transform_cloud_to_model[:3]]
    scale = hypot(*linear[2])
    tilt = degrees(acos(max(-1.0, min(1.0, linear[2][2] / scale))))
    if tilt > MAX_TILT_DEGREES:
        _log.warning("The model is tilted by %.2f degrees against the scan: the IFC is written without %s.", tilt, building.crs)
        return
    foot = next((name for name, size in _FEET.items() if abs(scale / size - 1) < 1e-9), None)
    unit = _FEET[foot] if foot else 1.0
    length = hypot(linear[0][0], linear[0][1])
    x_axis = (linear[0][0] / length, linear[0][1] / length)
    x, y, z = middle = _middle(building)
    shift = [row[3] for row in building.transform_cloud_to_model[:3]]
    on_map = [sum(linear[i][j] * (middle[i] - shift[i]) for i in range(3)) / scale / unit for j in range(3)]
    turned = (x_axis[0] * x - x_axis[1] * y, x_axis[1] * x + x_axis[0] * y, z)
    origin = [place - offset / unit for place, offset in zip(on_map, turned, strict=True)]
    map_unit = ifc.units[0]
    if foot:
        size = ifc.create("IfcMeasureWithUnit", ifc.create("IfcLengthMeasure", unit), ifc.units[0])
        dimensions = ifc.create("IfcDimensionalExponents", 1, 0, 0, 0, 0, 0, 0)
        map_unit = ifc.create("IfcConversionBasedUnit", dimensions, "LENGTHUNIT", foot, size)
    crs = ifc.create("IfcProjectedCRS", Name=building.crs, MapUnit=map_unit)
    for context in (ifc.model_context, ifc.plan_context):
        context.TrueNorth = ifc.direction((x_axis[1], x_axis[0]))
        ifc.create("IfcMapConversion", context, crs, *origin, *x_axis, 1.0 / unit)


def _middle(building: Building) -> tuple[float, float, float]:
    """Middle of the plan on the lowest floor, metres."""
    corners = [corner for storey in building.storeys for wall in storey.walls for corner in wall.footprint]
    if not corners:
        return 0.0, 0.0, 0.0
    (x0, x1), (y0, y1) = ((min(values), max(values)) for values in zip(*corners, strict=True))
    return (x0 + x1) / 2, (y0 + y1) / 2, building.storeys[0].elevation
