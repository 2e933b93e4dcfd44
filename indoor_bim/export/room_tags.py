"""Names and areas of rooms, placed where they fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from indoor_bim.export.marks import Item, Layer, Stroke, Text, text_width
from indoor_bim.export.page import View
from indoor_bim.model import Point2, Room, Storey

_CLEARANCE = 0.6
_LEADING = 1.45
_STEP = 1.5
_MOST_PLACES = 2500


@dataclass(frozen=True, slots=True)
class TagLine:
    """One line of a room's tag."""

    text: str
    size: float
    bold: bool = False


@dataclass(frozen=True, slots=True)
class Tags:
    """Drawn tags, and the rooms that had to be numbered because their names did not fit."""

    layer: Layer
    numbered: tuple[tuple[int, Room], ...]


def room_layer(storey: Storey, view: View) -> Layer:
    """Draw the floor of each room as an area without lines, one item per room, named after it."""
    items = [
        Item(
            (
                Stroke(
                    tuple(tuple(view.point(corner) for corner in ring) for ring in (room.outline.exterior, *room.outline.holes)),
                    "room",
                    True,
                ),
            ),
            "room",
            room.id,
            f"{room.name}, {area_text(room)}, clear height {room.height:.2f} m",
        )
        for room in storey.rooms
    ]
    return Layer("rooms", "Rooms", tuple(items))


def room_tags(storey: Storey, view: View, *, obstacles: list[BaseGeometry]) -> Tags:
    """Place the tag of each room inside it.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    view : View
        Way to the paper.
    obstacles : list of shapely geometry
        What tags keep clear of, on paper, millimetres.

    Returns
    -------
    Tags
        Texts; none leaves its room.
    """
    items: list[Item] = []
    numbered: list[tuple[int, Room]] = []
    blocked = shapely.union_all(obstacles)
    for room in storey.rooms:
        whole = view.shape(room.outline.polygon).buffer(-_CLEARANCE)
        free = whole.difference(blocked)
        texts = next((texts for lines, angle in _variants(room) if (texts := _place(lines, free, angle))), [])
        if not texts:
            numbered.append((len(numbered) + 1, room))
            number = str(len(numbered))
            sizes = ((free, 2.5), (whole, 2.5), (whole, 1.8))
            texts = next((texts for space, size in sizes if (texts := _place([TagLine(number, size, True)], space, 0.0))), [])
        if texts:
            items.append(Item(tuple(texts), "room-tag"))
    return Tags(Layer("room-tags", "Room tags", tuple(items)), tuple(numbered))


def area_text(room: Room) -> str:
    """Return the area of a room as text, in square metres with one decimal."""
    return f"{room.area:.1f} m²"


def _variants(room: Room) -> Iterator[tuple[list[TagLine], float]]:
    area, sides, name = area_text(room), _clear_sides(room), room.name
    if sides:
        yield [TagLine(name, 3.0, True), TagLine(area, 2.5), TagLine(sides, 2.0)], 0.0
    yield [TagLine(name, 3.0, True), TagLine(area, 2.5)], 0.0
    yield [TagLine(name, 2.5, True), TagLine(area, 2.2)], 0.0
    yield [TagLine(name, 2.5, True), TagLine(area, 2.2)], -90.0
    words = name.split()
    if len(words) > 1:
        cut = min(range(1, len(words)), key=lambda i: abs(len(" ".join(words[:i])) - len(" ".join(words[i:]))))
        yield [TagLine(" ".join(words[:cut]), 2.2, True), TagLine(" ".join(words[cut:]), 2.2, True), TagLine(area, 2.0)], 0.0
    for angle in (0.0, -90.0):
        yield [TagLine(name, 2.0, True), TagLine(area, 2.0)], angle
    for angle in (0.0, -90.0):
        yield [TagLine(f"{name} {area}", 1.8)], angle


def _clear_sides(room: Room) -> str:
    """Clear length and width of a rectangular room."""
    polygon = room.outline.polygon
    box = shapely.minimum_rotated_rectangle(polygon)
    if not isinstance(box, shapely.Polygon) or polygon.area < 0.98 * box.area:
        return ""
    corners = np.array(box.exterior.coords)
    edges = corners[1:3] - corners[:2]
    edges = edges[np.argsort(-np.abs(edges[:, 0]))]
    return " × ".join(f"{length:.2f}" for length in np.hypot(*edges.T))


def _place(lines: list[TagLine], space: BaseGeometry, angle: float) -> list[Text]:
    """Lines centred on the place nearest to the middle of a shape where all of them fit into it; empty if nowhere."""
    width = max(text_width(line.text, line.size, bold=line.bold) for line in lines)
    height = _LEADING * sum(line.size for line in lines)
    across, down = (width, height) if angle == 0 else (height, width)
    places = _places(space)
    if not len(places):
        return []
    half = np.array([across, down]) / 2
    boxes = shapely.box(*(places - half).T, *(places + half).T)
    fitting = np.flatnonzero(shapely.covers(space, boxes))
    return _stack(lines, tuple(places[fitting[0]].tolist()), height, angle) if len(fitting) else []


def _places(space: BaseGeometry) -> np.ndarray:
    """Points (n, 2) of a grid over a shape, nearest first to the centre of its largest inscribed circle."""
    parts = [part for part in shapely.get_parts(space) if part.geom_type == "Polygon" and part.area > 1]
    if not parts:
        return np.zeros((0, 2))
    largest = max(parts, key=lambda part: part.area)
    middle = np.array(shapely.maximum_inscribed_circle(largest, tolerance=0.1).coords[0])
    x0, y0, x1, y1 = largest.bounds
    step = max(_STEP, float(np.sqrt((x1 - x0) * (y1 - y0) / _MOST_PLACES)))
    columns, rows = (
        np.arange(np.ceil((low - m) / step), np.floor((high - m) / step) + 1) for low, high, m in ((x0, x1, middle[0]), (y0, y1, middle[1]))
    )
    steps = np.array(np.meshgrid(columns, rows)).reshape(2, -1).T
    order = np.lexsort((steps[:, 0], steps[:, 1], (steps**2).sum(axis=1)))
    return middle + step * steps[order]


def _stack(lines: list[TagLine], centre: Point2, height: float, angle: float) -> list[Text]:
    texts = []
    top = -height / 2
    for line in lines:
        baseline = top + _LEADING * line.size / 2 + 0.36 * line.size
        x, y = (centre[0], centre[1] + baseline) if angle == 0 else (centre[0] + baseline, centre[1])
        texts.append(Text((x, y), line.text, line.size, "middle", angle, "room-text", line.bold))
        top += _LEADING * line.size
    return texts
