"""Lines that continue one another become one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]
Line = tuple[float, float, float, float]

APART = 0.035
"""Largest step from one piece of a line to the next, metres, where the map did not drift."""


def merge_lines(lines: FaceLines, *, gap: float = 4.0, apart: float = APART, turn: float = 1.5) -> FaceLines:
    """Lines that continue one another, in the same direction and seen from the same side, become one.

    Parameters
    ----------
    lines : FaceLines
        Lines of all sweeps.
    gap : float
        Longest gap between two pieces of one line, metres.
    apart : float
        Largest distance across between the pieces where they come closest, metres.
    turn : float
        Largest angle between long pieces, degrees; short ones may turn by what `apart` allows over their length.
    """
    from indoor_bim.plan.merging_loops import first_pair

    order = np.lexsort((lines.start, lines.offset, -np.round(lines.end - lines.start, 6)))
    groups = [[int(row)] for row in order]
    table = np.column_stack([lines.angle, lines.offset, lines.start, lines.end])[order]
    row, changed = 0, False
    while row < len(groups):
        first, second = first_pair(table, row, changed, gap, apart, float(np.radians(turn)))
        changed = first >= 0
        if not changed:
            row += 1
            continue
        row = first
        groups[first] += groups.pop(second)
        table = np.delete(table, second, axis=0)
        table[first] = common_line(lines, groups[first])
    spread = np.array([np.average(lines.spread[g], weights=(lines.end - lines.start)[g]) for g in groups])
    family = np.array([lines.family[g[0]] for g in groups], dtype=np.int64)
    return FaceLines(table[:, 0], table[:, 1], table[:, 2], table[:, 3], spread, family)


def _ends_on(line: Line, angle: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Both ends of a line in the frame (along, across) of an angle."""
    turn = line[0] - angle
    cos, sin = float(np.cos(turn)), float(np.sin(turn))
    _, offset, start, end = line
    return (start * cos - offset * sin, start * sin + offset * cos), (end * cos - offset * sin, end * sin + offset * cos)


def common_line(lines: FaceLines, group: list[int]) -> tuple[float, float, float, float]:
    """Length-weighted line through the pieces of a group."""
    base = float(lines.angle[group[0]])
    a = weight = 0.0
    points = []
    for row in group:
        p, q = _ends_on((lines.angle[row], lines.offset[row], lines.start[row], lines.end[row]), base)
        points.append((p, q))
    length = np.array([q[0] - p[0] for p, q in points])
    mx = float(np.average([(p[0] + q[0]) / 2 for p, q in points], weights=length))
    my = float(np.average([(p[1] + q[1]) / 2 for p, q in points], weights=length))
    for (p, q), n in zip(points, length, strict=True):
        dx, dy = q[0] - p[0], q[1] - p[1]
        cx, cy = (p[0] + q[0]) / 2 - mx, (p[1] + q[1]) / 2 - my
        a += n * (dx * dy / 12 + cx * cy)
        weight += n * (dx * dx / 12 + cx * cx)
    turn = float(np.arctan2(a, weight))
    cos, sin = np.cos(turn), np.sin(turn)
    along = [cos * x + sin * y for ends in points for x, y in ends]
    return base + turn, float(-sin * mx + cos * my), float(min(along)), float(max(along))
