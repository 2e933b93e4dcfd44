"""Faces back to back: between the two faces of a wall nobody sees a floor or a ceiling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]

PARALLEL_COS = np.cos(np.radians(4.0))  # the two faces of a wall differ less than this in direction
LEAST_OVERLAP = 0.3  # metres that two faces share at least
LEAST_OUTSIDE = 0.06  # metres beyond a face: nearer than this the scan's noise blurs what is seen
EMPTY = 0.3  # of the points outside: fewer in the gap, and it is inside a wall


def turn_back_to_back(faces: Segments, seen: Raster, *, min_thickness: float = 0.05, max_thickness: float = 0.60) -> Segments:
    """Turn parallel faces away from each other where the gap between them is inside a wall.

    A gap is inside a wall when its middle holds far fewer points of floor and ceiling than the room on either side of it.
    Thin walls need this: what is seen a hand's breadth from one face may already belong to the next room.

    Parameters
    ----------
    faces : Segments
        Faces, metres.
    seen : Raster
        Number of points of floor and ceiling in each (small) pixel.
    min_thickness, max_thickness : float
        Bounds of a wall's thickness, metres.

    Returns
    -------
    Segments
        The same rows; faces of walls found this way are sided, free space to the left of p -> q.
    """
    p, q, sided = faces.p.copy(), faces.q.copy(), faces.sided.copy()
    d, n, length = faces.direction, faces.normal, faces.length
    nearest = np.full(len(faces), np.inf)
    for i in range(len(faces)):
        offset = (faces.p - faces.p[i]) @ n[i]
        ends = np.sort(np.stack([(faces.p - faces.p[i]) @ d[i], (faces.q - faces.p[i]) @ d[i]]), axis=0)
        start, end = np.maximum(ends[0], 0.0), np.minimum(ends[1], length[i])
        near = (np.abs(d @ d[i]) > PARALLEL_COS) & (np.abs(offset) >= min_thickness) & (np.abs(offset) <= max_thickness)
        for j in np.flatnonzero(near & (end - start >= LEAST_OVERLAP)):
            gap = float(offset[j])
            if abs(gap) >= nearest[i] or not _inside_wall(faces.p[i], d[i], n[i], (start[j], end[j]), gap, seen):
                continue
            nearest[i], sided[i] = abs(gap), True
            material_left = gap > 0
            p[i], q[i] = (faces.q[i], faces.p[i]) if material_left else (faces.p[i], faces.q[i])
    return replace(faces, p=p, q=q, sided=sided)


def _inside_wall(p: Floats, d: Floats, n: Floats, span: tuple[float, float], gap: float, seen: Raster) -> bool:
    """Tell whether the gap beside a line is emptier than what lies beyond its two faces."""
    along = p + np.arange(span[0], span[1], seen.cell)[:, None] * d
    beyond = np.copysign(max(abs(gap) / 2, LEAST_OUTSIDE), gap)
    between = sum(seen.sample(along + share * gap * n).mean() for share in (0.4, 0.5, 0.6)) / 3
    outside = max(seen.sample(along + step * n).mean() for step in (-beyond, gap + beyond))
    return bool(outside > 0 and between <= EMPTY * outside)
