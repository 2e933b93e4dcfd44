"""Points around walls, and what they tell where the path of the scanner is not known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.wall_rays import FRONT, MARGIN, WallBox, WallRays, rows_of_walls, wall_table

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
    from indoor_bim.plan.wall_loops import point_places, points_of_walls

    boxes = wall_table(walls)
    points = np.ascontiguousarray(points, dtype=np.float64)
    found = rows_of_walls(
        lambda part, *out: points_of_walls(points[part], boxes, reach, MARGIN, *out), walls=len(boxes), points=len(points)
    )
    for box, rows in zip(boxes, found, strict=True):
        places = np.zeros((3, len(rows)))
        point_places(points, rows, box, places)
        yield places[0], places[1], places[2]


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
        length=depth[near].astype(np.float32),
        period=np.zeros(len(x), dtype=np.int64),
    )
