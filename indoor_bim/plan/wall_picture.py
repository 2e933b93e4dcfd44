"""The picture of a wall, along x up: where its faces were hit, where rays went in and through, what stood before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.relief import STEEP
from indoor_bim.plan.wall_rays import WallBox, WallRays

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

POINTS_PER_CELL = 6.0


@dataclass(frozen=True, slots=True, eq=False)
class WallPicture:
    """Counts per side (0 left, 1 right) and cell, row 0 at the foot of the wall, column 0 at the first end of its axis.

    Parameters
    ----------
    cell : float
        Side of a cell, metres.
    face : (2, rows, columns) int64
        Hits on the faces.
    entered : (2, rows, columns) int64
        Rays that ended behind the face they came to, counted where they met it.
    through : (2, rows, columns) int64
        Those of them that ended behind the other face as well.
    front : (rows, columns) int64
        Points in front of the faces.
    """

    cell: float
    face: Counts
    entered: Counts
    through: Counts
    front: Counts


def cell_size(wall: WallBox, rays: int, *, smallest: float = 0.02, largest: float = 0.06) -> float:
    """Side of the cells of a wall's picture that hold a few rays each, metres.

    Parameters
    ----------
    wall : WallBox
        Wall.
    rays : int
        Rays that came to it.
    smallest, largest : float
        Bounds, metres: finer than edges are sharp, and too coarse for a door frame.
    """
    return float(np.clip(np.sqrt(POINTS_PER_CELL * wall.length * wall.height / max(rays, 1)), smallest, largest))


def picture_shape(wall: WallBox, *, cell: float) -> tuple[int, int]:
    """Rows and columns of the picture of a wall.

    Parameters
    ----------
    wall : WallBox
        Wall.
    cell : float
        Side of a cell, metres.
    """
    return max(int(np.ceil(wall.height / cell)), 1), max(int(np.ceil(wall.length / cell)), 1)


def draw_picture(
    wall: WallBox,
    rays: WallRays,
    *,
    tolerance: float,
    through_depth: float,
    cell: float,
    around: tuple[Floats, Floats, Floats] | None = None,
) -> WallPicture:
    """Picture of one wall.

    Parameters
    ----------
    wall : WallBox
        Wall.
    rays : WallRays
        Rays that came to it, with corrected depths.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    through_depth : float
        Rays that ended this far behind the nearer face went through the wall, metres.
    cell : float
        Side of a cell, metres.
    around : ((m,), (m,), (m,)) float64, optional
        Points around the wall: along, across, up; metres. Those in front of it are counted.
    """
    from indoor_bim.plan.wall_loops import count_ahead, count_rays

    shape = picture_shape(wall, cell=cell)
    face, entered, through = (np.zeros((2, *shape), dtype=np.int64) for _ in range(3))
    ends = (rays.along, rays.up, rays.along_end, rays.up_end)
    count_rays(rays.side, rays.depth, rays.slant, *ends, tolerance, through_depth, STEEP, cell, face, entered, through)
    front = np.zeros(shape, dtype=np.int64)
    if around is not None:
        count_ahead(*around, wall.thickness / 2 + tolerance, cell, front)
    return WallPicture(cell, face, entered, through, front)
