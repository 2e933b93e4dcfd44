"""Faces that lie on one line and look the same way, chained over doors and butting walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.intervals import Interval, merge_intervals, overlap
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]

PARALLEL_COS = np.cos(np.radians(2.5))  # faces of one line differ less than this in direction
CROSSING_SINE = np.sin(np.radians(30.0))  # a face that crosses a line differs more than this in direction
CROSSING_REACH = 0.25  # metres that it reaches beyond the line on both sides: more than a corner's tolerance
CROSSING_SLACK = 0.10  # metres that a gap is widened by, to hold the faces that bound it


@dataclass(frozen=True, slots=True, eq=False)
class FaceChains:
    """Lines that carry one or more faces.

    Parameters
    ----------
    faces : Segments
        All faces.
    members : tuple of tuple of int
        Rows of `faces` on each line.
    point, direction : (k, 2) float64
        A point of each line and its unit direction; free space to the left where `sided`.
    sided : (k,) bool
        True where the side of free space is known.
    extents : tuple of tuple of Interval
        Where each line carries faces, in metres from `point` along `direction`, gaps bridged.
    """

    faces: Segments
    members: tuple[tuple[int, ...], ...]
    point: Floats
    direction: Floats
    sided: NDArray[np.bool_]
    extents: tuple[tuple[Interval, ...], ...]

    def __len__(self) -> int:
        return len(self.point)

    @property
    def normal(self) -> Floats:
        """(k, 2) float64 unit normals to the left."""
        return np.column_stack([-self.direction[:, 1], self.direction[:, 0]])

    def mostly(self, flag: NDArray[np.bool_], chain: int) -> bool:
        """Tell whether a flag (m,) of the faces holds for more than half of a chain's length."""
        rows = list(self.members[chain])
        length = self.faces.length[rows]
        return bool(length[flag[rows]].sum() > 0.5 * length.sum())

    def offset_at(self, chain: int, *, direction: Floats, along: float) -> float:
        """Offset of a chain's line, to the left of `direction` (2,), at `along` metres on it."""
        normal = np.array([-direction[1], direction[0]])
        d, p = self.direction[chain], self.point[chain]
        s = (along - p @ direction) / (d @ direction)
        return float((p + s * d) @ normal)

    def evidence(self, chains: tuple[int, ...], *, direction: Floats, span: Interval) -> tuple[int, float, float, float]:
        """Support, coverage, rmse and top of the faces of some chains within a stretch.

        Parameters
        ----------
        chains : tuple of int
            The one or two chains of a wall.
        direction : (2,) float64
            Unit direction along which `span` is measured, in metres from the origin.
        span : Interval
            The stretch.
        """
        support, seen, squares, tops = 0.0, 0.0, 0.0, []
        for row in (row for chain in chains for row in self.members[chain]):
            a, b = sorted(float(x) for x in np.array([self.faces.p[row], self.faces.q[row]]) @ direction)
            share = overlap((a, b), span) / max(b - a, 1e-9)
            if share <= 0:
                continue
            n = float(self.faces.support[row]) * share
            support += n
            seen += float(self.faces.coverage[row]) * overlap((a, b), span)
            squares += n * float(np.nan_to_num(self.faces.rmse[row])) ** 2
            tops.append(float(self.faces.top[row]))
        coverage = seen / max(len(chains) * (span[1] - span[0]), 1e-9)
        rmse = float(np.sqrt(squares / support)) if support else float("nan")
        known = [t for t in tops if np.isfinite(t)]
        return round(support), min(1.0, coverage), rmse, max(known) if known else float("nan")


