"""Small buildings made by hand: wall axes and joints are given, footprints, rooms and slabs follow exactly."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import atan2, cos, radians, sin
from typing import Literal, NamedTuple

import numpy as np
import shapely

from indoor_bim.model import Building, Column, Evidence, Joint, Opening, Outline, Point2, Ring, Room, Slab, Storey, Wall

HEIGHT = 2.5
SLAB_THICKNESS = 0.3
WALL_EVIDENCE = Evidence(support=1200, coverage=0.8, rmse=0.004, sides=2)


class Axis(NamedTuple):
    """Centre line and thickness of a wall."""

    start: Point2
    end: Point2
    thickness: float = 0.2


def door(id: str, start: float, width: float = 0.9, *, height: float = 2.1) -> Opening:
    return Opening(id, "Door", "door", start, width, 0.0, height, "start", "left", 1, 0.9, Evidence(40, 0.3, 0.006, 1))


def window(id: str, start: float, width: float = 1.2) -> Opening:
    return Opening(id, "Window", "window", start, width, 0.9, 1.2, leaves=0, confidence=0.8)


def passage(id: str, start: float, width: float = 1.5) -> Opening:
    return Opening(id, "Passage", "opening", start, width, 0.0, 2.2, leaves=0, confidence=0.7)


def storey(
    axes: dict[str, Axis],
    joints: tuple[Joint, ...],
    *,
    openings: dict[str, tuple[Opening, ...]] | None = None,
    columns: tuple[Column, ...] = (),
    level: float = 0.0,
    prefix: str = "",
    external: tuple[str, ...] = (),
) -> Storey:
    """Storey of walls with the given axes; an end that no joint names is cut square."""
    openings = openings or {}
    footprints = {id: _footprint(id, axis, axes, joints) for id, axis in axes.items()}
    walls = tuple(
        Wall(
            prefix + id,
            f"Wall {prefix}{id}",
            (axis.start, axis.end),
            axis.thickness,
            True,
            level,
            HEIGHT,
            footprints[id],
            id in external if external else None,
            tuple(replace(o, id=prefix + o.id) for o in openings.get(id, ())),
            WALL_EVIDENCE,
        )
        for id, axis in axes.items()
    )
    # footprints that touch only share float-rounded corners: close hairline gaps before looking for rooms
    built = shapely.union_all([shapely.Polygon(ring) for ring in footprints.values()], grid_size=1e-9)
    outside = shapely.union_all([shapely.Polygon(part.exterior) for part in getattr(built, "geoms", [built])])
    inside = outside.difference(built)
    polygons = sorted((p for p in getattr(inside, "geoms", [inside]) if p.area > 1e-6), key=lambda p: p.bounds)
    rooms = tuple(
        Room(f"{prefix}R{i}", f"Room {prefix}{i}", Outline.from_polygon(p), level, HEIGHT, _around(p, footprints, prefix))
        for i, p in enumerate(polygons, 1)
    )
    slabs = tuple(
        Slab(f"{prefix}S{i}{kind[0].upper()}", f"{kind.title()} {prefix}{i}", kind, Outline.from_polygon(p), z, SLAB_THICKNESS)
        for i, p in enumerate(getattr(outside, "geoms", [outside]), 1)
        for kind, z in _plates(level)
        if rooms
    )
    columns = tuple(replace(c, id=prefix + c.id, base=level) for c in columns)
    joints = tuple(replace(j, walls=tuple(prefix + id for id in j.walls)) for j in joints)
    return Storey(f"{prefix}ST", f"Storey {prefix or '0'}", level, HEIGHT, walls, joints, columns, rooms, slabs)


def one_room(*, width: float = 5.0, depth: float = 4.0) -> Building:
    """One rectangular room of `width` x `depth` inside, walls of 0.2 m, a door and a window."""
    axes, joints = _rectangle(-0.1, -0.1, width + 0.1, depth + 0.1)
    return _building(storey(axes, joints, openings={"W1": (door("D1", 1.1),), "W3": (window("F1", 2.0),)}, external=tuple(axes)))


def two_rooms() -> Building:
    """Two rooms side by side, inside 4 x 4 and 3 x 4 m: L joints outside, T joints of a 0.1 m wall; an opening of each kind."""
    axes, joints = _rectangle(-0.15, -0.15, 7.25, 4.15, thickness=0.3)
    axes["W5"] = Axis((4.05, -0.15), (4.05, 4.15), 0.1)
    joints += (Joint((4.05, -0.15), ("W1", "W5"), ("path", "start")), Joint((4.05, 4.15), ("W3", "W5"), ("path", "end")))
    openings = {"W1": (door("D1", 1.0), window("F1", 5.0)), "W5": (passage("O1", 1.2),), "W3": (window("F2", 1.0, 2.0),)}
    return _building(storey(axes, joints, openings=openings, external=("W1", "W2", "W3", "W4")))


def four_rooms() -> Building:
    """Four rooms around an X joint: W5 goes through, W6 and W7 end at it."""
    axes, joints = _rectangle(0.0, 0.0, 8.0, 6.0, thickness=0.25)
    axes |= {"W5": Axis((0.0, 3.0), (8.0, 3.0), 0.15), "W6": Axis((4.0, 0.0), (4.0, 3.0), 0.1), "W7": Axis((4.0, 3.0), (4.0, 6.0), 0.1)}
    joints += (
        Joint((0.0, 3.0), ("W4", "W5"), ("path", "start")),
        Joint((8.0, 3.0), ("W2", "W5"), ("path", "end")),
        Joint((4.0, 0.0), ("W1", "W6"), ("path", "start")),
        Joint((4.0, 6.0), ("W3", "W7"), ("path", "end")),
        Joint((4.0, 3.0), ("W5", "W6", "W7"), ("path", "end", "start")),
    )
    openings = {"W5": (door("D1", 1.0), door("D2", 5.5)), "W6": (door("D3", 1.0, 0.8),), "W1": (window("F1", 1.2), door("D4", 5.0, 1.0))}
    column = Column("C1", "Column C1", ((1.0, 4.5), (1.3, 4.5), (1.3, 4.8), (1.0, 4.8)), 0.0, HEIGHT, WALL_EVIDENCE)
    return _building(storey(axes, joints, openings=openings, columns=(column,), external=("W1", "W2", "W3", "W4")))


def star() -> Building:
    """Three walls of unlike thickness that meet in a Y joint inside a hexagon of L joints: three rooms, walls at odd angles."""
    corners = [(5 * cos(radians(a)), 5 * sin(radians(a))) for a in range(0, 360, 60)]
    axes = {f"W{i + 1}": Axis(corners[i], corners[(i + 1) % 6], 0.2) for i in range(6)}
    middles = {i: _middle(axes[f"W{i}"]) for i in (1, 3, 5)}
    spokes = {1: "W7", 3: "W8", 5: "W9"}
    axes |= {spokes[i]: Axis((0.0, 0.0), middles[i], t) for i, t in ((1, 0.1), (3, 0.15), (5, 0.24))}
    joints = tuple(Joint(corners[i], (f"W{(i - 1) % 6 + 1}", f"W{i + 1}"), ("end", "start")) for i in range(6))
    joints += tuple(Joint(middles[i], (f"W{i}", spokes[i]), ("path", "end")) for i in spokes)
    joints += (Joint((0.0, 0.0), ("W7", "W8", "W9"), ("start", "start", "start")),)
    return _building(storey(axes, joints, openings={"W8": (door("D1", 1.5),), "W2": (window("F1", 1.0),)}))


def diagonal() -> Building:
    """One room with a corner cut off by a diagonal wall, all turned by 17 degrees."""
    ring = [(0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (4.0, 5.0), (0.0, 5.0)]
    c, s = cos(radians(17)), sin(radians(17))
    ring = [(c * x - s * y, s * x + c * y) for x, y in ring]
    axes, joints = _loop(ring, 0.2)
    return _building(storey(axes, joints, openings={"W3": (window("F1", 0.8),), "W1": (door("D1", 2.0),)}))


def courtyard() -> Building:
    """A room around a closed core: its outline has a hole; a second room lies in the core."""
    axes, joints = _rectangle(0.0, 0.0, 10.0, 8.0)
    inner, more = _loop([(4.0, 3.0), (6.0, 3.0), (6.0, 5.0), (4.0, 5.0)], 0.15, first=5)
    return _building(storey(axes | inner, joints + more, openings={"W5": (door("D1", 0.5),), "W1": (door("D2", 2.0),)}))


def two_storeys() -> Building:
    """Two storeys with a slab of 0.3 m between them, the same walls on each, other openings above."""
    axes, joints = _rectangle(0.0, 0.0, 6.0, 5.0, thickness=0.3)
    axes["W5"] = Axis((3.0, 0.0), (3.0, 5.0), 0.1)
    joints += (Joint((3.0, 0.0), ("W1", "W5"), ("path", "start")), Joint((3.0, 5.0), ("W3", "W5"), ("path", "end")))
    ground = storey(axes, joints, openings={"W1": (door("D1", 1.0),), "W5": (door("D2", 2.0),)}, prefix="0.")
    upper = storey(
        axes, joints, openings={"W1": (window("F1", 1.0),), "W5": (door("D2", 1.0),)}, prefix="1.", level=HEIGHT + SLAB_THICKNESS
    )
    return _building(ground, upper)


def empty() -> Building:
    """Nothing was found, and the building says why."""
    return Building("Empty", source="empty.las", method="test", warnings=("No walls were found: the scan shows a ceiling only.",))


def moved(building: Building, *, yaw: float, shift: tuple[float, float, float]) -> Building:
    """The same model from a scan turned back by `yaw` degrees and moved: only `transform_cloud_to_model` changes."""
    c, s = cos(radians(yaw)), sin(radians(yaw))
    turn = np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    turn[:3, 3] = shift
    return replace(building, transform_cloud_to_model=tuple(tuple(float(x) for x in row) for row in np.linalg.inv(turn)))


def _plates(level: float) -> tuple[tuple[Literal["floor", "ceiling"], float], ...]:
    return (("floor", level), ("ceiling", level + HEIGHT))


def _building(*storeys: Storey) -> Building:
    return Building("House", storeys, source="house.laz", method="test")


def _rectangle(x0: float, y0: float, x1: float, y1: float, *, thickness: float = 0.2) -> tuple[dict[str, Axis], tuple[Joint, ...]]:
    return _loop([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], thickness)


def _loop(ring: list[Point2], thickness: float, *, first: int = 1) -> tuple[dict[str, Axis], tuple[Joint, ...]]:
    ids = [f"W{first + i}" for i in range(len(ring))]
    axes = {id: Axis(a, b, thickness) for id, (a, b) in zip(ids, pairwise([*ring, ring[0]]), strict=True)}
    joints = tuple(Joint(corner, (ids[i - 1], ids[i]), ("end", "start")) for i, corner in enumerate(ring))
    return axes, joints


def _footprint(id: str, axis: Axis, axes: dict[str, Axis], joints: tuple[Joint, ...]) -> Ring:
    head, tail = _end_corners(id, "start", axes, joints), _end_corners(id, "end", axes, joints)
    ring = [*head, *tail]
    return Outline.from_polygon(shapely.Polygon(ring)).exterior


def _end_corners(id: str, end: str, axes: dict[str, Axis], joints: tuple[Joint, ...]) -> list[Point2]:
    """Corners of one end of the footprint, counter-clockwise: right to left when looking back along the wall."""
    origin, out = _ray(axes[id], end)
    half = axes[id].thickness / 2
    left = np.array([-out[1], out[0]])
    joint = next((j for j in joints if (id, end) in zip(j.walls, j.ends, strict=True)), None)
    if joint is None:
        return [tuple(origin + half * left), tuple(origin - half * left)]
    if "path" in joint.ends:
        through = axes[joint.walls[joint.ends.index("path")]]
        start, along = _ray(through, "start")
        normal = np.array([-along[1], along[0]])
        normal *= np.sign(normal @ out)
        face = start + normal * through.thickness / 2
        return [_cross(origin + side * left * half, out, face, along) for side in (1, -1)]
    rays = []
    for other, at in zip(joint.walls, joint.ends, strict=True):
        _, direction = _ray(axes[other], at)
        rays.append((atan2(direction[1], direction[0]), other, direction))
    rays.sort(key=lambda ray: ray[0])
    here = [ray[1] for ray in rays].index(id)
    corners = []
    for side, step in ((1, 1), (-1, -1)):
        _, other, direction = rays[(here + step) % len(rays)]
        other_left = np.array([-direction[1], direction[0]])
        corners.append(_cross(origin + side * left * half, out, origin - side * other_left * axes[other].thickness / 2, direction))
    return corners if len(rays) == 2 else [corners[0], tuple(origin), corners[1]]


def _ray(axis: Axis, end: str) -> tuple[np.ndarray, np.ndarray]:
    a, b = np.array(axis.start), np.array(axis.end)
    if end == "end":
        a, b = b, a
    return a, (b - a) / np.linalg.norm(b - a)


def _cross(p: np.ndarray, u: np.ndarray, q: np.ndarray, v: np.ndarray) -> Point2:
    s = np.linalg.solve(np.column_stack([u, -v]), q - p)[0]
    x, y = p + s * u
    return (float(x), float(y))


def _middle(axis: Axis) -> Point2:
    return ((axis.start[0] + axis.end[0]) / 2, (axis.start[1] + axis.end[1]) / 2)


def _around(room: shapely.Polygon, footprints: dict[str, Ring], prefix: str) -> tuple[str, ...]:
    near = room.buffer(1e-6)
    return tuple(prefix + id for id, ring in footprints.items() if shapely.Polygon(ring).intersection(near).length > 0.01)
