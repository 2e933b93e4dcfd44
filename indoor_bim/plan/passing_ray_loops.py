"""Rays at an upright plane, counted: the compiled inner loops of `passing_rays`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_boxes, _fixed_boxes = types.Array(types.float64, 2, "C"), _points

BLOCK = 128
"""Rays that lie in one box: those that a scanner measured one after another keep together."""
ROUNDING = 1e-6
"""Metres by which boxes are wider, so that no rounding loses a ray."""


@compiled(_points, _points, _boxes)
def boxes_around(hits, origins, boxes):  # type: ignore[no-untyped-def]
    """Lowest x and y, highest x and y of every `BLOCK` rays."""
    for block in range(len(boxes)):
        left = bottom = np.inf
        right = top = -np.inf
        for i in range(block * BLOCK, min((block + 1) * BLOCK, len(hits))):
            left, right = min(left, hits[i, 0], origins[i, 0]), max(right, hits[i, 0], origins[i, 0])
            bottom, top = min(bottom, hits[i, 1], origins[i, 1]), max(top, hits[i, 1], origins[i, 1])
        boxes[block, 0], boxes[block, 1], boxes[block, 2], boxes[block, 3] = left, bottom, right, top


@compiled(_points, _points, _fixed_boxes, _values, _values, *[types.float64] * 4, types.bool_, types.float64)
def count_rays(hits, origins, boxes, p, d, length, low, high, near, both_sides, enough):  # type: ignore[no-untyped-def]
    """Rays that meet the plane from p along d between two heights, and those of them that it stopped; no more once `enough` pass."""
    met = stopped = 0
    margin = near + ROUNDING
    left, right = min(p[0], p[0] + length * d[0]) - margin, max(p[0], p[0] + length * d[0]) + margin
    bottom, top = min(p[1], p[1] + length * d[1]) - margin, max(p[1], p[1] + length * d[1]) + margin
    for block in range(len(boxes)):
        if boxes[block, 0] > right or boxes[block, 2] < left or boxes[block, 1] > top or boxes[block, 3] < bottom:
            continue
        for i in range(block * BLOCK, min((block + 1) * BLOCK, len(hits))):
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
        if met - stopped > enough:
            break
    return met, stopped
