"""Dimension chains outside the plan: openings in outer walls, faces of the walls of the outer rooms, overall sizes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import floor
from typing import Literal

import shapely
from shapely.geometry.base import BaseGeometry

from indoor_bim.export.drawing import drawn_bounds, plan_bounds
from indoor_bim.export.marks import Item, Layer, Mark, Stroke, Text, text_width
from indoor_bim.export.mesh import region
from indoor_bim.export.page import DIMENSION_SPACE, View
from indoor_bim.model import Outline, Point2, Storey, Wall

Side = Literal["bottom", "left", "top", "right"]

_SIDES: tuple[Side, ...] = ("bottom", "left", "top", "right")
_OPPOSITE: dict[Side, Side] = {"top": "bottom", "right": "left"}
FIRST_LINE, LINE_SPACING = 9.0, 8.0
_GAP = 2.0
_OVERSHOOT = 1.5
_TICK = 1.0
_TEXT_SIZE, _SMALL_TEXT_SIZE = 2.5, 1.8
_TEXT_OFFSET = 0.8
_MERGE = 0.015
_LEAST_FACE = 0.3
_NUDGE = 0.02
_SKEW = 0.01


@dataclass(frozen=True, slots=True)
class Rail:
    """Line on paper that a chain is drawn on, at a distance beside the plan's edge; helper lines come from `start`."""

    side: Side
    edge: float
    distance: float
    start: float

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
    items = (_side_items(storey, side, chains, view) for side, chains in side_chains(storey).items())
    return Layer("dimensions", "Dimensions", tuple(item for side_items in items for item in side_items))


def side_chains(storey: Storey) -> dict[Side, list[list[float]]]:
    """Return the chains to draw beside each side of a plan, from the inside outwards.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.

    Returns
    -------
    dict
        Jambs of openings, wall faces and overall size, metres along the side; what the opposite side tells is left out.
    """
    if plan_bounds(storey) is None:
        return {}
    faces = {side: wall_face_chain(storey, side) for side in _SIDES}
    chains: dict[Side, list[list[float]]] = {}
    for side, chain in faces.items():
        opposite = faces.get(_OPPOSITE[side], []) if side in _OPPOSITE else []
        told = len(chain) == len(opposite) and all(abs(a - b) < _MERGE for a, b in zip(chain, opposite, strict=True))
        jambs = opening_chain(storey, side)
        chains[side] = [jambs] if jambs else []
        if len(chain) > 2 and not told:
            chains[side].append(chain)
        if side in ("bottom", "left"):
            chains[side].append([chain[0], chain[-1]])
    return chains


def dimension_space(storey: Storey) -> float:
    """Return the room that the chains of a storey need on each side, millimetres."""
    most = max((2 + bool(opening_chain(storey, side)) for side in _SIDES), default=2)
    return DIMENSION_SPACE + (most - 2) * LINE_SPACING


