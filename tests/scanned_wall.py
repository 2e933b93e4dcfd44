"""Rays at one wall with known holes, without noise: what a scanner would measure, computed by hand."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from indoor_bim.model import Storey, Wall

LENGTH, THICKNESS, HEIGHT = 6.0, 0.2, 2.6
ROOM = 3.0  # metres from the centre line to the walls opposite


@dataclass(frozen=True)
class Hole:
    """Hole of the given depths from either face; through the wall by default; `pane` is the share of rays that glass returns."""

    start: float
    end: float
    bottom: float
    top: float
    depth: float = THICKNESS
    depth_right: float | None = None
    pane: float = 0.0


@dataclass(frozen=True)
class Screen:
    """Upright rectangle in front of the wall, seen from the left; rays to it end there."""

    start: float
    end: float
    bottom: float
    top: float
    distance: float


@dataclass(frozen=True, eq=False)
class Scan:
    points: np.ndarray
    gps_time: np.ndarray
    trajectory: np.ndarray
    storey: Storey = field(default_factory=lambda: storey())

    def given(self) -> dict:
        return {"trajectory": self.trajectory, "gps_time": self.gps_time}


def storey(*, base: float = 0.0) -> Storey:
    half = THICKNESS / 2
    footprint = ((0.0, -half), (LENGTH, -half), (LENGTH, half), (0.0, half))
    wall = Wall("S1-W001", "Wall 1", ((0.0, 0.0), (LENGTH, 0.0)), THICKNESS, True, base, HEIGHT, footprint)
    return Storey("S1", "Storey 1", base, HEIGHT, walls=(wall,))


def scan(holes=(), *, screens=(), extra=(), unseen=(), rays=120_000, sides=(1, -1), walk=(), seed=1) -> Scan:
    """Rays from a walk along either side; `extra` points have no ray, rays to `unseen` rectangles do not return."""
    rng = np.random.default_rng(seed)
    path, points, times = [], [], []
    clock = 0.0
    for side in sides:
        n = rays // len(sides)
        t = np.sort(rng.uniform(0, 60, n))
        x = 0.5 + (LENGTH - 1.0) * np.abs((t / 30) % 2 - 1)
        origin = np.column_stack([x, np.full(n, 1.5 * side), np.full(n, 1.6)])
        knots = np.arange(0, 60.01, 0.1)
        path.append(
            np.column_stack(
                [
                    clock + knots,
                    0.5 + (LENGTH - 1.0) * np.abs((knots / 30) % 2 - 1),
                    np.full(len(knots), 1.5 * side),
                    np.full(len(knots), 1.6),
                ]
            )
        )
        origin[:, 0] = np.interp(t, knots, path[-1][:, 1])
        target = np.column_stack([rng.uniform(-0.2, LENGTH + 0.2, n), np.full(n, side * THICKNESS / 2), rng.uniform(0.0, HEIGHT, n)])
        end, kept = _cast(origin, target, side, holes, screens if side == 1 else (), unseen if side == 1 else (), rng)
        points.append(end[kept])
        times.append(clock + t[kept])
        clock += 61.0
    for a, b in walk:
        steps = np.linspace(a, b, 21)
        path.append(np.column_stack([clock + np.arange(21) * 0.1, steps[:, :1], steps[:, 1:2], np.full(21, 1.6)]))
        clock += 3.0
    if len(extra):
        points.append(np.asarray(extra))
        times.append(np.full(len(extra), 0.05))
    return Scan(np.vstack(points), np.concatenate(times), np.vstack(path))


def _cast(origin, target, side, holes, screens, unseen, rng):
    end = target.copy()
    direction = target - origin
    kept = (target[:, 0] >= 0) & (target[:, 0] <= LENGTH)
    for hole in holes:
        inside = _within(target, hole)
        depth = hole.depth if side == 1 or hole.depth_right is None else hole.depth_right
        if depth == 0.0:
            continue
        inside = np.flatnonzero(inside)
        o, d = origin[inside], direction[inside]
        across = -side * d[:, 1]  # metres towards the wall over the whole ray
        to_back = (1.5 - THICKNESS / 2 + depth) / across
        to_opposite = (1.5 + ROOM) / across
        exits = [to_opposite if depth >= THICKNESS else to_back]
        with np.errstate(divide="ignore", invalid="ignore"):
            for axis, low, high in ((0, hole.start, hole.end), (2, hole.bottom, hole.top)):
                hit = np.where(d[:, axis] > 0, (high - o[:, axis]) / d[:, axis], (low - o[:, axis]) / d[:, axis])
                exits.append(np.where(hit <= to_back, hit, np.inf))
            floor_or_ceiling = np.where(d[:, 2] > 0, (HEIGHT - o[:, 2]) / d[:, 2], -o[:, 2] / d[:, 2])
        exits.append(floor_or_ceiling)
        stop = np.min(exits, axis=0)
        glass = (rng.random(len(stop)) < hole.pane) & (stop > (1.5 / across))
        stop = np.where(glass, 1.5 / across, stop)
        end[inside] = o + d * stop[:, None]
    for screen in screens:
        share = (1.5 - THICKNESS / 2 - screen.distance) / (1.5 - THICKNESS / 2)
        at = origin + direction * share
        hidden = _within(at, screen)
        end[hidden] = at[hidden]
    for patch in unseen:
        kept &= ~_within(target, patch)
    return end, kept


def _within(points, box):
    x, z = points[:, 0], points[:, 2]
    return (x > box.start) & (x < box.end) & (z > box.bottom) & (z < box.top)


def leaf(jamb: float, outward: float, width: float, *, swing: int, angle: float = 90.0, top: float = 2.05) -> np.ndarray:
    """Points of an open leaf that hangs on a jamb; `outward` is the direction along the wall in which it would close."""
    s, z = np.meshgrid(np.arange(0.02, width, 0.03), np.arange(0.02, top, 0.03))
    a = np.radians(angle)
    x, y = jamb + outward * s * np.cos(a), swing * (THICKNESS / 2 + s * np.sin(a))
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])
