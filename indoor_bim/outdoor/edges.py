"""Wall lines placed on the points themselves, and the corners where they meet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BAND = 0.12
END_MARGIN = 0.15
BIN = 0.25
WOBBLE = 0.01
STEPS = 10
SETTLED = 2e-5
PARALLEL = np.radians(8.0)


@dataclass(frozen=True, slots=True, eq=False)
class FittedEdge:
    """Side of a house with the line that its points place.

    Parameters
    ----------
    start, end : (2,) float64
        Ends, metres; the house lies to the left.
    angle : float
        Direction of the line, radians.
    anchor : (2,) float64
        Point of the line, metres.
    points : int
        Number of points on the wall.
    rmse : float
        Root mean square distance of these points from the line, metres; NaN without points.
    coverage : float
        Share of the side with points.
    fitted : bool
        False where there were too few points: the line is that of the outline.
    """

    start: Floats
    end: Floats
    angle: float
    anchor: Floats
    points: int
    rmse: float
    coverage: float
    fitted: bool

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(np.hypot(*(self.end - self.start)))

    @property
    def direction(self) -> Floats:
        """Unit vector along the line."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def normal(self) -> Floats:
        """Unit vector to the left, into the house."""
        return np.array([-np.sin(self.angle), np.cos(self.angle)])


def fit_edges(corners: Floats, xy: Floats, *, least_coverage: float = 0.25, right_angles: bool = True, rounds: int = 4) -> list[FittedEdge]:
    """Move the sides of an outline onto the wall points and its corners to where the sides meet.

    Parameters
    ----------
    corners : (m, 2) float64
        Outline, counter-clockwise, metres.
    xy : (n, 2) float64
        Points of the walls, metres.
    least_coverage : float
        Share of a side that must have points; other sides keep their line.
    right_angles : bool
        Square up the sides whose directions agree with a right angle within their own uncertainty.
    rounds : int
        How often lines and corners are found from each other.

    Returns
    -------
    list of FittedEdge
        One for each side, corner i to corner i + 1.

    Notes
    -----
    Each line is a least squares fit with Tukey's weights, in which every stretch of the wall counts alike, however close the
    scanner came to it: the error that matters is the slow drift of the scanner's path, not the noise.
    """
    corners = np.asarray(corners, dtype=np.float64)
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    beside = [xy[near_segment(xy, a, b, band=4 * BAND, margin=-4 * BAND)[2]] for a, b in sides]
    edges: list[FittedEdge] = []
    for _ in range(rounds):
        ends = np.roll(corners, -1, axis=0)
        edges = [_fit(a, b, points, least_coverage) for a, b, points in zip(corners, ends, beside, strict=True)]
        if right_angles:
            edges = _square_up(edges, beside)
        moved = _corners(edges)
        settled = np.abs(moved - corners).max() < 1e-4
        corners = moved
        edges = [replace(edge, start=a, end=b) for edge, a, b in zip(edges, corners, np.roll(corners, -1, axis=0), strict=True)]
        if settled:
            break
    return edges


