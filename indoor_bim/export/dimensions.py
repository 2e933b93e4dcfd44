"""Dimension chains outside the plan: overall sizes, and the faces of the walls of the outer rooms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import shapely
from shapely.geometry.base import BaseGeometry

from indoor_bim.export.drawing import plan_bounds
from indoor_bim.export.marks import Item, Layer, Mark, Stroke, Text, text_width
from indoor_bim.export.page import View
from indoor_bim.model import Outline, Point2, Storey

Side = Literal["bottom", "left", "top", "right"]

_FIRST_LINE, _SECOND_LINE = 9.0, 17.0
_GAP = 2.0
_OVERSHOOT = 1.5
_TICK = 1.0
_TEXT_SIZE, _SMALL_TEXT_SIZE = 2.5, 1.8
_TEXT_OFFSET = 0.8
_MERGE = 0.015
_LEAST_FACE = 0.3
_NUDGE = 0.02


@dataclass(frozen=True, slots=True)
class Rail:
    """Line on paper that a chain is drawn on, beside the plan."""

    side: Side
    edge: float
    distance: float

    def at(self, along: float, out: float) -> Point2:
        """Point at a place along the line and a distance outwards from the plan's edge, millimetres."""
        sign = 1.0 if self.side in ("bottom", "right") else -1.0
        across = self.edge + sign * out
        return (along, across) if self.side in ("bottom", "top") else (across, along)


def dimension_layer(storey: Storey, view: View) -> Layer:
    """Draw the dimension chains of a storey.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    view : View
        Way to the paper.

    Returns
    -------
    Layer
        Chains below and left of the plan, and above and right where they differ.
    """
    bounds = plan_bounds(storey)
    if bounds is None:
        return Layer("dimensions", "Dimensions", ())
    items: list[Item] = []
    seen: list[list[float]] = []
    for side in ("bottom", "left", "top", "right"):
        chain = wall_face_chain(storey, side)
        if any(len(chain) == len(other) and all(abs(a - b) < _MERGE for a, b in zip(chain, other, strict=True)) for other in seen):
            continue
        seen.append(chain)
        ends = [chain[0], chain[-1]]
        chains = [chain, ends] if len(chain) > 2 else [ends]
        if side in ("top", "right"):
            chains = [chain] if len(chain) > 2 else []
        items += _side_items(side, chains, bounds, view)
    return Layer("dimensions", "Dimensions", tuple(items))


def wall_face_chain(storey: Storey, side: Side) -> list[float]:
    """Return where the faces of walls lie that bound the outer rooms, as seen from one side of the building.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    side : {"bottom", "left", "top", "right"}
        Side that one looks from; "bottom" looks along +y.

    Returns
    -------
    list of float
        Ascending positions along the side, metres, from one end of the building to the other.
    """
    bounds = plan_bounds(storey)
    if bounds is None:
        return []
    rooms = shapely.union_all([room.outline.polygon for room in storey.rooms])
    first, last = (bounds[0], bounds[2]) if side in ("bottom", "top") else (bounds[1], bounds[3])
    faces = [position for room in storey.rooms for position in _visible_faces(room.outline, rooms, side, bounds)]
    chain = [first]
    for position in sorted(faces):
        if position - chain[-1] > _MERGE and last - position > _MERGE:
            chain.append(position)
    return [*chain, last]


def _visible_faces(outline: Outline, rooms: BaseGeometry, side: Side, bounds: tuple[float, float, float, float]) -> Iterator[float]:
    """Positions of the room's faces square to a side that nothing but a wall hides from it."""
    upright = side in ("bottom", "top")
    for (x0, y0), (x1, y1) in pairwise((*outline.exterior, outline.exterior[0])):
        run, rise = (abs(x1 - x0), abs(y1 - y0)) if upright else (abs(y1 - y0), abs(x1 - x0))
        if rise < _LEAST_FACE or run > 0.01 * rise:
            continue
        if upright:
            x, inward = (x0 + x1) / 2, _NUDGE if y0 > y1 else -_NUDGE
            foot, beyond = (min(y0, y1), bounds[1] - 1) if side == "bottom" else (max(y0, y1), bounds[3] + 1)
            sight = shapely.LineString([(x + inward, foot), (x + inward, beyond)])
        else:
            x, inward = (y0 + y1) / 2, _NUDGE if x1 > x0 else -_NUDGE
            foot, beyond = (min(x0, x1), bounds[0] - 1) if side == "left" else (max(x0, x1), bounds[2] + 1)
            sight = shapely.LineString([(foot, x + inward), (beyond, x + inward)])
        if sight.intersection(rooms).length < 2 * _NUDGE:
            yield x


def _side_items(side: Side, chains: Iterable[list[float]], bounds: tuple[float, float, float, float], view: View) -> Iterator[Item]:
    (left, bottom), (right, top) = view.point(bounds[:2]), view.point(bounds[2:])
    edge = {"bottom": bottom, "top": top, "left": left, "right": right}[side]
    for chain, distance in zip(chains, (_FIRST_LINE, _SECOND_LINE), strict=False):
        upright = side in ("bottom", "top")
        places = [view.point((position, position))[0 if upright else 1] for position in chain]
        rail = Rail(side, edge, distance)
        marks = [*_rail_lines(rail, places), *_rail_texts(rail, places, chain)]
        yield Item(tuple(marks), "dimension")


def _rail_lines(rail: Rail, places: list[float]) -> Iterator[Mark]:
    ends = (min(places) - _OVERSHOOT, max(places) + _OVERSHOOT)
    start = rail.distance - _OVERSHOOT if rail.distance > _FIRST_LINE else _GAP
    helpers = [(rail.at(place, start), rail.at(place, rail.distance + _OVERSHOOT)) for place in places]
    yield Stroke(((rail.at(ends[0], rail.distance), rail.at(ends[1], rail.distance)), *helpers), "dimension-line")
    centres = (rail.at(place, rail.distance) for place in places)
    yield Stroke(tuple(((x - _TICK, y + _TICK), (x + _TICK, y - _TICK)) for x, y in centres), "tick")


def _rail_texts(rail: Rail, places: list[float], chain: list[float]) -> list[Text]:
    """Lengths above their parts of the chain, below where they are too narrow; what would cover another is left out."""
    spans = [((a + b) / 2, abs(b - a), f"{v - u:.2f}") for (a, b), (u, v) in zip(pairwise(places), pairwise(chain), strict=True)]
    texts: list[Text] = []
    for middle, room, label in sorted(spans, key=lambda span: (-span[1], span[0])):
        fits = text_width(label, _TEXT_SIZE) < room
        choices = [(_TEXT_SIZE, True)] if fits else [(_SMALL_TEXT_SIZE, True), (_SMALL_TEXT_SIZE, False)]
        for size, above in choices:
            text = _rail_text(rail, middle, label, size, above=above)
            if not any(text.box.buffer(0.2).intersects(other.box) for other in texts):
                texts.append(text)
                break
    return sorted(texts, key=lambda text: text.at)


def _rail_text(rail: Rail, middle: float, label: str, size: float, *, above: bool) -> Text:
    x, y = rail.at(middle, rail.distance)
    shift = -_TEXT_OFFSET if above else _TEXT_OFFSET + 0.8 * size
    if rail.side in ("bottom", "top"):
        return Text((x, y + shift), label, size, "middle", style="dimension-text")
    return Text((x + shift, y), label, size, "middle", angle=-90.0, style="dimension-text")
