"""How noisy a scanner is, told by how far points lie from the lines that they were taken on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.polar_fit import PolarLines

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_RANGE_NOISE = 0.0005  # metres: no scanner is better, and no wall flatter
LEAST_RATIO = 0.02  # 1 / metres: bearing noise times this many metres is no less than the range noise over 50
TO_SIGMA = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
ROUNDS = 5


def line_distance(points: Floats, group: Ints, lines: PolarLines) -> Floats:
    """Signed distance (n,) of points (n, 2) from the line of their group (n,), metres; NaN for negative groups."""
    if not len(lines):
        return np.full(len(points), np.nan)
    row = np.maximum(group, 0)
    distance: Floats = (points * lines.normal[row]).sum(axis=1) - lines.radius[row]
    return np.where(group >= 0, distance, np.nan)


def scatter(distance: Floats) -> float:
    """Robust standard deviation of distances (n,), metres; NaN are left out.

    Examples
    --------
    >>> round(scatter(np.array([-0.01, 0.01, 0.01, -0.01, 5.0, np.nan])), 4)
    0.0148
    """
    known = np.abs(distance[np.isfinite(distance)])
    return max(TO_SIGMA * float(np.median(known)), LEAST_RANGE_NOISE) if len(known) else LEAST_RANGE_NOISE


def scanner_noise(points: Floats, scanner: Floats, group: Ints, lines: PolarLines) -> tuple[float, float]:
    """Range and bearing noise that explain the distances of points from their lines.

    The variance of a distance is that of the range times the squared cosine of the angle of incidence, and that of the bearing
    times the squared range times the squared sine: two unknowns, by least squares on what lies within three standard deviations.

    Parameters
    ----------
    points, scanner : (n, 2) float64
        Points, and where the scanner was, metres.
    group : (n,) int64
        Line of each point; negative: none.
    lines : PolarLines
        Lines fitted to them.

    Returns
    -------
    range_noise : float
        Metres.
    bearing_noise : float
        Radians.
    """
    distance = line_distance(points, group, lines)
    on = np.isfinite(distance)
    if on.sum() < 10:
        return LEAST_RANGE_NOISE, LEAST_RANGE_NOISE * LEAST_RATIO
    ray = (points - scanner)[on]
    square = np.maximum((ray**2).sum(axis=1), 1e-6)
    ahead = (ray * lines.normal[group[on]]).sum(axis=1) ** 2
    design = np.column_stack([ahead / square, square - ahead])
    target = distance[on] ** 2
    variance = np.full(len(target), scatter(distance) ** 2)
    of_range, of_bearing = float(variance[0]), 0.0
    for _ in range(ROUNDS):
        near = target < 9 * variance
        weight = near / variance**2  # the variance of a squared normal number is twice its square
        a = (weight[:, None] * design).T @ design
        b = (weight[:, None] * design).T @ target
        determinant = a[0, 0] * a[1, 1] - a[0, 1] ** 2
        if determinant > 1e-12 * a[0, 0] * a[1, 1]:
            of_range = (a[1, 1] * b[0] - a[0, 1] * b[1]) / determinant
            of_bearing = (a[0, 0] * b[1] - a[0, 1] * b[0]) / determinant
        if of_bearing < 0 or determinant <= 0:
            of_range, of_bearing = b[0] / max(a[0, 0], 1e-300), 0.0
        if of_range < 0:
            of_range, of_bearing = 0.0, b[1] / max(a[1, 1], 1e-300)
        variance = np.maximum(design @ np.array([of_range, of_bearing]), LEAST_RANGE_NOISE**2)
    range_noise = max(float(np.sqrt(of_range)), LEAST_RANGE_NOISE)
    return range_noise, max(float(np.sqrt(of_bearing)), LEAST_RATIO * range_noise)
