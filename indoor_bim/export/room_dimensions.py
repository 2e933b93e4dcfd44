"""Dimensions inside rooms: clear length and width from wall to wall, where they leave room for everything else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from indoor_bim.export.marks import Item, Layer, Stroke, Text, text_width
from indoor_bim.export.mesh import region
from indoor_bim.export.page import View
from indoor_bim.model import Point2, Room, Storey

_LEAST_WIDTH, _LEAST_HEIGHT = 24.0, 20.0
_FROM_WALL, _STEP, _TRIES = 4.0, 2.0, 6
_TEXT_SIZE, _TEXT_OFFSET, _TICK, _MARGIN = 2.0, 0.7, 0.8, 0.5
_SHARES = (0.5, 0.36, 0.64, 0.25, 0.75)
_SKEW = 0.01
_WHOLE = 0.98
_AT_WALL = 0.03


@dataclass(frozen=True, slots=True)
class RoomDimensions:
    """Drawn dimensions, their lines in metres, what they cover on paper, and the rooms whose length and width are both told."""

    layer: Layer
    lines: tuple[tuple[Point2, Point2], ...]
    covered: tuple[BaseGeometry, ...]
    rooms: frozenset[str]


@dataclass(frozen=True, slots=True)
class _Dimension:
    """Line from wall to wall with its text, on paper."""

    line: shapely.LineString
    text: Text
    label: str

    @property
    def covered(self) -> BaseGeometry:
        return self.text.box.union(self.line.buffer(_MARGIN))


def room_dimensions(storey: Storey, view: View, *, obstacles: list[BaseGeometry], skip: frozenset[str] = frozenset()) -> RoomDimensions:
    """Draw the clear length and width of the rooms that are large enough on paper and have square walls.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    view : View
        Way to the paper.
    obstacles : list of shapely geometry
        What dimensions keep clear of, on paper, millimetres.
    skip : frozenset of str
        Identifiers of rooms without dimensions.

    Returns
    -------
    RoomDimensions
        Up to two dimension lines a room.
    """
    tree = shapely.STRtree(obstacles)
    walls = view.shape(shapely.union_all([region(wall.footprint) for wall in storey.walls])).buffer(_AT_WALL * view.mm_per_metre)
    items: list[Item] = []
    covered: list[BaseGeometry] = []
    lines: list[tuple[Point2, Point2]] = []
    complete = set()
    for room in storey.rooms:
        shape = view.shape(region(room.outline.exterior, room.outline.holes))
        x0, y0, x1, y1 = shape.bounds
        if room.id in skip or x1 - x0 < _LEAST_WIDTH or y1 - y0 < _LEAST_HEIGHT:
            continue
        blocked = shapely.union_all([obstacles[k] for k in tree.query(shape)])
        drawn: list[_Dimension] = []
        for upright in (False, True):
            taken = shapely.union_all([blocked, *(dimension.text.box.buffer(_MARGIN) for dimension in drawn)])
            found = next(_candidates(shape, view, taken, walls, upright=upright), None)
            if found is not None:
                drawn.append(found)
        if not drawn or (len(drawn) == 2 and drawn[1].text.box.intersects(drawn[0].line.buffer(_MARGIN))):
            drawn = drawn[:1]
        items += [_item(room, dimension) for dimension in drawn]
        covered += [dimension.covered for dimension in drawn]
        lines += [_in_model(dimension.line, view) for dimension in drawn]
        if len(drawn) == 2:
            complete.add(room.id)
    return RoomDimensions(Layer("room-dimensions", "Room dimensions", tuple(items)), tuple(lines), tuple(covered), frozenset(complete))


def _candidates(shape: BaseGeometry, view: View, taken: BaseGeometry, walls: BaseGeometry, *, upright: bool) -> Iterator[_Dimension]:
    """Yield dimension lines across a room that are as long as it is, nearest to a wall first."""
    low, high = (shape.bounds[0], shape.bounds[2]) if upright else (shape.bounds[1], shape.bounds[3])
    first, last = (shape.bounds[1], shape.bounds[3]) if upright else (shape.bounds[0], shape.bounds[2])
    for step in range(_TRIES):
        inwards = _FROM_WALL + step * _STEP
        for at in (high - inwards, low + inwards) if not upright else (low + inwards, high - inwards):
            ends = [(at, first - 1), (at, last + 1)] if upright else [(first - 1, at), (last + 1, at)]
            pieces = shapely.get_parts(shape.intersection(shapely.LineString(ends)))
            line = max((piece for piece in pieces if piece.geom_type == "LineString"), key=lambda piece: piece.length, default=None)
            if line is None or line.length < _WHOLE * (last - first) or not _square_ends(shape, line, walls, upright=upright):
                continue
            inside = shapely.LineString([line.interpolate(1.0), line.interpolate(line.length - 1.0)])
            if inside.buffer(_MARGIN).intersects(taken):
                continue
            label = f"{line.length / view.mm_per_metre + 1e-9:.2f}"
            for share in _SHARES:
                text = _text(line, label, share, upright=upright)
                if shape.covers(text.box.buffer(_MARGIN)) and not text.box.buffer(_MARGIN).intersects(taken):
                    yield _Dimension(line, text, label)
                    break


def _square_ends(shape: BaseGeometry, line: shapely.LineString, walls: BaseGeometry, *, upright: bool) -> bool:
    """Tell whether both ends of a line lie at walls, on borders of the room that are square to it."""
    ends = shapely.points(np.asarray(line.coords))
    along = 1 if upright else 0
    square = []
    for ring in [ring for part in shapely.get_parts(shape) for ring in (part.exterior, *part.interiors)]:
        for p, q in pairwise(ring.coords):
            if abs(q[along] - p[along]) <= _SKEW * abs(q[1 - along] - p[1 - along]):
                square.append(shapely.LineString([p, q]))
    borders = shapely.union_all(square)
    return bool(square) and bool((shapely.distance(ends, borders) < 0.05).all() and shapely.intersects(ends, walls).all())


def _text(line: shapely.LineString, label: str, share: float, *, upright: bool) -> Text:
    half = text_width(label, _TEXT_SIZE) / 2
    place = line.interpolate(min(max(share * line.length, half + 2 * _TICK), line.length - half - 2 * _TICK))
    if upright:
        return Text((place.x - _TEXT_OFFSET, place.y), label, _TEXT_SIZE, "middle", angle=-90.0, style="dimension-text")
    return Text((place.x, place.y - _TEXT_OFFSET), label, _TEXT_SIZE, "middle", style="dimension-text")


def _in_model(line: shapely.LineString, view: View) -> tuple[Point2, Point2]:
    (x0, y0), (x1, y1) = line.coords
    return view.model_point((x0, y0)), view.model_point((x1, y1))


def _item(room: Room, dimension: _Dimension) -> Item:
    ends = tuple((float(x), float(y)) for x, y in dimension.line.coords)
    ticks = tuple(((x - _TICK, y + _TICK), (x + _TICK, y - _TICK)) for x, y in ends)
    marks = (Stroke((ends,), "dimension-line"), Stroke(ticks, "tick"), dimension.text)
    return Item(marks, "room-dimension", title=f"{room.name}: {dimension.label} m")
