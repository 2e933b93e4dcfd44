"""Names and areas of rooms, placed where they fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from indoor_bim.export.marks import Item, Layer, Stroke, Text, text_width
from indoor_bim.export.mesh import region
from indoor_bim.export.page import View
from indoor_bim.model import Point2, Room, Storey

_CLEARANCE = 0.6
_AT_WALL = 0.03
_RECTANGULAR = 0.995
_LEADING = 1.45
_STEP = 1.5
_MOST_PLACES = 2500
_NAME_SIZES = (3.0, 2.5, 2.2, 1.8)
_LEAST_SIZE = 1.8
_MOST_ROOMS = 0.75


@dataclass(frozen=True, slots=True)
class TagLine:
    """One line of a room's tag."""

    text: str
    size: float
    bold: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """Free part of a room on paper, and the places (n, 2) to try for its tag, best first."""

    free: BaseGeometry
    places: NDArray[np.float64]
    dimensioned: bool


@dataclass(frozen=True, slots=True)
class Tags:
    """Drawn tags, and the rooms that had to be numbered because their names did not fit."""

    layer: Layer
    numbered: tuple[tuple[int, Room], ...]


def room_layer(storey: Storey, view: View) -> Layer:
    """Draw each room, one item named after it: its floor, and a thin line where no wall bounds it."""
    walls = shapely.union_all([region(wall.footprint) for wall in storey.walls]).buffer(_AT_WALL)
    items = []
    for room in storey.rooms:
        rings = (room.outline.exterior, *room.outline.holes)
        floor = Stroke(tuple(tuple(view.point(corner) for corner in ring) for ring in rings), "room", closed=True)
        border = shapely.line_merge(region(room.outline.exterior, room.outline.holes).boundary.difference(walls))
        pieces = tuple(sorted(tuple(piece.coords) for piece in shapely.get_parts(view.shape(border)) if piece.length > 1))
        marks = (floor, Stroke(pieces, "open-border")) if pieces else (floor,)
        items.append(Item(marks, "room", room.id, f"{room.name}, {area_text(room)}, clear height {room.height:.2f} m"))
    return Layer("rooms", "Rooms", tuple(items))


def room_tags(storey: Storey, view: View, *, obstacles: list[BaseGeometry], dimensioned: frozenset[str] = frozenset()) -> Tags:
    """Place the tag of each room inside it.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    view : View
        Way to the paper.
    obstacles : list of shapely geometry
        What tags keep clear of, on paper, millimetres.
    dimensioned : frozenset of str
        Identifiers of the rooms whose sizes are drawn already.

    Returns
    -------
    Tags
        Texts; none leaves its room.
    """
    items: list[Item] = []
    numbered: list[tuple[int, Room]] = []
    blocked = shapely.union_all(obstacles)
    spaces = [_space(room, view, blocked, dimensioned=room.id in dimensioned) for room in storey.rooms]
    size = _common_size(storey.rooms, spaces)
    for room, space in zip(storey.rooms, spaces, strict=True):
        variants = (lines for name_size in _NAME_SIZES if name_size <= size for lines in _variants(room, name_size, space))
        texts = next((texts for lines, angle in variants if (texts := _place(lines, space, angle))), [])
        if not texts:
            numbered.append((len(numbered) + 1, room))
            number = str(len(numbered))
            choices = (
                [TagLine(number, 2.5, True), TagLine(area_text(room), _LEAST_SIZE)],
                *([TagLine(number, s, True)] for s in (2.5, 1.8)),
            )
            texts = next((texts for lines in choices if (texts := _place(lines, space, 0.0))), [])
        if texts:
            items.append(Item(tuple(texts), "room-tag"))
    return Tags(Layer("room-tags", "Room tags", tuple(items)), tuple(numbered))


def area_text(room: Room) -> str:
    """Return the area of a room as text, in square metres with one decimal."""
    return f"{room.area:.1f} m²"


def _space(room: Room, view: View, blocked: BaseGeometry, *, dimensioned: bool) -> Space:
    whole = view.shape(region(room.outline.exterior, room.outline.holes))
    free = whole.buffer(-_CLEARANCE).difference(blocked.buffer(_CLEARANCE))
    shapely.prepare(free)
    parts = [part for part in shapely.get_parts(free) if part.geom_type == "Polygon" and part.area > 1]
    if not parts:
        return Space(free, np.zeros((0, 2)), dimensioned)
    largest = max(parts, key=lambda part: part.area)
    middle = (
        whole.centroid if largest.covers(whole.centroid) else shapely.get_point(shapely.maximum_inscribed_circle(largest, tolerance=0.1), 0)
    )
    return Space(free, _places(largest, np.array(middle.coords[0])), dimensioned)


