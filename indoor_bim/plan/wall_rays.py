"""Rays of the scanner at walls: where they met the nearer face and how far beyond it they ended."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Float32s = NDArray[np.float32]
Ints = NDArray[np.int64]

FRONT = 0.15  # metres before a face: points farther away are not on it
MARGIN = 0.30  # metres beyond the ends of a wall that belong to its picture
SENSOR_CELL = 0.5  # metres: rays from one such square of the plan are looked up together
CHUNK = 4_000_000  # rays sorted at a time
TURN = 2 * np.pi


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
    period : (n,) int64
        Stretch of the path that it was measured on.
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
    period: Ints

    def __len__(self) -> int:
        return len(self.side)

    def take(self, rows: NDArray) -> Self:
        """Rays of the given rows (indices or mask)."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})


def rays_at_walls(walls: Sequence[WallBox], points: Floats, sensors: Floats, period: Ints) -> list[WallRays]:
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

    Returns
    -------
    list of WallRays
        One for each wall.
    """
    parts: list[list[WallRays]] = [[] for _ in walls]
    for begin in range(0, max(len(points), 1), CHUNK):
        rows = slice(begin, begin + CHUNK)
        for part, rays in zip(parts, _rays_of_chunk(walls, points[rows], sensors[rows], period[rows]), strict=True):
            part.append(rays)
    return [_joined(part) for part in parts]


def _rays_of_chunk(walls: Sequence[WallBox], points: Floats, sensors: Floats, period: Ints) -> Iterator[WallRays]:
    """Rays of one chunk, sorted by sensor square and azimuth, so that each wall only looks at those that point towards it."""
    square = np.floor(sensors[:, :2] / SENSOR_CELL).astype(np.int64)
    square -= square.min(axis=0) if len(square) else 0
    name = square[:, 0] * (int(square[:, 1].max()) + 1 if len(square) else 1) + square[:, 1]
    names, group = np.unique(name, return_inverse=True)
    heading = np.arctan2(*(points[:, :2] - sensors[:, :2]).T[::-1].astype(np.float32)).astype(np.float64) % TURN
    key = group * (2 * TURN) + heading
    order = np.argsort(key, kind="stable")
    key = key[order]
    p, s, t = points[order].astype(np.float32), sensors[order].astype(np.float32), period[order]
    bounds = np.searchsorted(key, np.arange(len(names) + 1) * (2 * TURN))
    corners = np.array([[_extent(s[a:b, k]) for k in (0, 1)] for a, b in itertools.pairwise(bounds)])
    for wall in walls:
        spans = _spans_towards(wall, corners.reshape(-1, 2, 2), key, bounds)
        yield _rays_of_wall(wall, p, s, t, spans)


def _extent(values: Float32s) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def _spans_towards(wall: WallBox, corners: Floats, key: Floats, bounds: Ints) -> list[tuple[int, int]]:
    """Ranges of the sorted rays whose azimuth can hit the wall from anywhere in their sensor square."""
    d = np.array(wall.direction)
    n = np.array([-d[1], d[0]])
    half = wall.thickness / 2 + FRONT
    u, v = np.array([-MARGIN, wall.length + MARGIN]), np.array([-half, half])
    plan = np.array(wall.start) + u[:, None, None] * d + v[None, :, None] * n
    offset = 0.01  # metres and radians: rounding
    xs = corners[:, 0][:, [0, 0, 1, 1]] + offset * np.array([-1, -1, 1, 1])
    ys = corners[:, 1][:, [0, 1, 0, 1]] + offset * np.array([-1, 1, -1, 1])
    to_x = (plan[..., 0].reshape(1, 1, 4) - xs[:, :, None]).reshape(len(corners), -1)
    to_y = (plan[..., 1].reshape(1, 1, 4) - ys[:, :, None]).reshape(len(corners), -1)
    middle = np.arctan2(to_y.mean(axis=1), to_x.mean(axis=1))
    turn = (np.arctan2(to_y, to_x) - middle[:, None] + np.pi) % TURN - np.pi
    low, high = turn.min(axis=1) - offset, turn.max(axis=1) + offset
    around = high - low > 0.9 * np.pi  # the square touches the wall: rays of any azimuth
    spans: list[tuple[int, int]] = []
    begin = (middle + low) % TURN
    end = begin + (high - low)
    base = np.arange(len(corners)) * (2 * TURN)
    first, last = np.searchsorted(key, base + begin), np.searchsorted(key, base + np.minimum(end, TURN))
    wrapped = np.searchsorted(key, base + np.maximum(end - TURN, 0))
    for g in range(len(corners)):
        if around[g]:
            spans.append((int(bounds[g]), int(bounds[g + 1])))
            continue
        if last[g] > first[g]:
            spans.append((int(first[g]), int(last[g])))
        if end[g] > TURN and wrapped[g] > bounds[g]:
            spans.append((int(bounds[g]), int(wrapped[g])))
    return spans


def _rays_of_wall(wall: WallBox, p: Float32s, s: Float32s, t: Ints, spans: Sequence[tuple[int, int]]) -> WallRays:
    """Exact test of the rays in the ranges."""
    dx, dy = wall.direction
    half = wall.thickness / 2
    x0, y0 = wall.start
    offset = np.float32(-x0 * -dy - y0 * dx)
    nx, ny = np.float32(-dy), np.float32(dx)
    found: list[Ints] = []
    for a, b in spans:
        vs = s[a:b, 0] * nx + s[a:b, 1] * ny + offset
        vp = p[a:b, 0] * nx + p[a:b, 1] * ny + offset
        hit = ((vs > half) & (vp < half + FRONT) & (vp < vs)) | ((vs < -half) & (vp > -half - FRONT) & (vp > vs))
        found.append(np.flatnonzero(hit) + a)
    rows = np.concatenate(found) if found else np.zeros(0, dtype=np.int64)
    start, end = s[rows], p[rows]
    vs = start[:, 0] * nx + start[:, 1] * ny + offset
    side = np.where(vs > 0, 1, -1).astype(np.int8)
    vs, vp = vs * side, (end[:, 0] * nx + end[:, 1] * ny + offset) * side
    us = (start[:, 0] - x0) * dx + (start[:, 1] - y0) * dy
    ue = (end[:, 0] - x0) * dx + (end[:, 1] - y0) * dy
    share = (vs - half) / (vs - vp)
    along, up = us + share * (ue - us), start[:, 2] + share * (end[:, 2] - start[:, 2]) - wall.base
    keep = (along > -MARGIN) & (along < wall.length + MARGIN) & (up > -MARGIN) & (up < wall.height + MARGIN)
    far = (vs + half) / (vs - vp)
    reach = np.sqrt(((end - start) ** 2).sum(axis=1))
    rays = WallRays(
        side=side,
        depth=_float32(half - vp),
        along=_float32(along),
        up=_float32(up),
        along_far=_float32(us + far * (ue - us)),
        up_far=_float32(start[:, 2] + far * (end[:, 2] - start[:, 2]) - wall.base),
        along_end=_float32(ue),
        up_end=_float32(end[:, 2] - wall.base),
        slant=_float32((vs - vp) / np.maximum(reach, 1e-9)),
        period=t[rows],
    )
    return rays.take(keep)


def _float32(values: NDArray) -> Float32s:
    return values.astype(np.float32)


def _joined(parts: Sequence[WallRays]) -> WallRays:
    return WallRays(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in WallRays.__slots__})
