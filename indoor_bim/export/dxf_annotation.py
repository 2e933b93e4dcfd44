"""Texts, dimensions and the sheet of a DXF plan, placed as on the page that the plan is drawn for."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from indoor_bim.export.dimensions import FIRST_LINE, LINE_SPACING, Side, side_chains
from indoor_bim.export.drawing import drawn_bounds, plan_bounds
from indoor_bim.export.marks import Layer, Stroke, Text
from indoor_bim.export.sheet import Plan
from indoor_bim.model import Point2, Storey

_FONT = "PLAN"
_BY_LAYER = 256
_ALIGN = {"start": "LEFT", "middle": "CENTER", "end": "RIGHT"}
_SHEET_LAYERS = ("notes", "title-block")
_CAP_HEIGHT = 0.72  # height of capitals, which DXF asks for, by the size of the type


def add_texts(doc: Any, plan: Plan) -> None:
    """Add the tags of rooms to the model space, in the place and at the size that they have on the page.

    Parameters
    ----------
    doc : ezdxf.document.Drawing
        Drawing, metres.
    plan : Plan
        Drawn page.
    """
    if plan.view is None:
        return
    for layer in plan.layers:
        if layer.name == "room-tags":
            for text in layer.texts:
                _add_text(doc.modelspace(), text, plan.view.model_point(text.at), 1 / plan.view.mm_per_metre, "A-AREA-IDEN")


def add_dimensions(doc: Any, storey: Storey, plan: Plan) -> None:
    """Add the chains beside the plan and the dimensions inside rooms as linear dimensions that measure the drawing.

    Parameters
    ----------
    doc : ezdxf.document.Drawing
        Drawing, metres.
    storey : Storey
        Part of the model, metres.
    plan : Plan
        Drawn page.
    """
    from ezdxf.tools.standards import setup_dimstyle

    walls, drawn = plan_bounds(storey), drawn_bounds(storey)
    if plan.view is None or walls is None or drawn is None:
        return
    outer, inner = (f"EZ_M_{plan.view.scale}_H{height}_M" for height in (25, 18))
    for name in (outer, inner):
        if name not in doc.dimstyles:
            dimension_style = setup_dimstyle(doc, name, style=_text_style(doc))
            dimension_style.dxf.dimdec, dimension_style.dxf.dimzin = 2, 0
            dimension_style.dxf.dimclrd = dimension_style.dxf.dimclre = dimension_style.dxf.dimclrt = _BY_LAYER
    for side, chains in side_chains(storey).items():
        for number, chain in enumerate(chains):
            out = (FIRST_LINE + number * LINE_SPACING) / plan.view.mm_per_metre
            _add_chain(doc, side, chain, walls, drawn, out, outer)
    for line in plan.room_lines:
        (x0, y0), (x1, y1) = line
        _add_dimension(doc, line[0], line[1], line[0], inner, upright=abs(y1 - y0) > abs(x1 - x0))


def add_sheet(doc: Any, plan: Plan) -> None:
    """Draw frame, title block and notes on the layout, with a viewport on the model space at the scale of the plan.

    Parameters
    ----------
    doc : ezdxf.document.Drawing
        Drawing.
    plan : Plan
        Drawn page.
    """
    page = plan.page
    layout = doc.layout("Layout1")
    layout.page_setup(size=(page.width, page.height), margins=(0, 0, 0, 0), units="mm")
    for layer in plan.layers:
        if layer.name in _SHEET_LAYERS:
            _add_to_sheet(layout, layer, page.height)
    if plan.view is not None:
        x, y = page.drawing.centre
        layout.add_viewport(
            center=(x, page.height - y),
            size=(page.drawing.width, page.drawing.height),
            view_center_point=plan.view.model_point((x, y)),
            view_height=page.drawing.height / plan.view.mm_per_metre,
            dxfattribs={"layer": "Defpoints"},
        )


def _add_to_sheet(layout: Any, layer: Layer, height: float) -> None:
    name = "A-ANNO-TTLB" if layer.name == "title-block" else "A-ANNO-TEXT"
    for item in layer.items:
        for mark in item.marks:
            if isinstance(mark, Stroke):
                for line in mark.lines:
                    layout.add_lwpolyline([(x, height - y) for x, y in line], close=mark.closed, dxfattribs={"layer": name})
            elif isinstance(mark, Text):
                _add_text(layout, mark, (mark.at[0], height - mark.at[1]), 1.0, name)


def _add_text(space: Any, text: Text, place: Point2, unit: float, layer: str) -> None:
    from ezdxf.enums import TextEntityAlignment

    attributes = {"layer": layer, "height": text.size * _CAP_HEIGHT * unit, "rotation": -text.angle, "style": _text_style(space.doc)}
    space.add_text(text.text, dxfattribs=attributes).set_placement(place, align=TextEntityAlignment[_ALIGN[text.anchor]])


def _text_style(doc: Any) -> str:
    if _FONT not in doc.styles:
        doc.styles.add(_FONT, font="arial.ttf")
    return _FONT


def _add_chain(
    doc: Any,
    side: Side,
    chain: list[float],
    walls: tuple[float, float, float, float],
    drawn: tuple[float, float, float, float],
    out: float,
    style: str,
) -> None:
    place = {"left": 0, "bottom": 1, "right": 2, "top": 3}[side]
    sign = -1.0 if side in ("left", "bottom") else 1.0
    upright = side in ("left", "right")
    at, foot = drawn[place] + sign * out, walls[place]
    for start, end in pairwise(chain):
        ends = [(foot, start), (foot, end)] if upright else [(start, foot), (end, foot)]
        _add_dimension(doc, ends[0], ends[1], (at, start) if upright else (start, at), style, upright=upright)


def _add_dimension(doc: Any, start: Point2, end: Point2, base: Point2, style: str, *, upright: bool) -> None:
    dimension = doc.modelspace().add_linear_dim(
        base=base, p1=start, p2=end, angle=90 if upright else 0, dimstyle=style, dxfattribs={"layer": "A-ANNO-DIMS"}
    )
    dimension.render()
