"""From the lines of the published method to the plan of a storey: faces that are walls, turned to the free space before them."""

from __future__ import annotations

import numpy as np

from indoor_bim.cloud.cloud import WALL, LevelledCloud
from indoor_bim.plan.alignment import share_lines
from indoor_bim.plan.back_to_back import turn_back_to_back
from indoor_bim.plan.curtains import draw_curtains
from indoor_bim.plan.raster import Raster, count_raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.selection import wall_like
from indoor_bim.plan.storey_plan import StoreyPlan

HORIZONTAL_CELL = 0.02
"""Side of the pixels that points of floor and ceiling are counted in, metres."""


def slope_plan(levelled: LevelledCloud, faces: Segments, *, free: Raster) -> StoreyPlan:
    """Plan of the lowest storey from all faces that the method found.

    Parameters
    ----------
    levelled : LevelledCloud
        The levelled scan.
    faces : Segments
        Faces, as `indoor_bim.slope.slope_segments` gives them, metres.
    free : Raster
        Where floor or ceiling was seen.
    """
    level = levelled.storeys[0]
    height = (level.ceiling or float(np.nanmax(faces.top))) - (level.floor or 0.0)
    faces = faces.take(wall_like(faces, storey_height=height))
    horizontal = count_raster(levelled.points[levelled.part != WALL, :2], cell=HORIZONTAL_CELL)
    faces = share_lines(draw_curtains(turn_back_to_back(faces, horizontal)))
    return StoreyPlan(faces, level.floor, level.ceiling, seen=free, warnings=levelled.warnings)
