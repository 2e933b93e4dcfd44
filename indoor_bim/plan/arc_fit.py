"""Circular arcs fitted to the points of a wall, and the proof that it is curved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.ordering import ascending_in_groups
from indoor_bim.plan.evidence import WallPoints

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

COLUMN = 0.10
"""Width of the columns of points that are one observation, metres."""
REACH = 0.05
"""Points this close to an arc lie on it, metres."""
FINEST = 0.001
"""Least standard deviation that is assumed, metres."""
LEAST_SURE = 0.02
"""Largest standard deviation of a radius, as a share of it."""
FEWEST = 6
"""Columns that an arc rests on at least."""
FINE, COARSE = 0.01, 0.02
"""Deviations of the points from an arc, metres: one is a strip wide, and always allowed, the other never exceeded."""


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """Face of a curved wall.

    Parameters
    ----------
    centre : (2,) float64
        Centre, metres.
    radius : float
        Radius, metres.
    start, end : float
        Angles of the ends seen from the centre, counter-clockwise, radians; 2 pi apart where the circle is closed.
    from_within : bool
        True where it was seen from the side of the centre.
    covariance : (3, 3) float64
        Covariance of centre and radius, square metres.
    noise : float
        Robust standard deviation of the points across, metres.
    deviation : float
        Distance from the arc that 95 % of the medians of the columns keep to, metres.
    """

    centre: Floats
    radius: float
    start: float
    end: float
    from_within: bool
    covariance: Floats
    noise: float
    deviation: float

    @property
    def turn(self) -> float:
        """Angle between its ends, radians."""
        return self.end - self.start

    @property
    def length(self) -> float:
        """Length, metres."""
        return self.radius * self.turn

    @property
    def closed(self) -> bool:
        """Whether it is a whole circle."""
        return self.turn > 2 * np.pi - 1e-9

    def after_start(self, xy: Floats) -> Floats:
        """Angles (n,) of points (n, 2) past the start of the arc, 0 to 2 pi, radians."""
        away = xy - self.centre
        angles: Floats = np.mod(np.arctan2(away[:, 1], away[:, 0]) - self.start, 2 * np.pi)
        return angles

    def holds(self, xy: Floats, *, across: float, beyond: float = 0.0) -> Bools:
        """Points (n, 2) no farther than this from the arc, across and beyond its ends, metres."""
        squares = (xy[:, 0] - self.centre[0]) ** 2 + (xy[:, 1] - self.centre[1]) ** 2
        held: Bools = (squares <= (self.radius + across) ** 2) & (squares >= max(self.radius - across, 0.0) ** 2)
        angle, slack = self.after_start(xy[held]), beyond / self.radius
        held[held] = (angle <= self.turn + slack) | (angle >= 2 * np.pi - slack)
        return held


def circle_through(xy: Floats, centre: Floats, radius: float, *, rounds: int = 12, finest: float = FINEST) -> tuple[Floats, float, Floats]:
    """Circle through points by least squares of their distances with Tukey's weights.

    Parameters
    ----------
    xy : (n, 2) float64
        Points near a circle, metres.
    centre : (2,) float64
        Centre to start from, metres.
    radius : float
        Radius to start from, metres.
    rounds : int
        Steps of Gauss and Newton.
    finest : float
        Least standard deviation that is assumed, metres.

    Returns
    -------
    centre : (2,) float64
    radius : float
    covariance : (3, 3) float64
        Of both, each point one observation.

    References
    ----------
    Gander, Golub, Strebel, Least-squares fitting of circles and ellipses, BIT Numerical Mathematics 34, 1994.

    Examples
    --------
    >>> angle = np.linspace(0, 1, 20)
    >>> on = np.column_stack([3 + 2 * np.cos(angle), 1 + 2 * np.sin(angle)])
    >>> centre, radius, _ = circle_through(on, np.array([2.9, 1.1]), 2.1)
    >>> centre.round(6).tolist(), round(radius, 6)
    ([3.0, 1.0], 2.0)
    """
    from indoor_bim.plan.arc_loops import fit_circle

    circle, normal = np.array([*centre, radius], dtype=np.float64), np.eye(3)
    sigma = fit_circle(*xy.T, rounds, finest, circle, normal)
    return circle[:2], float(circle[2]), sigma**2 * np.linalg.inv(normal)


def longest_run(xy: Floats, centre: Floats, radius: float, *, gap: float) -> tuple[float, float, float]:
    """Start and end of the run of points on a circle that covers most, and the length that it covers, radians and metres.

    Parameters
    ----------
    xy : (n, 2) float64
        Points on a circle, metres.
    centre : (2,) float64
        Its centre, metres.
    radius : float
        Its radius, metres.
    gap : float
        Longest gap in a run, metres.
    """
    column = COLUMN / radius
    columns = max(round(2 * np.pi / column), 8)
    angle = np.mod(np.arctan2(*(xy - centre).T[::-1]), 2 * np.pi)
    place = np.minimum((angle / (2 * np.pi) * columns).astype(np.int64), columns - 1)
    filled = np.flatnonzero(np.bincount(place, minlength=columns))
    if not len(filled):
        return 0.0, 0.0, 0.0
    steps = np.diff(filled, append=filled[0] + columns)
    breaks = np.flatnonzero(steps * COLUMN > gap)
    if not len(breaks):
        return 0.0, 2 * np.pi, len(filled) * COLUMN
    runs = [np.arange(a + 1, b + 1) for a, b in zip(breaks, [*breaks[1:], breaks[0] + len(filled)], strict=True)]
    best = max(runs, key=len)
    in_run = np.zeros(columns, dtype=bool)
    in_run[filled[best % len(filled)]] = True
    members = angle[in_run[place]]
    start = float(filled[best[0] % len(filled)]) / columns * 2 * np.pi
    past = np.mod(members - start, 2 * np.pi)
    return start + float(past.min()), start + float(past.max()), len(best) * COLUMN


def fit_arc(points: WallPoints, centre: Floats, radius: float, start: float, end: float, *, rounds: int = 3) -> Arc | None:
    """Arc through the points along it that were seen from the side that most of them were seen from; None where it is no curved wall.

    It is one where the medians of its columns keep to the arc as closely as the noise of the points allows, where no straight line reaches
    them, and where a line with one bend does not explain them as well.

    Parameters
    ----------
    points : WallPoints
        Points high on walls.
    centre : (2,) float64
        Centre, metres, near enough for the points to be within reach.
    radius : float
        Radius, metres.
    start, end : float
        Ends, radians.
    rounds : int
        Number of times that columns are formed anew.
    """
    arc = Arc(np.asarray(centre), radius, start, end, True, np.full((3, 3), np.inf), 0.0, np.inf)
    columns = np.zeros((0, 2))
    for _ in range(rounds):
        rows = np.flatnonzero(arc.holds(points.xy, across=REACH))
        xy = points.xy[rows]
        from_within = True
        if points.sensor is not None:
            within = ((points.sensor[rows] - xy) * (arc.centre - xy)).sum(axis=1) > 0
            from_within = bool(within.sum() >= 0.5 * len(xy))
            xy = xy[within == from_within]
        columns, place, apart = _column_medians(arc, xy)
        if len(columns) < FEWEST or len(columns) * COLUMN < 0.5 * arc.length:
            return None
        centre, radius, covariance = circle_through(columns, arc.centre, arc.radius)
        noise = max(1.4826 * float(np.median(np.abs(apart))), FINEST)
        residual = np.hypot(*(columns - centre).T) - radius
        kept = _run_of(place, np.abs(residual) <= _allowed(noise), round(2 * np.pi * arc.radius / COLUMN) if arc.closed else None)
        if len(kept) < FEWEST:
            return None
        at = np.unwrap(np.arctan2(*(columns[kept] - centre).T[::-1]))
        whole = arc.closed and len(kept) == len(columns)
        half = 0.5 * COLUMN / radius
        first, last = (arc.start, arc.end) if whole else (float(at[0]) - half, float(at[-1]) + half)
        columns, deviation = columns[kept], float(np.quantile(np.abs(residual[kept]), 0.95))
        arc = Arc(centre, radius, first, min(last, first + 2 * np.pi), from_within, covariance, noise, deviation)
    return arc if _is_curved(arc, columns) else None


def _allowed(noise: float) -> float:
    """Deviation from an arc that the noise of the points allows, metres."""
    return min(max(FINE, 2 * noise), COARSE)


def _run_of(place: Ints, on: Bools, around: int | None, *, off: int = 3, gap: int = 13) -> Ints:
    """Rows of the longest run of columns that lie on an arc; several in a row that do not, or none seen over a long gap, part runs.

    Parameters
    ----------
    place : (n,) int64
        Places of the columns along the arc, ascending.
    on : (n,) bool
        Columns that lie on the arc.
    around : int, optional
        Number of places of a closed circle.
    off : int
        So many columns aside in a row part runs.
    gap : int
        Longer gaps than so many places part runs.
    """
    rows = np.flatnonzero(on)
    if not len(rows):
        return rows
    aside, apart = np.diff(rows) - 1, np.diff(place[rows])
    parted = (aside >= off) | (apart > gap)
    joined = around is not None and len(place) - 1 - rows[-1] + rows[0] < off and place[rows[0]] + around - place[rows[-1]] <= gap
    runs = [run.tolist() for run in np.split(rows, np.flatnonzero(parted) + 1)]
    spans = [list(range(run[0], run[-1] + 1)) for run in runs]
    if joined and len(spans) > 1:
        spans[0] = list(range(spans[-1][0], len(place))) + list(range(spans[0][-1] + 1))
        spans.pop()
    elif joined:
        spans = [list(range(len(place)))]
    return np.array(max(spans, key=lambda span: (len(span), -span[0])), dtype=np.int64)


def _column_medians(arc: Arc, xy: Floats, *, fewest: int = 5) -> tuple[Floats, Ints, Floats]:
    """Median point (n, 2) and place (n,) of each column along an arc that has points, and the distances of points from their median."""
    count = max(round(arc.length / COLUMN), 1)
    column = np.minimum((arc.after_start(xy) / arc.turn * count).astype(np.int64), count - 1)
    across = np.hypot(*(xy - arc.centre).T) - arc.radius
    first, across = ascending_in_groups(column, across, count)
    number = np.diff(first)
    told = number >= fewest
    if not told.any():
        return np.zeros((0, 2)), np.zeros(0, dtype=np.int64), np.zeros(0)
    median = np.where(told, across[np.minimum(first[:-1] + number // 2, len(across) - 1)], np.nan)
    at = arc.start + (np.arange(count) + 0.5) / count * arc.turn
    points = arc.centre + (arc.radius + median)[:, None] * np.column_stack([np.cos(at), np.sin(at)])
    apart = across - np.repeat(median, number)
    return points[told], np.flatnonzero(told), apart[np.isfinite(apart)]


def _is_curved(arc: Arc, columns: Floats) -> bool:
    """Whether a wall is an arc, and neither straight nor a straight one with a bend."""
    sagitta = arc.radius * (1 - np.cos(min(arc.turn, np.pi) / 2))
    if arc.deviation > _allowed(arc.noise) or sagitta < 1.5 * REACH or np.sqrt(arc.covariance[2, 2]) > LEAST_SURE * arc.radius:
        return False
    if arc.turn > np.pi / 2:
        return True
    middle = arc.start + arc.turn / 2
    along = (columns - arc.centre) @ np.array([-np.sin(middle), np.cos(middle)])
    across = (columns - arc.centre) @ np.array([np.cos(middle), np.sin(middle)])
    residual = np.hypot(*(columns - arc.centre).T) - arc.radius
    return bool(np.sqrt(np.mean(residual**2)) < _rms_of_one_bend(along, across))


def _rms_of_one_bend(x: Floats, y: Floats) -> float:
    """Root mean square distance of points from the best line with one bend."""
    best = np.inf
    for bend in np.linspace(x.min(), x.max(), 12)[1:-1]:
        table = np.column_stack([np.ones(len(x)), x, np.maximum(x - bend, 0.0)])
        coefficients, *_ = np.linalg.lstsq(table, y, rcond=None)
        best = min(best, float(np.sqrt(np.mean((y - table @ coefficients) ** 2))))
    return best
