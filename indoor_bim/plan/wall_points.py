"""Points around walls, and what they tell where the path of the scanner is not known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.wall_rays import FRONT, MARGIN, WallBox, WallRays

Floats = NDArray[np.float64]

ON_FACE = 0.04  # metres
DEEPEST = 0.40  # metres behind a face: reveals and frames are not deeper


def points_at_walls(walls: Sequence[WallBox], points: Floats, *, reach: float) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Points close to each wall, one wall after the other.

    Parameters
    ----------
    walls : sequence of WallBox
        Walls.
    points : (n, 3) float64
        Points, metres.
    reach : float
        Largest distance from a face, metres.

    Yields
    ------
    along, across, up : (m,) float64
        Distance along the axis from its first end, to the left of it, and above the foot of the wall, metres.
    """
    cell = 0.5
    low = points[:, :2].min(axis=0) if len(points) else np.zeros(2)
    index = np.floor((points[:, :2] - low) / cell).astype(np.int64)
    shape = index.max(axis=0) + 1 if len(points) else np.ones(2, dtype=np.int64)
    key = index[:, 0] * shape[1] + index[:, 1]
    order = np.argsort(key, kind="stable")
    first = np.searchsorted(key[order], np.arange(int(shape.prod()) + 1))
    ordered = points[order]
    centre = low + (np.indices(tuple(shape)).reshape(2, -1).T + 0.5) * cell
    for wall in walls:
        d = np.array(wall.direction)
        n = np.array([-d[1], d[0]])
        half = wall.thickness / 2
        u, v = (centre - wall.start) @ d, (centre - wall.start) @ n
        near = (np.abs(v) < half + reach + cell) & (u > -MARGIN - cell) & (u < wall.length + MARGIN + cell)
        cells = np.flatnonzero(near & (first[1:] > first[:-1]))
        near_points = np.concatenate([ordered[first[c] : first[c + 1]] for c in cells]) if len(cells) else np.zeros((0, 3))
        x, y = near_points[:, 0] - wall.start[0], near_points[:, 1] - wall.start[1]
        along, across, up = x * d[0] + y * d[1], x * n[0] + y * n[1], near_points[:, 2] - wall.base
        keep = (np.abs(across) < half + reach) & (along > -MARGIN) & (along < wall.length + MARGIN)
        keep &= (up > -MARGIN) & (up < wall.height + MARGIN)
        yield along[keep], across[keep], up[keep]


def rays_from_points(along: Floats, across: Floats, up: Floats, *, thickness: float, both_faces: bool) -> WallRays:
    """Take the points at a wall for ends of rays that came to the nearer face square on.

    Parameters
    ----------
    along, across, up : (n,) float64
        Distance along the axis from its first end, to the left of it, and above the foot of the wall, metres.
    thickness : float
        Thickness of the wall, metres.
    both_faces : bool
        False where one face was seen and the thickness is assumed: then all rays come to the face that was hit more often.
    """
    half = thickness / 2
    if both_faces:
        side = np.where(across > 0, 1, -1)
    else:
        hits = [int((np.abs(across - s * half) < ON_FACE).sum()) for s in (1, -1)]
        side = np.full(len(across), 1 if hits[0] >= hits[1] else -1)
    depth = half - side * across
    near = (depth > -FRONT) & (depth < DEEPEST)
    x, z = along[near].astype(np.float32), up[near].astype(np.float32)
    return WallRays(
        side=side[near].astype(np.int8),
        depth=depth[near].astype(np.float32),
        along=x,
        up=z,
        along_far=x,
        up_far=z,
        along_end=x,
        up_end=z,
        slant=np.ones(len(x), dtype=np.float32),
        period=np.zeros(len(x), dtype=np.int64),
    )
