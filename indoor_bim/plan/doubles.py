"""Faces that were drawn twice: what hangs on a wall, and passes of the scanner that do not agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

PARALLEL_COS = np.cos(np.radians(15.0))  # a double differs less than this in direction
SQUARE_COS = np.cos(np.radians(75.0))  # steeper ones may be the side of something
DEPTH = 0.15  # metres before the wall: pictures, curtains, shelves
BEHIND = 0.06  # metres behind it: as far as passes of the scanner differ
SHORT = 0.35  # metres
COVERED = 0.6  # of its length that a double shares with the wall


def without_doubles(faces: Segments, *, shortest: float = 0.0) -> Segments:
    """Faces without those that lie close before a longer face that looks the same way and goes on behind them.

    Short oblique ones, that the noise of a wall or a curtain makes, are left out whichever way they look.

    Parameters
    ----------
    faces : Segments
        Faces, metres, free space to the left where `sided`.
    shortest : float
        Shorter faces are left out in any case, metres: noise does not let them be told.

    Examples
    --------
    >>> faces = Segments.from_ends([[0, 0], [1, 0.08], [1, 0.3]], [[4, 0], [2, 0.06], [2, 0.3]])
    >>> len(without_doubles(faces))
    2
    """
    keep = faces.length >= shortest
    d, n, length = faces.direction, faces.normal, np.round(faces.length, 6)
    middle = (faces.p + faces.q) / 2
    for k in np.lexsort((faces.p[:, 1], faces.p[:, 0], -length)):
        if not keep[k]:
            continue
        same = np.where(faces.sided & faces.sided[k], d @ d[k], np.abs(d @ d[k])) > PARALLEL_COS
        before = (middle - faces.p[k]) @ n[k]
        if not faces.sided[k]:
            before = np.abs(before)
        along = np.sort(np.stack([(faces.p - faces.p[k]) @ d[k], (faces.q - faces.p[k]) @ d[k]]), axis=0)
        shared = np.minimum(along[1], length[k]) - np.maximum(along[0], 0.0)
        cos = np.abs(d @ d[k])
        oblique = (faces.length < SHORT) & (cos < PARALLEL_COS) & (cos > SQUARE_COS) & (np.abs(before) < DEPTH)
        double = (same & (before < DEPTH) & (before > -BEHIND) | oblique) & (shared >= COVERED * length) & (length < length[k])
        keep &= ~double
    kept: NDArray[np.bool_] = keep
    return faces.take(kept)
