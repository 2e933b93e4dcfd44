"""Points around walls, and what they tell where the path of the scanner is not known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.tiles import TILE, Tiles
from indoor_bim.plan.wall_rays import FRONT, MARGIN, Int32s, WallBox, WallRays, wall_table
from indoor_bim.threads import even_slices, in_threads, threads_for

Floats = NDArray[np.float64]

ON_FACE = 0.04  # metres
DEEPEST = 0.40  # metres behind a face: reveals and frames are not deeper


@dataclass(frozen=True, slots=True, eq=False)
class PointsAround:
    """Points around a wall, looked up when they are asked for.

    Parameters
    ----------
    wall : WallBox
        Wall.
    reach : float
        Largest distance from a face, metres.
    points : (n, 3) float64
        All points, metres.
    tiles : Tiles
        Where the rows of each tile are in `rows`.
    rows : (m,) int32
        Rows of the points, tile by tile.
    """

    wall: WallBox
    reach: float
    points: Floats
    tiles: Tiles
    rows: Int32s

    def within(
        self, start: float = -np.inf, end: float = np.inf, bottom: float = -np.inf, top: float = np.inf
    ) -> tuple[Floats, Floats, Floats]:
        """Where the points are, seen from the wall, that lie around a rectangle of it.

        Parameters
        ----------
        start, end, bottom, top : float
            Sides of the rectangle, metres; what is beyond the margin of the wall is left out.

        Returns
        -------
        along, across, up : (k,) float64
            Distance along the axis from its first end, to the left of it, and above the foot of the wall, metres; in the order of the
            tiles.
        """
        from indoor_bim.plan.tile_loops import places_within

        wall, axis = self.wall, np.array(self.wall.direction)
        start, end = max(start, -MARGIN), min(end, wall.length + MARGIN)
        bottom, top = max(bottom, -MARGIN), min(top, wall.height + MARGIN)
        p, q = wall.start + start * axis, wall.start + max(end, start) * axis
        ranges = self.tiles.along(p, q, wall.thickness / 2 + self.reach)
        places = np.zeros((3, int(np.diff(ranges, axis=1).sum()) + 1))
        found = places_within(self.points, self.rows, ranges, wall_table([wall])[0], self.reach, start, end, bottom, top, places)
        return places[0, :found], places[1, :found], places[2, :found]


def points_around(walls: Sequence[WallBox], points: Floats, *, reach: float) -> list[PointsAround]:
    """Points around each wall.

    Parameters
    ----------
    walls : sequence of WallBox
        Walls.
    points : (n, 3) float64
        Points, metres.
    reach : float
        Largest distance from a face, metres.
    """
    from indoor_bim.plan.tile_loops import find_tiles, put_into_tiles

    points = np.ascontiguousarray(points, dtype=np.float64)
    if not walls:
        return []
    beyond = reach + MARGIN + max(wall.thickness for wall in walls)
    ends = np.array([end for wall in walls for end in (wall.start, wall.end)])
    low, high = (np.floor(corner / TILE).astype(np.int64) for corner in (ends.min(axis=0) - beyond, ends.max(axis=0) + beyond))
    columns, rows = (int(side) for side in high - low + 1)
    parts = even_slices(len(points), threads_for(len(points)))
    tile, count = np.zeros(len(points), dtype=np.int32), np.zeros((len(parts), rows * columns), dtype=np.int64)
    grid = (TILE, int(low[0]), int(low[1]), columns, rows)
    in_threads(lambda k: find_tiles(points[parts[k]], *grid, tile[parts[k]], count[k]), range(len(parts)), threads=len(parts))
    first = np.concatenate([[0], np.cumsum(count.sum(axis=0))]).astype(np.int64)
    place = first[:-1] + np.cumsum(count, axis=0) - count
    ordered = np.zeros(int(first[-1]), dtype=np.int32)
    in_threads(lambda k: put_into_tiles(tile[parts[k]], parts[k].start, place[k], ordered), range(len(parts)), threads=len(parts))
    return [PointsAround(wall, reach, points, Tiles(low, columns, first), ordered) for wall in walls]


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
