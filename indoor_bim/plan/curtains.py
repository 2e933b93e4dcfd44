"""Walls behind curtains: a flat thing close before a wall hides it, but does not bend it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]

PARALLEL_COS = np.cos(np.radians(5.0))
END_SLACK = 0.20  # metres that a curtain's end and the wall's visible end differ by at most
LEAST_COVER = 0.6  # share of the gap in the wall that the curtain covers at least


def draw_curtains(
    faces: Segments, *, depth: float = 0.15, offset_tolerance: float = 0.03, soft: NDArray[np.bool_] | None = None
) -> Segments:
    """Replace faces that hang close before a wall by the wall behind them.

    A face hangs before a wall when faces looking the same way go on at both of its ends, in one line with each other and no more
    than `depth` behind it.

    Parameters
    ----------
    faces : Segments
        Faces, metres. A curtain need not be sided, the wall behind it must be.
    depth : float
        Largest distance of a curtain from the wall, metres.
    offset_tolerance : float
        The two visible parts of the wall are in line within this, metres.
    soft : (m,) bool, optional
        Faces that may be curtains; None: all.

    Returns
    -------
    Segments
        Faces without curtains; the wall behind each is a face without support.
    """
    out, changed = faces, True
    while changed:
        changed = False
        for c in np.lexsort((np.arange(len(out)), -np.round(out.length, 6))):
            if soft is not None and not soft[c]:
                continue
            sides = _wall_behind(out, int(c), depth=depth, offset_tolerance=offset_tolerance)
            if sides is not None:
                out, changed = _replaced(out, int(c), *sides), True
                break
    return out


def _wall_behind(faces: Segments, c: int, *, depth: float, offset_tolerance: float) -> tuple[int, int] | None:
    """Rows of the visible wall before the start and after the end of a curtain."""
    ways = [(faces.p[c], faces.direction[c])] + ([] if faces.sided[c] else [(faces.q[c], -faces.direction[c])])
    found = (_neighbours(faces, p, d, float(faces.length[c]), depth=depth, offset_tolerance=offset_tolerance) for p, d in ways)
    return next((rows for rows in found if rows is not None), None)


def _neighbours(faces: Segments, p: Floats, d: Floats, length: float, *, depth: float, offset_tolerance: float) -> tuple[int, int] | None:
    """Rows of the faces that go on before and after the curtain that starts in `p` and runs along `d`."""
    n = np.array([-d[1], d[0]])
    behind = -((faces.p + faces.q) / 2 - p) @ n
    usable = faces.sided & (faces.direction @ d > PARALLEL_COS) & (behind > offset_tolerance) & (behind <= depth)
    start, end = (faces.p - p) @ d, (faces.q - p) @ d
    before = np.flatnonzero(usable & (end < END_SLACK) & (end > -END_SLACK - (1 / LEAST_COVER - 1) * length))
    after = np.flatnonzero(usable & (start > length - END_SLACK) & (start < END_SLACK + length / LEAST_COVER))
    best: tuple[float, int, int] | None = None
    for a in before:
        for b in after:
            gap = float(start[b] - end[a])
            in_line = abs((faces.p[b] - faces.q[a]) @ faces.normal[a]) <= offset_tolerance
            if in_line and gap > 0 and LEAST_COVER * gap <= length and (best is None or gap < best[0]):
                best = (gap, int(a), int(b))
    return None if best is None else best[1:]


def _replaced(faces: Segments, c: int, a: int, b: int) -> Segments:
    """Faces with the curtain's row moved back to close the gap between its neighbours."""
    p, q, sided = faces.p.copy(), faces.q.copy(), faces.sided.copy()
    support, rmse, coverage = faces.support.copy(), faces.rmse.copy(), faces.coverage.copy()
    p[c], q[c], sided[c] = faces.q[a], faces.p[b], True
    support[c], rmse[c], coverage[c] = 0, np.nan, 0.0
    return replace(faces, p=p, q=q, sided=sided, support=support, rmse=rmse, coverage=coverage)
