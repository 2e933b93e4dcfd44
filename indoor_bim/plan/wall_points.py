"""Points around walls, and what they tell where the path of the scanner is not known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.wall_rays import FRONT, MARGIN, Int32s, WallBox, WallRays, rows_of_walls, wall_table

Floats = NDArray[np.float64]

ON_FACE = 0.04  # metres
DEEPEST = 0.40  # metres behind a face: reveals and frames are not deeper


def rows_at_walls(walls: Sequence[WallBox], points: Floats, *, reach: float) -> list[Int32s]:
    """Rows of the points close to each wall.

    Parameters
    ----------
    walls : sequence of WallBox
        Walls.
    points : (n, 3) float64
        Points, metres.
    reach : float
        Largest distance from a face, metres.
    """
    from indoor_bim.plan.wall_loops import points_of_walls

    boxes, points = wall_table(walls), np.ascontiguousarray(points, dtype=np.float64)
    return rows_of_walls(lambda part, *out: points_of_walls(points[part], boxes, reach, MARGIN, *out), walls=len(boxes), points=len(points))


def places_at_wall(wall: WallBox, points: Floats, rows: Int32s) -> tuple[Floats, Floats, Floats]:
    """Where some of the points are, seen from a wall.

    Parameters
    ----------
    wall : WallBox
        Wall.
    points : (n, 3) float64
        Points, metres.
    rows : (m,) int32
        Rows of those that are asked for.

    Returns
    -------
    along, across, up : (m,) float64
        Distance along the axis from its first end, to the left of it, and above the foot of the wall, metres.
    """
    from indoor_bim.plan.wall_loops import point_places

    places = np.zeros((3, len(rows)))
    point_places(np.ascontiguousarray(points, dtype=np.float64), rows, wall_table([wall])[0], places)
    return places[0], places[1], places[2]


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
