"""What hangs or stands close before a face: curtains, leaves, and the doubles of a map that drifts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

CLOSE = (0.035, 0.13)
"""Mean distance of what hangs before a face, metres; nearer, it is the face itself."""
LONGEST = 3.0
"""Length of the longest curtain, metres."""
TIMES = 2.5
"""How many times longer the face is at least."""
GAP = 1.5
"""Longest stretch between two pieces of the face, metres."""
SKEW = (1.0, 8.0)
"""Angle between a face and what is askew before it, degrees."""


def hangings(lines: FaceLines, evidence: Callable[[int, float, float], Floats], *, shown: float = 0.35, share: float = 0.3) -> Bools:
    """Lines close before a longer face that goes on behind them, and either askew to it or with the face showing past them.

    Pilasters stay: they are parallel to their wall, and nothing of the wall shows behind them. So do walls that are askew: no
    longer face runs along behind them.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    evidence : callable
        Wall evidence along a line (row, start, end), values from 0 to 1 at even steps.
    shown : float
        Evidence from which a face shows.
    share : float
        Share of a line past which the face shows at least.

    Returns
    -------
    (m,) bool
        One value for each line.
    """
    length = lines.end - lines.start
    tails, heads = lines.ends()
    found = np.zeros(len(lines), dtype=bool)
    for k in np.flatnonzero(length < LONGEST):
        d, n = lines.direction[k], lines.normal[k]
        same = lines.direction @ d > np.cos(np.radians(SKEW[1]))
        first, last = (tails - tails[k]) @ d, (heads - tails[k]) @ d
        middle = (np.maximum(first, 0.0) + np.minimum(last, length[k])) / 2
        place = tails[k] + middle[:, None] * d
        before = (place * lines.normal).sum(axis=1) - lines.offset
        behind = np.flatnonzero(same & (first < length[k]) & (last > 0) & (before > CLOSE[0]) & (before < CLOSE[1]) & (length > 1.0))
        if not len(behind) or not _covers(first[behind], last[behind], float(length[k])):
            continue
        face = int(behind[np.lexsort((lines.offset[behind], -length[behind]))[0]])
        if length[face] < TIMES * length[k]:
            continue
        turn = np.degrees(np.arcsin(abs(float(lines.direction[face] @ n))))
        along = np.sort([tails[k] @ lines.direction[face], heads[k] @ lines.direction[face]])
        seen = float((evidence(face, float(along[0]), float(along[1])) > shown).mean())
        found[k] = turn > SKEW[0] or seen >= share
    return found


def _covers(first: Floats, last: Floats, length: float) -> bool:
    """Whether intervals cover the stretch from 0 to `length` with no gap that is too long, its ends within a few centimetres."""
    order = np.argsort(first, kind="stable")
    reached = np.maximum.accumulate(last[order])
    gaps = first[order][1:] - reached[:-1]
    return bool(first.min() < 0.05 and reached[-1] > length - 0.05 and (gaps < GAP).all())