def chain_faces(faces: Segments, *, bridged_gap: float, offset_tolerance: float) -> FaceChains:
    """Chain faces that lie on one line, look the same way and are no farther apart than `bridged_gap`.

    A gap that another face crosses is a passage between two walls, such as a corridor, and is never bridged.

    Greedy from the longest face: a face joins a line when both its ends are within `offset_tolerance` of it. The line
    is then fitted to all its faces, each weighted by its length.

    Parameters
    ----------
    faces : Segments
        Faces in metres.
    bridged_gap : float
        Widest gap between neighbours on a line, metres.
    offset_tolerance : float
        Largest distance of a face's ends from the line, metres.
    """
    order = np.lexsort(np.column_stack([np.round(np.column_stack([faces.q, faces.p]), 6), -np.round(faces.length, 6)]).T)
    free = np.ones(len(faces), dtype=bool)
    members: list[tuple[int, ...]] = []
    lines: list[tuple[Floats, Floats]] = []
    for seed in order:
        if not free[seed]:
            continue
        group = _collect(faces, int(seed), free, bridged_gap=bridged_gap, offset_tolerance=offset_tolerance)
        free[list(group)] = False
        members.append(group)
        lines.append(_fit(faces, group))
    point = np.array([p for p, _ in lines]).reshape(-1, 2)
    direction = np.array([d for _, d in lines]).reshape(-1, 2)
    extents = []
    for k, group in enumerate(members):
        spans = [_span(faces, row, point[k], direction[k]) for row in group]
        extents.append(tuple(_bridged(spans, _crossings(faces, point[k], direction[k]), gap=bridged_gap)))
    sided = np.array([bool(faces.sided[group[0]]) for group in members], dtype=bool)
    return FaceChains(faces, tuple(members), point, direction, sided, tuple(extents))


def _collect(faces: Segments, seed: int, free: NDArray[np.bool_], *, bridged_gap: float, offset_tolerance: float) -> tuple[int, ...]:
    """Rows on the line of the seed, growing outwards while the gaps stay narrow."""
    d, n, p = faces.direction[seed], faces.normal[seed], faces.p[seed]
    on_line = (
        free
        & (faces.sided == faces.sided[seed])
        & (faces.direction @ d > PARALLEL_COS)
        & (np.abs((faces.p - p) @ n) < offset_tolerance)
        & (np.abs((faces.q - p) @ n) < offset_tolerance)
    )
    rows = [int(k) for k in np.flatnonzero(on_line)]
    spans = {k: _span(faces, k, p, d) for k in rows}
    for lo, hi in _bridged(list(spans.values()), _crossings(faces, p, d), gap=bridged_gap):
        if lo <= spans[seed][0] and spans[seed][1] <= hi:
            return tuple(k for k in rows if lo <= spans[k][0] and spans[k][1] <= hi)
    return (seed,)


def _span(faces: Segments, row: int, point: Floats, direction: Floats) -> Interval:
    """Stretch of a line that a face covers, in metres from `point`."""
    a, b = sorted(float(x) for x in (np.array([faces.p[row], faces.q[row]]) - point) @ direction)
    return a, b


def _crossings(faces: Segments, point: Floats, direction: Floats) -> Floats:
    """Places where faces cross a line and reach beyond it on both sides."""
    normal = np.array([-direction[1], direction[0]])
    a, b = (faces.p - point) @ normal, (faces.q - point) @ normal
    through = (np.minimum(a, b) < -CROSSING_REACH) & (np.maximum(a, b) > CROSSING_REACH)
    crossing = (np.abs(faces.direction @ normal) > CROSSING_SINE) & through
    share = a[crossing] / (a[crossing] - b[crossing])
    hits = faces.p[crossing] + share[:, None] * (faces.q - faces.p)[crossing]
    places: Floats = (hits - point) @ direction
    return places


def _bridged(spans: list[Interval], crossings: Floats, *, gap: float) -> list[Interval]:
    """Union of spans over gaps that no face crosses; spans that touch are joined in any case."""
    touching = merge_intervals(spans, gap=0.05)
    barriers = [float(x) + shift for x in crossings for shift in (-CROSSING_SLACK, 0.0, CROSSING_SLACK)]
    return merge_intervals(touching, gap=gap, barriers=barriers)


def _fit(faces: Segments, group: tuple[int, ...]) -> tuple[Floats, Floats]:
    """Line through the end points of some faces, each weighted by its length: (point, direction)."""
    rows = list(group)
    if len(rows) == 1:
        return faces.p[rows[0]], faces.direction[rows[0]]
    length = faces.length[rows]
    ends = np.concatenate([faces.p[rows], faces.q[rows]])
    weight = np.concatenate([length, length])
    centre = np.average(ends, axis=0, weights=weight)
    rest = ends - centre
    _, vectors = np.linalg.eigh((rest * weight[:, None]).T @ rest)
    direction = vectors[:, 1]
    along = np.average(faces.direction[rows], axis=0, weights=length)
    return centre, direction if direction @ along > 0 else -direction
