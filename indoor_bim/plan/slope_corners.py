"""End points and corners of slope lines (Remote Sensing 2021, 13, 4930, end of section 2.3, and section 2.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.skeleton import VERTICAL

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SLOPE_DIRECTION = {0: (1.0, 0.0), 1: (np.sqrt(0.5), np.sqrt(0.5)), -1: (np.sqrt(0.5), -np.sqrt(0.5)), VERTICAL: (0.0, 1.0)}
"""Unit vector x, y along the lines of each slope."""


def correct_ends(ends: Floats, midpoint: Floats, slope: Ints) -> Floats:
    """End points moved onto the line through the midpoint (section 2.3, equations 16 to 18, figure 17).

    Slope 0 keeps x and takes the midpoint's y, slope 2 the other way round. For slope k = 1 or -1 the end moves to the foot of
    the perpendicular, ``x' = (x_e + x_0 + (y_e - y_0) / k) / 2`` and ``y' = (y_e + y_0 + k (x_e - x_0)) / 2``. (The paper prints
    2 y_0 for y_e + y_0, which misses points that already lie on the line.)

    Parameters
    ----------
    ends : (m, 2) float64
        Raw end points x, y.
    midpoint : (m, 2) float64
        Means of the pixels of each line (the paper omits the division by their number).
    slope : (m,) int64
        0, 1, -1 or 2 (vertical).

    Returns
    -------
    (m, 2) float64
        New end points.

    Examples
    --------
    >>> correct_ends(np.array([[4.0, 0.0]]), np.array([[1.0, 1.0]]), np.array([1])).tolist()
    [[2.0, 2.0]]
    """
    (xe, ye), (x0, y0) = ends.T, midpoint.T
    k = np.where(np.abs(slope) == 1, slope, 1)
    diagonal = np.column_stack([(xe + x0 + (ye - y0) / k) / 2, (ye + y0 + k * (xe - x0)) / 2])
    horizontal, vertical = np.column_stack([xe, y0]), np.column_stack([x0, ye])
    corrected: Floats = np.where((slope == 0)[:, None], horizontal, np.where((slope == VERTICAL)[:, None], vertical, diagonal))
    return corrected


def join_corners(p: Floats, q: Floats, slope: Ints, *, corner_gap: float) -> tuple[Floats, Floats]:
    """Near end points of lines that are not parallel, moved to the intersection (section 2.4, equation 19).

    For each end point the nearest end point of another line is looked up. If it is closer than `corner_gap` and the lines differ in slope
    (by 90 or 45 degrees), both become the intersection. Close pairs come first; an end point moves once.

    Parameters
    ----------
    p, q : (m, 2) float64
        End points of the lines.
    slope : (m,) int64
        0, 1, -1 or 2 (vertical).
    corner_gap : float
        Distance below which end points become a corner (d_v), in the unit of `p` and `q`.

    Returns
    -------
    p, q : (m, 2) float64
        End points with corners.

    Examples
    --------
    >>> p, q = np.array([[0.0, 0.0], [9.0, 1.0]]), np.array([[8.0, 0.0], [9.0, 7.0]])
    >>> [ends.tolist() for ends in join_corners(p, q, np.array([0, 2]), corner_gap=3)]
    [[[0.0, 0.0], [9.0, 0.0]], [[9.0, 0.0], [9.0, 7.0]]]
    """
    from scipy.spatial import cKDTree

    m = len(p)
    if m < 2:
        return p, q
    ends = np.concatenate([p, q])
    line = np.tile(np.arange(m), 2)
    # of three nearest, one is the end point itself and one may be the other end of its line
    near = cKDTree(ends).query(ends, k=3)[1]
    other = line[near] != line[:, None]
    nearest = near[np.arange(2 * m), other.argmax(axis=1)]
    distance = np.hypot(*(ends - ends[nearest]).T)
    rank = np.lexsort((ends[:, 1], ends[:, 0], distance))
    corners = ends.copy()
    moved = np.zeros(2 * m, dtype=bool)
    k = slope[line]
    for i in rank:
        j = nearest[i]
        if distance[i] >= corner_gap:
            break
        if moved[i] or moved[j] or not other[i].any() or not _are_perpendicular_or_oblique(int(k[i]), int(k[j])):
            continue
        corners[[i, j]] = _intersection(ends[i], int(k[i]), ends[j], int(k[j]))
        moved[[i, j]] = True
    return corners[:m], corners[m:]


def _are_perpendicular_or_oblique(k1: int, k2: int) -> bool:
    return abs(k1 - k2) == 2 or abs(abs(k1) - abs(k2)) == 1


def _intersection(a: Floats, ka: int, b: Floats, kb: int) -> Floats:
    (dx, dy), (ex, ey) = SLOPE_DIRECTION[ka], SLOPE_DIRECTION[kb]
    if {ka, kb} == {0, VERTICAL}:
        return np.array([b[0], a[1]]) if ka == 0 else np.array([a[0], b[1]])
    t = ((b[0] - a[0]) * ey - (b[1] - a[1]) * ex) / (dx * ey - dy * ex)
    return np.array([a[0] + t * dx, a[1] + t * dy])
