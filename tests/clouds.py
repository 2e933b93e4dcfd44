"""Point clouds of known rooms, sampled without noise unless asked for."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray


def rooms_cloud(
    *rooms: list[tuple[float, float]],
    height: float = 2.5,
    spacing: float = 0.03,
    noise: float = 0.0,
    floor: bool = True,
    ceiling: bool = True,
) -> NDArray[np.float64]:
    """Floor, ceiling and walls of rooms given as rings, on a grid of points."""
    parts = []
    for room in rooms:
        polygon = shapely.Polygon(room)
        x0, y0, x1, y1 = polygon.bounds
        grid = np.stack(np.meshgrid(np.arange(x0, x1, spacing) + spacing / 2, np.arange(y0, y1, spacing) + spacing / 2), axis=-1).reshape(
            -1, 2
        )
        grid = grid[shapely.contains_xy(polygon, grid[:, 0], grid[:, 1])]
        for z, seen in ((0.0, floor), (height, ceiling)):
            if seen:
                parts.append(np.column_stack([grid, np.full(len(grid), z)]))
        levels = np.arange(spacing / 2, height, spacing)
        for a, b in zip(room, (*room[1:], room[0]), strict=True):
            length = float(np.hypot(b[0] - a[0], b[1] - a[1]))
            along = (np.arange(spacing / 2, length, spacing) / length)[:, None]
            line = np.array(a) + along * (np.array(b) - np.array(a))
            parts.append(np.column_stack([np.repeat(line, len(levels), axis=0), np.tile(levels, len(line))]))
    points = np.concatenate(parts)
    return points + np.random.default_rng(0).normal(0, noise, points.shape) if noise else points


def tilted(
    points: NDArray[np.float64], *, tilt: float, yaw: float, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> NDArray[np.float64]:
    """Points turned by a yaw about z, then tilted about x, degrees, then moved."""
    a, b = np.radians(yaw), np.radians(tilt)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    lean = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    return points @ (lean @ turn).T + np.array(shift)
