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
    order = np.lexsort((lines.start, lines.offset, -np.round(lines.end - lines.start, 6)))
    groups = [[int(row)] for row in order]
    table = np.column_stack([lines.angle, lines.offset, lines.start, lines.end])[order]
    limits = {"gap": gap, "apart": apart, "turn": float(np.radians(turn))}
    first, changed = 0, False
    while first < len(groups):
        pair = _first_pair(table, first, changed=changed, **limits)
        changed = pair is not None
        if pair is None:
            first += 1
            continue
        first, second = pair
        groups[first] += groups.pop(second)
        table = np.delete(table, second, axis=0)
        table[first] = common_line(lines, groups[first])
    spread = np.array([np.average(lines.spread[g], weights=(lines.end - lines.start)[g]) for g in groups])
    family = np.array([lines.family[g[0]] for g in groups], dtype=np.int64)
    return FaceLines(table[:, 0], table[:, 1], table[:, 2], table[:, 3], spread, family)


def _first_pair(table: Floats, row: int, *, changed: bool, gap: float, apart: float, turn: float) -> tuple[int, int] | None:
    """Rows of the first two lines of which one continues the other: an earlier line and this one, if it has changed; this and a later."""
    limits = {"gap": gap, "apart": apart, "turn": turn}
    pairs = [(int(k), row) for k in np.flatnonzero(_may_continue(table[:row], table[row], **limits))] if changed else []
    pairs += [(row, row + 1 + int(k)) for k in np.flatnonzero(_may_continue(table[row], table[row + 1 :], **limits))]
    for first, second in pairs:
        if continues(_line(table[first]), _line(table[second]), **limits):
            return first, second
    return None


def _line(row: Floats) -> Line:
    angle, offset, start, end = row.tolist()
    return angle, offset, start, end


def _may_continue(first: Floats, second: Floats, *, gap: float, apart: float, turn: float, slack: float = 1e-9) -> NDArray[np.bool_]:
    """Whether `continues` may hold for one line (4,) and others (n, 4): the same tests, all at once and with a little slack."""
    first, second = np.broadcast_arrays(first.T.reshape(4, -1), second.T.reshape(4, -1))
    longer = second[3] - second[2] > first[3] - first[2]
    a, b = np.where(longer, second, first), np.where(longer, first, second)
    difference = np.abs(np.mod(b[0] - a[0] + np.pi, 2 * np.pi) - np.pi)
    near: NDArray[np.bool_] = difference <= np.maximum(turn, np.minimum(apart / (b[3] - b[2]), np.radians(8.0))) + slack
    cos, sin = np.cos(b[0] - a[0]), np.sin(b[0] - a[0])
    near &= np.maximum(b[2] * cos - b[1] * sin, a[2]) - np.minimum(b[3] * cos - b[1] * sin, a[3]) <= gap + slack
    near &= np.abs(b[2] * sin + b[1] * cos - a[1]) <= apart + slack
    near &= np.abs(b[3] * sin + b[1] * cos - a[1]) <= apart + slack
    return near


def continues(first: Line, second: Line, *, gap: float, apart: float, turn: float) -> bool:
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
