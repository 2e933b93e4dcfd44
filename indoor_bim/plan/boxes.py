"""Wardrobes up to the ceiling: boxes before a wall that goes on behind them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]

PARALLEL_COS = np.cos(np.radians(4.0))
IN_LINE = 0.05  # metres that the parts of the wall on both sides differ by across
WIDTH = (0.3, 2.7)  # metres
DEPTH = (0.35, 0.75)  # metres: what stands out less is a pilaster
LEAST_FRONT = 0.5  # of the width
SLACK = 0.10  # metres


def without_boxes(faces: Segments) -> Segments:
    """Faces without the fronts and sides of boxes as deep as furniture between two parts of one wall.

    Parameters
    ----------
    faces : Segments
        Faces, metres, free space to the left where `sided`.

    Examples
    --------
    >>> from dataclasses import replace
    >>> corners = [[0, 0], [2, 0], [2, 0.6], [3.4, 0.6], [3.4, 0], [6, 0]]
    >>> wall_and_box = Segments.from_ends(corners[:-1], corners[1:])
    >>> len(without_boxes(replace(wall_and_box, sided=np.ones(5, dtype=bool))))
    2
    """
    keep = np.ones(len(faces), dtype=bool)
    d, n = faces.direction, faces.normal
    for a in np.flatnonzero(faces.sided):
        same = faces.sided & (d @ d[a] > PARALLEL_COS)
        starts, ends = (faces.p - faces.q[a]) @ d[a], (faces.q - faces.q[a]) @ d[a]
        across_p, across_q = (faces.p - faces.q[a]) @ n[a], (faces.q - faces.q[a]) @ n[a]
        goes_on = same & (np.abs(across_p) <= IN_LINE) & (starts >= WIDTH[0]) & (starts <= WIDTH[1])
        goes_on[a] = False
        if not goes_on.any():
            continue
        width = float(starts[goes_on].min())
        within = (np.minimum(starts, ends) > -SLACK) & (np.maximum(starts, ends) < width + SLACK)
        front = within & same & (across_p >= DEPTH[0]) & (across_p <= DEPTH[1]) & (ends - starts >= LEAST_FRONT * width)
        if not front.any():
            continue
        deep = float(across_p[front].max()) + SLACK
        box = within & (np.minimum(across_p, across_q) > -SLACK) & (np.maximum(across_p, across_q) < deep)
        box &= ~(same & (np.abs(across_p) <= IN_LINE))
        keep &= ~box
    return faces.take(keep)