def opening_chain(storey: Storey, side: Side) -> list[float]:
    """Return where the jambs of the openings lie that one sees from one side of the building, between its ends.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    side : {"bottom", "left", "top", "right"}
        Side that one looks from; "bottom" looks along +y.

    Returns
    -------
    list of float
        Ascending positions along the side, metres, the ends of the building included; empty without openings.
    """
    bounds = plan_bounds(storey)
    if bounds is None:
        return []
    along, across = (0, 1) if side in ("bottom", "top") else (1, 0)
    solids = [region(wall.footprint) for wall in storey.walls]
    solids += [region(room.outline.exterior, room.outline.holes) for room in storey.rooms]
    tree = shapely.STRtree(solids)
    beyond = {"bottom": bounds[1], "left": bounds[0], "top": bounds[3], "right": bounds[2]}[side]
    jambs: list[float] = []
    for number, wall in enumerate(storey.walls):
        p, q = wall.axis
        if abs(q[across] - p[across]) > _SKEW * abs(q[along] - p[along]):
            continue
        for opening in wall.openings:
            ends = [p[along] + (q[along] - p[along]) * place / wall.length for place in (opening.start, opening.start + opening.width)]
            middle, depth = sum(ends) / 2, (p[across] + q[across]) / 2
            sight = shapely.LineString([(middle, depth), (middle, beyond)] if along == 0 else [(depth, middle), (beyond, middle)])
            others = [solids[k] for k in tree.query(sight) if k != number]
            if not shapely.union_all(shapely.intersection(sight, others)).length > _NUDGE:
                jambs += ends
    if not jambs:
        return []
    first, last = bounds[along], bounds[along + 2]
    chain = [first]
    for position in sorted(jambs):
        if position - chain[-1] > _MERGE and last - position > _MERGE:
            chain.append(position)
    return [*chain, last]


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
    rooms = shapely.union_all([region(room.outline.exterior, room.outline.holes) for room in storey.rooms])
    first, last = (bounds[0], bounds[2]) if side in ("bottom", "top") else (bounds[1], bounds[3])
    walls = shapely.union_all([region(wall.footprint) for wall in storey.walls]).buffer(_MERGE)
    faces = [position for room in storey.rooms for position in _visible_faces(room.outline, rooms, walls, side, bounds)]
    if not storey.rooms:
        faces = [position for wall in storey.walls for position in _inner_face(wall, side, first, last)]
    chain = [first]
    for position in sorted(faces):
        if position - chain[-1] > _MERGE and last - position > _MERGE:
            chain.append(position)
    return [*chain, last]


def _inner_face(wall: Wall, side: Side, first: float, last: float) -> Iterator[float]:
    """Position of the inner face of a wall that lies along one end of the building, square to a side."""
    along, across = (0, 1) if side in ("bottom", "top") else (1, 0)
    low, high = (end([corner[along] for corner in wall.footprint]) for end in (min, max))
    (p, q) = wall.axis
    if abs(q[along] - p[along]) > _SKEW * abs(q[across] - p[across]):
        return
    if low - first < _MERGE:
        yield high
    elif last - high < _MERGE:
        yield low


def _visible_faces(
    outline: Outline, rooms: BaseGeometry, walls: BaseGeometry, side: Side, bounds: tuple[float, float, float, float]
) -> Iterator[float]:
    """Positions of the wall faces of a room, square to a side, that nothing but a wall hides from it."""
    upright = side in ("bottom", "top")
    for p, q in pairwise((*outline.exterior, outline.exterior[0])):
        (u0, v0), (u1, v1) = (p, q) if upright else (p[::-1], q[::-1])
        if abs(v1 - v0) < _LEAST_FACE or abs(u1 - u0) > _SKEW * abs(v1 - v0):
            continue
        if shapely.LineString([p, q]).intersection(walls).length < _LEAST_FACE:
            continue
        u = (u0 + u1) / 2
        inside = u + (_NUDGE if (v0 > v1) == upright else -_NUDGE)
        start, beyond = {
            "bottom": (min(v0, v1), bounds[1]),
            "left": (min(v0, v1), bounds[0]),
            "top": (max(v0, v1), bounds[3]),
            "right": (max(v0, v1), bounds[2]),
        }[side]
        sight = [(inside, start), (inside, beyond)] if upright else [(start, inside), (beyond, inside)]
        if shapely.LineString(sight).intersection(rooms).length < _NUDGE:
            yield u


def _side_items(storey: Storey, side: Side, chains: Iterable[list[float]], view: View) -> Iterator[Item]:
    walls, drawn = plan_bounds(storey), drawn_bounds(storey)
    if walls is None or drawn is None:
        return
    edge, far = _edge(side, walls, view), _edge(side, drawn, view)
    for number, chain in enumerate(chains):
        distance = FIRST_LINE + number * LINE_SPACING
        places = [view.point((position, position))[0 if side in ("bottom", "top") else 1] for position in chain]
        outwards = distance + abs(far - edge)
        rail = Rail(side, edge, outwards, _GAP if number == 0 else outwards - _OVERSHOOT)
        marks = [*_rail_lines(rail, places), *_rail_texts(rail, places, chain)]
        yield Item(tuple(marks), "dimension")


