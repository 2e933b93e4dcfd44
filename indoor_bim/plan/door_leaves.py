"""Leaves of open doors: upright planes that stand at a jamb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from indoor_bim.plan.wall_points import PointsAround

THICKEST = 0.06  # metres: half the thickness of a leaf and the error of its points
NARROWEST, WIDEST = 0.55, 1.25  # metres
HINGE_SLACK = 0.12  # metres between the jamb and the pivot of the leaf
ANGLES = np.radians(np.arange(40.0, 156.0, 5.0))  # from closed; leaves that are nearer to the wall cannot be told from it
PATCH = 0.10  # metres
SLACK = 0.30  # metres: what a leaf is looked for beyond its length, to see that it ends
NEAREST = 0.15  # metres from the pivot: where hits may be on the jamb
FILLED = 0.40  # share of the patches of a leaf that are hit at least
LOW, HIGH = 0.30, 1.80  # metres above the floor: what every leaf covers


@dataclass(frozen=True, slots=True)
class Leaf:
    """Open leaf.

    Parameters
    ----------
    hinge : {"start", "end"}
        Jamb that it hangs on.
    swing : {"left", "right"}
        Side of the wall axis that it opens to.
    filled : float
        Share of it that was hit.
    """

    hinge: Literal["start", "end"]
    swing: Literal["left", "right"]
    filled: float


def find_leaves(around: PointsAround, *, start: float, end: float, thickness: float) -> tuple[Leaf, ...]:
    """Leaves of a door: one at either jamb, or two that share the width.

    Parameters
    ----------
    around : PointsAround
        Points around the wall.
    start, end : float
        Jambs, metres along the axis.
    thickness : float
        Thickness of the wall, metres.
    """
    from indoor_bim.plan.opening_loops import best_fill

    width = end - start
    along, across, up = around.within(start - WIDEST, end + WIDEST, LOW, HIGH)
    directions = (np.cos(ANGLES), np.sin(ANGLES))
    found: list[tuple[float, Leaf]] = []
    for swing, sign in (("left", 1.0), ("right", -1.0)):
        beyond = across * sign - thickness / 2
        ahead = np.flatnonzero(beyond > 2 * THICKEST)
        for hinge, jamb, inward in (("start", start, 1.0), ("end", end, -1.0)):
            x, y, z = (along.take(ahead) - jamb) * inward, beyond.take(ahead), up.take(ahead)
            for share in (1, 2) if width > 2 * NARROWEST else (1,):
                if not NARROWEST <= width / share <= WIDEST + HINGE_SLACK:
                    continue
                filled = best_fill(x, y, z, width / share, SLACK, HINGE_SLACK / 2, *directions, THICKEST, PATCH, NEAREST, LOW, HIGH)
                if filled >= FILLED:
                    found.append((filled / share, Leaf(hinge, swing, filled)))  # type: ignore[arg-type]
    if not found:
        return ()
    best = max(found, key=lambda item: (item[0], item[1].hinge, item[1].swing))[1]
    others = [leaf for _, leaf in found if leaf.swing == best.swing and leaf.hinge != best.hinge]
    if width > 2 * NARROWEST and others:
        return (best, max(others, key=lambda leaf: leaf.filled))
    return (best,)
