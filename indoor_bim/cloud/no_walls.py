"""Clouds that no wall stands in, and how to say so."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.extent import bounds
from indoor_bim.errors import NothingToReconstructError

FLAT = 0.001
"""Extent below which a cloud has no depth, metres."""


def check_depth(points: NDArray[np.float64]) -> None:
    """Refuse clouds without depth along one of the axes.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.

    Raises
    ------
    NothingToReconstructError
        If the points lie in a plane across an axis, or on a line along one.

    Examples
    --------
    >>> check_depth(np.array([[0.0, 0, 0], [4, 3, 0]]))
    Traceback (most recent call last):
    ...
    indoor_bim.errors.NothingToReconstructError: found 2 points in one plane (4.00 x 3.00 x 0.00 m): a cloud in two dimensions; ...
    """
    low, high = bounds(points)
    size = (high - low).tolist()
    flat = sum(extent < FLAT for extent in size)
    if flat:
        shape = "in one plane" if flat == 1 else "on one line"
        raise NothingToReconstructError(
            f"found {len(points)} points {shape} ({' x '.join(f'{extent:.2f}' for extent in size)} m): a cloud in "
            f"{'two dimensions' if flat == 1 else 'one dimension'}; expected walls from floor to ceiling: scan in three dimensions"
        )


def no_walls(points: int, *, floor: bool, ceiling: bool) -> str:
    """Message for a scan of level surfaces only.

    Parameters
    ----------
    points : int
        Number of points.
    floor, ceiling : bool
        Whether they were seen.

    Examples
    --------
    >>> no_walls(9600, floor=False, ceiling=True)
    'found a ceiling and hardly anything else in 9600 points; expected walls: scan them too, at their full height'
    """
    alone = "a floor" if floor else "a ceiling"
    what = "floor and ceiling, but hardly a point between them," if floor == ceiling else f"{alone} and hardly anything else"
    return f"found {what} in {points} points; expected walls: scan them too, at their full height"
