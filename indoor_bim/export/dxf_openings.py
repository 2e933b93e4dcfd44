"""Doors, windows and passages as DXF blocks: one block for each size and way of opening, inserted where it is needed."""

from __future__ import annotations

from math import atan2, degrees, hypot
from typing import Any

from indoor_bim.export.drawing import LEAF_THICKNESS, door_leaves
from indoor_bim.model import Opening, Point2, Wall

_GLASS_GAP = 0.06
_LAYER = {"door": "A-DOOR", "window": "A-GLAZ", "opening": "A-DOOR"}


def insert_opening(doc: Any, wall: Wall, opening: Opening) -> Any:
    """Insert the block of an opening at its first jamb, on the axis of the wall, turned along it.

    Parameters
    ----------
    doc : ezdxf.document.Drawing
        Drawing; the block is added to it when it is not there yet.
    wall : Wall
        Wall that holds the opening.
    opening : Opening
        Door, window or passage.

    Returns
    -------
    ezdxf.entities.Insert
        The inserted block.
    """
    name = _block_name(wall, opening)
    if name not in doc.blocks:
        _draw(doc.blocks.new(name), wall, opening)
    (x0, y0), (x1, y1) = wall.axis
    share = opening.start / wall.length
    place = (x0 + share * (x1 - x0), y0 + share * (y1 - y0))
    turn = degrees(atan2(y1 - y0, x1 - x0))
    return doc.modelspace().add_blockref(name, place, dxfattribs={"layer": _LAYER[opening.kind], "rotation": turn})


def _block_name(wall: Wall, opening: Opening) -> str:
    size = f"{opening.kind.upper()}_{_tenths(opening.width)}_WALL_{_tenths(wall.thickness)}"
    if opening.kind != "door":
        return size
    return "_".join([size, f"LEAVES_{opening.leaves}", (opening.hinge or "unknown").upper(), (opening.swing or "unknown").upper()])


def _tenths(length: float) -> str:
    """Length in millimetres with one decimal, as block names may hold it."""
    return f"{1000 * length:.1f}".replace(".", "-")


def _draw(block: Any, wall: Wall, opening: Opening) -> None:
    """Draw an opening from its first jamb: x along the wall, y to the left of its axis, metres."""
    width, half = opening.width, wall.thickness / 2
    line_type = {"linetype": "DASHED2"} if opening.kind == "opening" else {}
    for y in (-half, half):
        block.add_line((0, y), (width, y), dxfattribs={"layer": "0"} | line_type)
    if opening.kind == "window":
        gap = min(_GLASS_GAP, half) / 2
        for y in (-gap, gap):
            block.add_line((0, y), (width, y), dxfattribs={"layer": "0"})
    if opening.kind != "door":
        return
    straight = Wall("", "", ((0.0, 0.0), (width, 0.0)), wall.thickness, True, 0.0, 1.0, ((0.0, -half), (width, -half), (width, half)))
    at_start = Opening("", "", "door", 0.0, width, 0.0, 1.0, opening.hinge, opening.swing, opening.leaves)
    leaves = list(door_leaves(straight, at_start))
    for hinge, tip, latch in leaves:
        block.add_line(hinge, tip, dxfattribs={"layer": "0"})
        _add_swing(block, hinge, tip, latch)
    if not leaves and opening.leaves:
        y = LEAF_THICKNESS / 2
        block.add_lwpolyline([(0, -y), (width, -y), (width, y), (0, y)], close=True, dxfattribs={"layer": "0"})


def _add_swing(block: Any, hinge: Point2, tip: Point2, latch: Point2) -> None:
    """Quarter circle that the tip of a leaf describes."""
    start, end = (degrees(atan2(point[1] - hinge[1], point[0] - hinge[0])) % 360 for point in (latch, tip))
    if (end - start) % 360 > 180:
        start, end = end, start
    block.add_arc(hinge, hypot(tip[0] - hinge[0], tip[1] - hinge[1]), start, end, dxfattribs={"layer": "0"})
