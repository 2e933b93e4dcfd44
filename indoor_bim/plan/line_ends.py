"""Where the lines of wall faces end: on the next line, or with a cut across what lies behind them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]
OVERLAP = 0.01
"""Lines reach this far past what they meet, metres."""


def prolong(lines: FaceLines, *, least: float = 1.5, most: float = 8.0, slack: float = 0.3) -> tuple[Floats, Floats]:
    """Ends of lines that run on to the next line beyond `least` metres.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    least, most : float
        Shortest and longest prolongation, metres.
    slack : float
        How far the line that is met may itself be prolonged, metres.

    Returns
    -------
    start, end : (m,) float64
        New extents along the lines, metres.
    """
    p, q = lines.ends(slack)
    direction, normal = lines.direction, lines.normal
    start, end = lines.start - least, lines.end + least
    for k in range(len(lines)):
        a = p @ normal[k] - lines.offset[k]
        b = q @ normal[k] - lines.offset[k]
        crossing = (a * b < 0) & (np.abs(a - b) > 1e-9)
        share = a[crossing] / (a - b)[crossing]
        along = (p[crossing] + share[:, None] * (q - p)[crossing]) @ direction[k]
        after = along[(along > end[k]) & (along < lines.end[k] + most)]
        before = along[(along < start[k]) & (along > lines.start[k] - most)]
        if len(after):
            end[k] = after.min() + 0.01
        if len(before):
            start[k] = before.max() - 0.01
    return start, end


def gap_cuts(
    lines: FaceLines, *, gap: float = 8.0, overlap: float = 0.5, across: float = 0.07, turn: float = 3.0
) -> tuple[FaceLines, Floats, Floats]:
    """Lines that run on to the next piece of the same face, and cuts across halfway that join the two.

    A map that drifts shows one face in pieces a few centimetres apart, which never cross: without cuts no cell closes between them.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    gap : float
        Longest gap between two pieces, metres.
    overlap : float
        Longest stretch along which both run, metres.
    across : float
        Largest step from one to the next where they come closest, metres.
    turn : float
        Largest angle between them, degrees.

    Returns
    -------
    lines : FaceLines
        Lines whose ends reach the cuts.
    p, q : (m, 2) float64
        Ends of the cuts, metres.
    """
    tails, heads = lines.ends()
    direction, normal = lines.direction, lines.normal
    start, end = lines.start.copy(), lines.end.copy()
    cuts = []
    for k in range(len(lines)):
        ahead = (tails - heads[k]) @ direction[k]
        step = (tails - heads[k]) @ normal[k]
        further = ((heads - heads[k]) @ direction[k] > 0) & ((tails - tails[k]) @ direction[k] > 0)
        same = direction @ direction[k] > np.cos(np.radians(turn))
        onward = np.flatnonzero(same & further & (ahead < gap) & (ahead > -overlap) & (np.abs(step) < across))
        if not len(onward):
            continue
        n = onward[np.lexsort((step[onward], ahead[onward]))[0]]
        middle = (heads[k] + tails[n]) / 2
        a, b = middle @ direction[k], middle @ direction[n]
        end[k], start[n] = max(end[k], a + OVERLAP), min(start[n], b - OVERLAP)
        foot = [a * direction[k] + lines.offset[k] * normal[k], b * direction[n] + lines.offset[n] * normal[n]]
        side = np.sign((foot[1] - foot[0]) @ normal[k]) or 1.0
        cuts.append((foot[0] - side * OVERLAP * normal[k], foot[1] + side * OVERLAP * normal[k]))
    p, q = (np.array([cut[k] for cut in cuts]).reshape(-1, 2) for k in (0, 1))
    return replace(lines, start=start, end=end), p, q


def end_cuts(
    lines: FaceLines, *, depth: float = 1.0, near: float = 0.20, shortest: float = 0.6, thickest: float = 0.6
) -> tuple[Floats, Floats]:
    """Cuts across what lies behind a face, where the face ends and no other line runs on from there.

    Walls are not cut: what lies between a face and one that looks the other way.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    depth : float
        Length of a cut, metres.
    near : float
        Lines across the face this close to its end make a cut superfluous, metres.
    shortest : float
        Shortest face, metres.
    thickest : float
        Thickest wall, metres.

    Returns
    -------
    p, q : (m, 2) float64
        Ends of the cuts, metres.
    """
    tails, heads = lines.ends()
    p, q = lines.ends(near)
    direction, normal = lines.direction, lines.normal
    cuts = []
    for k in np.flatnonzero(lines.end - lines.start >= shortest):
        opposite = direction @ direction[k] < -0.99
        for end in (tails[k], heads[k]):
            along_p, along_q = (p - end) @ direction[k], (q - end) @ direction[k]
            across_p, across_q = (p - end) @ normal[k], (q - end) @ normal[k]
            beside = np.minimum(np.abs(along_p), np.abs(along_q)) < near
            steep = np.abs(across_q - across_p) > np.abs(along_q - along_p)
            behind = np.minimum(across_p, across_q) < -0.1
            reaches = np.maximum(across_p, across_q) > -near
            spans = (np.minimum(along_p, along_q) < near) & (np.maximum(along_p, along_q) > -near)
            back = opposite & spans & (across_p < -0.02) & (across_p > -thickest)
            if not (back | (beside & steep & behind & reaches)).any():
                cuts.append((end + 0.02 * normal[k], end - depth * normal[k]))
    return np.array([a for a, _ in cuts]).reshape(-1, 2), np.array([b for _, b in cuts]).reshape(-1, 2)
