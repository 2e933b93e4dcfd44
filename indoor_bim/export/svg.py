"""Floor plan as SVG: a page in millimetres at true scale, layers as groups, identifiers of the model."""

from __future__ import annotations

import base64
import hashlib
import os
import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from indoor_bim.export.files import write_text
from indoor_bim.export.guids import storey_guids
from indoor_bim.export.json import to_json
from indoor_bim.export.marks import Arc, Item, Layer, Mark, Stroke
from indoor_bim.export.page import View
from indoor_bim.export.plan_style import USUAL, PlanStyle, Underlay
from indoor_bim.export.sheet import draw_plan, find_storey
from indoor_bim.export.svg_style import style_sheet
from indoor_bim.model import FORMAT, VERSION, Building, Point2, Storey

_SVG = "http://www.w3.org/2000/svg"
_MODEL = "https://indoor-bim.invalid/plan"
_INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"


def plan_svg(building: Building, *, storey: str | None = None, style: PlanStyle = USUAL) -> str:
    """Return the plan of one storey as SVG text.

    Parameters
    ----------
    building : Building
        Model, metres.
    storey : str, optional
        Identifier of the storey; by default the first one.
    style : PlanStyle
        Scale, paper, colours and pictures of the scan.

    Returns
    -------
    str
        SVG document; equal input gives equal text.

    Raises
    ------
    WriteError
        If there is no storey of that identifier, or if its plan does not fit the paper asked for.
    """
    plan = draw_plan(building, storey=storey, style=style)
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
    root.append(_metadata(building, shown))
    ElementTree.SubElement(root, "style").text = style_sheet(style.theme)
    ElementTree.SubElement(root, "rect", {"class": "sheet", "width": width, "height": height})
    if shown and plan.view and shown.id in style.underlays:
        root.append(_image(style.underlays[shown.id], plan.view))
    guids = storey_guids(building.source, shown) if shown else {}
    for layer in plan.layers:
        root.append(layer_group(layer, guids))
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def write_svg(
    building: Building,
    path: str | os.PathLike[str],
    *,
    storey: str | None = None,
    style: PlanStyle = USUAL,
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
    style : PlanStyle
        Scale, paper, colours and pictures of the scan.

    Raises
    ------
    WriteError
        If there is no storey of that identifier, or if the file cannot be written.
    """
    write_text(path, plan_svg(building, storey=storey, style=style))


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


def write_plans(building: Building, path: str | os.PathLike[str], *, style: PlanStyle = USUAL) -> list[Path]:
    """Write one plan for each storey.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File of the first storey's plan; the others stand beside it, see `plan_paths`.
    style : PlanStyle
        Scale, paper, colours and pictures of the scan.

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
        write_svg(building, target, storey=storey, style=style)
    return list(paths)


def _metadata(building: Building, storey: Storey | None) -> ElementTree.Element:
    """What the plan was drawn from, for programs that read it."""
    facts = {
        "format": FORMAT,
        "version": str(VERSION),
        "model-sha256": hashlib.sha256(to_json(building).encode("utf-8")).hexdigest(),
        "source": building.source,
        "method": building.method,
        "storey": storey.id if storey else "",
        "crs": building.crs or "",
    }
    metadata = ElementTree.Element("metadata")
    ElementTree.SubElement(metadata, "model", {"xmlns": _MODEL} | {name: _clean(value) for name, value in facts.items() if value})
    return metadata


def layer_group(layer: Layer, guids: Mapping[str, str]) -> ElementTree.Element:
    """Return a layer as an SVG group.

    Parameters
    ----------
    layer : Layer
        Marks in millimetres of paper.
    guids : mapping of str to str
        GlobalIds by the identifiers of items.
    """
    attributes = {"id": f"layer-{layer.name}", "inkscape:groupmode": "layer", "inkscape:label": layer.label}
    group = ElementTree.Element("g", attributes)
    for item in layer.items:
        group.append(_item(item, guids))
    return group


def _item(item: Item, guids: Mapping[str, str]) -> ElementTree.Element:
    attributes = {"id": _clean(item.id), "class": item.kind, "data-guid": guids.get(item.id, "")}
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
