"""Units and axes of a scan: declared, or recognised where the scan leaves no doubt."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.extent import bounds
from indoor_bim.cloud.grid import cell_keys
from indoor_bim.cloud.spacing import point_spacing, sample_mask

METRES_PER_UNIT: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "us-ft": 1200 / 3937, "in": 0.0254}
)
UP_ROTATIONS: Mapping[str, tuple[tuple[float, float, float], ...]] = MappingProxyType(
    {
        "z": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        "y": ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
        "x": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    }
)
TALLEST_SCAN = 1000.0
SMALLEST_MILLIMETRE_SPACING = 0.5
SMALLEST_STOREY = 1.5
FLAT_WITHIN = np.cos(np.radians(25.0))
Y_UP_EVIDENCE = 6.0


def looks_like_millimetres(points: NDArray[np.float64], *, up: str) -> bool:
    """Whether a scan can only be in millimetres: as metres it would be over a kilometre high.

    The height is that between the 0.5 and 99.5 % quantiles, so stray points do not decide. Plan size does not count: a
    campus in metres and a large coordinate offset are no signs of millimetres. The point spacing must agree.

    Parameters
    ----------
    points : (n, 3) float64
        Finite points in the scan's unit and axes.
    up : str
        Axis that points up: ``x``, ``y`` or ``z``.
    """
    axis = "xyz".index(up)
    low, high = bounds(points)
    if high[axis] - low[axis] <= TALLEST_SCAN:
        return False
    lowest, highest = np.quantile(points[sample_mask(points, 200_000), axis], [0.005, 0.995])
    return bool(highest - lowest > TALLEST_SCAN) and point_spacing(points) > SMALLEST_MILLIMETRE_SPACING


def looks_y_up(points: NDArray[np.float64]) -> bool:
    """Whether a scan's floors and ceilings lie across the y axis.

    Two signs must agree: the scan is much lower along y than along z, and there is much more surface across y than
    across z. A face within 25 degrees of square to an axis counts as lying across it, so a tilted scan keeps its z axis,
    as does every scan in doubt.

    Parameters
    ----------
    points : (n, 3) float64
        Finite points in the scan's axes, any unit.
    """
    sample = points.take(np.flatnonzero(sample_mask(points, 200_000)), axis=0)
    low, high = np.quantile(sample, [0.005, 0.995], axis=0)
    extent = high - low
    if extent[1] >= 0.8 * min(extent[0], extent[2]) or extent[1] < SMALLEST_STOREY:
        return False
    across = _surface_shares(sample, low=low, high=high)
    evidence = across[1] / max(float(across[2]), 0.01) * extent[2] / extent[1]
    return bool(across[1] >= 0.3 and evidence >= Y_UP_EVIDENCE)


def _surface_shares(sample: NDArray[np.float64], *, low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the flat cells of a grid whose normal lies along x, y and z; the grid is as fine as the points allow."""
    sample = sample[np.lexsort(sample.T)]
    sample = sample[((sample >= low) & (sample <= high)).all(axis=1)]
    for cells_along_smallest in (16, 8, 4):
        edge = float((high - low).min()) / cells_along_smallest
        cell = np.floor((sample - low) / edge)
        shape = cell.max(axis=0).astype(np.int64) + 1
        _, place, count = np.unique(cell_keys(cell.astype(np.int64), shape), return_inverse=True, return_counts=True)
        if np.count_nonzero(count >= 10) >= 0.5 * len(count):
            break
    offset = sample - low - cell * edge
    mean = np.stack([np.bincount(place, column) for column in offset.T], axis=1) / count[:, None]
    offset -= mean[place]
    covariance = np.stack([np.stack([np.bincount(place, a * b) for b in offset.T], axis=1) for a in offset.T], axis=1)
    value, vector = np.linalg.eigh(covariance[count >= 10])
    normal = np.abs(vector[value[:, 0] < 0.05 * value[:, 1], :, 0])
    shares: NDArray[np.float64] = (normal > FLAT_WITHIN).mean(axis=0) if len(normal) else np.zeros(3)
    return shares
