"""Deviations as a table, as data, as a coloured cloud and as a coloured plan."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.cloud.write import write_ply
from indoor_bim.export.files import write_text
from indoor_bim.export.page import View, fit_page
from indoor_bim.quality.deviation import Deviations, WallDeviation
from indoor_bim.quality.wall_bodies import Body, WallModel

Floats = NDArray[np.float64]

FULL_COLOUR = 0.05  # metres: deviations of this size and more have the full colour
_FRONT, _EVEN, _BEHIND = np.array([200, 30, 30]), np.array([235, 235, 225]), np.array([30, 70, 200])
_FAR = np.array([150, 150, 150])
_EXTRA, _MISSING = "#c000c0", "#e08000"
_MOST_POINTS = 2_000_000
_SVG = "http://www.w3.org/2000/svg"


def deviation_data(deviations: Deviations) -> dict[str, object]:
    """All figures as plain data, for JSON; lengths in metres."""
    return {
        "placement": deviations.message,
        "summary": summary(deviations.walls),
        "walls": [asdict(wall) for wall in deviations.walls],
        "extra_surfaces": [asdict(surface) for surface in deviations.extra],
    }


def summary(walls: Sequence[WallDeviation]) -> dict[str, object]:
    """Numbers of walls by status, and the median over the walls seen of the amounts of their bias, metres."""
    seen = [abs(wall.bias) for wall in walls if wall.bias is not None]
    counts: dict[str, object] = {status: sum(wall.status == status for wall in walls) for status in ("seen", "not seen", "missing")}
    return counts | {"median_bias": float(np.median(seen)) if seen else None, "largest_bias": max(seen, default=None)}


def deviation_table(deviations: Deviations) -> str:
    """All figures as a text table, millimetres; a dash where there is nothing to measure."""
    rows = [("wall", "storey", "status", "seen %", "bias", "median", "p95", "shift", "thicker", "drift")]
    for wall in deviations.walls:
        lengths = (wall.bias, wall.median, wall.p95, wall.shift, wall.thicker, wall.drift)
        cells = ("-" if length is None else f"{1000 * length:.1f}" for length in lengths)
        rows.append((wall.name or wall.id, wall.storey, wall.status, f"{100 * wall.covered:.0f}", *cells))  # type: ignore[arg-type]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = [
        "  ".join(text.ljust(w) if k < 3 else text.rjust(w) for k, (text, w) in enumerate(zip(row, widths, strict=True))) for row in rows
    ]
    found = summary(deviations.walls)
    lines += ["", f"walls: {found['seen']} seen, {found['not seen']} not seen, {found['missing']} missing"]
    if found["median_bias"] is not None:
        lines.append(f"bias of the walls seen: median {1000 * float(str(found['median_bias'])):.1f} mm, ")
        lines[-1] += f"largest {1000 * float(str(found['largest_bias'])):.1f} mm"
    lines.append(f"upright surfaces that the model does not have: {len(deviations.extra)}")
    for surface in deviations.extra:
        (x0, y0), (x1, y1) = surface.start, surface.end
        lines.append(f"  {surface.length:.2f} m from ({x0:.2f}, {y0:.2f}) to ({x1:.2f}, {y1:.2f})")
    return "\n".join(line.rstrip() for line in lines)


def write_deviations(deviations: Deviations, model: WallModel, folder: Path) -> tuple[Path, ...]:
    """Write deviations.json, deviations.ply (points coloured by distance) and deviations.svg (walls coloured by bias).

    Parameters
    ----------
    deviations : Deviations
        What was measured.
    model : WallModel
        The model.
    folder : path
        Folder that exists.

    Returns
    -------
    tuple of Path
        Files written.

    Raises
    ------
    WriteError
        If a file cannot be written.
    """
    data, cloud, plan = (folder / f"deviations.{ending}" for ending in ("json", "ply", "svg"))
    write_text(data, json.dumps(deviation_data(deviations), indent=2, ensure_ascii=False) + "\n")
    some = slice(None, None, max(1, len(deviations.points) // _MOST_POINTS))
    write_ply(cloud, deviations.points[some], colours=colours(deviations.distance[some]))
    write_text(plan, deviation_plan(deviations, model))
    return data, cloud, plan


def colours(distance: Floats) -> NDArray[np.uint8]:
    """Colour of each signed distance (n,) in metres, (n, 3): red in front of the face, blue behind it, grey where there is none.

    Examples
    --------
    >>> colours(np.array([0.0, 0.05, np.nan])).tolist()
    [[235, 235, 225], [200, 30, 30], [150, 150, 150]]
    """
    share = np.clip(np.nan_to_num(distance) / FULL_COLOUR, -1, 1)[:, None]
    blend = _EVEN + np.where(share > 0, share * (_FRONT - _EVEN), -share * (_BEHIND - _EVEN))
    return np.where(np.isnan(distance)[:, None], _FAR, blend.round()).astype(np.uint8)


def deviation_plan(deviations: Deviations, model: WallModel) -> str:
    """Return a plan as SVG text: walls coloured by their bias, missing walls and extra surfaces marked.

    Parameters
    ----------
    deviations : Deviations
        What was measured.
    model : WallModel
        The model.
    """
    measured = {wall.guid: wall for wall in deviations.walls}
    shapes = {body.guid: _footprint(body) for body in model.walls if body.guid in measured}
    ends = [point for surface in deviations.extra for point in (surface.start, surface.end)]
    bounds = shapely.union_all([*shapes.values(), *shapely.points(np.array(ends).reshape(-1, 2))]).bounds
    page, view = fit_page(bounds if shapes else (0.0, 0.0, 1.0, 1.0))
    size = {"width": f"{page.width:g}mm", "height": f"{page.height:g}mm", "viewBox": f"0 0 {page.width:g} {page.height:g}"}
    root = ElementTree.Element("svg", {"xmlns": _SVG} | size)
    ElementTree.SubElement(root, "rect", {"width": f"{page.width:g}", "height": f"{page.height:g}", "fill": "#ffffff"})
    for guid, shape in shapes.items():
        root.append(_wall(measured[guid], view.shape(shape)))
    for surface in deviations.extra:
        (x0, y0), (x1, y1) = view.point(surface.start), view.point(surface.end)
        line = {"x1": f"{x0:.2f}", "y1": f"{y0:.2f}", "x2": f"{x1:.2f}", "y2": f"{y1:.2f}"}
        mark = ElementTree.SubElement(root, "line", line | {"stroke": _EXTRA, "stroke-width": "0.8"})
        ElementTree.SubElement(mark, "title").text = f"not in the model, {surface.length:.2f} m"
    _legend(root, page.frame.x + 2, page.frame.bottom - 6, view)
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _wall(wall: WallDeviation, shape: shapely.Geometry) -> ElementTree.Element:
    rings = [ring for part in shapely.get_parts(shape) if part.geom_type == "Polygon" for ring in (part.exterior, *part.interiors)]
    path = " ".join("M " + " L ".join(f"{x:.2f} {y:.2f}" for x, y in ring.coords[:-1]) + " Z" for ring in rings)
    fill = "#{:02x}{:02x}{:02x}".format(*colours(np.array([wall.bias]))[0].tolist()) if wall.bias is not None else "none"
    dash = {"seen": {}, "not seen": {"stroke-dasharray": "1 1"}, "missing": {"stroke": _MISSING, "stroke-dasharray": "2 1"}}[wall.status]
    attributes = {"d": path, "fill": fill, "fill-rule": "evenodd", "stroke": "#303030", "stroke-width": "0.18", "data-guid": wall.guid}
    element = ElementTree.Element("path", attributes | dash)
    told = wall.status if wall.bias is None else f"bias {1000 * wall.bias:.1f} mm, seen {wall.covered:.0%}"
    ElementTree.SubElement(element, "title").text = f"{wall.name or wall.id}: {told}"
    return element


def _footprint(body: Body) -> shapely.Geometry:
    triangles = body.vertices[body.triangles][:, :, :2]
    flat = shapely.polygons(np.concatenate([triangles, triangles[:, :1]], axis=1))
    return shapely.union_all(flat[shapely.area(flat) > 1e-6], grid_size=1e-4)


def _legend(root: ElementTree.Element, x: float, y: float, view: View) -> None:
    steps = np.linspace(-FULL_COLOUR, FULL_COLOUR, 11)
    for k, colour in enumerate(colours(steps).tolist()):
        fill = "#{:02x}{:02x}{:02x}".format(*colour)
        ElementTree.SubElement(root, "rect", {"x": f"{x + 6 * k:.2f}", "y": f"{y - 4:.2f}", "width": "6", "height": "4", "fill": fill})
        if k % 5 == 0:
            _text(root, x + 6 * k + 3, y + 3, f"{1000 * steps[k]:+.0f} mm", anchor="middle")
    _text(root, x, y - 6, f"1:{view.scale}. Blue: the scan lies behind the modelled face; red: in front of it.")
    _text(root, x + 72, y, "Dotted: not seen. Orange: missing. Violet: not in the model.")


def _text(root: ElementTree.Element, x: float, y: float, text: str, *, anchor: str = "start") -> None:
    attributes = {"x": f"{x:.2f}", "y": f"{y:.2f}", "font-size": "2.5", "font-family": "DejaVu Sans, Arial, sans-serif"}
    ElementTree.SubElement(root, "text", attributes | {"text-anchor": anchor}).text = text
