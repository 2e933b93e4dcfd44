"""Floor plan as DXF for CAD: metres, AIA layers, hatches, blocks for doors and windows, dimensions that can be edited."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import shapely

from indoor_bim.errors import WriteError
from indoor_bim.export.drawing import HATCH_SPACING, WIDE_HATCH_SPACING, merged_lines, wall_body, wall_outlines
from indoor_bim.export.dxf_annotation import add_dimensions, add_sheet, add_texts
from indoor_bim.export.dxf_openings import insert_opening
from indoor_bim.export.files import write_text
from indoor_bim.export.guids import storey_guids
from indoor_bim.export.plan_style import USUAL, PlanStyle
from indoor_bim.export.sheet import Plan, draw_plan, find_storey
from indoor_bim.export.svg import plan_paths
from indoor_bim.model import Building, Storey

APP = "INDOOR_BIM"
LAYERS = {
    "A-WALL": (7, 50),
    "A-WALL-PATT": (8, 9),
    "A-COLS": (7, 35),
    "A-DOOR": (3, 25),
    "A-GLAZ": (5, 25),
    "A-AREA": (9, 13),
    "A-AREA-IDEN": (7, 18),
    "A-ANNO-DIMS": (1, 13),
    "A-ANNO-TEXT": (7, 18),
    "A-ANNO-TTLB": (7, 25),
}
_ANSI31_SPACING = 3.175  # units between the lines of the pattern at scale 1 in a metric drawing
_OUTLINES = {"outline": "CONTINUOUS", "outline unseen": "DASHED", "outline unsupported": "DASHED2"}


def write_dxf(building: Building, path: str | os.PathLike[str], *, style: PlanStyle = USUAL) -> list[Path]:
    """Write one drawing for each storey.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File of the first storey's drawing; the others stand beside it, see `svg.plan_paths`.
    style : PlanStyle
        Scale and paper of the layout; the scale also sets the size of texts.

    Returns
    -------
    list of pathlib.Path
        Files written.

    Raises
    ------
    WriteError
        If a file cannot be written, or if ezdxf is not installed.
    """
    paths = plan_paths(building, path)
    for target, storey in paths.items():
        write_text(target, dxf_text(building, storey=storey, style=style))
    return list(paths)


def dxf_text(building: Building, *, storey: str | None = None, style: PlanStyle = USUAL) -> str:
    """Return the drawing of one storey as DXF (AutoCAD 2018) text.

    Model space holds the plan in model coordinates, one unit a metre; the layout holds the sheet with a viewport at its scale.
    Walls, openings, columns and rooms carry their identifier and GlobalId as extended data of the application `APP`.

    Parameters
    ----------
    building : Building
        Model, metres.
    storey : str, optional
        Identifier of the storey; by default the first one.
    style : PlanStyle
        Scale and paper.

    Returns
    -------
    str
        DXF document; equal input gives equal text.

    Raises
    ------
    WriteError
        If there is no storey of that identifier, if its plan does not fit the paper asked for, or if ezdxf is not installed.
    """
    try:
        from ezdxf.filemanagement import new
    except ImportError as error:
        raise WriteError("writing DXF needs the package ezdxf; install it: pip install 'indoor-bim[dxf]'") from error
    plan = draw_plan(building, storey=storey, style=style)
    shown = find_storey(building, storey)
    with fixed_time():
        doc = new("R2018", setup=True, units=6)
        _add_plan(doc, building, shown, plan)
        stream = io.StringIO()
        doc.write(stream)
    return stream.getvalue()


def _add_plan(doc: Any, building: Building, shown: Storey | None, plan: Plan) -> None:
    doc.appids.new(APP)
    for name, (colour, weight) in LAYERS.items():
        doc.layers.add(name, color=colour, lineweight=weight)
    if shown and plan.view:
        doc.header["$LTSCALE"] = 4 / plan.view.mm_per_metre
        guids = storey_guids(building.source, shown)
        _add_walls(doc, shown, plan.view.scale, guids)
        _add_rooms(doc, shown, guids)
        add_texts(doc, plan)
        add_dimensions(doc, shown, plan)
    add_sheet(doc, plan)


def mark(entity: Any, id: str, guids: dict[str, str]) -> None:
    """Attach identifier and GlobalId of an element of the model."""
    entity.set_xdata(APP, [(1000, f"id={id}"), (1000, f"guid={guids[id]}")])


def _add_walls(doc: Any, storey: Storey, scale: int, guids: dict[str, str]) -> None:
    space = doc.modelspace()
    for wall in storey.walls:
        spacing = HATCH_SPACING if wall.thickness_measured else WIDE_HATCH_SPACING
        for part in _polygons(wall_body(wall)):
            hatch = _hatch(space, part, {"layer": "A-WALL-PATT"})
            hatch.set_pattern_fill("ANSI31", scale=spacing * scale / 1000 / _ANSI31_SPACING)
            mark(hatch, wall.id, guids)
        for opening in wall.openings:
            mark(insert_opening(doc, wall, opening), opening.id, guids)
    for kind, lines in wall_outlines(storey).items():
        for line in merged_lines(lines):
            closed = line[0] == line[-1]
            corners = line[:-1] if closed else line
            space.add_lwpolyline(corners, close=closed, dxfattribs={"layer": "A-WALL", "linetype": _OUTLINES[kind]})
    for column in storey.columns:
        for part in _polygons(shapely.Polygon(column.footprint)):
            hatch = _hatch(space, part, {"layer": "A-COLS"})
            hatch.set_solid_fill(color=8)
            mark(hatch, column.id, guids)
        mark(space.add_lwpolyline(column.footprint, close=True, dxfattribs={"layer": "A-COLS"}), column.id, guids)


def _add_rooms(doc: Any, storey: Storey, guids: dict[str, str]) -> None:
    space = doc.modelspace()
    for room in storey.rooms:
        for ring in (room.outline.exterior, *room.outline.holes):
            mark(space.add_lwpolyline(ring, close=True, dxfattribs={"layer": "A-AREA"}), room.id, guids)


def _hatch(space: Any, polygon: shapely.Polygon, attributes: dict[str, Any]) -> Any:
    hatch = space.add_hatch(dxfattribs=attributes)
    hatch.paths.add_polyline_path(polygon.exterior.coords[:-1], is_closed=True, flags=1)
    for hole in polygon.interiors:
        hatch.paths.add_polyline_path(hole.coords[:-1], is_closed=True, flags=16)
    return hatch


def _polygons(shape: Any) -> Iterator[shapely.Polygon]:
    for part in shapely.get_parts(shapely.normalize(shape)):
        if part.geom_type == "Polygon" and part.area > 0:
            yield part


@contextmanager
def fixed_time() -> Iterator[None]:
    """Keep the time and random identifiers out of the file."""
    from ezdxf._options import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before
