"""Lines of faces placed on the points themselves, by weighted robust least squares."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]

TUKEY = 4.685
"""Tukey's constant: 95 % efficiency where there are no outliers."""
COLUMN = 0.10
LAYERS = 10
"""Cells of a face: width in metres, and number along the height."""
DEPTH = 0.0025
"""Points of a cell that are this close across the line are taken together, metres."""
FULL = 4.0
"""Points of a cell beyond which it hardly gains weight."""
MICROMETRE = 1e-6
STRETCH = 0.10
"""Width of the columns that points are sorted into, metres."""


def fit_to_points(lines: FaceLines, points: WallPoints, *, reach: float = 0.05, finest: float = 0.001, shortest: float = 0.7) -> FaceLines:
    """Lines fitted to the points along them that were seen from their left.

    Every bit of surface counts about alike, however often it was hit. Weights are Tukey's, their scale the median distance of
    the points from the line.

    Parameters
    ----------
    lines : FaceLines
        Lines within a strip or two of the points.
    points : WallPoints
        Candidates.
    reach : float
        Points this close to a line take part, metres.
    finest : float
        Least standard deviation that is assumed, metres.
    shortest : float
        Shorter lines keep their direction, metres.

    Returns
    -------
    FaceLines
        The same rows; lines that would leave what they were found on stay.

    References
    ----------
    Beaton, Tukey, The fitting of power series, meaning polynomials, illustrated on band-spectroscopic data, Technometrics 16, 1974.
    """
    angle, offset, start, end = (getattr(lines, name).copy() for name in ("angle", "offset", "start", "end"))
    ordered = [_by_column(points, axis) for axis in (0, 1)]
    tails, heads = lines.ends()
    for k, (d, n) in enumerate(zip(lines.direction, lines.normal, strict=True)):
        axis = int(abs(d[0]) > abs(d[1]))
        ends = sorted([tails[k, axis], heads[k, axis]])
        columns = ordered[axis]
        rows = columns.between(ends[0] - reach, ends[1] + reach)
        x, y = columns.xy[rows].T
        along, across = x * d[0] + y * d[1] - lines.start[k], x * n[0] + y * n[1] - lines.offset[k]
        length = float(lines.end[k] - lines.start[k])
        on = (np.abs(across) < reach) & (along > 0) & (along < length)
        if columns.sensor is not None:
            x, y = columns.sensor[rows][on].T
            on[on] = x * n[0] + y * n[1] > lines.offset[k]
        found = _robust_line(along[on], across[on], columns.rise[rows][on], reach=reach, finest=finest, turn=length >= shortest)
        if found is None or max(abs(found[0]), abs(found[0] + found[1] * length)) > 0.6 * reach:
            continue
        turn = float(np.arctan(found[1]))
        angle[k] += turn
        foot = np.array([lines.start[k], lines.offset[k] + found[0]])
        start[k], offset[k] = np.cos(turn) * foot[0] + np.sin(turn) * foot[1], np.cos(turn) * foot[1] - np.sin(turn) * foot[0]
        end[k] = start[k] + length / np.cos(turn)
    return replace(lines, angle=angle, offset=offset, start=start, end=end)


@dataclass(frozen=True, slots=True, eq=False)
class _Columns:
    """Points in the order of columns across an axis; `first` of each column, from `low` on."""

    xy: Floats
    rise: Floats
    sensor: Floats | None
    low: float
    first: NDArray[np.int64]

    def between(self, start: float, stop: float) -> slice:
        """Points of the columns from a coordinate to another."""
        ends = np.clip([(start - self.low) // STRETCH, (stop - self.low) // STRETCH + 1], 0, len(self.first) - 1).astype(np.int64)
        return slice(*self.first[ends])


def _by_column(points: WallPoints, axis: int) -> _Columns:
    from indoor_bim.plan.face_loops import sort_by_column

    turn = slice(None) if axis == 0 else slice(None, None, -1)
    low, high = (float(points.xy[:, axis].min()), float(points.xy[:, axis].max())) if len(points) else (0.0, 0.0)
    first, rows = np.zeros(int((high - low) / STRETCH) + 2, dtype=np.int64), np.zeros((len(points), 5))
    sensor = np.zeros((0, 2)) if points.sensor is None else np.ascontiguousarray(points.sensor[:, turn])
    sort_by_column(np.ascontiguousarray(points.xy[:, turn]), np.ascontiguousarray(points.rise), sensor, low, STRETCH, first, rows)
    return _Columns(rows[:, :2][:, turn], rows[:, 2], None if points.sensor is None else rows[:, 3:][:, turn], low, first)


def _robust_line(
    x: Floats, y: Floats, rise: Floats, *, reach: float, finest: float, turn: bool, rounds: int = 12
) -> tuple[float, float] | None:
    """Line y = level + slope x; None where the points are too few. Sums of whole micrometres make it the same for any order of them."""
    layer = np.clip((rise * LAYERS).astype(np.int64), 0, LAYERS - 1)
    cell = (x / COLUMN).astype(np.int64) * LAYERS + layer
    slots = int(np.ceil(2 * reach / DEPTH)) + 1
    slot = cell * slots + ((y + reach) / DEPTH).astype(np.int64)
    count = np.bincount(slot)
    taken = np.flatnonzero(count)
    in_cell = np.bincount(cell)
    if np.count_nonzero(in_cell) < 5:
        return None
    x, y = (np.bincount(slot, weights=np.rint(w / MICROMETRE))[taken] * MICROMETRE / count[taken] for w in (x, y))
    share = count[taken] / (in_cell[taken // slots] + FULL)
    level = slope = 0.0
    width = reach
    for _ in range(rounds):
        residual = y - level - slope * x
        near = np.abs(residual) < width
        width = (
            float(np.clip(TUKEY * 1.4826 * _median(np.abs(residual[near]), share[near]), TUKEY * finest, reach)) if near.any() else reach
        )
        weight = share * np.maximum(1 - (residual / width) ** 2, 0.0) ** 2
        total = weight.sum()
        if total < 0.2 * share.sum():
            return None
        mx, my = float((weight * x).sum() / total), float((weight * y).sum() / total)
        if turn:
            slope = float((weight * (x - mx) * (y - my)).sum() / max((weight * (x - mx) ** 2).sum(), 1e-9))
        before, level = level, my - slope * mx
        if abs(level - before) < MICROMETRE:
            break
    return level, slope


def _median(values: Floats, weights: Floats) -> float:
    """Weighted median."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, total[-1] / 2)]])
