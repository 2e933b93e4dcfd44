"""Floor plan as SVG: a page in millimetres at true scale, layers as groups, identifiers of the model."""

from __future__ import annotations

import base64
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from indoor_bim.export.files import write_text
from indoor_bim.export.marks import Arc, Item, Layer, Mark, Stroke
from indoor_bim.export.page import View
from indoor_bim.export.sheet import draw_plan, find_storey
from indoor_bim.export.svg_style import style_sheet
from indoor_bim.model import Building, Point2

Theme = Literal["print", "dark"]

_SVG = "http://www.w3.org/2000/svg"
_INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"


@dataclass(frozen=True, slots=True)
class Underlay:
    """Picture that lies under the plan.

    Parameters
    ----------
    png : bytes
        PNG file.
    bounds : (float, float, float, float)
        Least x and y, greatest x and y of the picture in model coordinates, metres.
    """

    png: bytes
    bounds: tuple[float, float, float, float]


def plan_svg(building: Building, *, storey: str | None = None, theme: Theme = "print", underlay: Underlay | None = None) -> str:
    """Return the plan of one storey as SVG text.

    Parameters
    ----------
    building : Building
        Model, metres.
    storey : str, optional
        Identifier of the storey; by default the first one.
    theme : {"print", "dark"}
        Colours.
    underlay : Underlay, optional
        Picture of the scan to lie under the plan.

    Returns
    -------
    str
        SVG document; equal input gives equal text.

    Raises
    ------
    WriteError
        If there is no storey of that identifier.
    """
    plan = draw_plan(building, storey=storey)
    width, height = _number(plan.page.width), _number(plan.page.height)
    root = ElementTree.Element(
        "svg",
        {
            "xmlns": _SVG,
            "xmlns:inkscape": _INKSCAPE,
            "width": f"{width}mm",
            "height": f"{height}mm",
            "viewBox": f"0 0 {width} {height}",
        },
    )
    shown = find_storey(building, storey)
    ElementTree.SubElement(root, "title").text = _clean(" - ".join(filter(None, (building.name, shown.name if shown else ""))))
    if plan.view:
        root.set("data-scale", str(plan.view.scale))
        root.set("data-model-origin", _pair(plan.view.point((0.0, 0.0))))
    ElementTree.SubElement(root, "style").text = style_sheet(theme)
    ElementTree.SubElement(root, "rect", {"class": "sheet", "width": width, "height": height})
    if underlay and plan.view:
        root.append(_image(underlay, plan.view))
    for layer in plan.layers:
        root.append(_group(layer))
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def write_svg(
    building: Building,
    path: str | os.PathLike[str],
    *,
    storey: str | None = None,
    theme: Theme = "print",
    underlay: Underlay | None = None,
) -> None:
    """Write the plan of one storey as SVG.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File to create or to replace.
    storey : str, optional
        Identifier of the storey; by default the first one.
    theme : {"print", "dark"}
        Colours.
    underlay : Underlay, optional
        Picture of the scan to lie under the plan.

    Raises
    ------
    WriteError
        If there is no storey of that identifier, or if the file cannot be written.
    """
    write_text(path, plan_svg(building, storey=storey, theme=theme, underlay=underlay))


def plan_paths(building: Building, path: str | os.PathLike[str]) -> dict[Path, str | None]:
    """Return the file of each storey's plan: the first at `path`, each other with its storey's identifier added to the name.

    Parameters
    ----------
    building : Building
        Model.
    path : path
        File of the first plan.

    Returns
    -------
    dict
        Paths and the identifiers of their storeys; one path without identifier for a building without storeys.

    Examples
    --------
    >>> from indoor_bim.model import Storey
    >>> house = Building("H", (Storey("G", "Ground", 0.0, 2.5), Storey("U", "Upper", 2.8, 2.5)))
    >>> [str(path) for path in plan_paths(house, "plan.svg")]
    ['plan.svg', 'plan-U.svg']
    """
    first = Path(path)
    paths: dict[Path, str | None] = {}
    for storey in building.storeys:
        suffix = re.sub(r"[^\w.-]+", "_", storey.id)
        paths[first.with_stem(f"{first.stem}-{suffix}") if paths else first] = storey.id
    return paths or {first: None}


def write_plans(building: Building, path: str | os.PathLike[str], *, theme: Theme = "print") -> list[Path]:
    """Write one plan for each storey.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File of the first storey's plan; the others stand beside it, see `plan_paths`.
    theme : {"print", "dark"}
        Colours.

    Returns
    -------
    list of pathlib.Path
        Files written.

    Raises
    ------
    WriteError
        If a file cannot be written.
    """
    paths = plan_paths(building, path)
    for target, storey in paths.items():
        write_svg(building, target, storey=storey, theme=theme)
    return list(paths)


def _group(layer: Layer) -> ElementTree.Element:
    attributes = {"id": f"layer-{layer.name}", "inkscape:groupmode": "layer", "inkscape:label": layer.label}
    group = ElementTree.Element("g", attributes)
    for item in layer.items:
        group.append(_item(item))
    return group


def _item(item: Item) -> ElementTree.Element:
    attributes = {"id": _clean(item.id), "class": item.kind}
    group = ElementTree.Element("g", {name: value for name, value in attributes.items() if value})
    if item.title:
        ElementTree.SubElement(group, "title").text = _clean(item.title)
    for mark in item.marks:
        group.append(_mark(mark))
    return group


def _mark(mark: Mark) -> ElementTree.Element:
    if isinstance(mark, Stroke):
        end = " Z" if mark.closed else ""
        path = " ".join("M " + " L ".join(_pair(corner) for corner in line) + end for line in mark.lines)
        return ElementTree.Element("path", {"class": mark.style, "d": path})
    if isinstance(mark, Arc):
        radius, sweep = _number(mark.radius), "1" if mark.clockwise else "0"
        path = f"M {_pair(mark.start)} A {radius} {radius} 0 0 {sweep} {_pair(mark.end)}"
        return ElementTree.Element("path", {"class": mark.style, "d": path})
    x, y = (_number(value) for value in mark.at)
    attributes = {"class": mark.style, "x": x, "y": y, "font-size": _number(mark.size), "text-anchor": mark.anchor}
    if mark.bold:
        attributes["font-weight"] = "bold"
    if mark.angle:
        attributes["transform"] = f"rotate({_number(mark.angle)} {x} {y})"
    element = ElementTree.Element("text", attributes)
    element.text = _clean(mark.text)
    return element


def _image(underlay: Underlay, view: View) -> ElementTree.Element:
    x0, y0, x1, y1 = underlay.bounds
    (left, top), (right, bottom) = view.point((x0, y1)), view.point((x1, y0))
    place = {"x": left, "y": top, "width": right - left, "height": bottom - top}
    attributes = {"id": "underlay", "class": "underlay", "preserveAspectRatio": "none"}
    attributes |= {name: _number(value) for name, value in place.items()}
    attributes["href"] = "data:image/png;base64," + base64.b64encode(underlay.png).decode("ascii")
    return ElementTree.Element("image", attributes)


def _number(value: float) -> str:
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _pair(point: Point2) -> str:
    return f"{_number(point[0])} {_number(point[1])}"


def _clean(text: str) -> str:
    """Text without the control characters that XML forbids."""
    return re.sub(r"[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "", text)
