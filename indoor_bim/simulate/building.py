"""Known buildings, made in code: the truth that a virtual scan is compared with.

A storey is laid out on centre lines: a closed ring of outer walls and partitions that end on the centre lines of
other walls. Footprints, rooms and joints follow from these exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from indoor_bim.model import Building, Joint, Opening, Outline, Point2, Ring, Room, Slab, Storey, Wall

if TYPE_CHECKING:
    import shapely

_TOUCH = 1e-6


@dataclass(frozen=True, slots=True)
class Partition:
    """Inner wall on its centre line; both ends lie on centre lines of other walls, metres."""

    start: Point2
    end: Point2
    thickness: float
    openings: tuple[Opening, ...] = ()


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
    partitions: Sequence[Partition],
    rooms: Sequence[tuple[str, Point2]],
    *,
    elevation: float = 0.0,
    height: float = 2.6,
    slab_thickness: float = 0.3,
    stairwells: tuple[Ring | None, Ring | None] = (None, None),
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
    partitions : sequence of Partition
        Inner walls; those that run through at a T joint before those that end there.
    rooms : sequence of (name, (x, y))
        Name of every room and a point in it.
    elevation, height, slab_thickness : float
        Level of the floor, clear height and thickness of floor and ceiling plates, metres.
    stairwells : tuple of two rings
        Holes in the floor and in the ceiling, if any.

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
        body = _strip(partition, partitions[k + 1 :]).intersection(free)
        if body.geom_type != "Polygon":
            raise ValueError(f"partition {k} falls apart: let it end at the wall that it crosses")
        specs.append(partition)
        bodies.append(body)
        free = free.difference(body)
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
        rooms=_rooms(number, free, rooms, walls, bodies, elevation, height),
        slabs=(
            Slab(f"s{number}-floor", "Floor", "floor", _pierced(plate, stairwells[0]), elevation, slab_thickness),
            Slab(f"s{number}-ceiling", "Ceiling", "ceiling", _pierced(plate, stairwells[1]), elevation + height, slab_thickness),
        ),
    )


def demo_house() -> Building:
    """One-storey house, 11.9 x 9.0 m outside: seven rooms, a corner cut at 45 degrees, open and closed doors, windows."""
    ring = [(0.0, 0.0), (11.6, 0.0), (11.6, 6.7), (9.6, 8.7), (0.0, 8.7)]
    ring_openings = [
        [window(2.3, width=1.6), window(6.2, width=1.2), window(9.8)],
        [window(5.2, width=1.6, sill=0.1, height=2.1)],
        [window(1.41, width=1.2)],
        [window(3.9, width=1.6), window(7.6, width=0.8, sill=1.3, height=0.9)],
        [door(4.35, width=1.0)],
    ]
    partitions = [
        Partition(
            (0.0, 3.6),
            (11.6, 3.6),
            0.20,
            (door(2.2, hinge="start", swing="right"), door(6.4, hinge="end", swing="right"), door(9.0, hinge="start")),
        ),
        Partition((7.6, 3.6), (7.6, 8.7), 0.20, (passage(0.76),)),
        Partition((0.0, 5.1), (7.6, 5.1), 0.12, (door(1.5, width=0.8, hinge="end"), door(6.3, hinge="start"))),
        Partition((3.9, 5.1), (3.9, 8.7), 0.12, (door(1.2, width=0.8),)),
        Partition((4.6, 0.0), (4.6, 3.6), 0.12),
        Partition((7.9, 0.0), (7.9, 3.6), 0.12),
    ]
    rooms = [
        ("Corridor", (3.0, 4.3)),
        ("Bathroom", (2.0, 7.0)),
        ("Bedroom", (6.0, 7.0)),
        ("Living room", (9.5, 5.5)),
        ("Kitchen", (2.0, 1.8)),
        ("Study", (6.0, 1.8)),
        ("Guest room", (9.5, 1.8)),
    ]
    return Building("Demo house", (lay_out_storey(1, ring, 0.30, ring_openings, partitions, rooms),))


def single_room(*, width: float = 7.0, depth: float = 5.0, height: float = 3.0, cut_corner: float = 0.0) -> Building:
    """One room with a door and a window.

    Parameters
    ----------
    width, depth, height : float
        Clear size, metres.
    cut_corner : float
        Length that a 45 degree cut takes off both sides of a corner on the centre lines, metres; 0 for none.
    """
    w, d, t = width + 0.3, depth + 0.3, 0.3
    corner = [(w, d - cut_corner), (w - cut_corner, d)] if cut_corner > 0 else [(w, d)]
    ring = [(0.0, 0.0), (w, 0.0), *corner, (0.0, d)]
    openings: list[list[Opening]] = [[] for _ in ring]
    openings[0] = [door(1.2, hinge="start")]
    openings[-1] = [window(d / 2, width=1.6)]
    return Building("Single room", (lay_out_storey(1, ring, t, openings, [], [("Room", (w / 2, d / 2))], height=height),))


def office_floor(*, offices: int = 5, seed: int = 0) -> Building:
    """Office floor: a corridor with offices of varied width on both sides.

    Parameters
    ----------
    offices : int
        Number of offices on each side, at least 2.
    seed : int
        Draws widths, doors and which doors are closed.
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    widths = [np.round(rng.uniform(2.8, 4.6, offices), 2) for _ in range(2)]
    widths[1] = np.round(widths[1] * widths[0].sum() / widths[1].sum(), 2)
    widths[1][-1] += widths[0].sum() - widths[1].sum()
    length, south, north, depth = round(float(widths[0].sum()), 2), 5.0, 7.2, 11.9
    corridor_walls, cross_walls, rooms = [], [], [("Corridor", (length / 2, (south + north) / 2))]
    ring_openings: list[list[Opening]] = [
        [],
        [window((south + north) / 2, width=1.2)],
        [],
        [door((depth - (south + north) / 2), width=1.2)],
    ]
    for side, (y, y_facade) in enumerate(((south, 0.0), (north, depth))):
        edges = np.round(np.concatenate([[0.0], np.cumsum(widths[side])]), 2)
        doors = []
        for k, (x0, x1) in enumerate(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)):
            closed = k > 0 and rng.random() < 0.15
            hinge: Literal["start", "end"] = "start" if rng.random() < 0.5 else "end"
            doors.append(
                door(
                    round(float(rng.uniform(x0 + 0.9, x1 - 0.9)), 2),
                    hinge=None if closed else hinge,
                    swing="right" if side == 0 else "left",
                )
            )
            centre = (x0 + x1) / 2
            ring_openings[2 * side].append(
                window(round(centre if side == 0 else length - centre, 3), width=round(min(2.0, x1 - x0 - 1.0), 2))
            )
            rooms.append((f"Office {len(rooms)}", (centre, (y + y_facade) / 2)))
            if k > 0:
                cross_walls.append(Partition((x0, y_facade), (x0, y), 0.12))
        corridor_walls.append(Partition((0.0, y), (length, y), 0.20, tuple(doors)))
    ring = [(0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth)]
    return Building("Office floor", (lay_out_storey(1, ring, 0.36, ring_openings, corridor_walls + cross_walls, rooms, height=2.75),))