def near_segment(xy: Floats, start: Floats, end: Floats, *, band: float, margin: float = 0.0) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Points beside a segment.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    start, end : (2,) float64
        Ends, metres.
    band : float
        Largest distance across, metres.
    margin : float
        Length left out at each end, metres.

    Returns
    -------
    along, across : (k,) float64
        Place along the segment from its start, and distance to its left, metres.
    rows : (k,) int64
        Which points.
    """
    length = float(np.hypot(*(end - start)))
    d = (end - start) / max(length, 1e-9)
    offset = xy - start
    across = offset[:, 1] * d[0] - offset[:, 0] * d[1]
    rows = np.flatnonzero(np.abs(across) <= band)
    along = offset[rows, 0] * d[0] + offset[rows, 1] * d[1]
    inside = (along >= margin) & (along <= length - margin)
    return along[inside], across[rows][inside], rows[inside]


def _fit(start: Floats, end: Floats, xy: Floats, least_coverage: float) -> FittedEdge:
    d = end - start
    length = float(np.hypot(*d))
    angle = float(np.arctan2(d[1], d[0]))
    margin = min(END_MARGIN, 0.2 * length)
    along, across, _ = near_segment(xy, start, end, band=2 * BAND, margin=margin)
    bins = max(1, int(np.ceil((length - 2 * margin) / BIN)))
    place = np.clip(((along - margin) / max(length - 2 * margin, 1e-9) * bins).astype(np.int64), 0, bins - 1)
    unfitted = FittedEdge(start, end, angle, (start + end) / 2, 0, np.nan, 0.0, fitted=False)
    if len(along) < 10:
        return unfitted
    slope, level = 0.0, _mode(across)
    for _ in range(STEPS):
        residual = across - (level + slope * (along - length / 2))
        weight = np.clip(1 - (residual / BAND) ** 2, 0.0, None) ** 2
        balanced = weight / np.maximum(np.bincount(place, weight, bins), 3.0)[place]
        new = _weighted_line(along - length / 2, across, balanced)
        if new is None:
            return unfitted
        change = abs(new[0] - slope) * length + abs(new[1] - level)
        slope, level = new
        if change < SETTLED:
            break
    residual = across - (level + slope * (along - length / 2))
    near = np.abs(residual) < BAND
    hit = np.bincount(place[near], minlength=bins) > 0
    coverage = float(hit.mean())
    if coverage < least_coverage or near.sum() < 10:
        return replace(unfitted, points=int(near.sum()), coverage=coverage)
    turned = angle + float(np.arctan(slope))
    unit, left = d / length, np.array([-d[1], d[0]]) / length
    anchor = start + unit * length / 2 + left * level
    return FittedEdge(start, end, turned, anchor, int(near.sum()), float(np.sqrt(np.mean(residual[near] ** 2))), coverage, fitted=True)


def _mode(across: Floats) -> float:
    """Distance at which the points lie most densely."""
    count, border = np.histogram(across, bins=int(4 * BAND / 0.02), range=(-2 * BAND, 2 * BAND))
    smooth = np.convolve(count, [1, 2, 2, 2, 1], mode="same")
    best = int(smooth.argmax())
    return float((border[best] + border[best + 1]) / 2)


def _weighted_line(x: Floats, y: Floats, weight: Floats) -> tuple[float, float] | None:
    """Slope and level at x = 0 of the line of least weighted squares; None without spread."""
    total = weight.sum()
    if total <= 0:
        return None
    mean_x, mean_y = float((weight * x).sum() / total), float((weight * y).sum() / total)
    x, y = x - mean_x, y - mean_y
    weighted = weight * x
    spread = float((weighted * x).sum())
    if spread < 1e-9 * total:
        return None
    slope = float((weighted * y).sum()) / spread
    return slope, mean_y - slope * mean_x


def _square_up(edges: list[FittedEdge], beside: list[Floats]) -> list[FittedEdge]:
    """Give the sides that agree with a common right-angled cross its directions; the others keep theirs."""
    chosen = [i for i, edge in enumerate(edges) if edge.fitted]
    if len(chosen) < 3:
        return edges
    angle = np.array([edges[i].angle for i in chosen])
    length = np.array([edges[i].length * edges[i].coverage for i in chosen])
    sigma = WOBBLE * np.sqrt(12) / np.maximum(length, 0.5)
    best, members = -1.0, np.zeros(len(chosen), dtype=np.bool_)
    for i in range(len(chosen)):
        away = _from_cross(angle - angle[i])
        agree = np.abs(away) < 2 * np.hypot(sigma, sigma[i])
        if length[agree].sum() > best + 1e-9:
            best, members = float(length[agree].sum()), agree
    if members.sum() < 3:
        return edges
    reference = angle[np.flatnonzero(members)[np.argmax(length[members])]]
    weight = np.where(members, sigma**-2.0, 0.0)
    cross = reference + float((weight * _from_cross(angle - reference)).sum() / weight.sum())
    members &= np.abs(_from_cross(angle - cross)) < 2 * sigma
    squared = list(edges)
    for k in np.flatnonzero(members):
        edge = edges[chosen[k]]
        squared[chosen[k]] = _fit_offset(replace(edge, angle=float(edge.angle - _from_cross(edge.angle - cross))), beside[chosen[k]])
    return squared


def _from_cross(angle: Floats | float) -> Floats:
    """Difference from the nearest multiple of a right angle, radians."""
    return (np.asarray(angle) + np.pi / 4) % (np.pi / 2) - np.pi / 4


def _fit_offset(edge: FittedEdge, xy: Floats) -> FittedEdge:
    """Edge of the same direction, moved onto its points."""
    half = edge.length / 2 * edge.direction
    margin = min(END_MARGIN, 0.2 * edge.length)
    along, across, _ = near_segment(xy, edge.anchor - half, edge.anchor + half, band=BAND, margin=margin)
    if not len(along):
        return edge
    place = np.floor(along / BIN).astype(np.int64)
    level = 0.0
    for _ in range(STEPS):
        weight = np.clip(1 - ((across - level) / BAND) ** 2, 0.0, None) ** 2
        count = np.bincount(place, weight)
        balanced = weight / np.maximum(count, 3.0)[place]
        moved = float((balanced * across).sum() / balanced.sum())
        if abs(moved - level) < SETTLED:
            break
        level = moved
    return replace(edge, anchor=edge.anchor + level * edge.normal, rmse=float(np.sqrt(np.mean((across - level) ** 2))))


def _corners(edges: list[FittedEdge]) -> Floats:
    """Corner before each side: where it meets the side before it."""
    corners = []
    for before, after in zip([edges[-1], *edges[:-1]], edges, strict=True):
        if abs(np.sin(before.angle - after.angle)) < np.sin(PARALLEL):
            old = after.start
            feet = [edge.anchor + edge.direction * ((old - edge.anchor) @ edge.direction) for edge in (before, after)]
            corners.append((feet[0] + feet[1]) / 2)
            continue
        normals = np.array([before.normal, after.normal])
        offsets = np.array([before.normal @ before.anchor, after.normal @ after.anchor])
        corners.append(np.linalg.solve(normals, offsets))
    return np.array(corners)
