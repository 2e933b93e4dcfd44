"""Points of one storey, between its floor and its ceiling and inside the building."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import LevelledCloud
from indoor_bim.plan.image import remove_burrs, thicken
from indoor_bim.plan.raster import Raster, count_raster

Points = NDArray[np.float64]

SLACK = 0.05  # metres: points this close to floor or ceiling belong to them
COVER_CELL, COVER_MARGIN = 0.20, 0.40  # metres: what has neither floor nor ceiling this close lies outside
USUAL_HEIGHT = 2.5  # metres, where no ceiling was seen
LEAST_HEIGHT = 1.0  # metres


def storey_points(levelled: LevelledCloud, number: int, scanner: Points | None) -> tuple[Points, Points | None, float, float]:
    """Points of a storey between its floor and its ceiling, below or above what was seen of them.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    number : int
        Storey, from 0.
    scanner : (n, 3) float64 or None
        Position of the scanner at each point, metres.

    Returns
    -------
    points : (n, 3) float64
        Metres, z above the floor.
    scanner : (n, 3) float64 or None
        Positions of the scanner, z above the floor.
    floor, height : float
        Level of the floor, or of the lowest points, and height up to the ceiling, or the usual height, metres.
    """
    storey = levelled.storeys[number]
    above = [s.floor for s in levelled.storeys[number + 1 :] if s.floor is not None]
    z = levelled.points[:, 2]
    lowest = float(np.quantile(z, 0.005))
    ceiling = storey.ceiling if storey.ceiling is not None else lowest + USUAL_HEIGHT
    floor = storey.floor if storey.floor is not None else min(lowest, ceiling - LEAST_HEIGHT)
    highest = above[0] - 0.3 if above else float(np.quantile(z, 0.995))
    top = storey.ceiling if storey.ceiling is not None else max(min(highest, floor + USUAL_HEIGHT), floor + LEAST_HEIGHT)
    spots = levelled.points[(np.abs(z - floor) < SLACK) | (np.abs(z - (floor if storey.ceiling is None else top)) < SLACK), :2]
    rows = np.flatnonzero((z > floor + SLACK) & (z < top - SLACK))
    if len(spots):
        seen = count_raster(spots, cell=COVER_CELL)
        margin = round(COVER_MARGIN / COVER_CELL)
        cover = ~thicken(~np.pad(remove_burrs(seen.image > 0), margin + 2))  # the faces of other houses are a line there, no area
        for _ in range(margin + 1):
            cover = thicken(cover)
        inside = Raster(cover, seen.origin - (margin + 2) * COVER_CELL, COVER_CELL).sample(levelled.points[rows, :2]) > 0
        rows = rows[inside]
    shift = np.array([0.0, 0.0, floor])
    return levelled.points[rows] - shift, None if scanner is None else scanner[rows] - shift, floor, top - floor


def storey_only(levelled: LevelledCloud, *, floor: float, top: float) -> LevelledCloud:
    """Cloud without the other storeys.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    floor, top : float
        Level of the floor and of the ceiling, metres.
    """
    if len(levelled.storeys) == 1:
        return levelled
    rows = (levelled.points[:, 2] > floor - 2 * SLACK) & (levelled.points[:, 2] < top + 2 * SLACK)
    return replace(levelled, points=levelled.points[rows], part=levelled.part[rows])
