"""Rays at an upright plane, counted: the compiled inner loop of `passing_rays`."""

from __future__ import annotations

from numba import types

from indoor_bim.compiled import compiled

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)


@compiled(_points, _points, _values, _values, *[types.float64] * 4, types.bool_)
def count_rays(hits, origins, p, d, length, low, high, near, both_sides):  # type: ignore[no-untyped-def]
    """Rays that meet the plane from p along d between two heights, and those of them that it stopped."""
    met = stopped = 0
    for i in range(len(hits)):
        behind = (hits[i, 1] - p[1]) * d[0] - (hits[i, 0] - p[0]) * d[1]
        before = (origins[i, 1] - p[1]) * d[0] - (origins[i, 0] - p[0]) * d[1]
        crosses = before > near and behind < near
        if not crosses and not (both_sides and before < -near and behind > -near):
            continue
        share = before / (before - (0.0 if before * behind > 0 else behind))
        x = origins[i, 0] + share * (hits[i, 0] - origins[i, 0]) - p[0]
        y = origins[i, 1] + share * (hits[i, 1] - origins[i, 1]) - p[1]
        z = origins[i, 2] + share * (hits[i, 2] - origins[i, 2])
        along = x * d[0] + y * d[1]
        if along > 0 and along < length and z > low and z < high:
            met += 1
            stopped += abs(behind) < near
    return met, stopped
