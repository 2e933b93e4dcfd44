"""Upright surfaces that a scan shows and a model does not have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.quality.unique_rows import unique_rows

Floats = NDArray[np.float64]
Point = tuple[float, float]

_PIXEL, _BIN = 0.05, 0.10
_MARGIN = (0.30, 0.20)  # metres left out above the floor and below the ceiling
_FULL = 0.85  # share of the height that a wall fills: door leaves and most cupboards end below
_LEAST_LENGTH, _MOST_DEPTH = 0.80, 0.30


@dataclass(frozen=True, slots=True)
class ExtraSurface:
    """Straight upright surface of a scan, from floor to ceiling, that belongs to no element of the model.

    Parameters
    ----------
    start, end : (float, float)
        Its ends in plan, metres.
    length : float
        Metres.
    """

    start: Point
    end: Point
    length: float


def extra_surfaces(points: Floats, *, floor: float, ceiling: float) -> tuple[ExtraSurface, ...]:
    """Find straight upright surfaces that reach from floor to ceiling.

    Parameters
    ----------
    points : (n, 3) float64
        Points that belong to no element, metres.
    floor, ceiling : float
        Heights that the scan shows, metres.

    Returns
    -------
    tuple of ExtraSurface
        Longest first; high cupboards are among them, for a scan does not tell them from walls.
    """
    from scipy.ndimage import label

    low, high = floor + _MARGIN[0], ceiling - _MARGIN[1]
    band = points[(points[:, 2] > low) & (points[:, 2] < high)]
    if not len(band) or high <= low:
        return ()
    pixel = np.floor(band[:, :2] / _PIXEL).astype(np.int64)
    origin = pixel.min(axis=0)
    level = np.floor((band[:, 2] - low) / _BIN).astype(np.int64)
    filled = unique_rows(np.column_stack([pixel - origin, level])).rows
    cells, _, _, count = unique_rows(filled[:, :2])
    upright = cells[count >= _FULL * np.ceil((high - low) / _BIN)]
    if not len(upright):
        return ()
    image = np.zeros(upright.max(axis=0) + 1, dtype=bool)
    image[upright[:, 0], upright[:, 1]] = True
    groups, number = label(image, structure=np.ones((3, 3)))
    found = []
    for k in range(1, number + 1):
        place = (np.argwhere(groups == k) + origin + 0.5) * _PIXEL
        surface = _straight(place)
        if surface is not None:
            found.append(surface)
    return tuple(sorted(found, key=lambda surface: (-surface.length, surface.start)))


def _straight(cells: Floats) -> ExtraSurface | None:
    """Line through the cells (k, 2) of a group; None when it is short or not straight."""
    if len(cells) * _PIXEL < _LEAST_LENGTH:
        return None
    middle = cells.mean(axis=0)
    _, _, axes = np.linalg.svd(cells - middle, full_matrices=False)
    along, across = (cells - middle) @ axes[0], (cells - middle) @ axes[1]
    if np.ptp(along) < _LEAST_LENGTH or np.ptp(across) > _MOST_DEPTH:
        return None
    ends = sorted(tuple(round(float(v), 3) for v in middle + s * axes[0]) for s in (along.min(), along.max()))
    return ExtraSurface((ends[0][0], ends[0][1]), (ends[1][0], ends[1][1]), round(float(np.ptp(along)), 3))
