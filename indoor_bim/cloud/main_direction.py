"""The main direction of a building in plan, from the lines that its walls share."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.box_moments import FEW_POINTS, box_moments
from indoor_bim.cloud.extent import bounds
from indoor_bim.cloud.heights import height_peaks, nearest_peak
from indoor_bim.cloud.spacing import sample_mask
from indoor_bim.threads import even_slices, in_threads, threads_for

Floats = NDArray[np.float64]

_COLUMN = 0.05
_ENOUGH = 30_000
"""So many columns tell the direction to a quarter of a degree."""


def main_direction(points: Floats) -> float:
    """Angle of the building's main direction in plan, radians in (-pi/4, pi/4].

    Parameters
    ----------
    points : (n, 3) float64
        Thinned upright points, metres.

    Returns
    -------
    float
        Angle from the x axis to the nearer of the two main directions.
    """
    xy, weight = _wall_columns(np.ascontiguousarray(points[:, :2]))
    few = sample_mask(xy, _ENOUGH)
    some = xy[few], weight[few]
    best, threads = 0.0, threads_for(len(points))
    for reach, step, width, columns in (
        (45.0, 1.0, 0.10, some),
        (1.5, 0.25, 0.05, some),
        (0.3, 0.05, 0.03, (xy, weight)),
        (0.06, 0.01, 0.03, (xy, weight)),
    ):
        angles = best + np.radians(np.arange(-reach, reach + step / 2, step))
        parts = even_slices(len(angles), threads)
        found = in_threads(partial(_sharpness, *columns, width=width), [angles[part] for part in parts], threads=threads)
        best = float(angles[int(np.argmax(np.concatenate(found)))])
    for width in (0.06, 0.05, 0.04, 0.04):
        best += _common_turn(xy, weight, best, width)
    return float(np.pi / 4 - np.mod(np.pi / 4 - best, np.pi / 2))


def _wall_columns(xy: Floats) -> tuple[Floats, Floats]:
    """Means (k, 2) and weights (k,) of the columns of the plan that hold most points."""
    if len(xy) <= FEW_POINTS:
        columns = box_moments(np.column_stack([xy, np.zeros(len(xy))]), sides=(_COLUMN, _COLUMN, _COLUMN))
        count, mean = columns.count, columns.mean[:, :2]
    else:
        from indoor_bim.cloud.voxel_sums import sum_voxels

        first, last = (np.floor(corner / _COLUMN) for corner in bounds(xy))
        _, count, mean = sum_voxels(xy, low=first * _COLUMN, voxel_size=_COLUMN, size=(last - first).astype(np.int64) + 2)
    weight = np.minimum(count, 40).astype(np.float64) ** 2
    wall = weight >= np.quantile(weight, 0.7)
    return np.ascontiguousarray(mean[wall]), weight[wall]


def _sharpness(xy: Floats, weight: Floats, angles: Floats, *, width: float) -> Floats:
    """How well points line up along directions and across them."""
    energy = energy_by_bincount
    if len(xy) > FEW_POINTS:
        from indoor_bim.cloud.point_loops import histogram_energy as energy
    along = [energy(xy, weight, cosine, sine, width) for cosine, sine in zip(np.cos(angles), np.sin(angles), strict=True)]
    across = [energy(xy, weight, -sine, cosine, width) for cosine, sine in zip(np.cos(angles), np.sin(angles), strict=True)]
    return np.array(along, dtype=np.float64) + np.array(across, dtype=np.float64)


def energy_by_bincount(xy: Floats, weight: Floats, cosine: float, sine: float, width: float) -> float:
    """Twin of `point_loops.histogram_energy` in numpy: slower, for few points."""
    offset = (xy @ np.array([cosine, sine])) / width
    base = np.floor(offset).astype(np.int64)
    fraction = offset - base
    base -= base.min()
    histogram = np.bincount(base, weights=weight * (1 - fraction), minlength=int(base.max()) + 2)
    histogram += np.bincount(base + 1, weights=weight * fraction, minlength=int(base.max()) + 2)
    return float((histogram**2).sum())


def _common_turn(xy: Floats, weight: Floats, angle: float, width: float) -> float:
    """Least-squares turn of the wall lines along and across a direction, Tukey weights."""
    along = xy @ np.array([np.cos(angle), np.sin(angle)])
    across = xy @ np.array([-np.sin(angle), np.cos(angle)])
    numerator = denominator = 0.0
    for u, v in ((along, across), (-across, along)):
        peaks = np.array(height_peaks(v, share=0.15))
        nearest = nearest_peak(v, peaks)
        residual = v - peaks[nearest]
        w = weight * np.maximum(1 - (residual / width) ** 2, 0) ** 2
        total = np.maximum(np.bincount(nearest, weights=w, minlength=len(peaks)), 1e-12)
        du = u - (np.bincount(nearest, weights=w * u, minlength=len(peaks)) / total)[nearest]
        dv = v - (np.bincount(nearest, weights=w * v, minlength=len(peaks)) / total)[nearest]
        numerator += float((w * du * dv).sum())
        denominator += float((w * du * du).sum())
    return float(np.arctan2(numerator, denominator)) if denominator > 0 else 0.0
