"""Directions of the walls that the main directions leave over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import FEW_POINTS, WallPoints
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.strips import height_layers
from indoor_bim.threads import even_slices, in_threads, threads_for

Floats = NDArray[np.float64]

PAST = 0.1
"""Points so far past the ends of a line still lie on it, metres."""
SPOT = 0.03
"""Side of the cells whose points are one spot, metres."""


def unexplained(points: WallPoints, lines: FaceLines, *, near: float = 0.08, upper: float = 0.8) -> WallPoints:
    """Points high on the walls that lie on none of the lines.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    lines : FaceLines
        Lines found so far.
    near : float
        Points this close to a line lie on it, metres.
    upper : float
        Share of the height above which points count.
    """
    table = np.column_stack([lines.direction, lines.normal, lines.offset, lines.start, lines.end]).astype(np.float64)
    if len(points) > FEW_POINTS:
        from indoor_bim.plan.oblique_loops import off_lines

        xy, threads = np.ascontiguousarray(points.xy), threads_for(len(points))

        def of_part(part: slice) -> NDArray[np.int64]:
            rows = np.zeros(part.stop - part.start, dtype=np.int64)
            count = off_lines(xy[part], points.rise[part], upper, table, near, PAST, rows)
            rows += part.start
            return rows[:count]

        return points.take(np.concatenate(in_threads(of_part, even_slices(len(points), threads), threads=threads)))
    high = np.flatnonzero(points.rise > upper)
    xy, free = points.xy.take(high, axis=0), np.ones(len(high), dtype=bool)
    for dx, dy, nx, ny, offset, start, end in table:
        along, across = xy @ np.array([dx, dy]), xy @ np.array([nx, ny]) - offset
        free &= (np.abs(across) > near) | (along < start - PAST) | (along > end + PAST)
    return points.take(high[free])


def other_directions(points: WallPoints, *, cell: float = 0.40, least: float = 0.4, most: int = 6) -> list[float]:
    """Directions that the remaining points line up in, radians.

    Parameters
    ----------
    points : WallPoints
        What the main directions do not explain.
    cell : float
        Side of the cells whose direction is looked at, metres; four grids half a cell apart are used.
    least : float
        Length of wall that a direction needs, metres.
    most : int
        Largest number of directions.
    """
    if not len(points):
        return []
    spots = np.floor(points.xy / SPOT).astype(np.int64)
    low, high = spots.min(axis=0), spots.max(axis=0)
    number = (spots[:, 0] - low[0]) * (high[1] - low[1] + 1) + spots[:, 1] - low[1]
    spot, layers = np.unique(np.unique(number * 32 + height_layers(points)) // 32, return_counts=True)
    filled = layers >= 2
    if not filled.any():
        return []
    fine = (low + np.stack(np.divmod(spot[filled], high[1] - low[1] + 1), axis=1)) * SPOT + SPOT / 2
    weight = layers[filled].astype(np.float64)
    angles, lengths = [], []
    for shift in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)):
        index = np.floor(fine / cell + np.array(shift)).astype(np.int64)
        index -= index.min(axis=0)
        _, group, count = np.unique(index[:, 0] * (index[:, 1].max() + 1) + index[:, 1], return_inverse=True, return_counts=True)
        total = np.bincount(group, weights=weight)
        mean = np.column_stack([np.bincount(group, weights=weight * fine[:, k]) / total for k in range(2)])
        x, y = (fine - mean[group]).T
        xx, yy, xy = (np.bincount(group, weights=weight * w) / total for w in (x * x, y * y, x * y))
        half = np.sqrt(((xx - yy) / 2) ** 2 + xy**2)
        minor, major = (xx + yy) / 2 - half, (xx + yy) / 2 + half
        straight = (count >= 6) & (minor < 0.15 * major) & (major > (0.2 * cell) ** 2)
        angles.append(np.mod(0.5 * np.arctan2(2 * xy, xx - yy)[straight], np.pi))
        lengths.append(np.sqrt(12 * major[straight]) / 4)
    angle, length = np.concatenate(angles), np.concatenate(lengths)
    grid = np.radians(np.arange(0, 180, 2.0))
    found: list[float] = []
    while len(found) < most and len(angle):
        apart = np.abs(np.mod(angle[None] - grid[:, None] + np.pi / 2, np.pi) - np.pi / 2)
        votes = ((apart < np.radians(6)) * length).sum(axis=1)
        best = int(np.argmax(votes))
        if votes[best] < least:
            break
        mine = apart[best] < np.radians(6)
        delta = np.mod(angle[mine] - grid[best] + np.pi / 2, np.pi) - np.pi / 2
        found.append(float(grid[best] + np.median(delta)))
        angle, length = angle[~mine], length[~mine]
    return found
