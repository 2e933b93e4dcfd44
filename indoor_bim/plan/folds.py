"""Curtains: what hangs in folds before a face that shows beside it or behind it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.ordering import ascending_in_groups
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import FaceLines

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

COLUMN = 0.025
"""Width of the columns along a face in which its depth is measured, metres: folds are wider."""
FEWEST = 4
"""Points of a column that has a depth."""
REACH = 0.06
"""Points this close to a line take part, metres."""
TREND = 0.20
"""Half of the stretch over which the depth is averaged, metres: several folds, and less than a wall bends."""
WINDOW = 0.40
"""Half of the stretch over which folds are told, metres."""
ROUGHEST = 0.015
"""Root mean square depth of folds at least, metres; noise and drift leave less of a wall."""
TIMES = 3.0
"""How many times deeper folds are than the noise of the points leaves at random."""
SHORTEST = 0.5
"""Shortest curtain, and shortest piece of a line beside one, metres."""
BEFORE = (0.035, 0.35)
"""Distance of a curtain from the face that it hangs before, metres."""
BESIDE = 8.0
"""Farthest end of that face from the curtain along the wall, metres."""
TURN = 6.0
"""Largest angle between the two, degrees."""


def without_curtains(lines: FaceLines, points: WallPoints) -> FaceLines:
    """Lines of faces, those of curtains replaced by the faces that they hang before.

    A curtain hangs in folds, up to the ceiling like a wall: within a few decimetres the depth of its points goes to and fro by
    centimetres, which that of a wall does not. Where a face runs behind it, or along farther on, that goes on behind the curtain.

    Parameters
    ----------
    lines : FaceLines
        Lines, near enough to the points.
    points : WallPoints
        Candidates.

    Returns
    -------
    FaceLines
        Lines, pieces of lines, and faces behind curtains.
    """
    before = _hang_before(lines)
    table = []
    for k in range(len(lines)):
        start, end = float(lines.start[k]), float(lines.end[k])
        curtains = _curtains(start, folds_along(lines, k, points), end) if len(before[k]) else []
        stops = [start, *(stop for curtain in curtains for stop in curtain), end]
        shortest = SHORTEST if curtains else 0.0
        table += [(k, a, b) for a, b in zip(stops[::2], stops[1::2], strict=True) if b - a >= shortest]
        table += [piece for a, b in curtains for piece in _behind(lines, k, a, b, before[k])]
    rows, starts, ends = (np.array(column) for column in zip(*table, strict=True)) if table else (np.zeros(0),) * 3
    return replace(lines.take(rows.astype(np.int64)), start=starts, end=ends)


def folds_along(lines: FaceLines, row: int, points: WallPoints) -> Bools:
    """Where along a line the points lie in folds, one value for each `COLUMN`.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    row : int
        Line.
    points : WallPoints
        Candidates.
    """
    d, n = lines.direction[row], lines.normal[row]
    foot = lines.offset[row] * n
    ranges = points.along(foot + lines.start[row] * d, foot + lines.end[row] * d, REACH)
    x, y = np.concatenate([np.zeros((0, 2)), *(points.xy[first:last] for first, last in ranges)]).T
    length = float(lines.end[row] - lines.start[row])
    count = max(int(np.ceil(length / COLUMN)), 1)
    across = x * n[0] + y * n[1] - lines.offset[row]
    near = np.flatnonzero(np.abs(across) < REACH)
    along = x[near] * d[0] + y[near] * d[1] - lines.start[row]
    inside = (along >= 0) & (along < count * COLUMN)
    return folded((along[inside] / COLUMN).astype(np.int64), across[near[inside]], count)


def folded(column: Ints, depth: Floats, count: int) -> Bools:
    """Columns around which the depth of a surface goes to and fro.

    Parameters
    ----------
    column : (n,) int64
        Column of each point, from 0.
    depth : (n,) float64
        Its distance across the surface, metres.
    count : int
        Number of columns.

    Examples
    --------
    >>> column = np.repeat(np.arange(80), 9)
    >>> noise = np.tile(np.linspace(-0.01, 0.01, 9), 80)
    >>> folds = 0.03 * np.sin(2 * np.pi * column * COLUMN / 0.18)
    >>> bool(folded(column, noise + folds, 80).all()), bool(folded(column, noise, 80).any())
    (True, False)
    """
    first, depth = ascending_in_groups(column, depth, count)
    number = np.diff(first)
    known = number >= FEWEST
    if not known.any():
        return np.zeros(count, dtype=bool)
    lower, upper = ((first[:-1] + np.maximum(number - shift, 0) // 2)[known] for shift in (1, 0))
    median = np.zeros(count)
    median[known] = (depth[lower] + depth[np.minimum(upper, len(depth) - 1)]) / 2
    column = np.repeat(np.arange(count), number)
    total = np.bincount(column, depth, count)
    scatter = np.bincount(column, depth**2, count) - total**2 / np.maximum(number, 1)
    trend, around = round(TREND / COLUMN), round(WINDOW / COLUMN)
    mean = _sum_around(median, trend) / np.maximum(_sum_around(known, trend), 1)
    away = np.where(known, median - mean, 0.0)
    columns = np.maximum(_sum_around(known, around), 1)
    rough = np.sqrt(_sum_around(away**2, around) / columns)
    variance = _sum_around(np.where(known, scatter, 0.0), around) / np.maximum(_sum_around(np.where(known, number - 1, 0), around), 1)
    by_chance = np.sqrt(np.pi / 2 * variance * _sum_around(np.where(known, 1 / np.maximum(number, 1), 0.0), around) / columns)
    filled = _sum_around(known, around) >= around / 2
    return np.asarray(filled & (rough > ROUGHEST) & (rough > TIMES * by_chance), dtype=bool)


def _sum_around(values: NDArray, reach: int) -> Floats:
    """Sums of the values up to `reach` places to both sides."""
    total = np.concatenate([[0.0], np.cumsum(values, dtype=np.float64)])
    place = np.arange(len(values))
    sums: Floats = total[np.minimum(place + reach + 1, len(values))] - total[np.maximum(place - reach, 0)]
    return sums


def _hang_before(lines: FaceLines) -> list[Ints]:
    """Lines that each line may hang before: of about its direction, behind it, running along or beginning not far beside it."""
    direction = lines.direction
    tails, heads = lines.ends()
    found = []
    for k in range(len(lines)):
        d = direction[k]
        first, last = (tails - tails[k]) @ d, (heads - tails[k]) @ d
        length = float(lines.end[k] - lines.start[k])
        middle = (np.clip(first, 0.0, length) + np.clip(last, 0.0, length)) / 2
        depth = ((tails[k] + middle[:, None] * d) * lines.normal).sum(axis=1) - lines.offset
        near = (first < length + BESIDE) & (last > -BESIDE) & (depth > BEFORE[0]) & (depth < BEFORE[1])
        found.append(np.flatnonzero(near & (direction @ d > np.cos(np.radians(TURN)))))
    return found


def _curtains(start: float, folds: Bools, end: float) -> list[tuple[float, float]]:
    """Stretches of a line that are curtains: all of it where most of it is."""
    if folds.mean() > 0.5:
        return [(start, end)]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], folds.astype(np.int8), [0]]))).reshape(-1, 2)
    return [(a, min(b, end)) for a, b in (start + edges * COLUMN).tolist() if b - a >= SHORTEST]


def _behind(lines: FaceLines, k: int, a: float, b: float, faces: Ints) -> list[tuple[int, float, float]]:
    """Face behind a curtain, where it is not known there: its number, and start and end along it."""
    d = lines.direction
    tails, heads = (ends[faces] @ d[k] for ends in lines.ends())
    away = np.maximum(np.maximum(tails - b, a - heads), 0.0)
    face = int(faces[np.lexsort((faces, np.round(away, 6)))[0]])
    hung = np.array([a, b])[:, None] * d[k] + lines.offset[k] * lines.normal[k]
    first, last = hung @ d[face]
    known = (float(lines.start[face]), float(lines.end[face]))
    pieces = [(first, min(last, known[0])), (max(first, known[1]), last)]
    return [(face, float(u), float(v)) for u, v in pieces if v - u > COLUMN]
