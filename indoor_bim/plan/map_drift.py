"""Doubled faces: what a map that drifted shows twice, a few centimetres apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]

APART = (0.025, 0.07)
"""Distance between the two images of a face, metres; nearer, they are one."""
COLUMN = 0.10
"""Width of the columns in which both are looked for, metres."""
SHORTEST = 1.5
"""Length along which both show at least, metres."""
UPRIGHT = 0.5
"""Share of the height above which points count: below, furniture stands close to walls."""
FEWEST = 3
"""Points of an image in a column at least."""
SHARE = 0.25
"""The fewer of the points of both images in a column are this share of the more at least."""
TURN = 1.5
"""Largest angle between the images, degrees."""


def largest_double(lines: FaceLines, points: WallPoints) -> float:
    """Largest distance between two images of one face, metres; 0 where no face shows twice.

    A face hides what is behind it. Where two that look the same way show at one place a few centimetres apart, they are one
    face, seen at two times by a scanner whose position had drifted in between. Steps in a face of up to that much tell nothing then.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    points : WallPoints
        Candidates.
    """
    direction, normal = lines.direction, lines.normal
    tails, heads = lines.ends()
    largest = 0.0
    for k in range(len(lines)):
        d, n = direction[k], normal[k]
        first, last = (tails - tails[k]) @ d, (heads - tails[k]) @ d
        length = float(lines.end[k] - lines.start[k])
        low, high = np.maximum(first, 0.0), np.minimum(last, length)
        same = (direction @ d > np.cos(np.radians(TURN))) & (high - low >= SHORTEST)
        for j in np.flatnonzero(same):
            cross = float(direction[j] @ n) / float(direction[j] @ d)
            before = float((tails[j] - tails[k]) @ n) + cross * ((low[j] + high[j]) / 2 - float(first[j]))
            if (
                APART[0] < before < APART[1]
                and before > largest
                and _both_show(lines, k, float(low[j]), float(high[j]), before, cross, points)
            ):
                largest = before
    return largest


def _both_show(lines: FaceLines, k: int, low: float, high: float, before: float, cross: float, points: WallPoints) -> bool:
    """Whether points lie on line k and on one that far before it, side by side."""
    d, n = lines.direction[k], lines.normal[k]
    foot = lines.offset[k] * n + lines.start[k] * d
    ranges = points.along(foot + low * d, foot + high * d, APART[1])
    rows = np.concatenate([np.arange(0), *(np.arange(*ends) for ends in ranges)])
    rows = rows[points.rise[rows] > UPRIGHT]
    away = points.xy[rows] - foot
    along, across = away @ d, away @ n
    inside = (along >= low) & (along < high)
    column = ((along[inside] - low) / COLUMN).astype(np.int64)
    other = before + cross * (along[inside] - (low + high) / 2)
    half = before / 3
    count = int(np.ceil((high - low) / COLUMN))
    on = [np.bincount(column[np.abs(across[inside] - level) < half], minlength=count)[:count] for level in (0.0, other)]
    fewer, more = np.minimum(*on), np.maximum(*on)
    both = (fewer >= FEWEST) & (fewer >= SHARE * more)
    return bool(both.sum() * COLUMN >= SHORTEST)
