"""The scan as the ways of finding footprints get it: ground, heights above it, and what may be of buildings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.outdoor.classes import classify
from indoor_bim.outdoor.terrain import Terrain, ground_terrain

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Ground and building points of an outdoor scan.

    Parameters
    ----------
    ground : (g, 3) float64
        Ground points, metres.
    terrain : Terrain
        Height of the ground everywhere.
    building : (n, 3) float64
        Points that may be of buildings, metres.
    above_ground : (n,) float64
        Height of each of them above the ground, metres.
    classes_from_file : bool
        Whether the class codes of the file told ground from buildings.
    """

    ground: Floats
    terrain: Terrain
    building: Floats
    above_ground: Floats
    classes_from_file: bool


def see_scene(points: Floats, classification: NDArray[np.uint8] | None, *, terrain_spacing: float = 1.0) -> Scene | None:
    """Split a scan into ground and what may be buildings; None when it has no ground.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z up.
    classification : (n,) uint8, optional
        ASPRS classes of the file.
    terrain_spacing : float
        Distance between the grid points of the terrain, metres.
    """
    classes = classify(points, classification)
    if not classes.ground.any():
        return None
    ground = points[classes.ground]
    terrain = ground_terrain(ground, spacing=terrain_spacing)
    building = points[classes.building]
    return Scene(ground, terrain, building, building[:, 2] - terrain.at(building[:, :2]), classes.from_file)
