"""How surely the faces of walls are known, from the faces that they were made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments
from indoor_bim.plan.walls import Walls

Floats = NDArray[np.float64]

PARALLEL_COS = np.cos(np.radians(2.5))
"""A face of a wall and what it was made from differ less than this in direction."""
APART = 0.05
"""Largest distance between them, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class FaceAccuracy:
    """Accuracy of walls, one row each: that of the less certain of the faces that were seen; NaN where not known.

    Parameters
    ----------
    position : (m,) float64
        Standard deviation of the position across, in the middle of what was seen, metres.
    direction : (m,) float64
        Standard deviation of the direction, radians.
    deviation : (m,) float64
        Distance from the face that the local medians of the points keep to along 95 % of it, metres.
    """

    position: Floats
    direction: Floats
    deviation: Floats


def face_accuracy(walls: Walls, faces: Segments) -> FaceAccuracy:
    """Accuracy of the faces of walls.

    Pieces of one face add their information: that on the position, and that on the direction, which grows with the square of
    the distance between pieces. What moved a face from its points, for it to be square or as thick as others, adds to its deviation.

    Parameters
    ----------
    walls : Walls
        Walls, metres.
    faces : Segments
        The faces that they were made from, with covariance and deviation where these are known.
    """
    table = np.full((3, len(walls)), np.nan)
    known = faces.take(np.isfinite(faces.covariance[:, 0, 0]))
    for k in range(len(walls)):
        sides = (1.0, -1.0) if walls.measured[k] else (1.0,) if walls.seen_left[k] else (-1.0,)
        found = [_one_face(walls, k, side, known) for side in sides]
        told = [one for one in found if one is not None]
        if told:
            table[:, k] = np.max(told, axis=0)
    return FaceAccuracy(*table)


def _one_face(walls: Walls, k: int, side: float, faces: Segments) -> tuple[float, float, float] | None:
    """Standard deviations and deviation of the face to the left (1) or right (-1) of the axis of a wall."""
    d, n = side * walls.direction[k], side * walls.normal[k]
    tail = walls.p[k] if side > 0 else walls.q[k]
    along = np.stack([faces.p - tail, faces.q - tail]) @ d
    across = np.stack([faces.p - tail, faces.q - tail]) @ n - walls.thickness[k] / 2
    shared = np.minimum(along[1], walls.length[k]) - np.maximum(along[0], 0.0)
    mine = (shared > 0) & (faces.direction @ d > PARALLEL_COS) & (np.abs(across.mean(axis=0)) < APART)
    if not mine.any():
        return None
    rows = np.flatnonzero(mine)
    covariance = faces.covariance[rows]
    share = shared[rows] / faces.length[rows]
    turn = covariance[:, 0, 0] / share**3
    position = (covariance[:, 1, 1] - covariance[:, 0, 1] ** 2 / covariance[:, 0, 0]) / share
    middle = (np.minimum(along[1, rows], walls.length[k]) + np.maximum(along[0, rows], 0.0)) / 2
    weight = 1 / np.maximum(position, 1e-16)
    lever = middle - np.average(middle, weights=weight)
    moved = np.abs(across[:, rows]).max(axis=0)
    deviation = np.nan_to_num(faces.deviation[rows]) + moved
    information = float((1 / np.maximum(turn, 1e-16) + weight * lever**2).sum())
    return float(weight.sum() ** -0.5), information**-0.5, float(deviation.max())
