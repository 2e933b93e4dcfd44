"""Turn a scan upright and into the building's main direction, and find its storeys.

Everything rests on area, not on point counts: the cloud is thinned to one mean per small voxel first, and
surfaces are cells of a coarse grid whose points lie in a plane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud, LevelledCloud, StoreyLevels
from indoor_bim.cloud.heights import LEVEL_TOLERANCE
from indoor_bim.cloud.main_direction import main_direction
from indoor_bim.cloud.motion import FEW_POINTS, moved
from indoor_bim.cloud.storey_levels import storey_levels
from indoor_bim.cloud.thinning import thin_evenly
from indoor_bim.cloud.upright import upright
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.threads import even_slices, in_threads, threads_for

__all__ = ["level", "lowered", "main_direction", "storey_levels", "thin", "upright"]

Floats = NDArray[np.float64]

_VOXEL = 0.05


def thin(points: Floats) -> Floats:
    """Mean point of every occupied voxel of 5 cm, so that each bit of surface counts alike.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.

    Returns
    -------
    (m, 3) float64
        Means, ordered by voxel.

    Examples
    --------
    >>> thin(np.array([[0.01, 0, 0], [0.03, 0, 0], [1.0, 1, 1]])).round(2).tolist()
    [[0.02, 0.0, 0.0], [1.0, 1.0, 1.0]]
    """
    return thin_evenly(points, cell=_VOXEL)


def level(cloud: Cloud) -> LevelledCloud:
    """Turn a cloud upright and into its main direction, and find its storeys.

    Parameters
    ----------
    cloud : Cloud
        Scan with z roughly up.

    Returns
    -------
    LevelledCloud
        Lowest floor at z = 0.

    Raises
    ------
    NothingToReconstructError
        If the scan has no level surface.
    """
    sample = thin(cloud.points)
    turn = upright(sample)
    sample = moved(sample, turn)
    works: list[Callable[[Floats], Any]] = [main_direction, storey_levels]
    yaw, storeys = in_threads(lambda work: work(sample), works, threads=threads_for(len(sample)))
    cos, sin = np.cos(-yaw), np.sin(-yaw)
    about_z = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    warnings = list(cloud.warnings)
    if not storeys:
        raise NothingToReconstructError("found neither floor nor ceiling: no level surface covers enough of the plan")
    known = [z for s in storeys for z in (s.floor, s.ceiling) if z is not None]
    base = next((s.floor for s in storeys if s.floor is not None), min(known))
    rotation = about_z @ turn
    shift = np.array([0.0, 0.0, -base])
    points = moved(cloud.points, rotation, shift)
    storeys = tuple(StoreyLevels(_minus(s.floor, base), _minus(s.ceiling, base)) for s in storeys)
    for number, s in enumerate(storeys, 1):
        if s.floor is None:
            warnings.append(f"storey {number}: the floor was not seen")
        if s.ceiling is None:
            warnings.append(f"storey {number}: no level ceiling was seen")
    trajectory = cloud.trajectory
    if trajectory is not None:
        trajectory = np.column_stack([trajectory[:, 0], moved(trajectory[:, 1:4], rotation, shift)])
    return LevelledCloud(
        points=points,
        frame=cloud.frame.then(rotation, shift),
        part=_parts(points, storeys),
        storeys=storeys,
        trajectory=trajectory,
        warnings=tuple(warnings),
    )


def lowered(levelled: LevelledCloud, height: float) -> LevelledCloud:
    """Return the scan `height` metres lower, so that another floor lies at z = 0.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    height : float
        Height of the floor, metres.
    """
    shift = np.array([0.0, 0.0, -height])
    path = levelled.trajectory
    return replace(
        levelled,
        points=levelled.points + shift,
        frame=levelled.frame.then(np.eye(3), shift),
        storeys=tuple(StoreyLevels(_minus(s.floor, height), _minus(s.ceiling, height)) for s in levelled.storeys),
        trajectory=None if path is None else path + np.array([0.0, *shift]),
    )


def _minus(height: float | None, base: float) -> float | None:
    return None if height is None else height - base


def _parts(points: Floats, storeys: tuple[StoreyLevels, ...]) -> NDArray[np.uint8]:
    """Part of the storey that each point belongs to by its height."""
    levels = [(height, label) for s in storeys for height, label in ((s.floor, FLOOR), (s.ceiling, CEILING)) if height is not None]
    part = np.full(len(points), WALL, dtype=np.uint8)
    if len(points) <= FEW_POINTS:
        for height, label in levels:
            part[np.abs(points[:, 2] - height) < LEVEL_TOLERANCE] = label
        return part
    from indoor_bim.cloud.point_loops import label_heights

    heights, labels = np.array([height for height, _ in levels]), np.array([label for _, label in levels])
    threads = threads_for(len(points))
    in_threads(
        lambda rows: label_heights(points[rows], heights, labels, LEVEL_TOLERANCE, part[rows]),
        even_slices(len(points), threads),
        threads=threads,
    )
    return part