def _edge(side: Side, bounds: tuple[float, float, float, float], view: View) -> float:
    (left, bottom), (right, top) = view.point(bounds[:2]), view.point(bounds[2:])
    return {"bottom": bottom, "top": top, "left": left, "right": right}[side]


def _rail_lines(rail: Rail, places: list[float]) -> Iterator[Mark]:
    ends = (min(places) - _OVERSHOOT, max(places) + _OVERSHOOT)
    helpers = [(rail.at(place, rail.start), rail.at(place, rail.distance + _OVERSHOOT)) for place in places]
    yield Stroke(((rail.at(ends[0], rail.distance), rail.at(ends[1], rail.distance)), *helpers), "dimension-line")
    centres = (rail.at(place, rail.distance) for place in places)
    yield Stroke(tuple(((x - _TICK, y + _TICK), (x + _TICK, y - _TICK)) for x, y in centres), "tick")


def _rail_texts(rail: Rail, places: list[float], chain: list[float]) -> list[Text]:
    """Lengths above their parts of the chain, outside where these are too narrow; what would cover another is left out."""
    spans = [((a + b) / 2, abs(b - a), label) for (a, b), label in zip(pairwise(places), centimetre_labels(chain), strict=True)]
    texts: list[Text] = []
    boxes: list[shapely.Polygon] = []
    for middle, room, label in sorted(spans, key=lambda span: (-span[1], span[0])):
        narrow = text_width(label, _TEXT_SIZE) > room - 2 * _TICK
        text = _outside_text(rail, middle, label) if narrow else _inline_text(rail, middle, label)
        box = text.box
        if not shapely.intersects(box.buffer(0.2), boxes).any():
            texts.append(text)
            boxes.append(box)
    return sorted(texts, key=lambda text: text.at)


def centimetre_labels(chain: list[float]) -> list[str]:
    """Write the parts of a chain in metres to the centimetre so that they add up to the whole.

    Parameters
    ----------
    chain : list of float
        Ascending positions, metres.

    Returns
    -------
    list of str
        Each part rounded up or down; the largest remainders go up.

    Examples
    --------
    >>> centimetre_labels([0.0, 0.25, 4.075, 4.175, 8.0, 8.25])
    ['0.25', '3.83', '0.10', '3.82', '0.25']
    """
    lengths = [round(100 * (b - a), 6) for a, b in pairwise(chain)]
    whole = [floor(length) for length in lengths]
    missing = floor(round(100 * (chain[-1] - chain[0]), 6) + 0.5) - sum(whole)
    for i in sorted(range(len(whole)), key=lambda i: (whole[i] - lengths[i], -lengths[i], i))[:missing]:
        whole[i] += 1
    return [f"{length / 100:.2f}" for length in whole]


def _inline_text(rail: Rail, middle: float, label: str) -> Text:
    """Text between the helper lines, just above the line; upright lines are read from the right."""
    x, y = rail.at(middle, rail.distance)
    if rail.side in ("bottom", "top"):
        return Text((x, y - _TEXT_OFFSET), label, _TEXT_SIZE, "middle", style="dimension-text")
    return Text((x - _TEXT_OFFSET, y), label, _TEXT_SIZE, "middle", angle=-90.0, style="dimension-text")


def _outside_text(rail: Rail, middle: float, label: str) -> Text:
    """Small text on the far side of the line, beyond the ends of the helper lines."""
    size = _SMALL_TEXT_SIZE
    x, y = rail.at(middle, rail.distance + _OVERSHOOT + 0.3)
    if rail.side in ("bottom", "top"):
        return Text((x, y + (0.78 * size if rail.side == "bottom" else -0.1)), label, size, "middle", style="dimension-text")
    return Text((x + (0.78 * size if rail.side == "right" else -0.1), y), label, size, "middle", angle=-90.0, style="dimension-text")
