"""Rays of the scanner at walls: where they met the nearer face and how far beyond it they ended."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from indoor_bim.threads import even_slices, in_threads, threads_for

Floats = NDArray[np.float64]
Float32s = NDArray[np.float32]
Ints = NDArray[np.int64]
Int16s = NDArray[np.int16]
Int32s = NDArray[np.int32]

FRONT = 0.15  # metres before a face: points farther away are not on it
USUAL_PAIRS = 3  # walls that a ray comes to
METRES = ("depth", "along", "up", "along_far", "up_far", "along_end", "up_end", "slant", "length")
MARGIN = 0.30  # metres beyond the ends of a wall that belong to its picture


@dataclass(frozen=True, slots=True)
class WallBox:
    """Where a wall stands: what rays are measured against.

    Parameters
    ----------
    start, end : (float, float)
        Ends of the centre line in plan, metres.
    thickness : float
        Metres.
    base, height : float
        Level of the foot, and height, metres.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    thickness: float
    base: float
    height: float

    @property
    def length(self) -> float:
        """Length of the centre line, metres."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))

    @property
    def direction(self) -> tuple[float, float]:
        """Unit vector of the centre line."""
        length = max(self.length, 1e-9)
        return (self.end[0] - self.start[0]) / length, (self.end[1] - self.start[1]) / length


@dataclass(frozen=True, slots=True, eq=False)
class WallRays:
    """Rays that came to a wall's face or through it, one row each; metres along the axis and up from the foot of its first end.

    Parameters
    ----------
    side : (n,) int8
        Side of the axis direction that the ray came from: 1 left, -1 right.
    depth : (n,) float32
        How far beyond the nearer face the ray ended; negative: before it.
    along, up : (n,) float32
        Where the ray met the nearer face.
    along_far, up_far : (n,) float32
        Where the line of the ray meets the farther face.
    along_end, up_end : (n,) float32
        Where the ray ended.
    slant : (n,) float32
        Cosine of the angle between the ray and the normal of the wall.
    length : (n,) float32
        Metres.
    period : (n,) int64
        Stretch of the path that it was measured on.
    intensity : (n,) array, optional
        Strength of its return, in the unit of the scanner.
    brightness : (n,) float32, optional
        Logarithm of the intensity relative to that of the faces from the same distance and angle; NaN where not known.
    """

    side: NDArray[np.int8]
    depth: Float32s
    along: Float32s
    up: Float32s
    along_far: Float32s
    up_far: Float32s
    along_end: Float32s
    up_end: Float32s
    slant: Float32s
    length: Float32s
    period: Ints
    intensity: NDArray | None = None
    brightness: Float32s | None = None

    def __len__(self) -> int:
        return len(self.side)

    def take(self, rows: Ints) -> Self:
        """Rays of the given rows."""
        return replace(self, **{name: values.take(rows) for name in self.__slots__ if (values := getattr(self, name)) is not None})


def rays_at_walls(
    walls: Sequence[WallBox], points: Floats, sensors: Floats, period: Ints, intensity: NDArray | None = None
) -> list[WallRays]:
    """Rays that came to each wall.

    Parameters
    ----------
    walls : sequence of WallBox
        Walls.
    points : (n, 3) float64
        Ends of the rays, metres.
    sensors : (n, 3) float64
        Their beginnings, metres.
    period : (n,) int64
        Stretch of the path that each was measured on.
    intensity : (n,) array, optional
        Strength of each return, in the unit of the scanner; 0 where it is not known.

    Returns
    -------
    list of WallRays
        One for each wall.
    """
    from indoor_bim.plan.wall_loops import ray_fields, rays_of_walls

    boxes = wall_table(walls)
    points, sensors = np.ascontiguousarray(points, dtype=np.float64), np.ascontiguousarray(sensors, dtype=np.float64)

    def rays_at(wall: int) -> WallRays:
        fields = np.zeros((10, len(rows[wall])), dtype=np.float32)
        ray_fields(points, sensors, rows[wall], boxes[wall], fields)
        metres = dict(zip(METRES, fields[1:], strict=True))
        strength = None if intensity is None else intensity.take(rows[wall])
        return WallRays(side=fields[0].astype(np.int8), period=period.take(rows[wall]), intensity=strength, **metres)

    rows = rows_of_walls(
        lambda part, *out: rays_of_walls(points[part], sensors[part], boxes, FRONT, MARGIN, *out), walls=len(boxes), points=len(points)
    )
    return in_threads(rays_at, range(len(boxes)), threads=threads_for(len(points)))


def wall_table(walls: Sequence[WallBox]) -> Floats:
    """Walls for compiled loops, one row each: x, y, dx, dy, half, length, base, height; metres.

    Parameters
    ----------
    walls : sequence of WallBox
        Walls.
    """
    rows = [(*w.start, *w.direction, w.thickness / 2, w.length, w.base, w.height) for w in walls]
    return np.array(rows, dtype=np.float64).reshape(-1, 8)


def rows_of_walls(loop: Callable[[slice, Int32s, Int16s], int], *, walls: int, points: int) -> list[Int32s]:
    """Rows that a compiled loop finds for each wall, in ascending order.

    Parameters
    ----------
    loop : callable
        Writes pairs of row and wall among a slice of the rows, as far as there is room, and tells their number.
    walls, points : int
        Number of walls and of rows.
    """
    from indoor_bim.plan.wall_loops import sort_by_wall

    def grouped(part: slice) -> list[Int32s]:
        room = USUAL_PAIRS * (part.stop - part.start)
        while True:
            rows, names = np.zeros(room, dtype=np.int32), np.zeros(room, dtype=np.int16)
            count = loop(part, rows, names)
            if count <= room:
                break
            room = count
        first, ordered = np.zeros(walls + 1, dtype=np.int64), np.zeros(count, dtype=np.int32)
        sort_by_wall(rows[:count], names[:count], part.start, first, ordered)
        return np.split(ordered, first[1:-1])

    threads = threads_for(points)
    parts = in_threads(grouped, even_slices(points, threads), threads=threads)
    return [np.concatenate([part[wall] for part in parts]) for wall in range(walls)]
