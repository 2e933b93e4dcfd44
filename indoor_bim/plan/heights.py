"""Heights of wall lines (Remote Sensing 2021, 13, 4930, section 2.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def line_heights(
    midpoints: Floats, xy: Floats, z: Floats, *, radius: float, storey_height: float | None = None, snap: float = 0.15
) -> Floats:
    """Height of each line: the largest height of the wall points near its midpoint (section 2.4).

    Parameters
    ----------
    midpoints : (m, 2) float64
        Midpoints of the lines, metres.
    xy : (n, 2) float64
        Wall points in plan, metres.
    z : (n,) float64
        Their heights above the floor, metres.
    radius : float
        Points within this distance of the midpoint count as near, metres. Where there are none, those as near as the
        nearest one count.
    storey_height : float, optional
        Height of the ceiling above the floor, metres.
    snap : float
        Heights closer than this to `storey_height` become equal to it, metres.

    Returns
    -------
    (m,) float64
        Heights above the floor, metres; NaN without points.

    Examples
    --------
    >>> xy = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    >>> line_heights(np.array([[0.0, 0.01], [0.9, 0.0]]), xy, np.array([0.3, 2.42, 1.0]), radius=0.05, storey_height=2.5).tolist()
    [2.5, 1.0]
    """
    from scipy.spatial import cKDTree

    if not len(xy) or not len(midpoints):
        return np.full(len(midpoints), np.nan)
    tree = cKDTree(xy)
    reach = np.maximum(tree.query(midpoints)[0] * 1.000001, radius)
    near = tree.query_ball_point(midpoints, reach)
    height = np.array([z[rows].max() for rows in near])
    if storey_height is not None:
        height = np.where(np.abs(height - storey_height) < snap, storey_height, height)
    return height
