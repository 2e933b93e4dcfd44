"""Points on circles: the compiled inner loops of `arc_fit.circle_through` and `arcs`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

TUKEY = 4.685
"""Tukey's constant: 95 % efficiency where there are no outliers."""
LEAST = 1e-9
"""What is added to the weight of each unknown, so that there is always a solution; distances are no smaller, metres."""
STILL = 1e-7
"""Steps below which nothing changes any more, metres."""

_values = types.Array(types.float64, 1, "A", readonly=True)
_rows = types.Array(types.float64, 2, "C", readonly=True)
_fitted, _normal = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
_marks = types.Array(types.boolean, 2, "C")


@compiled(_values, _values, types.int64, types.float64, _fitted, _normal)
def fit_circle(x, y, rounds, finest, circle, normal):  # type: ignore[no-untyped-def]
    """Move a circle (centre and radius) onto points by steps of Gauss and Newton; write the normal equations, return the deviation."""
    count = len(x)
    residual, distance = np.zeros(count), np.zeros(count)
    right = np.zeros(3)
    sigma = finest
    for _ in range(rounds):
        for i in range(count):
            distance[i] = np.sqrt((x[i] - circle[0]) ** 2 + (y[i] - circle[1]) ** 2)
            residual[i] = distance[i] - circle[2]
        sigma = max(1.4826 * np.median(np.abs(residual)), finest)
        xx = xy = yy = xr = yr = rr = 0.0
        right[:] = 0.0
        for i in range(count):
            weight = max(1 - (residual[i] / (TUKEY * sigma)) ** 2, 0.0) ** 2
            away = max(distance[i], LEAST)
            to_x, to_y = (x[i] - circle[0]) / away, (y[i] - circle[1]) / away
            xx, xy, yy = xx + weight * to_x * to_x, xy + weight * to_x * to_y, yy + weight * to_y * to_y
            xr, yr, rr = xr + weight * to_x, yr + weight * to_y, rr + weight
            right[0] += weight * to_x * residual[i]
            right[1] += weight * to_y * residual[i]
            right[2] += weight * residual[i]
        normal[0, 0], normal[1, 1], normal[2, 2] = xx + LEAST, yy + LEAST, rr + LEAST
        normal[0, 1] = normal[1, 0] = xy
        normal[0, 2] = normal[2, 0] = xr
        normal[1, 2] = normal[2, 1] = yr
        step = np.linalg.solve(normal, right)
        circle += step
        if np.abs(step).max() < STILL:
            break
    return sigma


@compiled(_rows, _rows, _rows, types.float64, types.float64, _marks)
def mark_on_circles(xy, tangent, circles, across, slope, on):  # type: ignore[no-untyped-def]
    """Mark for each circle (centre and radius) the spots that lie on it, and whose tangent has no more than this slope to it."""
    for k in range(len(circles)):
        for i in range(len(xy)):
            x, y = xy[i, 0] - circles[k, 0], xy[i, 1] - circles[k, 1]
            distance = np.sqrt(x * x + y * y)
            off = abs(x * tangent[i, 0] + y * tangent[i, 1])
            on[k, i] = (abs(distance - circles[k, 2]) < across) & (off < slope * distance)
