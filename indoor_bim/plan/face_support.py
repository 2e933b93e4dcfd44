"""Support, spread, deviation, coverage and covariance of faces by the points on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.segments import Segments
from indoor_bim.threads import in_threads, threads_for

Floats = NDArray[np.float64]
COLUMN = 0.10
"""Width of the columns that the coverage of a face is counted in, metres."""
LAYERS = 10
STRETCH = 0.25
"""Length of the stretches of a face in which the median distance of its points is looked at, metres."""
ACROSS = 0.0001
"""Width of the bins that distances are counted in, metres."""
FINEST = 0.001
"""Least scatter of points that is assumed, metres."""
UPPER = 0.8
"""Share of the height above which doors, windows and furniture hardly reach."""
LEAST_POINTS = 20
"""Points of a stretch that tell where it is."""
FEW_POINTS = 20_000
"""So many points are sorted, sooner than the compiled loops are loaded."""


def measure(faces: Segments, points: WallPoints, *, reach: float = 0.05) -> Segments:
    """Support, spread, deviation, coverage and covariance of faces.

    Parameters
    ----------
    faces : Segments
        Faces, free space to the left of p -> q.
    points : WallPoints
        Candidates.
    reach : float
        Points this close to a face lie on it, metres.
    """
    if len(points) <= FEW_POINTS:
        return measure_by_sorting(faces, points, reach=reach)
    from indoor_bim.plan.face_loops import MICROMETRE, points_on_face

    sensor = np.zeros((0, 2)) if points.sensor is None else np.ascontiguousarray(points.sensor)
    table = (np.ascontiguousarray(points.xy), np.ascontiguousarray(points.rise), sensor)
    direction, normal, length = faces.direction, faces.normal, faces.length

    def one(k: int) -> tuple[int, float, float, NDArray[np.int64]]:
        hit = np.zeros((max(int(np.ceil(length[k] / COLUMN)), 1), LAYERS), dtype=bool)
        counts = np.zeros(_bins(float(length[k]), reach), dtype=np.int64)
        place = (points.along(faces.p[k], faces.p[k] + length[k] * direction[k], reach), faces.p[k].copy(), direction[k], normal[k])
        count, squares = points_on_face(*table, *place, length[k], reach, COLUMN, UPPER, hit, counts)
        return count, np.sqrt(squares / count) * MICROMETRE if count else np.nan, hit.mean(), counts

    found = in_threads(one, range(len(faces)), threads=threads_for(len(points)))
    support, tables = np.array([count for count, *_ in found], dtype=np.int64), [counts for *_, counts in found]
    rmse, coverage = (np.array([row[k] for row in found], dtype=np.float64) for k in (1, 2))
    measured = replace(faces, sided=np.ones(len(faces), dtype=bool), support=support, rmse=rmse, coverage=coverage)
    return _with_accuracy(measured, tables, reach=reach)


def _bins(length: float, reach: float) -> tuple[int, int]:
    """Number of stretches along a face and of bins across it."""
    return max(round(length / STRETCH), 1), round(2 * reach / ACROSS)


def _medians(counts: NDArray[np.int64], *, reach: float) -> Floats:
    """Median distance of the points of each stretch from the face; NaN where a stretch has few."""
    total = np.cumsum(counts, axis=1)
    half = total[:, -1] / 2
    rows, bins = np.arange(len(counts)), np.argmax(total >= half[:, None], axis=1)
    within = (half - total[rows, bins]) / np.maximum(counts[rows, bins], 1) + 1
    medians: Floats = np.where(total[:, -1] >= LEAST_POINTS, (bins + within) * (2 * reach / counts.shape[1]) - reach, np.nan)
    return medians


def _with_accuracy(faces: Segments, counts: Sequence[NDArray[np.int64]], *, reach: float, share: float = 0.95) -> Segments:
    """Faces with the deviation of the points and the covariance of their lines in polar form (alpha, R).

    All points of a stretch count as one observation: they were taken within moments and share the drift of the scanner. For n stretches
    evenly along a line of length L, and points that scatter by s, the variance of the offset in the middle is s^2 / n, and that of the
    angle 12 s^2 / (n L^2). The scatter is 1.4826 times the median distance high on the wall, as things before it are none of its noise;
    where few points are that high, it is the root mean square distance of all.
    """
    deviation, spread = np.full(len(faces), np.nan), np.maximum(faces.rmse, FINEST)
    stretches = np.maximum(faces.coverage * faces.length / STRETCH, 1.0)
    for k, table in enumerate(counts):
        if table.sum() < LEAST_POINTS:
            continue
        medians = _medians(table, reach=reach)
        told = np.abs(medians[np.isfinite(medians)])
        stretches[k] = max(len(told), 1)
        deviation[k] = np.quantile(told, share) if len(told) else np.nan
        apart = np.cumsum(table.sum(axis=0).reshape(2, -1)[0, ::-1] + table.sum(axis=0).reshape(2, -1)[1])
        spread[k] = max(1.4826 * (np.searchsorted(apart, apart[-1] / 2) + 0.5) * reach / len(apart), FINEST)
    offset = spread**2 / stretches
    angle = 12 * offset / np.maximum(faces.length, STRETCH) ** 2
    lever = -((faces.p + faces.q) / 2 * faces.direction).sum(axis=1)
    both = angle * lever
    covariance = np.array([[angle, both], [both, offset + angle * lever**2]]).transpose(2, 0, 1)
    return replace(faces, deviation=deviation, covariance=covariance)


def measure_by_sorting(faces: Segments, points: WallPoints, *, reach: float = 0.05) -> Segments:
    """Twin of `measure` in numpy: slower, for few points."""
    order = np.argsort(points.xy[:, 0], kind="stable")
    xy, rise = points.xy[order], points.rise[order]
    sensor = None if points.sensor is None else points.sensor[order]
    support, rmse, coverage = np.zeros(len(faces), dtype=np.int64), np.full(len(faces), np.nan), np.zeros(len(faces))
    tables = [np.zeros((1, 2), dtype=np.int64)] * len(faces)
    for k, (p, d, n, length) in enumerate(zip(faces.p, faces.direction, faces.normal, faces.length, strict=True)):
        ends = np.sort([p[0], p[0] + length * d[0]])
        rows = slice(*np.searchsorted(xy[:, 0], [ends[0] - reach, ends[1] + reach]))
        along, across = (xy[rows] - p) @ d, (xy[rows] - p) @ n
        on = (np.abs(across) < reach) & (along > 0) & (along < length)
        if sensor is not None:
            on &= (sensor[rows] - p) @ n > 0
        if not on.any():
            continue
        support[k] = int(on.sum())
        rmse[k] = float(np.sqrt(np.mean(across[on] ** 2)))
        columns, layers = max(int(np.ceil(length / COLUMN)), 1), LAYERS
        cells = np.minimum((along[on] / COLUMN).astype(np.int64), columns - 1) * layers + np.minimum(
            (rise[rows][on] * layers).astype(np.int64), layers - 1
        )
        coverage[k] = min(len(np.unique(cells)) / (columns * layers), 1.0)
        stretches, bins = _bins(length, reach)
        stretch = np.minimum((along[on] / length * stretches).astype(np.int64), stretches - 1)
        place = np.minimum(((across[on] + reach) / (2 * reach) * bins).astype(np.int64), bins - 1)
        high = rise[rows][on] > UPPER
        counts = np.bincount((stretch * bins + place)[high], minlength=stretches * bins).reshape(stretches, bins)
        tables[k] = counts
    measured = replace(faces, sided=np.ones(len(faces), dtype=bool), support=support, rmse=rmse, coverage=coverage)
    return _with_accuracy(measured, tables, reach=reach)
