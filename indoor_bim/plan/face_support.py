"""Support, spread, coverage and covariance of faces by the points on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]
COLUMN = 0.10
"""Width of the columns that the coverage of a face is counted in, metres."""
LAYERS = 10
FEW_POINTS = 20_000
"""So many points are sorted, sooner than the compiled loops are loaded."""


def measure(faces: Segments, points: WallPoints, *, reach: float = 0.05) -> Segments:
    """Support, spread, coverage and covariance of faces.

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
    support, rmse, coverage = np.zeros(len(faces), dtype=np.int64), np.full(len(faces), np.nan), np.zeros(len(faces))
    for k, (p, d, n, length) in enumerate(zip(faces.p, faces.direction, faces.normal, faces.length, strict=True)):
        hit = np.zeros((max(int(np.ceil(length / COLUMN)), 1), LAYERS), dtype=bool)
        ranges = points.along(p, p + length * d, reach)
        count, squares = points_on_face(*table, ranges, p.copy(), d.copy(), n.copy(), length, reach, COLUMN, hit)
        if count:
            support[k], rmse[k], coverage[k] = count, np.sqrt(squares / count) * MICROMETRE, hit.mean()
    return _with_covariance(replace(faces, sided=np.ones(len(faces), dtype=bool), support=support, rmse=rmse, coverage=coverage))


def _with_covariance(faces: Segments) -> Segments:
    """Faces with the covariance of their lines in polar form (alpha, R), from their spread and what was seen of them.

    All points of a column count as one observation: they were taken within moments and share the drift of the scanner. For n columns
    evenly along a line of length L, the variance of the offset in the middle is rmse^2 / n, and that of the angle 12 rmse^2 / (n L^2).
    """
    columns = np.maximum(faces.coverage * faces.length / COLUMN, 1.0)
    offset = faces.rmse**2 / columns
    angle = 12 * offset / np.maximum(faces.length, COLUMN) ** 2
    lever = -((faces.p + faces.q) / 2 * faces.direction).sum(axis=1)
    both = angle * lever
    return replace(faces, covariance=np.array([[angle, both], [both, offset + angle * lever**2]]).transpose(2, 0, 1))


def measure_by_sorting(faces: Segments, points: WallPoints, *, reach: float = 0.05) -> Segments:
    """Twin of `measure` in numpy: slower, for few points."""
    order = np.argsort(points.xy[:, 0], kind="stable")
    xy, rise = points.xy[order], points.rise[order]
    sensor = None if points.sensor is None else points.sensor[order]
    support, rmse, coverage = np.zeros(len(faces), dtype=np.int64), np.full(len(faces), np.nan), np.zeros(len(faces))
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
        coverage[k] = len(np.unique(cells)) / (columns * layers)
    return _with_covariance(
        replace(faces, sided=np.ones(len(faces), dtype=bool), support=support, rmse=rmse, coverage=np.minimum(coverage, 1.0))
    )
