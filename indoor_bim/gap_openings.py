"""Gaps of contours put into the walls of the model as openings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from indoor_bim.model import Evidence, Opening, Storey, Wall
from indoor_bim.plan.contour_gaps import ContourGap

DECIMALS = 4  # tenths of a millimetre
PROOF = 0.6  # confidence of a gap with all its edges: that rays went through it is not known
BESIDE = 0.10  # metres beside the body of a wall that its faces may lie at
NARROWEST = 0.4  # metres
NO_LINTEL = 0.05  # metres below the ceiling


def with_gap_openings(
    storey: Storey,
    gaps: Sequence[ContourGap],
    *,
    min_confidence: float = 0.4,
    min_door_width: float = 0.6,
    max_door_width: float = 2.5,
    min_door_height: float = 1.8,
    max_door_height: float = 2.6,
) -> Storey:
    """Storey whose walls have the gaps of its contour as openings where they have none yet.

    A gap down to the floor of the size of a door is a door, one that begins higher a window, the rest are openings. Gaps that
    something stands before are left out: the wall may go on behind it.

    Parameters
    ----------
    storey : Storey
        Storey with walls.
    gaps : sequence of ContourGap
        Gaps, metres.
    min_confidence : float
        Openings that are less certain are left out.
    min_door_width, max_door_width, min_door_height, max_door_height : float
        Bounds of doors, metres.
    """
    number = {kind: sum(o.kind == kind for wall in storey.walls for o in wall.openings) for kind in ("door", "window", "opening")}
    walls = {wall.id: wall for wall in storey.walls}
    for gap in sorted(gaps, key=lambda gap: (-gap.edges, gap.p, gap.q)):
        confidence = round(PROOF * gap.edges, 3)
        host = None if gap.hidden or confidence < min_confidence else _host(list(walls.values()), gap)
        if host is None:
            continue
        wall, start, end = host
        kind: Literal["door", "window", "opening"] = "window" if gap.bottom > 0 else "opening"
        is_door = min_door_width <= end - start <= max_door_width and min_door_height <= gap.top <= max_door_height
        if gap.bottom == 0 and is_door and gap.top < wall.height - NO_LINTEL:
            kind = "door"
        number[kind] += 1
        opening = Opening(
            id=f"{storey.id}-{kind.capitalize()}{number[kind]}",
            name=f"{kind.capitalize()} {number[kind]}",
            kind=kind,
            start=round(start, DECIMALS),
            width=round(end - start, DECIMALS),
            sill=round(gap.bottom, DECIMALS),
            height=round(min(gap.top, wall.height) - gap.bottom, DECIMALS),
            leaves=1 if kind == "door" else 0,
            confidence=confidence,
            evidence=Evidence(coverage=round(gap.edges, 3), sides=1),
        )
        if opening.height > 0:
            walls[wall.id] = replace(wall, openings=tuple(sorted([*wall.openings, opening], key=lambda o: (o.start, o.sill))))
    return replace(storey, walls=tuple(walls[wall.id] for wall in storey.walls))


def _host(walls: Sequence[Wall], gap: ContourGap) -> tuple[Wall, float, float] | None:
    """Wall that a gap is in, and where along it; None where there is none, or an opening already."""
    ends = np.array([gap.p, gap.q])
    best: tuple[float, str, Wall, float, float] | None = None
    for wall in walls:
        p, q = np.array(wall.axis)
        d = (q - p) / max(wall.length, 1e-9)
        along = np.sort((ends - p) @ d)
        across = np.abs((ends - p) @ np.array([-d[1], d[0]])).max()
        start, end = max(float(along[0]), 0.0), min(float(along[1]), wall.length)
        if across > wall.thickness / 2 + BESIDE or end - start < max(NARROWEST, 0.8 * float(np.ptp(along))):
            continue
        if best is None or (across, wall.id) < best[:2]:
            best = (float(across), wall.id, wall, start, end)
    if best is None or any(o.start < best[4] and o.start + o.width > best[3] for o in best[2].openings):
        return None
    return best[2:]
