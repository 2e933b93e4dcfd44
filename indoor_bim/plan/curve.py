"""A curved wall: the circle that its faces lie on, cut into straight pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

THINNEST, THICKEST = 0.05, 0.60
"""Distances between the faces of a wall, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Circle that the faces of a curved wall lie on.

    Parameters
    ----------
    centre : (2,) float64
        Centre, metres.
    radii : tuple of float
        Radius of each face that was seen, metres.
    start, end : float
        Angles of the ends seen from the centre, counter-clockwise, radians.
    radius_sigma : float
        Standard deviation of the radius, metres.
    deviation : float
        Distance from the circle that 95 % of the local medians of the points keep to, metres.
    pieces : int
        Number of equal pieces between the ends.
    """

    centre: Floats
    radii: tuple[float, ...]
    start: float
    end: float
    radius_sigma: float
    deviation: float
    pieces: int

    @property
    def breaks(self) -> Floats:
        """(pieces + 1,) angles of the ends of all pieces, radians."""
        angles: Floats = np.linspace(self.start, self.end, self.pieces + 1)
        return angles

    @property
    def closed(self) -> bool:
        """Whether it is a whole circle."""
        return self.end - self.start > 2 * np.pi - 1e-9

    def chord_distance(self, radius: float) -> float:
        """Distance from the centre of the straight pieces that explain the points of an arc best, metres."""
        half = (self.end - self.start) / self.pieces / 2
        return float(radius * np.sin(half) / half)
