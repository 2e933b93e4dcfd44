"""Levelling by principal components: a scan at any attitude turned upright and into its main direction.

Source: Remote Sensing 2021, 13, 4930, section 2.1; the paper has no main direction but needs it, as it knows four directions only.
"""

from __future__ import annotations

import numpy as np

from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud, LevelledCloud, StoreyLevels
from indoor_bim.cloud.floor_and_ceiling import THIN_CELL, find_floor_and_ceiling, main_body
from indoor_bim.cloud.no_walls import no_walls
from indoor_bim.cloud.plane import Plane, rotation_to_z
from indoor_bim.cloud.thinning import thin_evenly
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.directions import main_direction


def level_by_pca(
    cloud: Cloud, *, grid_count: int | None = None, floor_threshold: float | None = None, ceiling_threshold: float | None = None
) -> LevelledCloud:
    """Turn a one-storey scan upright and into its main direction, split into floor, ceiling and walls (section 2.1).

    Parameters
    ----------
    cloud : Cloud
        Scan at any attitude with z roughly up.
    grid_count : int, optional
        Cells along each side of the grid that finds floor and ceiling (n_fac); None: from the extent.
    floor_threshold, ceiling_threshold : float, optional
        Distance from the plane within which points belong to it, metres; None: from the spread of the plane's points.

    Returns
    -------
    LevelledCloud
        Floor at z = 0 (the lowest wall points, if the floor was not seen), x along the main direction; of the four
        equivalent quarter turns the one that turns the scan least.

    Raises
    ------
    NothingToReconstructError
        If neither floor nor ceiling can be found, or nothing but them.
    """
    if len(cloud) < 100:
        raise NothingToReconstructError(f"{cloud.source}: found {len(cloud)} points; expected a scan of a building with at least 100")
    planes = find_floor_and_ceiling(
        cloud.points, grid_count=grid_count, floor_threshold=floor_threshold, ceiling_threshold=ceiling_threshold
    )
    turn = rotation_to_z(planes.normal)
    height = Plane(planes.normal, 0.0).height(cloud.points)
    part = np.full(len(cloud), WALL)
    if planes.floor is not None:
        part[np.abs(height - planes.floor) < planes.floor_threshold] = FLOOR
    if planes.ceiling is not None:
        part[np.abs(height - planes.ceiling) < planes.ceiling_threshold] = CEILING
    low = planes.floor if planes.floor is not None else float(np.quantile(height, 0.005))
    high = planes.ceiling if planes.ceiling is not None else float(np.quantile(height, 0.995))
    between = (part == WALL) & (height > low) & (height < high)
    if between.sum() < 100:
        seen = {"floor": planes.floor is not None, "ceiling": planes.ceiling is not None}
        raise NothingToReconstructError(f"{cloud.source}: {no_walls(len(cloud), **seen)}")
    upright = cloud.points.take(np.flatnonzero(between), axis=0) @ turn.T
    walls = thin_evenly(upright, cell=THIN_CELL)
    walls = walls.take(np.flatnonzero(main_body(walls)), axis=0)
    angle = main_direction(walls[:, :2])
    c, s = np.cos(angle), np.sin(angle)
    yaw = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rotation, shift = yaw @ turn, np.array([0.0, 0.0, -low])
    trajectory = None
    if cloud.trajectory is not None:
        trajectory = cloud.trajectory.copy()
        trajectory[:, 1:] = cloud.trajectory[:, 1:] @ rotation.T + shift
    points = cloud.points @ rotation.T
    points += shift
    return LevelledCloud(
        points=points,
        frame=cloud.frame.then(rotation, shift),
        part=part,
        storeys=(StoreyLevels(None if planes.floor is None else 0.0, None if planes.ceiling is None else planes.ceiling - low),),
        trajectory=trajectory,
        warnings=(*cloud.warnings, *planes.warnings),
    )
