"""Points too near to the scanner or too far from it are no walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NEAREST = 0.4  # metres: nearer things are carried along with the scanner, or stand on its tripod
USUAL_SHARE = 0.99  # of the points: ranges up to this quantile are those of the rooms
BEYOND = 1.5  # times as far: what is still farther was seen through windows


def ranges(points: Floats, scanner: Floats) -> Floats:
    """Distance (n,) of points (n, 3) from the scanner (n, 3) at the time of each, metres."""
    metres: Floats = np.sqrt(((points - scanner) ** 2).sum(axis=1))
    return metres


def within_range(distance: Floats, *, nearest: float | None = None, farthest: float | None = None) -> NDArray[np.bool_]:
    """Points that are neither too near to the scanner nor too far from it (section 1.2, step 2).

    Parameters
    ----------
    distance : (n,) float64
        Distance of each point from the scanner, metres.
    nearest : float, optional
        Least distance, metres; None: `NEAREST`.
    farthest : float, optional
        Largest distance, metres; None: `BEYOND` times what `USUAL_SHARE` of the points keep within.

    Returns
    -------
    (n,) bool

    Examples
    --------
    >>> within_range(np.array([0.2, 3.0, 4.0, 90.0]), farthest=20.0).tolist()
    [False, True, True, False]
    """
    if not len(distance):
        return np.zeros(0, dtype=bool)
    least = NEAREST if nearest is None else nearest
    most = BEYOND * float(np.quantile(distance, USUAL_SHARE)) if farthest is None else farthest
    return (distance >= least) & (distance <= most)
