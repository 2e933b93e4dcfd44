"""Where the ground was seen and where something is overhead: what tells outside from inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class GroundSeen:
    """Pixels of the plan, kept as sorted keys, so that a large village costs only where there are points.

    Parameters
    ----------
    ground : (g,) int64
        Keys of the pixels with ground points.
    overhead : (r,) int64
        Keys of the pixels with building points overhead and no ground points.
    pixel : float
        Side of a pixel, metres.
    """

    ground: Ints
    overhead: Ints
    pixel: float

    def is_ground(self, xy: Floats) -> NDArray[np.bool_]:
        """Whether ground was seen at points (n, 2)."""
        return _contains(self.ground, pixel_keys(xy, self.pixel))

    def is_overhead(self, xy: Floats) -> NDArray[np.bool_]:
        """Whether there is something overhead, and no ground, at points (n, 2)."""
        return _contains(self.overhead, pixel_keys(xy, self.pixel))


def see_ground(ground: Floats, overhead: Floats, *, pixel: float = 0.25) -> GroundSeen:
    """Rasterise ground points and points overhead.

    Parameters
    ----------
    ground, overhead : (n, 2) float64
        Points in plan, metres.
    pixel : float
        Side of a pixel, metres.
    """
    below = np.unique(pixel_keys(ground, pixel))
    above = np.setdiff1d(pixel_keys(overhead, pixel), below)
    return GroundSeen(below, above, pixel)


def pixel_keys(xy: Floats, pixel: float) -> Ints:
    """One integer (n,) int64 for the pixel of each point (n, 2)."""
    index = np.floor(np.asarray(xy, dtype=np.float64) / pixel).astype(np.int64)
    key: Ints = index[:, 0] * (1 << 31) + index[:, 1]
    return key


def _contains(keys: Ints, asked: Ints) -> NDArray[np.bool_]:
    if not len(keys):
        return np.zeros(len(asked), dtype=np.bool_)
    place = np.minimum(np.searchsorted(keys, asked), len(keys) - 1)
    found: NDArray[np.bool_] = keys[place] == asked
    return found
