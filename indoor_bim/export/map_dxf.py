"""Map as DXF: scan coordinates, footprints at the height of the ground, spot heights as points."""

from __future__ import annotations

import io
import os
from typing import Any

import numpy as np

from indoor_bim.errors import WriteError
from indoor_bim.export.dxf import fixed_time
from indoor_bim.export.files import write_text
from indoor_bim.export.map_sheet import draw_map, label_lines
from indoor_bim.export.scan_coordinates import to_scan
from indoor_bim.outdoor.model import House, Village

APP = "INDOOR_BIM"
LAYERS = {
    "HOUSE": (7, 35),
    "HOUSE-UNSEEN": (8, 18),
    "HOUSE-TEXT": (7, 18),
    "SPOT-HEIGHT": (30, 13),
    "SPOT-HEIGHT-TEXT": (30, 13),
}
TEXT_MM, SPOT_MM = 2.0, 1.5


def write_map_dxf(village: Village, path: str | os.PathLike[str], *, scale: int | None = None) -> None:
    """Write the map as DXF.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    path : path
        File to create or to replace.
    scale : int, optional
        Denominator that sets the size of texts; by default that of the map sheet.

    Raises
    ------
    WriteError
        If the file cannot be written, or if ezdxf is not installed.
    """
    write_text(path, map_dxf(village, scale=scale))


def map_dxf(village: Village, *, scale: int | None = None) -> str:
    """Return the map as DXF (AutoCAD 2018) text: model space in scan coordinates; equal villages give equal text.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    scale : int, optional
        Denominator that sets the size of texts.
    """
    try:
        from ezdxf.filemanagement import new
    except ImportError as error:
        raise WriteError("writing DXF needs the package ezdxf; install it: pip install 'indoor-bim[dxf]'") from error
    denominator = scale or draw_map(village).view.scale
    unit = denominator / 1000 / float(np.hypot(*np.asarray(village.transform_cloud_to_model)[:2, 0]))
    with fixed_time():
        doc = new("R2018", setup=True, units=6)
        doc.appids.new(APP)
        doc.styles.add("MAP", font="arial.ttf")
        for name, (colour, weight) in LAYERS.items():
            doc.layers.add(name, color=colour, lineweight=weight)
        doc.layers.get("HOUSE-UNSEEN").dxf.linetype = "DASHED"
        for house in village.houses:
            _add_house(doc.modelspace(), house, village, unit)
        for x, y, z in to_scan(village.spot_heights or np.zeros((0, 3)), village.transform_cloud_to_model).tolist():
            doc.modelspace().add_point((x, y, z), dxfattribs={"layer": "SPOT-HEIGHT"})
            _add_text(doc.modelspace(), f"{z:.2f}", (x + 0.5 * SPOT_MM * unit, y), SPOT_MM * unit, "SPOT-HEIGHT-TEXT", "LEFT")
        stream = io.StringIO()
        doc.write(stream)
    return stream.getvalue()


def _add_house(space: Any, house: House, village: Village, unit: float) -> None:
    ring = to_scan([(x, y, house.base) for x, y in house.footprint], village.transform_cloud_to_model)
    attributes = {"layer": "HOUSE", "elevation": float(ring[:, 2].mean())}
    outline = space.add_lwpolyline(ring[:, :2].tolist(), close=True, dxfattribs=attributes)
    outline.set_xdata(APP, [(1000, f"id={house.id}"), (1040, house.height), (1070, house.storeys)])
    for facade in house.facades:
        if not facade.seen:
            ends = to_scan([(*facade.start, house.base), (*facade.end, house.base)], village.transform_cloud_to_model)
            space.add_line(ends[0].tolist(), ends[1].tolist(), dxfattribs={"layer": "HOUSE-UNSEEN"})
    x, y, _ = to_scan([(*house.centroid, house.base)], village.transform_cloud_to_model)[0]
    for i, line in enumerate((house.id, *label_lines(house))):
        _add_text(space, line, (x, y - 1.5 * (i - 1) * TEXT_MM * unit), TEXT_MM * unit, "HOUSE-TEXT", "MIDDLE_CENTER")


def _add_text(space: Any, text: str, at: tuple[float, float], height: float, layer: str, align: str) -> None:
    from ezdxf.enums import TextEntityAlignment

    space.add_text(text, dxfattribs={"layer": layer, "height": height, "style": "MAP"}).set_placement(at, align=TextEntityAlignment[align])
