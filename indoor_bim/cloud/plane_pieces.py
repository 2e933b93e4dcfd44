"""Small plane pieces of a scan: what floors, ceilings and walls are found by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.box_moments import BoxMoments, box_moments
from indoor_bim.threads import even_slices, in_threads, most_threads

Floats = NDArray[np.float64]

CELL = 0.30
MIN_CELL_POINTS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Small plane pieces of a scan, one per cubic cell whose points lie in a plane.

    Parameters
    ----------
    centre : (m, 3) float64
        Mean point, metres.
    normal : (m, 3) float64
        Unit normal, sign arbitrary.
    spread : (m,) float64
        Standard deviation of the points across the plane, metres.
    """

    centre: Floats
    normal: Floats
    spread: Floats


def patches(points: Floats, *, cell: float = CELL) -> Patches:
    """Plane pieces of a thinned cloud.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned points, metres.
    cell : float
        Side of a cell, metres.
    """
    return plane_pieces(box_moments(points, sides=(cell, cell, cell)))


def plane_pieces(boxes: BoxMoments, *, flatness: float = 0.2) -> Patches:
    """Boxes whose points lie in a plane.

    Parameters
    ----------
    boxes : BoxMoments
        Moments of the points in cubes.
    flatness : float
        Largest ratio between the standard deviations across the plane and along its shorter axis.
    """
    filled = boxes.count >= MIN_CELL_POINTS
    covariance = boxes.covariance[filled]
    parts = even_slices(len(covariance), most_threads())
    shares = in_threads(lambda part: np.linalg.eigh(covariance[part]), parts, threads=len(parts))
    values, vectors = (np.concatenate(found) for found in zip(*shares, strict=True))
    deviation = np.sqrt(np.maximum(values, 0))
    keep = deviation[:, 0] <= flatness * deviation[:, 1]
    return Patches(boxes.mean[filled][keep], vectors[keep, :, 0], deviation[keep, 0])


def level_pieces(boxes: BoxMoments) -> Floats:
    """Centres of flat boxes that are filled along both axes of the plan: level surfaces, not walls.

    Parameters
    ----------
    boxes : BoxMoments
        Moments of thinned upright points in boxes of `CELL` along x and y, a few of which are as high, metres.

    Returns
    -------
    (m, 3) float64
        Mean points, metres.
    """
    xx, yy, zz = (boxes.covariance[:, k, k] for k in range(3))
    minor = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + boxes.covariance[:, 0, 1] ** 2)
    evenly_filled = CELL**2 / 12
    level = (boxes.count >= MIN_CELL_POINTS) & (minor > 0.25 * evenly_filled) & (zz < 0.25 * minor)
    centre: Floats = boxes.mean[level]
    return centre
