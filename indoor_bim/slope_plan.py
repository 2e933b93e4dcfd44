"""From the lines of the published method to the plan of a storey: faces that are walls, turned to the free space before them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import FLOOR, WALL, LevelledCloud
from indoor_bim.cloud.spacing import point_spacing
from indoor_bim.plan.alignment import share_lines
from indoor_bim.plan.back_to_back import turn_back_to_back
from indoor_bim.plan.curtains import draw_curtains
from indoor_bim.plan.raster import count_raster
from indoor_bim.plan.scanner_path import known_positions
from indoor_bim.plan.selection import seen_in_parts, stacked, typical_coverage, wall_like, walls_in_line
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.plan.wall_stretches import columns_of, wall_share, wall_stretches
from indoor_bim.slope import SlopeStages, lowest_storey
from indoor_bim.slope_afar import seen_space, walls_afar

HORIZONTAL_CELL = 0.02
"""Side of the pixels that points of floor and ceiling are counted in, metres."""
FULL_WALL = 0.7
"""Share of its columns in which a face is a wall, whatever its height in the middle."""
LONGEST_FURNITURE = 3.0
"""Metres; cupboards side by side may be as high as walls."""
LEAST_REACH = 0.03
"""Distance within which points belong to a face at least, metres."""
ON_ONE_LINE = 0.03
"""Faces that are no farther apart than this, or than the points of the scan, are on one line, metres."""


def slope_plan(
    levelled: LevelledCloud, lines: SlopeStages, *, afar: bool = True, gps_time: NDArray[np.float64] | None = None
) -> StoreyPlan:
    """Plan of the lowest storey from all faces that the method found.

    Parameters
    ----------
    levelled : LevelledCloud
        The levelled scan.
    lines : SlopeStages
        What the method found.
    afar : bool
        Look for the walls of places that the scanner only looked into as well.
    gps_time : (n,) float64, optional
        Time of each point, seconds; with the path of the scanner it tells walls from what glass mirrors.
    """
    level = levelled.storeys[0]
    low, height = lowest_storey(levelled)
    tolerance = max(ON_ONE_LINE, point_spacing(lines.walls))
    floor = levelled.points[levelled.part == FLOOR, :2]
    columns = columns_of(lines.segments, lines.walls - [0, 0, low], floor, reach=max(2 * lines.image.cell, LEAST_REACH), height=height)
    sparse = seen_in_parts(lines.segments, storey_height=height)
    known = wall_like(lines.segments, storey_height=height) | (
        ~sparse & (wall_share(columns) >= FULL_WALL) & (lines.segments.length > LONGEST_FURNITURE)
    )
    walls = wall_stretches(lines.segments, columns, known=known, doubtful=sparse)
    usual = typical_coverage(lines.segments, storey_height=height)
    walls = walls_in_line(walls, lines.segments.take(~known), typical_coverage=usual, tolerance=tolerance)
    horizontal = count_raster(levelled.points[levelled.part != WALL, :2], cell=HORIZONTAL_CELL)
    if afar:
        walls = stacked(walls, walls_afar(levelled, lines, walls, known_positions(levelled.trajectory, gps_time)))
    faces = share_lines(draw_curtains(turn_back_to_back(walls, horizontal)), tolerance=tolerance)
    seen = seen_space(levelled, lines.free) if afar else lines.free
    return StoreyPlan(faces, level.floor, level.ceiling, seen=seen, warnings=levelled.warnings)
