"""Lines that continue one another become one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]
Line = tuple[float, float, float, float]


def merge_lines(lines: FaceLines, *, gap: float = 4.0, apart: float = 0.035, turn: float = 1.5) -> FaceLines:
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
    order = np.lexsort((lines.start, lines.offset, -np.round(lines.end - lines.start, 6)))
    groups = [[int(row)] for row in order]
    fitted = [(float(lines.angle[g[0]]), float(lines.offset[g[0]]), float(lines.start[g[0]]), float(lines.end[g[0]])) for g in groups]
    first = 0
    while first < len(groups):
        for second in first + 1 + _may_continue(fitted[first], fitted[first + 1 :], gap=gap, apart=apart, turn=np.radians(turn)):
            if _continues(fitted[first], fitted[second], gap=gap, apart=apart, turn=np.radians(turn)):
                groups[first] += groups.pop(second)
                fitted.pop(second)
                fitted[first] = _common_line(lines, groups[first])
                first = -1
                break
        first += 1
    table = np.array(fitted).reshape(-1, 4)
    spread = np.array([np.average(lines.spread[g], weights=(lines.end - lines.start)[g]) for g in groups])
    family = np.array([lines.family[g[0]] for g in groups], dtype=np.int64)
    return FaceLines(table[:, 0], table[:, 1], table[:, 2], table[:, 3], spread, family)


def _may_continue(line: Line, others: list[Line], *, gap: float, apart: float, turn: float, slack: float = 1e-9) -> NDArray[np.int64]:
    """Rows of the lines for which `_continues` may hold: the same tests, all at once and with a little slack."""
    second = np.array(others).reshape(-1, 4)
    longer = second[:, 3] - second[:, 2] > line[3] - line[2]
    a, b = np.where(longer, second.T, np.array(line)[:, None]), np.where(longer, np.array(line)[:, None], second.T)
    difference = np.abs(np.mod(b[0] - a[0] + np.pi, 2 * np.pi) - np.pi)
    straight = difference <= np.maximum(turn, np.minimum(apart / (b[3] - b[2]), np.radians(8.0))) + slack
    cos, sin = np.cos(b[0] - a[0]), np.sin(b[0] - a[0])
    near = np.maximum(b[2] * cos - b[1] * sin, a[2]) - np.minimum(b[3] * cos - b[1] * sin, a[3]) <= gap + slack
    near &= np.abs(b[2] * sin + b[1] * cos - a[1]) <= apart + slack
    near &= np.abs(b[3] * sin + b[1] * cos - a[1]) <= apart + slack
    return np.flatnonzero(straight & near)


def _continues(first: Line, second: Line, *, gap: float, apart: float, turn: float) -> bool:
    """Whether the shorter line continues the longer one."""
    if second[3] - second[2] > first[3] - first[2]:
        first, second = second, first
    difference = abs(np.mod(second[0] - first[0] + np.pi, 2 * np.pi) - np.pi)
    if difference > max(turn, min(apart / (second[3] - second[2]), np.radians(8.0))):
        return False
    p, q = _ends_on(second, first[0])
    if max(p[0], first[2]) - min(q[0], first[3]) > gap:
        return False
    return abs(p[1] - first[1]) <= apart and abs(q[1] - first[1]) <= apart


def _ends_on(line: Line, angle: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Both ends of a line in the frame (along, across) of an angle."""
    turn = line[0] - angle
    cos, sin = float(np.cos(turn)), float(np.sin(turn))
    _, offset, start, end = line
    return (start * cos - offset * sin, start * sin + offset * cos), (end * cos - offset * sin, end * sin + offset * cos)


def _common_line(lines: FaceLines, group: list[int]) -> tuple[float, float, float, float]:
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
