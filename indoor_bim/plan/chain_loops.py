"""Chains of points simplified: the compiled inner loop of `free_borders`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled


@compiled(types.Array(types.float64, 2, "C", readonly=True), types.float64)
def corners_of(chain, tolerance):  # type: ignore[no-untyped-def]
    """Which points of a chain (n, 2) stay so that no other is farther than the tolerance from the line between its neighbours.

    References
    ----------
    Douglas, Peucker, Algorithms for the reduction of the number of points required to represent a digitized line, 1973; distances as in
    `skimage.measure.approximate_polygon`.
    """
    stays = np.zeros(len(chain), np.bool_)
    stays[0] = stays[-1] = True
    stack = [(0, len(chain) - 1)]
    while len(stack):
        start, end = stack.pop()
        r0, c0, r1, c1 = chain[start, 0], chain[start, 1], chain[end, 0], chain[end, 1]
        turn = -np.arctan2(r1 - r0, c1 - c0)
        cos, sin = np.cos(turn), np.sin(turn)
        offset = c0 * sin + r0 * cos
        farthest, largest = start, tolerance
        for k in range(start + 1, end):
            r, c = chain[k, 0], chain[k, 1]
            ahead = (r - r0) * (r1 - r0) + (c - c0) * (c1 - c0)
            back = -(r - r1) * (r1 - r0) - (c - c1) * (c1 - c0)
            if ahead > 0 and back > 0:
                away = abs(r * cos + c * sin - offset)
            else:
                away = min(np.sqrt((c - c0) ** 2 + (r - r0) ** 2), np.sqrt((c - c1) ** 2 + (r - r1) ** 2))
            if away > largest:
                farthest, largest = k, away
        if farthest > start:
            stays[farthest] = True
            stack.append((start, farthest))
            stack.append((farthest, end))
    return stays
