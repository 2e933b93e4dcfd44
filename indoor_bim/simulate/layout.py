"""Laying out a known storey: walls with joints resolved, exact rooms, slabs.

A storey is laid out on centre lines: a closed ring of outer walls and partitions that end on the centre lines of
other walls. Footprints, rooms and joints follow from these exactly.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from indoor_bim.model import Column, Joint, Opening, Outline, Point2, Ring, Room, Slab, Storey, Wall

if TYPE_CHECKING:
    import shapely

_TOUCH, _GRID = 1e-6, 1e-9


@dataclass(frozen=True, slots=True)
class Partition:
    """Inner wall on its centre line; both ends lie on centre lines of other walls, metres."""

    start: Point2
    end: Point2
    thickness: float
    openings: tuple[Opening, ...] = ()


@dataclass(frozen=True, slots=True)
class CurvedPartition:
    """Inner wall along a chain of points on its centre line, closed where the last is the first; ends as of a `Partition`, metres.

    Parameters
    ----------
    path : tuple of (x, y)
        Points of the centre line.
    thickness : float
        Thickness.
    openings : mapping of int to tuple of Opening
        Openings of the pieces between two points, numbered from 0.
    """

    path: tuple[Point2, ...]
    thickness: float
    openings: Mapping[int, tuple[Opening, ...]] = field(default_factory=dict)

    @property
    def pieces(self) -> list[Partition]:
        """Straight pieces of the chain."""
        ends = enumerate(itertools.pairwise(self.path))
        return [Partition(start, end, self.thickness, tuple(self.openings.get(k, ()))) for k, (start, end) in ends]


def arc(start: Point2, end: Point2, radius: float, *, sagitta: float = 0.001) -> list[Point2]:
    """Points from start to end on the smaller arc between them, which lies to the right of the way.

    Parameters
    ----------
    start, end : (x, y)
        Ends, metres.
    radius : float
        Radius, metres.
    sagitta : float
        Largest distance of the arc from the chain of points, metres.

    Raises
    ------
    ValueError
        If the ends are farther apart than the diameter.

    Examples
    --------
    >>> [(round(x, 3), round(y, 3)) for x, y in arc((0.0, 0.0), (2.0, 0.0), 1.0, sagitta=0.3)]
    [(0.0, 0.0), (1.0, -1.0), (2.0, 0.0)]
    """
    a, b = np.asarray(start), np.asarray(end)
    half = (b - a) / 2
    rise = radius**2 - float(half @ half)
    if rise < -_TOUCH:
        raise ValueError(f"an arc of radius {radius} m does not reach from {start} to {end}")
    left = np.array([-half[1], half[0]]) / np.linalg.norm(half)
    centre = (a + b) / 2 + left * max(rise, 0.0) ** 0.5
    first = float(np.arctan2(*(a - centre)[::-1]))
    turn = 2 * float(np.arcsin(min(1.0, float(np.linalg.norm(half)) / radius)))
    angles = first + np.linspace(0.0, turn, int(np.ceil(turn / (2 * np.arccos(1 - sagitta / radius)) - _TOUCH)) + 1)
    inner = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])[1:-1]
    return [start, *((float(x), float(y)) for x, y in np.round(inner, 9)), end]


def door(
    centre: float,
    *,
    width: float = 0.9,
    height: float = 2.05,
    hinge: Literal["start", "end"] | None = None,
    swing: Literal["left", "right"] = "left",
) -> Opening:
    """Door centred `centre` metres from the first end of the wall axis; it stands open if it has a `hinge`, else it is closed.

    Examples
    --------
    >>> door(2.0, width=1.0).start
    1.5
    """
    return _opening("door", centre, width, 0.0, height, hinge, swing if hinge else None)


def passage(centre: float, *, width: float = 1.0, height: float = 2.1) -> Opening:
    """Opening to the floor without a leaf, centred `centre` metres from the first end of the wall axis."""
    return _opening("opening", centre, width, 0.0, height)


def window(centre: float, *, width: float = 1.4, sill: float = 0.9, height: float = 1.3) -> Opening:
    """Glazed window centred `centre` metres from the first end of the wall axis, its sill above the foot of the wall."""
    return _opening("window", centre, width, sill, height)


def _opening(
    kind: Literal["door", "window", "opening"],
    centre: float,
    width: float,
    sill: float,
    height: float,
    hinge: Literal["start", "end"] | None = None,
    swing: Literal["left", "right"] | None = None,
) -> Opening:
    return Opening(
        "unplaced", "", kind, round(centre - width / 2, 9), width, sill, height, hinge, swing, 0 if kind == "opening" else 1, 1.0
    )


def lay_out_storey(
    number: int,
    ring: Sequence[Point2],
    thickness: float,
    ring_openings: Sequence[Sequence[Opening]],
    partitions: Sequence[Partition | CurvedPartition],
    rooms: Sequence[tuple[str, Point2]],
    *,
    elevation: float = 0.0,
    height: float = 2.6,
    slab_thickness: float = 0.3,
    stairwells: tuple[Ring | None, Ring | None] = (None, None),
    columns: Sequence[Ring] = (),
) -> Storey:
    """Storey from centre lines, with joint-resolved wall footprints and exact rooms.

    Outer walls meet in mitres; a partition is cut by the outer walls and by the partitions listed before it.

    Parameters
    ----------
    number : int
        Number of the storey from 1, the prefix of all identifiers.
    ring : sequence of (x, y)
        Centre line of the outer walls, counter-clockwise, metres.
    thickness : float
        Thickness of the outer walls, metres.
    ring_openings : sequence of sequences of Opening
        Openings of each outer wall.
    partitions : sequence of Partition and CurvedPartition
        Inner walls; those that run through at a T joint before those that end there.
    rooms : sequence of (name, (x, y))
        Name of every room and a point in it.
    elevation, height, slab_thickness : float
        Level of the floor, clear height and thickness of floor and ceiling plates, metres.
    stairwells : tuple of two rings
        Holes in the floor and in the ceiling, if any.
    columns : sequence of rings
        Outlines of columns that stand in rooms.

    Raises
    ------
    ValueError
        If a partition falls apart, or rooms and names do not match one to one.
    """
    import shapely

    outer, inner = _offset_ring(ring, -thickness / 2), _offset_ring(ring, thickness / 2)
    corners = range(len(ring))
    specs = [Partition(ring[i], ring[i - len(ring) + 1], thickness, tuple(ring_openings[i])) for i in corners]
    bodies = [shapely.Polygon([outer[i], outer[i - len(ring) + 1], inner[i - len(ring) + 1], inner[i]]) for i in corners]
    free = shapely.Polygon(inner)
    for k, partition in enumerate(partitions):
        whole = free
        for spec, strip in _strips(partition, partitions[k + 1 :]):
            common = shapely.intersection(strip, whole, grid_size=_GRID)
            pieces = [piece for piece in shapely.get_parts(common) if piece.geom_type == "Polygon" and piece.area > _TOUCH]
            if len(pieces) != 1 and (isinstance(partition, Partition) or pieces):
                raise ValueError(f"partition {k} falls apart: let it end at the wall that it crosses")
            specs += [spec] * len(pieces)
            bodies += pieces
            free = shapely.difference(free, shapely.union_all(pieces), grid_size=_GRID)
    free = shapely.difference(free, shapely.union_all([shapely.Polygon(column) for column in columns]), grid_size=_GRID)
    counters = {"door": 0, "window": 0, "opening": 0}
    walls = tuple(
        Wall(
            id=f"s{number}-wall-{k + 1:02d}",
            name=f"Wall {number}.{k + 1:02d}",
            axis=(spec.start, spec.end),
            thickness=spec.thickness,
            thickness_measured=True,
            base=elevation,
            height=height,
            footprint=Outline.from_polygon(body.simplify(0)).exterior,
            external=k < len(ring),
            openings=tuple(_numbered(opening, number, counters) for opening in spec.openings),
        )
        for k, (spec, body) in enumerate(zip(specs, bodies, strict=True))
    )
    plate = Outline.from_polygon(shapely.Polygon(outer))
    return Storey(
        id=f"s{number}",
        name=f"Storey {number}",
        elevation=elevation,
        height=height,
        walls=walls,
        joints=_joints(walls),
        columns=tuple(
            Column(f"s{number}-column-{k + 1:02d}", f"Column {number}.{k + 1:02d}", column, elevation, height)
            for k, column in enumerate(columns)
        ),
        rooms=_rooms(number, free, rooms, walls, bodies, elevation, height),
        slabs=(
            Slab(f"s{number}-floor", "Floor", "floor", _pierced(plate, stairwells[0]), elevation, slab_thickness),
            Slab(f"s{number}-ceiling", "Ceiling", "ceiling", _pierced(plate, stairwells[1]), elevation + height, slab_thickness),
        ),
    )


def _offset_ring(ring: Sequence[Point2], distance: float) -> list[Point2]:
    """Mitred parallel ring, `distance` to the left of a counter-clockwise ring."""
    corners = np.asarray(ring, dtype=np.float64)
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    before, after = np.roll(normal, 1, axis=0), normal
    mitre = (before + after) / (1 + np.sum(before * after, axis=1))[:, None]
    return [(float(x), float(y)) for x, y in np.round(corners + distance * mitre, 9)]


def _strips(
    partition: Partition | CurvedPartition, later: Sequence[Partition | CurvedPartition]
) -> list[tuple[Partition, shapely.Polygon]]:
    """Straight pieces of a partition and their outlines, with mitres between them."""
    import shapely

    if isinstance(partition, Partition):
        return [(partition, _strip(partition, [other for other in later if isinstance(other, Partition)]))]
    left, right = (_offset_path(partition.path, sign * partition.thickness / 2) for sign in (1, -1))
    return [(piece, shapely.Polygon([left[k], right[k], right[k + 1], left[k + 1]])) for k, piece in enumerate(partition.pieces)]


def _offset_path(path: Sequence[Point2], distance: float) -> list[Point2]:
    """Mitred parallel chain, `distance` to the left; closed where the path is, else with ends square to it."""
    if path[0] == path[-1]:
        ring = _offset_ring(path[:-1], distance)
        return [*ring, ring[0]]
    points = np.asarray(path)
    beyond = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    return _offset_ring([(float(x), float(y)) for x, y in beyond], distance)[1:-1]


def _strip(partition: Partition, later: Sequence[Partition]) -> shapely.Polygon:
    """Rectangle about the axis, long enough to fill the corner with partitions listed later that end where it ends."""
    import shapely

    start, end = np.asarray(partition.start), np.asarray(partition.end)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]]) * partition.thickness / 2
    reach = [
        max(
            (other.thickness / 2 for other in later if min(_distance(point, other.start), _distance(point, other.end)) < _TOUCH),
            default=0.0,
        )
        for point in (partition.start, partition.end)
    ]
    start, end = start - along * reach[0], end + along * reach[1]
    return shapely.Polygon([start - across, end - across, end + across, start + across])


def _numbered(opening: Opening, number: int, counters: dict[str, int]) -> Opening:
    counters[opening.kind] += 1
    k = counters[opening.kind]
    return replace(opening, id=f"s{number}-{opening.kind}-{k:02d}", name=f"{opening.kind.capitalize()} {number}.{k:02d}")


def _joints(walls: Sequence[Wall]) -> tuple[Joint, ...]:
    import shapely

    points = sorted({(round(x, 6), round(y, 6)) for wall in walls for x, y in wall.axis})
    joints = []
    for point in points:
        members: list[tuple[str, Literal["start", "end", "path"]]] = []
        for wall in walls:
            if _distance(point, wall.axis[0]) < _TOUCH:
                members.append((wall.id, "start"))
            elif _distance(point, wall.axis[1]) < _TOUCH:
                members.append((wall.id, "end"))
            elif shapely.LineString(wall.axis).distance(shapely.Point(point)) < _TOUCH:
                members.append((wall.id, "path"))
        if len(members) > 1:
            joints.append(Joint(point, tuple(wall for wall, _ in members), tuple(end for _, end in members)))
    return tuple(joints)


def _rooms(
    number: int,
    free: shapely.Geometry,
    names: Sequence[tuple[str, Point2]],
    walls: Sequence[Wall],
    bodies: Sequence[shapely.Polygon],
    elevation: float,
    height: float,
) -> tuple[Room, ...]:
    import shapely

    parts = [part.simplify(0) for part in shapely.get_parts(free)]
    rooms = []
    for k, (name, point) in enumerate(names):
        inside = [part for part in parts if part.contains(shapely.Point(point))]
        if len(inside) != 1 or len(parts) != len(names):
            raise ValueError(f"room {name!r} is not alone: {len(parts)} rooms, {len(names)} names")
        bounding = [
            wall.id for wall, body in zip(walls, bodies, strict=True) if inside[0].exterior.intersection(body.buffer(_TOUCH)).length > 0.01
        ]
        rooms.append(Room(f"s{number}-room-{k + 1:02d}", name, Outline.from_polygon(inside[0]), elevation, height, tuple(bounding)))
    return tuple(rooms)


def _pierced(plate: Outline, hole: Ring | None) -> Outline:
    import shapely

    return plate if hole is None else Outline.from_polygon(plate.polygon.difference(shapely.Polygon(hole)))


def _distance(a: Point2, b: Point2) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))
