"""Drift of a mapped path: small, smooth errors of position and heading that grow and shrink over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

_KNOT_SECONDS = 6.0


@dataclass(frozen=True, slots=True, eq=False)
class Drift:
    """Pose error over time, between knots by cubic splines.

    Parameters
    ----------
    knots : (k,) float64
        Times, seconds.
    error : (k, 4) float64
        Error of x, y, z in metres and of the heading in radians at each knot.
    """

    knots: Points
    error: Points

    @classmethod
    def draw(cls, duration: float, *, position: float, yaw: float, rng: np.random.Generator) -> Self:
        """Random walk held at its mean, scaled to given root mean square errors; heights drift half as much.

        Parameters
        ----------
        duration : float
            Length of the walk, seconds.
        position, yaw : float
            Root mean square error of x and y in metres, and of the heading in degrees.
        rng : numpy.random.Generator
            Draws the steps.
        """
        knots = np.linspace(0.0, duration, max(4, int(duration / _KNOT_SECONDS) + 1))
        walk = np.cumsum(rng.standard_normal((len(knots), 4)), axis=0)
        walk -= walk.mean(axis=0)
        walk /= np.sqrt(np.mean(walk**2, axis=0))
        return cls(knots, walk * [position, position, position / 2, np.radians(yaw)])

    def apply(self, time: Points, origin: Points, ray: Points) -> Points:
        """Points (n, 3) as mapped: `ray` (n, 3) turned and set on `origin` (n, 3) moved by the error at `time` (n,)."""
        from scipy.interpolate import CubicSpline

        error = CubicSpline(self.knots, self.error)(time)
        cos, sin = np.cos(error[:, 3]), np.sin(error[:, 3])
        turned = np.column_stack([cos * ray[:, 0] - sin * ray[:, 1], sin * ray[:, 0] + cos * ray[:, 1], ray[:, 2]])
        return np.asarray(origin + error[:, :3] + turned)


def best_rigid_fit(moved: Points, fixed: Points) -> tuple[Points, Points]:
    """Turn about the vertical (3, 3) and shift (3,) that take `moved` (n, 3) to `fixed` (n, 3) with least squares.

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> turn, shift = best_rigid_fit(square + [1, 2, 3], square)
    >>> (turn @ (square[2] + [1, 2, 3]) + shift).round(9).tolist()
    [2.0, 2.0, 0.0]
    """
    a, b = moved - moved.mean(axis=0), fixed - fixed.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    return turn, fixed.mean(axis=0) - turn @ moved.mean(axis=0)
