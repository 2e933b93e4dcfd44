"""Walls that continue one another become one wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_bim.plan.walls import Walls

PARALLEL_COS = np.cos(np.radians(2.5))  # one wall's parts differ less than this in direction


def merge_collinear(walls: Walls, *, gap: float = 0.10, tolerance: float = 0.03) -> Walls:
    """Join walls on one line whose faces are flush.

    Two walls are parts of one when they are parallel, both their faces are within `tolerance` of each other's, and no more
    than `gap` lies between their ends. The joined axis and thickness are means weighted by length; measured thicknesses win
    over assumed ones.

    Parameters
    ----------
    walls : Walls
        Walls in metres.
    gap : float
        Widest gap between the ends, metres.
    tolerance : float
        Largest step between faces, metres.
    """
    table = walls
    while len(table) > 1:
        pair = _first_pair(table, gap=gap, tolerance=tolerance)
        if pair is None:
            break
        table = _joined(table, *pair)
    return table


def _first_pair(walls: Walls, *, gap: float, tolerance: float) -> tuple[int, int] | None:
    """The pair to join next: the longest wall first, then its nearest continuation."""
    length, d, n = walls.length, walls.direction, walls.normal
    for i in np.lexsort((np.arange(len(walls)), -np.round(length, 6))):
        parallel = np.abs(d @ d[i]) > PARALLEL_COS
        ends = np.stack([walls.p - walls.p[i], walls.q - walls.p[i]])
        along = np.sort(ends @ d[i], axis=0)
        between = np.maximum(along[0] - length[i], -along[1])
        near = np.argmin(np.abs(ends @ d[i] - length[i] / 2), axis=0)
        step = np.abs(ends @ n[i])[near, np.arange(len(walls))]
        slack = np.where(walls.measured & walls.measured[i], np.abs(walls.thickness - walls.thickness[i]) / 2, 0.0)
        good = parallel & (between <= gap) & (step + slack <= tolerance)
        good[i] = False
        if good.any():
            rows = np.flatnonzero(good)
            return int(i), int(rows[np.lexsort((rows, np.round(between[rows], 6)))[0]])
    return None


def _joined(walls: Walls, i: int, j: int) -> Walls:
    """Table with row j merged into row i."""
    rows = [i, j]
    length = walls.length[rows]
    weight = np.maximum(length, 1e-6)
    dominant = walls.direction[i]
    same = walls.direction[j] @ dominant > 0
    dj = walls.direction[j] if same else -walls.direction[j]
    direction = weight[0] * dominant + weight[1] * dj
    direction /= np.hypot(*direction)
    normal = np.array([-direction[1], direction[0]])
    middle = (walls.p[rows] + walls.q[rows]) / 2
    offset = np.average(middle @ normal, weights=weight)
    along = np.concatenate([walls.p[rows], walls.q[rows]]) @ direction
    trusted = walls.measured[rows] if walls.measured[rows].any() else np.ones(2, dtype=bool)
    support = walls.support[rows]
    squares = support * np.nan_to_num(walls.rmse[rows]) ** 2
    tops = walls.top[rows]
    row = Walls(
        p=(direction * along.min() + normal * offset)[None],
        q=(direction * along.max() + normal * offset)[None],
        thickness=np.array([np.average(walls.thickness[rows][trusted], weights=weight[trusted])]),
        measured=np.array([walls.measured[rows].any()]),
        seen_left=walls.seen_left[[i]],
        support=np.array([support.sum()]),
        coverage=np.array([np.average(walls.coverage[rows], weights=weight)]),
        rmse=np.array([np.sqrt(squares.sum() / support.sum()) if support.sum() else np.nan]),
        top=np.array([np.nanmax(tops) if np.isfinite(tops).any() else np.nan]),
    )
    rest = np.setdiff1d(np.arange(len(walls)), rows)
    kept = walls.take(rest)
    merged = {name: np.concatenate([getattr(kept, name), getattr(row, name)]) for name in Walls.__slots__}
    table = replace(walls, **merged)
    return table.take(np.lexsort(np.round(np.column_stack([table.q, table.p]).T, 6)))
