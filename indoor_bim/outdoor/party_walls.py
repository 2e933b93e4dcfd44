"""Houses that touch, told apart by the heights of their eaves."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.outdoor.edges import FittedEdge, near_segment
from indoor_bim.outdoor.heights import wall_top

Floats = NDArray[np.float64]

WINDOW = 1.0
LEAST_STEP = 1.2
LEAST_RUN = 2.0
SAME_HEIGHT = 0.2
LEAST_SAME = 0.6
LEAST_COMPANY = 0.2
SQUARE = np.radians(4.0)
STRAIGHT = 0.05


def split_at_party_walls(edges: list[FittedEdge], points: Floats, *, foot: float, least_area: float) -> list[Floats]:
    """Cut an outline between parts whose walls end at different heights.

    Parameters
    ----------
    edges : list of FittedEdge
        Sides of the outline, counter-clockwise.
    points : (n, 3) float64
        Points of buildings about it, metres.
    foot : float
        Height of the ground, metres.
    least_area : float
        Smallest part, square metres.

    Returns
    -------
    list of (m, 2) float64
        Corners of each part, counter-clockwise; one part where nothing is to be cut.
    """
    ring = np.array([edge.start for edge in edges])
    walls = _walls_with_tops(edges, points, foot)
    return _split(ring, walls, points, least_area)


def _walls_with_tops(edges: list[FittedEdge], points: Floats, foot: float) -> Floats:
    """Rows of x, y, height of the top, length for every stretch of wall."""
    from dataclasses import replace

    rows = []
    for edge in edges:
        if not edge.fitted:
            continue
        _, _, near = near_segment(points[:, :2], edge.start, edge.end, band=0.15)
        count = max(1, int(edge.length / WINDOW))
        steps = edge.start + np.linspace(0, 1, count + 1)[:, None] * (edge.end - edge.start)
        for start, end in pairwise(steps):
            top = wall_top(replace(edge, start=start, end=end), points[near], foot=foot)
            if top is not None:
                rows.append([*((start + end) / 2), top, edge.length / count])
    return np.array(rows).reshape(-1, 4)


def _split(ring: Floats, walls: Floats, points: Floats, least_area: float) -> list[Floats]:
    polygon = shapely.Polygon(ring)
    border = polygon.exterior
    place = shapely.line_locate_point(border, shapely.points(walls[:, :2]))
    order = np.argsort(place, kind="stable")
    place, tops, lengths = place[order], walls[order, 2], walls[order, 3]
    level = _level_between(tops, lengths)
    if level is None:
        return [ring]
    breaks = [_sharpened(border, at, points, walls, level) for at in _breaks(place, tops > level, lengths, border.length)]
    corners = shapely.line_locate_point(border, shapely.points(ring))
    best: tuple[float, shapely.Polygon, shapely.Polygon] | None = None
    for a, b in combinations(breaks, 2):
        for p, q in _chords(border, a, b, corners):
            if p != q:
                parts = _cut(polygon, p, q, least_area)
                if parts is not None and (best is None or parts[0] < best[0]) and _agree(parts[1:], walls, level):
                    best = parts
    if best is None:
        return [ring]
    pieces: list[Floats] = []
    for part in best[1:]:
        own = shapely.dwithin(part.exterior, shapely.points(walls[:, :2]), 0.05)
        cleaned = part.simplify(STRAIGHT)
        corners_of_part = np.asarray(shapely.orient_polygons(cleaned).exterior.coords)[:-1]
        pieces += _split(_from_a_corner(corners_of_part), walls[own], points, least_area)
    return pieces


def _level_between(tops: Floats, lengths: Floats) -> float | None:
    """Height between the two groups of wall tops that lie farthest apart; None where all are much the same."""
    if len(tops) < 2:
        return None
    order = np.argsort(tops, kind="stable")
    ordered, length = tops[order], lengths[order]
    gaps = np.diff(ordered)
    enough = (np.cumsum(length)[:-1] >= LEAST_RUN) & (np.cumsum(length[::-1])[::-1][1:] >= LEAST_RUN)
    gaps = np.where(enough, gaps, 0.0)
    widest = int(gaps.argmax())
    return float((ordered[widest] + ordered[widest + 1]) / 2) if gaps[widest] >= LEAST_STEP else None


def _breaks(place: Floats, high: NDArray[np.bool_], lengths: Floats, around: float) -> list[float]:
    """Places along the border between high and low stretches of some length."""
    runs: list[list[float]] = []
    for at, is_high, length in zip(place.tolist(), high.tolist(), lengths.tolist(), strict=True):
        if runs and runs[-1][0] == is_high:
            runs[-1][2] = at
            runs[-1][3] += length
        else:
            runs.append([is_high, at, at, length, length])
    runs = [run for run in runs if run[3] >= LEAST_RUN]
    breaks = []
    for before, after in zip(runs, [*runs[1:], *runs[:1]], strict=True):
        if before[0] != after[0]:
            gap = (after[1] - before[2]) % around
            breaks.append((before[2] + gap / 2) % around)
    return sorted(breaks)


def _from_a_corner(ring: Floats) -> Floats:
    """Ring without a first corner that lies on a straight side, where simplification could not take it out."""
    a, b, c = ring[-1], ring[0], ring[1]
    d = (c - a) / np.hypot(*(c - a))
    return ring[1:] if len(ring) > 3 and abs((b - a) @ np.array([-d[1], d[0]])) < STRAIGHT else ring


def _sharpened(border: shapely.LinearRing, at: float, points: Floats, walls: Floats, level: float) -> float:
    """Break moved to where the points of the higher wall end."""
    low, high = (float(np.median(walls[rows, 2])) for rows in (walls[:, 2] <= level, walls[:, 2] > level))
    upper = points[(points[:, 2] > low + 0.4) & (points[:, 2] < high - 0.2)]
    middle = np.asarray(border.interpolate(at).coords[0])
    near = upper[np.hypot(*(upper[:, :2] - middle).T) < 2 * WINDOW, :2]
    near = near[shapely.dwithin(border, shapely.points(near), 0.12)]
    if len(near) < 20:
        return at
    along = (shapely.line_locate_point(border, shapely.points(near)) - at + border.length / 2) % border.length - border.length / 2
    end = float(np.quantile(along, 0.99 if np.median(along) < 0 else 0.01))
    return float((at + end) % border.length)


def _chords(border: shapely.LinearRing, a: float, b: float, corners: Floats) -> list[tuple[float, float]]:
    """Pairs of places about two breaks: corners near them, the breaks themselves, and the foot of one on the side of the other."""
    chords = []
    for p in _near_corners(a, corners):
        for q in _near_corners(b, corners):
            chords += [(p, q), (p, _foot(border, p, q)), (_foot(border, q, p), q)]
    return chords


def _near_corners(at: float, corners: Floats) -> list[float]:
    """Corners about a place along the border, and the place itself."""
    near = [float(corner) for corner in corners if abs(corner - at) < 1.5 * WINDOW]
    return [*near, at]


def _foot(border: shapely.LinearRing, p: float, q: float) -> float:
    """Place next to `q` on its side of the border from which it is square to `p`; `q` where that is not near."""
    start, end = (np.asarray(border.interpolate((q + step) % border.length).coords[0]) for step in (-0.05, 0.05))
    d = (end - start) / max(np.hypot(*(end - start)), 1e-9)
    step = float((np.asarray(border.interpolate(p).coords[0]) - (start + end) / 2) @ d)
    return float((q + step) % border.length) if abs(step) < 0.5 * WINDOW else q


def _cut(polygon: shapely.Polygon, p: float, q: float, least_area: float) -> tuple[float, shapely.Polygon, shapely.Polygon] | None:
    """Length of the chord between two places on the border and the two parts; None where it is no likely party wall."""
    border = polygon.exterior
    a, b = (np.asarray(border.interpolate(at).coords[0]) for at in (p, q))
    length = float(np.hypot(*(b - a)))
    if length < 2.0:
        return None
    d = (b - a) / length
    chord = shapely.LineString([a - 0.01 * d, b + 0.01 * d])
    if shapely.LineString([a + 0.05 * d, b - 0.05 * d]).intersection(polygon.buffer(-0.04)).length < 0.95 * length - 0.3:
        return None
    if not (_square_to_border(border, p, d) or _square_to_border(border, q, d)):
        return None
    parts = [
        part for part in shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.union_all([border, chord])))) if part.area > 0.1
    ]
    if len(parts) != 2 or min(part.area for part in parts) < least_area:
        return None
    return length, parts[0], parts[1]


def _square_to_border(border: shapely.LinearRing, at: float, d: Floats) -> bool:
    """Whether a direction is square to the border on either side of a place."""
    for low, high in ((at - 0.3, at - 0.05), (at + 0.05, at + 0.3)):
        p, q = (np.asarray(border.interpolate(place % border.length).coords[0]) for place in (low, high))
        along = (q - p) / max(np.hypot(*(q - p)), 1e-9)
        if abs(along @ d) < np.sin(SQUARE):
            return True
    return False


def _agree(parts: tuple[shapely.Polygon, ...], walls: Floats, level: float) -> bool:
    """Whether one part ends on one side of the level, the other does not, and both end at heights that others share."""
    owns = [walls[shapely.dwithin(part.exterior, shapely.points(walls[:, :2]), 0.05)] for part in parts]
    if min(own[:, 3].sum() for own in owns) < 2 * LEAST_RUN:
        return False
    shares = [own[own[:, 2] > level, 3].sum() / own[:, 3].sum() for own in owns]
    if max(shares) - min(shares) < 0.3 or not any(share < 0.2 or share > 0.8 for share in shares):
        return False
    higher, lower = owns[int(np.argmax(shares))], owns[int(np.argmin(shares))]
    return _even(higher[higher[:, 2] > level]) and _even(lower[lower[:, 2] <= level])


def _even(walls: Floats) -> bool:
    """Whether most walls end at a height that others share; walls that were seen badly end anywhere."""
    alike = np.abs(walls[:, 2, None] - walls[None, :, 2]) < SAME_HEIGHT
    company = (alike * walls[:, 3]).sum(axis=1)
    length = walls[:, 3].sum()
    accompanied = company >= max(2 * LEAST_RUN, LEAST_COMPANY * length)
    return bool(walls[accompanied, 3].sum() > LEAST_SAME * length)
