"""Means and moments of groups of points: the compiled inner loop of `overhead.overhead_surface`."""

from __future__ import annotations

from numba import types

from indoor_bim.compiled import compiled

_points = types.Array(types.float64, 2, "C", readonly=True)
_groups = types.Array(types.int64, 1, "C", readonly=True)
_table = types.Array(types.float64, 2, "C")


@compiled(_points, _groups, _groups, _table, _table)
def central_moments(points, group, count, means, moments):  # type: ignore[no-untyped-def]
    """Mean of the points of each group, and the means of xx, yy, xy, zz, xz, yz about it."""
    for i in range(len(points)):
        for axis in range(3):
            means[group[i], axis] += points[i, axis]
    for k in range(len(count)):
        for axis in range(3):
            means[k, axis] /= count[k]
    for i in range(len(points)):
        mean, row = means[group[i]], moments[group[i]]
        x, y, z = points[i, 0] - mean[0], points[i, 1] - mean[1], points[i, 2] - mean[2]
        row[0] += x * x
        row[1] += y * y
        row[2] += x * y
        row[3] += z * z
        row[4] += x * z
        row[5] += y * z
    for k in range(len(count)):
        for column in range(6):
            moments[k, column] /= count[k]
