"""Which element of one storey is which of another: walls, rooms, corners and openings; distances between faces."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Opening, Storey, Wall

if TYPE_CHECKING:
    import shapely

Floats = NDArray[np.float64]

ANGLE, OFFSET, OVERLAP = np.radians(5.0), 0.10, 0.5
_SAMPLE, _FACING, _TURN, _ACROSS = 0.02, np.cos(np.radians(30.0)), np.radians(15.0), 0.30


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Samples on wall faces or their corners: points (n, 2) and the directions (n, 2) that they look to."""

    points: Floats
    normals: Floats


@dataclass(frozen=True, slots=True)
class WallOverlap:
    """Interval that a true wall and one of the result share, along the axis of each, metres."""

    on_true: tuple[float, float]
    on_made: tuple[float, float]


def rooms_area(storey: Storey) -> shapely.Geometry:
    """Union of the rooms of a storey."""
    import shapely

    return shapely.union_all([shapely.make_valid(room.outline.polygon) for room in storey.rooms])


def walls_area(storey: Storey) -> shapely.Geometry:
    """Union of the wall footprints of a storey, seams closed."""
    import shapely

    footprints = [shapely.make_valid(shapely.Polygon(wall.footprint)) for wall in storey.walls]
    union = shapely.union_all([footprint.buffer(1e-4, join_style="mitre") for footprint in footprints])
    return union.buffer(-1e-4, join_style="mitre").simplify(1e-4)


def sides_on_rooms(wall: Wall, rooms: shapely.Geometry) -> tuple[bool, bool]:
    """Whether rooms lie along at least a tenth of the left and of the right face of a wall."""
    import shapely

    a, b = np.asarray(wall.axis)
    along = (b - a) / wall.length
    normal = np.array([-along[1], along[0]]) * (wall.thickness / 2 + 0.05)
    samples = a + (b - a) * np.linspace(0.0, 1.0, 101)[:, None]
    left, right = (float(np.mean(shapely.contains_xy(rooms, samples + sign * normal))) for sign in (1, -1))
    return left >= 0.1, right >= 0.1


def wall_overlap(true: Wall, made: Wall, sides: tuple[bool, bool]) -> WallOverlap | None:
    """Where a wall of the result could be a true one; None if it cannot.

    The angle must be below 5 degrees and the offset below 0.10 m: of the axes, or where only one face bounds a room, of
    that face, as the other one cannot be seen.

    Parameters
    ----------
    true, made : Wall
        Wall of the truth and wall of the result.
    sides : (bool, bool)
        Whether rooms lie along the left and the right face of the true wall.
    """
    a, b = np.asarray(true.axis)
    along = (b - a) / true.length
    ends = np.asarray(made.axis) - a
    u, v = ends @ along, ends @ np.array([-along[1], along[0]])
    span = float(abs(u[1] - u[0]))
    start, end = max(0.0, float(u.min())), min(true.length, float(u.max()))
    if end <= start or abs(v[1] - v[0]) >= np.tan(ANGLE) * span:
        return None
    offset = float(np.interp((start + end) / 2, np.sort(u), v[np.argsort(u)]))
    if sides[0] != sides[1]:
        offset += (made.thickness - true.thickness) / 2 * (1 if sides[0] else -1)
    if abs(offset) >= OFFSET:
        return None
    on_made = sorted(float(abs(x - u[0])) / span * made.length for x in (start, end))
    return WallOverlap((start, end), (on_made[0], on_made[1]))


def covered_share(intervals: list[tuple[float, float]], length: float) -> float:
    """Share of a length covered by intervals.

    Examples
    --------
    >>> covered_share([(0.0, 2.0), (1.0, 3.0)], 4.0)
    0.75
    """
    reached = covered = 0.0
    for start, end in sorted(intervals):
        covered += max(0.0, end - max(start, reached))
        reached = max(reached, end)
    return covered / length


def sample_faces(area: shapely.Geometry, *, outward: bool) -> Faces:
    """Samples every 2 cm on the boundary of an area, looking out of it or into it.

    Parameters
    ----------
    area : shapely geometry
        Polygons, metres.
    outward : bool
        True for wall footprints, False for rooms.
    """
    import shapely

    points, normals = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for part in shapely.get_parts(shapely.orient_polygons(area)):
        if part.geom_type != "Polygon":
            continue
        for ring in (part.exterior, *part.interiors):
            coords = np.asarray(ring.coords)
            for a, b in itertools.pairwise(coords):
                length = float(np.hypot(*(b - a)))
                count = max(1, round(length / _SAMPLE))
                along = (b - a) / length
                left = np.array([-along[1], along[0]]) * (-1 if outward else 1)
                points.append(a + (b - a) * ((np.arange(count) + 0.5) / count)[:, None])
                normals.append(np.tile(left, (count, 1)))
    return Faces(np.concatenate(points), np.concatenate(normals))


