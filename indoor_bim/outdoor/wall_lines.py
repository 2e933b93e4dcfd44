"""Straight faces of walls among the wall cells, strongest first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.outdoor.wall_cells import WallCells

Floats = NDArray[np.float64]

ANGLE_STEP = np.radians(1.0)
ANGLE_SPREAD = 12
OFFSET_STEP = 0.05
TOLERANCE = 0.12
TAKEN = 0.25


@dataclass(frozen=True, slots=True)
class WallLine:
    """Face of a wall in plan.

    Parameters
    ----------
    start, end : (float, float)
        Ends, metres.
    fill : float
        Filled height of its cells summed along it, square metres of wall.
    coverage : float
        Share of its length with wall cells.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    fill: float
    coverage: float

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))


def find_wall_lines(cells: WallCells, *, shortest: float = 0.6, gap: float = 1.0, least_fill: float = 1.2) -> list[WallLine]:
    """Find the straight faces among the cells of one group of walls.

    Parameters
    ----------
    cells : WallCells
        Cells of one group.
    shortest : float
        Shortest face, metres.
    gap : float
        Faces end where there is nothing over this length, metres.
    least_fill : float
        Mean filled height of a face, metres.

    Returns
    -------
    list of WallLine
        Strongest first.

    Notes
    -----
    A Hough transform in which each cell votes about its own direction; the strongest line is fitted to its cells, they are taken
    out, and the next one follows. All votes count from the middle of the cells, in the frame of their main direction, so that it
    does not matter how the scan lies.
    """
    if len(cells) < 3:
        return []
    middle = np.average(cells.xy, axis=0, weights=cells.fill)
    turn = main_direction(cells.normal, cells.fill * cells.flatness)
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, s], [-s, c]])
    xy, normal = (cells.xy - middle) @ rotation.T, cells.normal @ rotation.T
    lines = []
    for p, q, fill, coverage in _peel(xy, normal, cells.fill, cells.flatness, shortest=shortest, gap=gap, least_fill=least_fill):
        start, end = np.array([p, q]) @ rotation + middle
        lines.append(WallLine((float(start[0]), float(start[1])), (float(end[0]), float(end[1])), fill, coverage))
    return lines


def main_direction(normal: Floats, weight: Floats) -> float:
    """Angle in radians, 0 to a quarter turn, that most directions lie at or square to.

    Parameters
    ----------
    normal : (m, 2) float64
        Directions.
    weight : (m,) float64
        Their weights.

    Examples
    --------
    >>> round(main_direction(np.array([[1.0, 0.1], [-0.1, 1.0]]), np.ones(2)), 4)
    0.0997
    """
    angle = np.arctan2(normal[:, 1], normal[:, 0])
    x, y = (weight * np.cos(4 * angle)).sum(), (weight * np.sin(4 * angle)).sum()
    return float(np.arctan2(y, x) / 4 % (np.pi / 2))


