"""Curved walls as chains of straight faces that keep close to an arc."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.arc_fit import COLUMN, FINE, Arc
from indoor_bim.plan.arcs import ON_ARC, Spots, explained_by_straight_lines, find_arcs
from indoor_bim.plan.curve import THICKEST, THINNEST, Curve
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import FaceLines, join_lines
from indoor_bim.plan.strips import Sweep, sweep

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

CLOSE = 0.04
"""Arcs of one wall have one centre: what is this close to a circle lies on it, metres."""
ASIDE, BESIDE = 0.50, 0.35
"""How far around a piece of a chain its evidence is worked out, across and along, metres."""
FARTHEST = 0.60
"""How far a chain is prolonged to the next line, metres."""
CONVEX_RADIUS = 0.75
"""Smaller circles that were seen from outside are columns, metres."""


def with_curved_walls(
    lines: FaceLines, sweeps: list[Sweep], points: WallPoints, spots: Spots
) -> tuple[FaceLines, list[Sweep], tuple[Curve, ...]]:
    """Lines with chains of pieces along curved walls, in place of the straight lines that were found there.

    Parameters
    ----------
    lines : FaceLines
        Straight lines.
    sweeps : list of Sweep
        Sweeps that show them.
    points : WallPoints
        Candidates.
    spots : Spots
        Their spots, as by `arcs.wall_spots`.

    Returns
    -------
    lines : FaceLines
        Straight lines, then the pieces of all chains; those of each face follow one another.
    sweeps : list of Sweep
        With one more for each piece.
    curves : tuple of Curve
        Circles of the chains; empty, and everything else unchanged, where no wall is curved.
    """
    arcs = [arc for arc in find_arcs(points, lines, spots) if arc.from_within or arc.radius > CONVEX_RADIUS or points.sensor is None]
    if not arcs:
        return lines, sweeps, ()
    loose = spots.take(~explained_by_straight_lines(spots, lines))
    curves, chains, found = [], [], list(sweeps)
    for group in _walls_of(arcs):
        if len({arc.from_within for arc in group}) == 1 and points.sensor is not None:
            group += _face_behind(group[0], spots)
        curve = _curve(group, loose)
        for radius, within in _faces(group, curve.centre, known=points.sensor is not None):
            chain = _chain(curve, radius, within=within, family=len(found))
            found += [_sweep_of_piece(chain, k, points) for k in range(len(chain))]
            chains.append(chain)
        curves.append(curve)
    return join_lines([lines.take(~_runs_along(lines, curves, spots)), *chains]), found, tuple(curves)


def _walls_of(arcs: Sequence[Arc]) -> list[list[Arc]]:
    """Arcs of one wall: about one centre, no farther from one another than walls are thick, at most a door apart."""
    groups: list[list[Arc]] = []
    for arc in arcs:
        for group in groups:
            if any(_one_wall(other, arc) for other in group):
                group.append(arc)
                break
        else:
            groups.append([arc])
    return groups


def _one_wall(arc: Arc, other: Arc) -> bool:
    ends = np.array([other.start, (other.start + other.end) / 2, other.end])
    places = other.centre + other.radius * np.column_stack([np.cos(ends), np.sin(ends)])
    distance = np.hypot(*(places - arc.centre).T)
    apart = abs(float(distance.mean()) - arc.radius)
    concentric = float(np.ptp(distance)) < 2 * CLOSE
    same_face = apart < CLOSE and arc.from_within == other.from_within
    return concentric and (same_face or THINNEST < apart < THICKEST)


def _curve(group: Sequence[Arc], spots: Spots, *, bound: float = FINE) -> Curve:
    """Common circle of the arcs of a wall as far as spots lie on it, cut into pieces that keep to its outer face within a bound, metres."""
    best = group[0]
    start, end = best.start, best.end
    for arc in group[1:]:
        middle = start + (end - start) / 2
        turn = np.mod(arc.start + arc.turn / 2 - middle + np.pi, 2 * np.pi) - np.pi
        start, end = min(start, middle + turn - arc.turn / 2), max(end, middle + turn + arc.turn / 2)
    radii = sorted({round(radius, 9) for radius, _ in _faces(group, best.centre, known=True)})
    start, end = _as_far_as_seen(spots, best.centre, radii, start, min(end, start + 2 * np.pi))
    longest = np.sqrt(12 * radii[-1] * bound)
    pieces = max(int(np.ceil((end - start) * radii[-1] / longest)), 1)
    deviation = max(arc.deviation for arc in group)
    return Curve(best.centre, tuple(radii), start, end, float(np.sqrt(best.covariance[2, 2])), deviation, pieces)


def _face_behind(arc: Arc, spots: Spots, *, least: float = 0.4, within: float = 0.02) -> list[Arc]:
    """Other face of a wall: a circle about the centre of an arc, as far behind it as walls are thick, with spots along most of it."""
    away = spots.xy - arc.centre
    distance = np.hypot(*away.T)
    along = np.abs((away * spots.tangent).sum(axis=1)) < 0.25 * distance
    angle = arc.after_start(spots.xy)
    columns = max(round(arc.length / COLUMN), 1)
    beside = along & (angle <= arc.turn)
    column = np.minimum((angle[beside] / arc.turn * columns).astype(np.int64), columns - 1)
    behind = (distance[beside] - arc.radius) * (1 if arc.from_within else -1)
    depths = np.arange(THINNEST, THICKEST, FINE)
    shares = np.array([len(np.unique(column[np.abs(behind - depth) < within])) / columns for depth in depths])
    if shares.max() < least:
        return []
    near = behind[np.abs(behind - depths[np.argmax(shares)]) < 1.5 * within]
    radius = arc.radius + float(np.median(near)) * (1 if arc.from_within else -1)
    return [replace(arc, radius=radius, from_within=not arc.from_within)] if radius > 0 else []


def _as_far_as_seen(
    spots: Spots, centre: Floats, radii: Sequence[float], start: float, end: float, *, gap: float = 0.15, least: float = 0.25
) -> tuple[float, float]:
    """Ends of an arc, moved on by at least so much, to the last spots on its circle that follow without a gap, in metres."""
    away = spots.xy - centre
    distance = np.hypot(*away.T)
    on = np.abs(distance[:, None] - np.array(radii)).min(axis=1) < ON_ARC / 2
    on &= np.abs((away * spots.tangent).sum(axis=1)) < 0.2 * distance
    angle = np.arctan2(away[on, 1], away[on, 0])
    room, step = 2 * np.pi - (end - start), gap / max(radii)
    if room < step:
        return start, end
    for past, sign in ((np.sort(np.mod(angle - end, 2 * np.pi)), 1.0), (np.sort(np.mod(start - angle, 2 * np.pi)), -1.0)):
        followed = past[past < room]
        steps = np.diff(followed, prepend=0.0)
        reached = int(np.argmax(np.append(steps > step, True)))
        on_by = float(followed[reached - 1]) if reached else 0.0
        on_by = on_by if on_by * max(radii) > least else 0.0
        start, end = (start, min(end + on_by, start + 2 * np.pi)) if sign > 0 else (max(start - on_by, end - 2 * np.pi), end)
    return start, end


def _faces(group: Sequence[Arc], centre: Floats, *, known: bool) -> list[tuple[float, bool]]:
    """Radius of each face of a wall, and whether it looks to the centre; both ways where that is not known."""
    faces: list[tuple[float, bool]] = []
    for arc in group:
        angles = np.linspace(arc.start, arc.end, 9)
        places = arc.centre + arc.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        radius = float(np.hypot(*(places - centre).T).mean())
        for within in (arc.from_within,) if known else (True, False):
            if not any(within == side and abs(radius - other) < CLOSE for other, side in faces):
                faces.append((radius, within))
    return faces


def _chain(curve: Curve, radius: float, *, within: bool, family: int) -> FaceLines:
    """Pieces of a face all along a curve."""
    first, last = (curve.breaks[:-1], curve.breaks[1:]) if within else (curve.breaks[1:], curve.breaks[:-1])
    outwards = np.column_stack([np.cos((first + last) / 2), np.sin((first + last) / 2)])
    foot = curve.chord_distance(radius)
    reach = foot * np.tan((curve.end - curve.start) / curve.pieces / 2)
    angle = (first + last) / 2 + (np.pi / 2 if within else -np.pi / 2)
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    normal = np.column_stack([-np.sin(angle), np.cos(angle)])
    middle = curve.centre + foot * outwards
    at = (middle * along).sum(axis=1)
    spread = np.full(curve.pieces, curve.deviation)
    return FaceLines(angle, (middle * normal).sum(axis=1), at - reach, at + reach, spread, family + np.arange(curve.pieces))


def _sweep_of_piece(chain: FaceLines, row: int, points: WallPoints) -> Sweep:
    """Wall evidence around a piece of a chain."""
    p, q = (ends[row] for ends in chain.ends(BESIDE))
    rows = np.concatenate([np.arange(first, last) for first, last in points.along(p, q, ASIDE)])
    d, n = chain.direction[row], chain.normal[row]
    along, across = points.xy[rows] @ d, points.xy[rows] @ n - chain.offset[row]
    near = (np.abs(across) < ASIDE) & (along > chain.start[row] - BESIDE) & (along < chain.end[row] + BESIDE)
    return sweep(points.take(rows[near]), float(chain.angle[row])).bare()


def _runs_along(lines: FaceLines, curves: Sequence[Curve], spots: Spots, *, share: float = 0.6, short: float = 1.0) -> Bools:
    """Lines most of whose spots lie on a curve; for short lines, on a curve or where its chain is prolonged."""
    on_curve, near_curve = np.zeros(len(spots), dtype=bool), np.zeros(len(spots), dtype=bool)
    for curve in curves:
        away = spots.xy - curve.centre
        on = np.abs(np.hypot(*away.T)[:, None] - np.array(curve.radii)).min(axis=1) < CLOSE
        angle = np.arctan2(away[:, 1], away[:, 0])
        for found, beyond in ((on_curve, 0.0), (near_curve, FARTHEST / max(curve.radii))):
            found |= on & (np.mod(angle - curve.start + beyond, 2 * np.pi) <= curve.end - curve.start + 2 * beyond)
    found = np.zeros(len(lines), dtype=bool)
    for k in range(len(lines)):
        along, across = spots.xy @ lines.direction[k], spots.xy @ lines.normal[k] - lines.offset[k]
        mine = (np.abs(across) < ON_ARC) & (along > lines.start[k] - ON_ARC) & (along < lines.end[k] + ON_ARC)
        curved = near_curve if lines.end[k] - lines.start[k] < short else on_curve
        found[k] = bool(mine.any()) and float(curved[mine].mean()) > share
    return found


def chain_ends(
    lines: FaceLines, chained: Bools, start: Floats, end: Floats, *, farthest: float = FARTHEST, overlap: float = 0.01, aside: float = 0.15
) -> tuple[Floats, Floats, Floats, Floats]:
    """Ends of the pieces of chains, on the next piece; the last goes on to the next line that is near, and is joined to one along it.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    chained : (m,) bool
        Pieces of chains.
    start, end : (m,) float64
        Ends of all lines along them, metres.
    farthest : float
        How far from the end of a chain the next line is sought, metres.
    overlap : float
        How far a piece reaches past what it meets, metres.
    aside : float
        How far a cut across the end of a chain reaches, to a line that the chain runs into all but in parallel, metres.

    Returns
    -------
    start, end : (m,) float64
        Ends of all lines, metres.
    p, q : (k, 2) float64
        Ends of the cuts, metres.
    """
    start, end = start.copy(), end.copy()
    tails, heads = lines.ends()
    p, q = lines.ends(0.3)
    cuts = []
    for k in np.flatnonzero(chained):
        d, n = lines.direction[k], lines.normal[k]
        start[k], end[k] = lines.start[k] - overlap, lines.end[k] + overlap
        a, b = p @ n - lines.offset[k], q @ n - lines.offset[k]
        crossing = (a * b < 0) & (np.abs(a - b) > 1e-9) & ~chained
        share = a[crossing] / (a - b)[crossing]
        places = (p[crossing] + share[:, None] * (q - p)[crossing]) @ d
        if not (np.hypot(*(tails - heads[k]).T) < overlap).any():
            after = places[(places > lines.end[k] - farthest / 2) & (places < lines.end[k] + farthest)]
            end[k] = max(end[k], float(after.min()) + overlap) if len(after) else end[k]
            cuts += [] if len(after) else _cut_to_parallel(lines, ~chained, heads[k], d, reach=aside, overlap=overlap)
        if not (np.hypot(*(heads - tails[k]).T) < overlap).any():
            before = places[(places < lines.start[k] + farthest / 2) & (places > lines.start[k] - farthest)]
            start[k] = min(start[k], float(before.max()) - overlap) if len(before) else start[k]
            cuts += [] if len(before) else _cut_to_parallel(lines, ~chained, tails[k], d, reach=aside, overlap=overlap)
    across = np.array(cuts).reshape(-1, 2, 2)
    return start, end, across[:, 0], across[:, 1]


def _cut_to_parallel(
    lines: FaceLines, straight: Bools, at: Floats, direction: Floats, *, reach: float, overlap: float, prolonged: float = 1.5
) -> list[tuple[Floats, Floats]]:
    """Cut from the end of a chain to the nearest straight line that runs beside it in nearly its direction, if there is one."""
    aside = lines.normal @ at - lines.offset
    along = lines.direction @ at
    beside = straight & (np.abs(aside) < reach) & (np.abs(lines.direction @ direction) > np.cos(np.radians(15.0)))
    beside &= (along > lines.start - prolonged) & (along < lines.end + prolonged)
    if not beside.any():
        return []
    rows = np.flatnonzero(beside)
    k = rows[np.lexsort((rows, np.round(np.abs(aside[rows]), 6)))[0]]
    away = -lines.normal[k] * (np.sign(aside[k]) or 1.0)
    return [(at - overlap * away, at + (abs(aside[k]) + overlap) * away)]
