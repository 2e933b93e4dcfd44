"""Map sheet as SVG: a page in millimetres at true scale."""

from __future__ import annotations

import os
from xml.etree import ElementTree

from indoor_bim.export.files import write_text
from indoor_bim.export.map_sheet import draw_map
from indoor_bim.export.svg import layer_group
from indoor_bim.export.svg_style import style_sheet
from indoor_bim.outdoor.model import Village

_STYLE = """
path.house-body { fill: #e6e1d8; stroke: none }
path.house-wall { stroke-width: 0.35; stroke-linecap: round }
path.unseen { stroke-dasharray: 1.6 1; stroke-width: 0.25 }
path.spot { fill: #7a4a1e; stroke: none }
text.spot-text { fill: #7a4a1e }
path.grid-cross { stroke: #5b8f5b; stroke-width: 0.13 }
"""


def write_map_svg(village: Village, path: str | os.PathLike[str], *, scale: int | None = None) -> None:
    """Write the map sheet as SVG.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    path : path
        File to create or to replace.
    scale : int, optional
        Denominator, 500 for 1:500; see `map_sheet.draw_map`.

    Raises
    ------
    WriteError
        If the file cannot be written, or if the village does not fit the scale asked for.
    """
    write_text(path, map_svg(village, scale=scale))


def map_svg(village: Village, *, scale: int | None = None) -> str:
    """Return the map sheet as SVG text; equal villages give equal text.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    scale : int, optional
        Denominator, 500 for 1:500.
    """
    sheet = draw_map(village, scale=scale)
    width, height = f"{sheet.page.width:g}", f"{sheet.page.height:g}"
    root = ElementTree.Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "xmlns:inkscape": "http://www.inkscape.org/namespaces/inkscape",
            "width": f"{width}mm",
            "height": f"{height}mm",
            "viewBox": f"0 0 {width} {height}",
            "data-scale": str(sheet.view.scale),
        },
    )
    ElementTree.SubElement(root, "title").text = f"{village.name} 1:{sheet.view.scale}"
    ElementTree.SubElement(root, "style").text = style_sheet("print") + _STYLE
    ElementTree.SubElement(root, "rect", {"class": "sheet", "width": width, "height": height})
    for layer in sheet.layers:
        root.append(layer_group(layer, {}))
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
