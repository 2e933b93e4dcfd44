"""Planes: fits by principal components, robust refits, and the turn that makes one level.

Source: Remote Sensing 2021, 13, 4930, section 2.1 (equations 1, 5 and 6).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Plane ``normal · x = offset``.

    Parameters
    ----------
    normal : (3,) float64
        Unit normal.
    offset : float
        Distance of the plane from the origin along the normal, metres.
    """

    normal: Points
    offset: float

    def height(self, points: Points) -> Points:
        """Signed distances (n,) of points (n, 3) from the plane, metres; positive on the side of the normal."""
        x, y, z = np.asarray(points, dtype=np.float64).T
        height: Points = self.normal[0] * x + self.normal[1] * y + self.normal[2] * z - self.offset
        return height

    def facing(self, up: Points) -> Self:
        """Return the same plane with its normal turned to the side of `up` (3,)."""
        return self if float(self.normal @ up) >= 0 else type(self)(-self.normal, -self.offset)


def principal_axes(points: Points) -> tuple[Points, Points, Points]:
    """Mean, principal axes and variances of points (section 2.1, algorithm 1).

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.

    Returns
    -------
    mean : (3,) float64
        Mean of the points.
    axes : (3, 3) float64
        Unit axes v1, v2, v3 in the rows, largest variance first; v3 is the normal of the mid plane.
    variances : (3,) float64
        Variances along the axes, square metres.

    Examples
    --------
    >>> mean, axes, variances = principal_axes(np.array([[0.0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 0]]))
    >>> mean.tolist(), np.abs(axes).round(6).tolist()
    ([2.0, 1.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    """
    mean = points.mean(axis=0)
    deviation = points - mean
    _, variances, axes = np.linalg.svd(deviation.T @ deviation / len(points))
    return mean, axes, variances


def fit_plane(points: Points) -> Plane:
    """Plane through points by principal components (section 2.1, equations 1 and 5).

    Parameters
    ----------
    points : (n, 3) float64
        At least three points, metres.

    Returns
    -------
    Plane
        Plane of least squared distance, its normal towards +z.
    """
    mean, axes, _ = principal_axes(points)
    return Plane(axes[2], float(axes[2] @ mean)).facing(np.array([0.0, 0.0, 1.0]))


def refit_plane(points: Points, plane: Plane, *, reach: float = 0.06, least_reach: float = 0.02) -> tuple[Plane, float]:
    """Robust refit of a plane to the points close to it.

    Parameters
    ----------
    points : (n, 3) float64
        Points, evenly thinned, metres.
    plane : Plane
        First guess.
    reach : float
        Distance of points from the first guess that take part in the first step, metres.
    least_reach : float
        Distance that is never undercut in the next steps, metres; above the spacing of clouds that were thinned to a grid.

    Returns
    -------
    plane : Plane
        Plane of the points within three standard deviations (from the median absolute deviation), repeatedly fitted.
    spread : float
        Standard deviation of these points, metres.
    """
    spread = reach / 3
    points = points.take(np.flatnonzero(np.abs(plane.height(points)) < 10 * reach), axis=0)
    for _ in range(6):
        height = plane.height(points)
        near = np.abs(height) < reach
        if near.sum() < 30:
            break
        spread = float(1.4826 * np.median(np.abs(height[near] - np.median(height[near]))))
        plane = fit_plane(points[near]).facing(plane.normal)
        reach = float(max(least_reach, min(3 * spread, 0.10)))
    return plane, spread


def mean_normal(first: Plane, second: Plane) -> Points:
    """Return the unit normal (3,) of two planes that ought to be parallel, the mean of both (section 2.1, equation 6)."""
    total = first.normal + second.facing(first.normal).normal
    unit: Points = total / np.linalg.norm(total)
    return unit


def rotation_to_z(normal: Points) -> Points:
    """Smallest rotation (3, 3) that takes the unit vector `normal` (3,) to +z.

    Examples
    --------
    >>> np.abs(rotation_to_z(np.array([0.6, 0.0, 0.8])) @ [0.6, 0.0, 0.8]).round(12).tolist()
    [0.0, 0.0, 1.0]
    """
    x, y, z = normal
    if z < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    turn: Points = np.eye(3) + cross + cross @ cross / (1 + z)
    return turn