def _peel(
    xy: Floats, normal: Floats, fill: Floats, flatness: Floats, *, shortest: float, gap: float, least_fill: float
) -> Iterator[tuple[Floats, Floats, float, float]]:
    """Yield ends, filled area and coverage of one face after another."""
    angles = np.arange(0.0, np.pi, ANGLE_STEP)
    reach = np.hypot(*xy.T).max() + 1.0
    offsets = int(2 * reach / OFFSET_STEP) + 2
    own = np.round(np.arctan2(normal[:, 1], normal[:, 0]) / ANGLE_STEP).astype(np.int64)
    spread = np.arange(-ANGLE_SPREAD, ANGLE_SPREAD + 1)
    turned = own[:, None] + spread
    angle_index = turned % len(angles)
    votes_angle = angles[angle_index]
    offset = xy[:, :1] * np.cos(votes_angle) + xy[:, 1:] * np.sin(votes_angle)
    offset_index = np.round((offset + reach) / OFFSET_STEP).astype(np.int64)
    key = angle_index * offsets + offset_index
    weight = fill * (0.2 + flatness)
    taper = 1.0 - 0.5 * np.abs(spread) / ANGLE_SPREAD
    votes = np.zeros(len(angles) * offsets)
    np.add.at(votes, key.ravel(), (weight[:, None] * taper).ravel())
    free = np.ones(len(xy), dtype=np.bool_)
    while free.sum() >= 3:
        image = votes.reshape(len(angles), offsets)
        smooth = image.copy()
        smooth[:, 1:] += 0.5 * image[:, :-1]
        smooth[:, :-1] += 0.5 * image[:, 1:]
        peak = int(smooth.argmax())
        if smooth.ravel()[peak] < 0.5 * shortest / 0.1 * least_fill:
            return
        angle, place = angles[peak // offsets], (peak % offsets) * OFFSET_STEP - reach
        n = np.array([np.cos(angle), np.sin(angle)])
        taken = np.zeros(0, dtype=np.int64)
        fitted = _fit(xy, normal, fill, free, n, place)
        if fitted is not None:
            n, place, member = fitted
            along = xy @ np.array([-n[1], n[0]])
            for low, high, run in _runs(along, member, gap):
                length = high - low
                area = float(fill[run].sum()) * 0.1
                if length < shortest or area < least_fill * length * 0.4:
                    continue
                coverage = len(np.unique(np.floor(along[run] / 0.2))) / (length / 0.2 + 1)
                if coverage < 0.4:
                    continue
                refit = _refit(xy[run], fill[run], n)
                m, at = refit
                d = np.array([-m[1], m[0]])
                s = xy[run] @ d
                yield m * at + d * s.min(), m * at + d * s.max(), area, min(1.0, coverage)
                near = free & (np.abs(xy @ m - at) < TAKEN) & (xy @ d > s.min() - 0.1) & (xy @ d < s.max() + 0.1)
                near &= (np.abs(normal @ m) > np.cos(np.radians(35.0))) | (np.abs(xy @ m - at) < TOLERANCE)
                taken = np.union1d(taken, np.flatnonzero(near))
        if not len(taken):
            close = free & (np.abs(xy @ np.array([np.cos(angle), np.sin(angle)]) - ((peak % offsets) * OFFSET_STEP - reach)) < OFFSET_STEP)
            close &= np.abs(normal @ np.array([np.cos(angle), np.sin(angle)])) > np.cos((ANGLE_SPREAD + 1) * ANGLE_STEP)
            taken = np.flatnonzero(close)
            if not len(taken):
                return
        free[taken] = False
        np.subtract.at(votes, key[taken].ravel(), (weight[taken, None] * taper).ravel())


def _fit(
    xy: Floats, normal: Floats, fill: Floats, free: NDArray[np.bool_], n: Floats, place: float
) -> tuple[Floats, float, NDArray[np.int64]] | None:
    """Fit a line to the free cells about it; None when there are none."""
    member = np.zeros(0, dtype=np.int64)
    for tolerance in (2 * TOLERANCE, 1.5 * TOLERANCE, TOLERANCE, TOLERANCE):
        along_it = np.abs(normal @ n) > np.cos(np.radians(20.0))
        member = np.flatnonzero(free & along_it & (np.abs(xy @ n - place) < tolerance))
        if len(member) < 3:
            return None
        fitted = _refit(xy[member], fill[member], n)
        if abs(fitted[0] @ n) < np.cos(np.radians(10.0)):
            return None
        n, place = fitted
    return n, place, member


def _refit(xy: Floats, weight: Floats, n: Floats) -> tuple[Floats, float]:
    """Line of least weighted square distance: normal and offset; the normal on the side of `n`."""
    mean = np.average(xy, axis=0, weights=weight)
    d = xy - mean
    _, vectors = np.linalg.eigh((d * weight[:, None]).T @ d)
    m = vectors[:, 0] * (1.0 if vectors[:, 0] @ n >= 0 else -1.0)
    return m, float(mean @ m)


def _runs(along: Floats, member: NDArray[np.int64], gap: float) -> list[tuple[float, float, NDArray[np.int64]]]:
    """Stretches of cells without a gap, longest first."""
    order = member[np.argsort(along[member], kind="stable")]
    breaks = np.flatnonzero(np.diff(along[order]) > gap) + 1
    runs = [(float(along[run[0]]), float(along[run[-1]]), run) for run in np.split(order, breaks)]
    return sorted(runs, key=lambda run: (run[0] - run[1], run[0]))
