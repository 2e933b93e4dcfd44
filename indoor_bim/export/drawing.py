"""Walls, openings and columns of a storey as a draughtsman draws them, cut about one metre above the floor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from indoor_bim.export.marks import Arc, Item, Layer, Mark, Stroke
from indoor_bim.export.mesh import opening_region, region, wall_frame
from indoor_bim.export.page import View
from indoor_bim.model import Opening, Point2, Storey, Wall

LEAST_COVERAGE = 0.2
HATCH_SPACING, WIDE_HATCH_SPACING = 1.2, 2.4
_GRID = 1e-6
LEAF_THICKNESS = 0.04
_GLASS_GAP = 0.06
_LEAST_GAP = 0.35
_FACE_STRIP = 0.01


def is_supported(wall: Wall) -> bool:
    """Tell whether the scan shows enough of a wall to draw it in full lines."""
    return wall.evidence.coverage >= LEAST_COVERAGE


def plan_bounds(storey: Storey) -> tuple[float, float, float, float] | None:
    """Return least x and y, greatest x and y of everything that a plan shows, metres; None when there is nothing."""
    rings = [element.footprint for kind in (storey.walls, storey.columns) for element in kind]
    corners = np.array([corner for ring in (*rings, *(room.outline.exterior for room in storey.rooms)) for corner in ring])
    if not len(corners):
        return None
    (x0, y0), (x1, y1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return x0, y0, x1, y1


def drawn_bounds(storey: Storey) -> tuple[float, float, float, float] | None:
    """Return the bounds of a plan as `plan_bounds`, open door leaves included."""
    bounds = plan_bounds(storey)
    if bounds is None:
        return None
    tips = [point for wall in storey.walls for opening in wall.openings for leaf in door_leaves(wall, opening) for point in leaf]
    corners = np.array([bounds[:2], bounds[2:], *tips])
    (x0, y0), (x1, y1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return x0, y0, x1, y1


def wall_layers(storey: Storey, view: View) -> Iterator[Layer]:
    """Draw the walls of a storey with their openings left out.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    view : View
        Way to the paper.

    Yields
    ------
    Layer
        Bodies (one item per wall, named after it), hatch and outlines.
    """
    bodies = {wall.id: wall_body(wall) for wall in storey.walls}
    kinds = {wall.id: _wall_kind(wall) for wall in storey.walls}
    items = (Item(_area(bodies[wall.id], view, "wall-body"), kinds[wall.id], wall.id, _wall_title(wall)) for wall in storey.walls)
    yield Layer("walls", "Walls", tuple(items))

    measured = [bodies[wall.id] for wall in storey.walls if wall.thickness_measured]
    assumed = [bodies[wall.id] for wall in storey.walls if not wall.thickness_measured]
    columns = [region(column.footprint) for column in storey.columns]
    hatches = [_hatch(_union(measured), view, HATCH_SPACING), _hatch(_union(assumed), view, WIDE_HATCH_SPACING)]
    yield Layer("wall-hatch", "Wall hatch", tuple(Item((Stroke(lines, "hatch"),)) for lines in hatches if lines))

    drawn = ((merged_lines(view.shape(shape)), style) for style, shape in wall_outlines(storey).items())
    yield Layer("wall-outlines", "Wall outlines", tuple(Item((Stroke(lines, style),)) for lines, style in drawn if lines))
    yield Layer(
        "columns",
        "Columns",
        tuple(
            Item(_area(shape, view, "column-body"), "column", column.id, column.name)
            for column, shape in zip(storey.columns, columns, strict=True)
        ),
    )


def wall_outlines(storey: Storey) -> dict[str, BaseGeometry]:
    """Return the outlines of the walls of a storey, openings cut out, by their style.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.

    Returns
    -------
    dict
        Lines in metres: "outline" of what was seen, "outline unseen" of far faces, "outline unsupported" of doubtful walls.
    """
    bodies = {wall.id: wall_body(wall) for wall in storey.walls}
    supported = _union(bodies[wall.id] for wall in storey.walls if is_supported(wall))
    border = _union(bodies.values()).boundary or shapely.MultiLineString()
    doubtful = border.difference(supported.buffer(10 * _GRID))
    sure = border.difference(doubtful)
    unseen = sure.intersection(_union(unseen_face(wall) for wall in storey.walls))
    return {"outline": sure.difference(unseen), "outline unseen": unseen, "outline unsupported": doubtful}


def opening_layers(storey: Storey, view: View) -> Iterator[Layer]:
    """Draw the doors, windows and passages of a storey.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    view : View
        Way to the paper.

    Yields
    ------
    Layer
        Doors, windows, passages: one item each, named after it.
    """
    symbols = {"door": _door, "window": _window, "opening": _passage}
    for kind, label in (("door", "Doors"), ("window", "Windows"), ("opening", "Openings")):
        items = [
            Item(tuple(symbols[kind](wall, opening, view)), kind, opening.id, _opening_title(opening))
            for wall in storey.walls
            for opening in wall.openings
            if opening.kind == kind
        ]
        yield Layer(label.lower(), label, tuple(items))


def swing_areas(storey: Storey, view: View) -> list[BaseGeometry]:
    """Return what door leaves sweep, on paper, in millimetres."""
    areas: list[BaseGeometry] = []
    for wall in storey.walls:
        for opening in wall.openings:
            areas += [view.shape(_sector(hinge, tip, latch)) for hinge, tip, latch in door_leaves(wall, opening)]
    return areas


def _sector(hinge: Point2, tip: Point2, latch: Point2) -> shapely.Polygon:
    """Quarter of a disc around a hinge."""
    share = np.linspace(0, np.pi / 2, 13)[:, None]
    centre = np.array(hinge)
    arc = centre + np.cos(share) * (np.array(tip) - centre) + np.sin(share) * (np.array(latch) - centre)
    return shapely.Polygon([centre, *arc])


def wall_body(wall: Wall) -> BaseGeometry:
    """Return the plan of a wall with its openings cut out, metres."""
    holes = shapely.union_all([shapely.Polygon(opening_region(wall, opening)) for opening in wall.openings])
    return region(wall.footprint).difference(holes)


def unseen_face(wall: Wall) -> BaseGeometry:
    """Narrow strip along the face of a wall that the scan did not show."""
    if wall.seen not in ("left", "right"):
        return shapely.Polygon()
    origin, along, left = wall_frame(wall)
    offset = (-0.5 if wall.seen == "left" else 0.5) * wall.thickness
    ends = [origin + offset * left + share * along for share in (-wall.thickness, wall.length + wall.thickness)]
    return shapely.LineString(ends).buffer(_FACE_STRIP, cap_style="flat")


def _union(shapes: Iterable[BaseGeometry]) -> BaseGeometry:
    return shapely.union_all(list(shapes), grid_size=_GRID)


def _wall_kind(wall: Wall) -> str:
    kinds = ["wall", "" if wall.thickness_measured else "assumed", "" if is_supported(wall) else "unsupported"]
    return " ".join(kind for kind in kinds if kind)


def _wall_title(wall: Wall) -> str:
    thickness = f"{wall.thickness * 1000:.0f} mm{'' if wall.thickness_measured else ' (assumed)'}"
    return f"{wall.name}, {wall.length:.2f} m, {thickness}, coverage {wall.evidence.coverage:.0%}"


def _opening_title(opening: Opening) -> str:
    return f"{opening.name}, {opening.width:.2f} x {opening.height:.2f} m, sill {opening.sill:.2f} m"


def _area(shape: BaseGeometry, view: View, style: str) -> tuple[Mark, ...]:
    rings = [
        ring
        for part in shapely.get_parts(shapely.normalize(view.shape(shape)))
        if part.area > 0
        for ring in (part.exterior, *part.interiors)
    ]
    return (Stroke(tuple(sorted(tuple(ring.coords[:-1]) for ring in rings)), style, closed=True),)


def merged_lines(shape: BaseGeometry) -> tuple[tuple[Point2, ...], ...]:
    """Return the corners of the lines of a shape, those that meet joined, in a fixed order."""
    lines = shapely.get_parts(shapely.line_merge(shapely.union_all(shapely.get_parts(shape))))
    return tuple(sorted(tuple(line.coords) for line in lines if line.geom_type == "LineString"))


def _hatch(shape: BaseGeometry, view: View, spacing: float) -> tuple[tuple[Point2, ...], ...]:
    """Lines at 45 degrees through a shape, at a fixed spacing on the paper."""
    if shape.is_empty:
        return ()
    paper = view.shape(shape)
    x0, y0, x1, y1 = paper.bounds
    step = spacing * np.sqrt(2)
    sums = step * np.arange(np.floor((x0 + y0) / step), np.ceil((x1 + y1) / step) + 1)
    lines = [shapely.LineString([(total - y0 + 1, y0 - 1), (total - y1 - 1, y1 + 1)]) for total in sums]
    pieces = shapely.get_parts(shapely.intersection(lines, paper))
    return tuple(sorted(tuple(piece.coords) for piece in pieces if piece.geom_type == "LineString" and piece.length > 0.05))


def jamb_points(wall: Wall, opening: Opening, offset: float) -> tuple[Point2, Point2]:
    """Jambs of an opening on a line beside the axis; a positive offset lies to its left."""
    origin, along, left = wall_frame(wall)
    a, b = (origin + s * along + offset * left for s in (opening.start, opening.start + opening.width))
    return (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))


def _across(wall: Wall, opening: Opening, view: View, offsets: Iterable[float], style: str) -> Stroke:
    lines = (jamb_points(wall, opening, offset) for offset in offsets)
    return Stroke(tuple((view.point(a), view.point(b)) for a, b in lines), style)


def door_leaves(wall: Wall, opening: Opening) -> Iterator[tuple[Point2, Point2, Point2]]:
    """Hinge, tip of the open leaf and latch of each leaf whose hinge and side are known, metres."""
    if opening.kind != "door" or opening.swing is None or opening.leaves == 0 or (opening.hinge is None and opening.leaves == 1):
        return
    side = 1.0 if opening.swing == "left" else -1.0
    start, end = (np.array(p) for p in jamb_points(wall, opening, side * wall.thickness / 2))
    out = side * wall_frame(wall)[2] * opening.width / opening.leaves
    middle = (start + end) / 2
    pairs = [(start, middle), (end, middle)] if opening.leaves == 2 else [(start, end) if opening.hinge == "start" else (end, start)]
    for hinge, latch in pairs:
        yield tuple(hinge.tolist()), tuple((hinge + out).tolist()), tuple(latch.tolist())


def _door(wall: Wall, opening: Opening, view: View) -> Iterator[Mark]:
    half = wall.thickness / 2
    yield _across(wall, opening, view, (-half, half), "threshold")
    leaves = list(door_leaves(wall, opening))
    for hinge, tip, latch in leaves:
        radius = float(np.hypot(tip[0] - hinge[0], tip[1] - hinge[1]))
        turn = (tip[0] - hinge[0]) * (latch[1] - hinge[1]) - (tip[1] - hinge[1]) * (latch[0] - hinge[0])
        yield Stroke(((view.point(hinge), view.point(tip)),), "leaf")
        yield Arc(view.point(tip), view.point(latch), radius * view.mm_per_metre, turn < 0, "swing")
    if not leaves and opening.leaves:
        offset = max(LEAF_THICKNESS, 0.5 / view.mm_per_metre) / 2
        (a, b), (d, c) = jamb_points(wall, opening, -offset), jamb_points(wall, opening, offset)
        yield Stroke((tuple(view.point(corner) for corner in (a, b, c, d)),), "closed-leaf", closed=True)


def _window(wall: Wall, opening: Opening, view: View) -> Iterator[Mark]:
    half = wall.thickness / 2
    gap = min(max(_GLASS_GAP, _LEAST_GAP / view.mm_per_metre), half) / 2
    yield _across(wall, opening, view, (-half, half), "threshold")
    yield _across(wall, opening, view, (-gap, gap), "glass")


def _passage(wall: Wall, opening: Opening, view: View) -> Iterator[Mark]:
    half = wall.thickness / 2
    yield _across(wall, opening, view, (-half, half), "lintel")