def facing(faces: Faces, rooms: shapely.Geometry) -> Faces:
    """The samples that look into a room not more than 0.6 m before them."""
    import shapely

    ahead = np.any([shapely.contains_xy(rooms, faces.points + reach * faces.normals) for reach in (0.05, 0.3, 0.6)], axis=0)
    return Faces(faces.points[ahead], faces.normals[ahead])


def face_distances(faces: Faces, area: shapely.Geometry, *, outward: bool) -> Floats:
    """Distance (n,) of each sample to the nearest boundary of an area that looks the same way, within 30 degrees.

    Parameters
    ----------
    faces : Faces
        Samples, metres.
    area : shapely geometry
        Polygons, metres.
    outward : bool
        Whether the boundary looks out of the area.
    """
    import shapely

    rings = [
        ring
        for part in shapely.get_parts(shapely.orient_polygons(area))
        if part.geom_type == "Polygon"
        for ring in (part.exterior, *part.interiors)
    ]
    ends = np.concatenate([np.zeros((0, 2, 2)), *(np.stack([c[:-1], c[1:]], axis=1) for c in (np.asarray(ring.coords) for ring in rings))])
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(*along.T)
    ends, along, length = ends[length > 1e-6], along[length > 1e-6], length[length > 1e-6]
    normal = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None] * (-1 if outward else 1)
    distance = np.full(len(faces.points), np.inf)
    for direction in np.unique(faces.normals.round(6), axis=0):
        rows = np.flatnonzero(np.all(np.abs(faces.normals - direction) < 1e-5, axis=1))
        alike = normal @ direction >= _FACING
        if alike.any():
            lines = shapely.union_all(shapely.linestrings(ends[alike]))
            shapely.prepare(lines)
            distance[rows] = shapely.distance(shapely.points(faces.points[rows]), lines)
    return distance


def corners(area: shapely.Geometry, *, outward: bool) -> Faces:
    """Corners of the boundary of an area that turn by more than 15 degrees, looking out of it or into it halfway between both faces.

    Parameters
    ----------
    area : shapely geometry
        Polygons, metres.
    outward : bool
        True for wall footprints, False for rooms.
    """
    import shapely

    points, normals = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for part in shapely.get_parts(shapely.orient_polygons(area)):
        for ring in (part.exterior, *part.interiors) if part.geom_type == "Polygon" else ():
            coords = np.asarray(ring.coords)[:-1]
            before, after = coords - np.roll(coords, 1, axis=0), np.roll(coords, -1, axis=0) - coords
            cross, dot = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.sum(before * after, axis=1)
            sharp = np.abs(np.arctan2(cross, dot)) > _TURN
            along = before / np.linalg.norm(before, axis=1)[:, None] + after / np.linalg.norm(after, axis=1)[:, None]
            along /= np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
            points.append(coords[sharp])
            normals.append((np.column_stack([-along[:, 1], along[:, 0]]) * (-1 if outward else 1))[sharp])
    return Faces(np.concatenate(points), np.concatenate(normals))


def count_pairs(gain: Floats, *, above: float) -> int:
    """Number of one to one pairs with a gain above a threshold, as many as possible by their sum of gains.

    Parameters
    ----------
    gain : (n, m) float64
        Likeness of each pair.
    above : float
        Smallest gain that counts.
    """
    from scipy.optimize import linear_sum_assignment

    if gain.size == 0:
        return 0
    counted = np.where(gain > above, gain, 0.0)
    rows, columns = linear_sum_assignment(counted, maximize=True)
    return int(np.sum(counted[rows, columns] > 0))


def room_overlaps(result: Storey, truth: Storey) -> Floats:
    """Intersection over union (n, m) of each true room with each room of the result."""
    import shapely

    a = np.array([room.outline.polygon for room in truth.rooms], dtype=object).reshape(-1, 1)
    b = np.array([shapely.make_valid(room.outline.polygon) for room in result.rooms], dtype=object).reshape(1, -1)
    common = shapely.area(shapely.intersection(a, b))
    return np.asarray(common / (shapely.area(a) + shapely.area(b) - common))


def opening_overlaps(result: list[tuple[Wall, Opening]], truth: list[tuple[Wall, Opening]]) -> Floats:
    """Intersection over union (n, m) along the true wall of each true opening with each of the result not more than 0.3 m off."""
    likeness = np.zeros((len(truth), len(result)))
    for i, (wall, opening) in enumerate(truth):
        a, b = np.asarray(wall.axis)
        along = (b - a) / wall.length
        normal = np.array([-along[1], along[0]])
        low, high = opening.start, opening.start + opening.width
        for j, (host, other) in enumerate(result):
            c, d = np.asarray(host.axis)
            jambs = c + (d - c) / host.length * np.array([[other.start], [other.start + other.width]]) - a
            u, v = np.sort(jambs @ along), jambs @ normal
            common = min(high, u[1]) - max(low, u[0])
            if common > 0 and np.abs(v).max() < _ACROSS:
                likeness[i, j] = common / (max(high, u[1]) - min(low, u[0]))
    return likeness
