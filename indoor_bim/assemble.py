"""From plan geometry to the building model: identifiers, heights, rooms, slabs and evidence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Column, Curve, Evidence, Joint, Outline, Ring, Room, Slab, Storey, Wall
from indoor_bim.plan.curve import Curve as FittedCurve
from indoor_bim.plan.curved_walls import pieces_of_curves
from indoor_bim.plan.face_accuracy import FaceAccuracy
from indoor_bim.plan.graph import Meeting
from indoor_bim.plan.hull import PROBE, building_hull
from indoor_bim.plan.walls import Walls

if TYPE_CHECKING:
    import shapely

Floats = NDArray[np.float64]

DECIMALS = 9  # coarser model coordinates would make joints overlap
SLAB_THICKNESS = 0.20  # metres; a scan shows one face of a slab only
SAME_PLATE = 0.001  # metres
NEAR = 0.15  # metres beyond a face: where the room on that side is looked for


def build_storey(
    walls: Walls,
    meetings: Sequence[Meeting],
    footprints: Sequence[shapely.Polygon],
    rooms: Sequence[shapely.Polygon],
    *,
    floor: float,
    ceiling: float,
    number: int = 1,
    name: str | None = None,
    room_evidence: Sequence[Evidence] = (),
    room_levels: Sequence[tuple[float, float]] = (),
    columns: Sequence[shapely.Polygon] = (),
    ceiling_plate: bool = True,
    accuracy: FaceAccuracy | None = None,
    curves: Sequence[FittedCurve] = (),
) -> Storey:
    """Storey of the building model from joined walls and rooms.

    Parameters
    ----------
    walls : Walls
        Joined walls, metres.
    meetings : sequence of Meeting
        Their corners.
    footprints : sequence of shapely.Polygon
        Their outlines.
    rooms : sequence of shapely.Polygon
        Free space of each room.
    floor, ceiling : float
        Levels of the storey in model coordinates, metres.
    number : int
        Storey number from the bottom, from 1; part of every identifier.
    name : str, optional
        Name of the storey.
    room_evidence : sequence of Evidence
        What each room rests on; may be empty.
    room_levels : sequence of (float, float)
        Floor and ceiling of each room where they differ from the storey's, metres; may be empty.
    columns : sequence of shapely.Polygon
        Outlines of free-standing columns.
    ceiling_plate : bool
        False where no plate covers the storey: under a pitched roof.
    accuracy : FaceAccuracy, optional
        How surely the faces of the walls are known.
    curves : sequence of Curve
        Circles that walls are pieces of.
    """
    prefix = f"S{number}"
    external = external_walls(walls, footprints, rooms)
    wall_ids = [f"{prefix}-W{k + 1:03d}" for k in range(len(walls))]
    model_walls = tuple(
        Wall(
            id=wall_ids[k],
            name=f"Wall {k + 1}",
            axis=(_point(walls.p[k]), _point(walls.q[k])),
            thickness=round(float(walls.thickness[k]), DECIMALS),
            thickness_measured=bool(walls.measured[k]),
            base=round(floor, DECIMALS),
            height=round(_wall_height(float(walls.top[k]), ceiling - floor), DECIMALS),
            footprint=_ring(footprints[k]),
            external=external[k],
            evidence=_wall_evidence(walls, k, accuracy),
            seen="both" if walls.measured[k] else "left" if walls.seen_left[k] else "right",
        )
        for k in range(len(walls))
    )
    bounds = _bounding_walls(rooms, footprints)
    levels = list(room_levels) or [(floor, ceiling)] * len(rooms)
    proofs = list(room_evidence) or [Evidence()] * len(rooms)
    model_rooms = tuple(
        Room(
            id=f"{prefix}-R{k + 1:02d}",
            name=f"Room {k + 1}",
            outline=_outline(room),
            floor=round(levels[k][0], DECIMALS),
            height=round(levels[k][1] - levels[k][0], DECIMALS),
            walls=tuple(wall_ids[i] for i in bounds[k]),
            evidence=proofs[k],
        )
        for k, room in enumerate(rooms)
    )
    return Storey(
        id=prefix,
        name=name or f"Storey {number}",
        elevation=round(floor, DECIMALS),
        height=round(ceiling - floor, DECIMALS),
        walls=model_walls,
        joints=tuple(Joint(_point(np.array(m.point)), tuple(wall_ids[w] for w in m.walls), m.ends) for m in meetings),
        curves=_curves(prefix, walls, curves),
        columns=tuple(
            Column(f"{prefix}-C{k + 1:02d}", f"Column {k + 1}", _ring(column), round(floor, DECIMALS), round(ceiling - floor, DECIMALS))
            for k, column in enumerate(columns)
        ),
        rooms=model_rooms,
        slabs=(
            *_slabs(prefix, "floor", footprints, rooms, floor, [level for level, _ in levels]),
            *(_slabs(prefix, "ceiling", footprints, rooms, ceiling, [level for _, level in levels]) if ceiling_plate else ()),
        ),
    )


def external_walls(walls: Walls, footprints: Sequence[shapely.Polygon], rooms: Sequence[shapely.Polygon]) -> list[bool | None]:
    """Tell which walls face the outside.

    A wall between two rooms is internal. A wall with a room on one side is external when nothing of the building lies beyond
    its other face, bays and gaps between rooms counted as building. Everything else is not known.

    Parameters
    ----------
    walls : Walls
        Joined walls, metres.
    footprints, rooms : sequence of shapely.Polygon
        Their outlines and the rooms between them.
    """
    import shapely

    if not rooms:
        return [None] * len(walls)
    tree = shapely.STRtree(list(rooms))
    hull = building_hull([*rooms, *footprints])
    out: list[bool | None] = []
    for k in range(len(walls)):
        share = (np.arange(10) + 0.5) / 10
        line = walls.p[k] + share[:, None] * (walls.q[k] - walls.p[k])
        has_room, outside = [], []
        for side in (1.0, -1.0):
            near = line + side * (walls.thickness[k] / 2 + NEAR) * walls.normal[k]
            far = line + side * (walls.thickness[k] / 2 + PROBE) * walls.normal[k]
            inside = np.unique(tree.query(shapely.points(near), predicate="within")[0])
            has_room.append(len(inside) >= 3)
            outside.append(float((~shapely.contains_xy(hull, far[:, 0], far[:, 1])).mean()) > 0.8)
        if all(has_room):
            out.append(False)
        elif any(has_room):
            out.append(True if outside[has_room.index(False)] else None)
        else:
            out.append(None)
    return out


def _curves(prefix: str, walls: Walls, curves: Sequence[FittedCurve]) -> tuple[Curve, ...]:
    """Curves with at least two walls, about the axes of these."""
    of_curve, of_piece = pieces_of_curves(walls, curves)
    out: list[Curve] = []
    for number, curve in enumerate(curves):
        rows = np.flatnonzero(of_curve == number)
        if len(rows) < 2:
            continue
        rows = rows[np.argsort(of_piece[rows], kind="stable")]
        foot = float(np.median(np.abs(((walls.p[rows] - curve.centre) * walls.normal[rows]).sum(axis=1))))
        radius = foot / curve.chord_distance(1.0)
        corner = foot / np.cos((curve.end - curve.start) / curve.pieces / 2)
        angles = curve.breaks[[of_piece[rows[0]], of_piece[rows[-1]] + 1]]
        ends = curve.centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
        out.append(
            Curve(
                id=f"{prefix}-A{len(out) + 1:02d}",
                centre=_point(curve.centre),
                radius=round(radius, DECIMALS),
                ends=(_point(ends[0]), _point(ends[1])),
                walls=tuple(f"{prefix}-W{k + 1:03d}" for k in rows),
                chain_deviation=round(max(corner - radius, radius - foot), DECIMALS),
                radius_sigma=round(curve.radius_sigma, DECIMALS),
                deviation=round(curve.deviation, DECIMALS),
            )
        )
    return tuple(out)


def _wall_evidence(walls: Walls, k: int, accuracy: FaceAccuracy | None) -> Evidence:
    def known(values: Floats) -> float | None:
        return round(float(values[k]), DECIMALS) if np.isfinite(values[k]) else None

    return Evidence(
        support=int(walls.support[k]),
        coverage=round(float(np.clip(walls.coverage[k], 0, 1)), 3),
        rmse=known(walls.rmse),
        sides=2 if walls.measured[k] else 1,
        deviation=None if accuracy is None else known(accuracy.deviation),
        position_sigma=None if accuracy is None else known(accuracy.position),
        direction_sigma=None if accuracy is None else known(np.degrees(accuracy.direction)),
    )


def _wall_height(top: float, storey: float) -> float:
    return top if np.isfinite(top) and top > 0.1 else storey


def _bounding_walls(rooms: Sequence[shapely.Polygon], footprints: Sequence[shapely.Polygon]) -> list[list[int]]:
    """Rows of the walls that touch each room along a stretch."""
    import shapely

    if not rooms or not footprints:
        return [[] for _ in rooms]
    tree = shapely.STRtree(list(footprints))
    out = []
    for room in rooms:
        ring = room.buffer(0.03, join_style="mitre").difference(room)
        near = sorted(int(k) for k in tree.query(room, predicate="dwithin", distance=0.03))
        out.append([k for k in near if footprints[k].intersection(ring).area > 0.03 * 0.10])
    return out


def _slabs(
    prefix: str,
    kind: Literal["floor", "ceiling"],
    footprints: Sequence[shapely.Polygon],
    rooms: Sequence[shapely.Polygon],
    level: float,
    room_levels: Sequence[float],
) -> tuple[Slab, ...]:
    """Plates under or over everything that walls enclose, and plates of their own for rooms at another level."""
    import shapely

    if not footprints and not rooms:
        return ()
    # a hair wider before, narrower after: outlines that touch in rounded coordinates become one
    plan = shapely.union_all([*rooms, *footprints]).buffer(0.005, join_style="mitre").buffer(-0.005, join_style="mitre")
    parts = [shapely.Polygon(part.exterior).simplify(0.001) for part in shapely.get_parts(plan) if part.geom_type == "Polygon"]
    own = [k for k, height in enumerate(room_levels) if abs(height - level) > SAME_PLATE]
    if own:
        others = shapely.union_all([rooms[k] for k in own])
        parts = [left for part in parts for left in shapely.get_parts(part.difference(others)) if left.geom_type == "Polygon"]
    parts.sort(key=lambda part: (-round(part.area, 3), part.bounds))
    plates = [(part, level) for part in parts] + [(rooms[k], room_levels[k]) for k in own]
    return tuple(
        Slab(
            id=f"{prefix}-{kind.capitalize()}{k + 1}",
            name=f"{kind.capitalize()} {k + 1}",
            kind=kind,
            outline=_outline(part),
            level=round(height, DECIMALS),
            thickness=SLAB_THICKNESS,
        )
        for k, (part, height) in enumerate(plates)
    )


def _point(xy: Floats) -> tuple[float, float]:
    return round(float(xy[0]), DECIMALS) + 0.0, round(float(xy[1]), DECIMALS) + 0.0


def _ring(polygon: shapely.Polygon) -> Ring:
    return _outline(polygon).exterior


def _outline(polygon: shapely.Polygon) -> Outline:
    import shapely

    rings = [[_point(np.array(c)) for c in ring.coords] for ring in (polygon.exterior, *polygon.interiors)]
    return Outline.from_polygon(shapely.Polygon(rings[0], rings[1:]))