def two_storeys() -> Building:
    """House of two storeys with a straight stair, 9.3 x 7.3 m outside."""
    ring = [(0.0, 0.0), (9.0, 0.0), (9.0, 7.0), (0.0, 7.0)]
    stairwell: Ring = ((1.2, 0.25), (4.2, 0.25), (4.2, 1.25), (1.2, 1.25))
    ground = lay_out_storey(
        1,
        ring,
        0.30,
        [[window(7.2)], [window(1.8), window(5.3)], [window(2.0), window(6.5)], [door(1.6, width=1.0)]],
        [
            Partition((0.0, 3.8), (9.0, 3.8), 0.20, (passage(1.2), door(7.0, hinge="start"))),
            Partition((5.5, 0.0), (5.5, 3.8), 0.12, (door(2.6, hinge="end"),)),
            Partition((4.2, 3.8), (4.2, 7.0), 0.12, (door(1.4, hinge="start", swing="right"),)),
        ],
        [("Hall", (2.5, 2.5)), ("Kitchen", (7.0, 2.0)), ("Entrance", (2.0, 5.5)), ("Living room", (7.0, 5.5))],
        height=2.5,
        stairwells=(None, stairwell),
    )
    upper = lay_out_storey(
        2,
        ring,
        0.30,
        [[window(7.2)], [window(1.8), window(5.3)], [window(2.0), window(6.5)], [window(2.0)]],
        [
            Partition((0.0, 3.8), (9.0, 3.8), 0.20, (door(2.0, hinge="end"), door(4.9, hinge="start"))),
            Partition((5.7, 0.0), (5.7, 3.8), 0.12, (door(2.4, hinge="start", swing="right"),)),
            Partition((3.6, 3.8), (3.6, 7.0), 0.12),
        ],
        [("Landing", (2.5, 2.5)), ("Bedroom", (7.2, 2.0)), ("Bathroom", (1.8, 5.5)), ("Child's room", (6.5, 5.5))],
        elevation=2.8,
        height=2.4,
        stairwells=(stairwell, None),
    )
    return Building("House of two storeys", (ground, upper))


def _offset_ring(ring: Sequence[Point2], distance: float) -> list[Point2]:
    """Mitred parallel ring, `distance` to the left of a counter-clockwise ring."""
    corners = np.asarray(ring, dtype=np.float64)
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    before, after = np.roll(normal, 1, axis=0), normal
    mitre = (before + after) / (1 + np.sum(before * after, axis=1))[:, None]
    return [(float(x), float(y)) for x, y in np.round(corners + distance * mitre, 12)]


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