def _common_size(rooms: tuple[Room, ...], spaces: list[Space]) -> float:
    """Largest size of type at which most names fit, so that the tags of a plan look alike."""
    for size in _NAME_SIZES[:-1]:
        fitting = sum(
            any(_place(lines, space, 0.0) for lines in _upright_variants(room, size, space))
            for room, space in zip(rooms, spaces, strict=True)
        )
        if fitting >= _MOST_ROOMS * len(rooms):
            return size
    return _NAME_SIZES[-1]


def _variants(room: Room, size: float, space: Space) -> Iterator[tuple[list[TagLine], float]]:
    for lines in _upright_variants(room, size, space):
        yield lines, 0.0
    yield [TagLine(room.name, size, True), TagLine(area_text(room), max(_LEAST_SIZE, 0.85 * size))], -90.0


def _upright_variants(room: Room, size: float, space: Space) -> Iterator[list[TagLine]]:
    small = max(_LEAST_SIZE, 0.85 * size)
    name, area = [TagLine(room.name, size, True)], TagLine(area_text(room), small)
    clear = "" if space.dimensioned else _clear_sides(room)
    sides = [TagLine(clear, max(_LEAST_SIZE, 0.7 * size))] if clear else []
    names = [name]
    words = room.name.split()
    if len(words) > 1:
        cut = min(range(1, len(words)), key=lambda i: abs(len(" ".join(words[:i])) - len(" ".join(words[i:]))))
        names.append([TagLine(" ".join(words[:cut]), size, True), TagLine(" ".join(words[cut:]), size, True)])
    for title in names:
        yield [*title, area, *sides]
    for title in names if sides else []:
        yield [*title, area]


def _clear_sides(room: Room) -> str:
    """Clear length and width of a rectangular room."""
    polygon = region(room.outline.exterior, room.outline.holes)
    box = shapely.minimum_rotated_rectangle(polygon)
    if not isinstance(box, shapely.Polygon) or polygon.area < _RECTANGULAR * box.area:
        return ""
    corners = np.array(box.exterior.coords)
    edges = corners[1:3] - corners[:2]
    edges = edges[np.argsort(-np.abs(edges[:, 0]))]
    return " × ".join(f"{length + 1e-9:.2f}" for length in np.hypot(*edges.T))


def _place(lines: list[TagLine], space: Space, angle: float) -> list[Text]:
    """Lines centred on the place nearest to the middle of a room where all of them are free; empty if nowhere."""
    width = max(text_width(line.text, line.size, bold=line.bold) for line in lines)
    height = _LEADING * sum(line.size for line in lines)
    half = np.array([width, height] if angle == 0 else [height, width]) / 2
    boxes = shapely.box(*(space.places - half).T, *(space.places + half).T)
    fitting = np.flatnonzero(shapely.covers(space.free, boxes))
    return _stack(lines, tuple(space.places[fitting[0]].tolist()), height, angle) if len(fitting) else []


def _places(shape: BaseGeometry, middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 2) of a grid over a shape, nearest to its middle first."""
    x0, y0, x1, y1 = shape.bounds
    step = max(_STEP, float(np.sqrt((x1 - x0) * (y1 - y0) / _MOST_PLACES)))
    ranges = ((x0 - middle[0], x1 - middle[0]), (y0 - middle[1], y1 - middle[1]))
    columns, rows = (np.arange(np.ceil(low / step), np.floor(high / step) + 1) for low, high in ranges)
    steps = np.array(np.meshgrid(columns, rows)).reshape(2, -1).T
    order = np.lexsort((steps[:, 0], steps[:, 1], (steps**2).sum(axis=1)))
    return np.asarray(middle + step * steps[order])


def _stack(lines: list[TagLine], centre: Point2, height: float, angle: float) -> list[Text]:
    texts = []
    top = -height / 2
    for line in lines:
        baseline = top + _LEADING * line.size / 2 + 0.36 * line.size
        x, y = (centre[0], centre[1] + baseline) if angle == 0 else (centre[0] + baseline, centre[1])
        texts.append(Text((x, y), line.text, line.size, "middle", angle, "room-text", line.bold))
        top += _LEADING * line.size
    return texts
