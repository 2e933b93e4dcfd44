"""Brightness of what rays hit: intensity freed from distance and angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.ordering import median
from indoor_bim.plan.relief import FACE_REACH, STEEP
from indoor_bim.plan.wall_rays import WallRays
from indoor_bim.threads import in_threads, threads_for

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CELL = 0.05  # of the logarithms of distance and cosine: hits within it are taken together
FEW = 20  # hits on faces in a cell
SMALLEST_SINGULAR = 1e-3  # of the largest singular value: distance and angle go together where the path runs along one wall
ROUNDS = 3
OUTLIER = 2.5  # times the robust standard deviation
RESOLUTION = 2.0**-12  # of the logarithm: results do not depend on the order of the hits


def with_brightness(walls: Sequence[WallRays]) -> list[WallRays]:
    """Replace intensity by brightness: the logarithm of its ratio to what the faces of all walls return on the whole.

    The logarithm of the intensity of faces is taken for a polynomial of second degree of the logarithms of distance and cosine of the
    incidence: the terms of the radar equation, and how scanners and surfaces deviate from it.

    Parameters
    ----------
    walls : sequence of WallRays
        Rays at each wall, all with intensity.

    Returns
    -------
    list of WallRays
        The same rays with `brightness` for those that ended at a face, without `intensity`. Without brightness where too few faces
        were hit.
    """
    unknown = [replace(rays, intensity=None) for rays in walls]
    known = in_threads(_on_face, walls, threads=threads_for(sum(len(rays) for rays in walls)))
    terms, values = (np.concatenate(parts, axis=-1) for parts in zip((np.zeros((2, 0)), np.zeros(0)), *(k[1:] for k in known), strict=True))
    factors = _robust_fit(terms, values)
    if factors is None:
        return unknown
    deviation = np.round((values - _polynomial(terms) @ factors) / RESOLUTION) * RESOLUTION
    out = []
    begin = 0
    for rays, (rows, _, _) in zip(unknown, known, strict=True):
        brightness = np.full(len(rays), np.nan, dtype=np.float32)
        brightness[rows] = deviation[begin : begin + len(rows)]
        begin += len(rows)
        out.append(replace(rays, brightness=brightness))
    return out


def _on_face(rays: WallRays) -> tuple[Ints, Floats, Floats]:
    """Rays that ended at a face, with a known intensity; logarithms (2, n) of length and cosine of the incidence; and (n,) of intensity."""
    if rays.intensity is None:
        return np.zeros(0, dtype=np.int64), np.zeros((2, 0)), np.zeros(0)
    rows = np.flatnonzero((np.abs(rays.depth) < FACE_REACH) & (rays.slant > STEEP) & (rays.intensity > 0))
    logarithms = np.log(np.maximum(np.stack([rays.length[rows], rays.slant[rows]]), 1e-3), dtype=np.float64)
    return rows, logarithms, np.log(rays.intensity[rows], dtype=np.float64)


def _polynomial(logarithms: Floats) -> Floats:
    """Terms (n, 5) of second degree."""
    return np.ascontiguousarray(np.vstack([np.ones(logarithms.shape[1]), logarithms, logarithms**2]).T)


def _robust_fit(logarithms: Floats, values: Floats) -> Floats | None:
    """Factors of the polynomial nearest to the values, cell by cell, without what deviates most."""
    if not len(values):
        return None
    row, column = np.floor((logarithms - logarithms.min(axis=1, keepdims=True)) / CELL).astype(np.int64)
    place = row * (int(column.max()) + 1) + column
    hit = np.bincount(place) > 0
    cell = (np.cumsum(hit) - 1).take(place)
    total = np.bincount(cell)
    terms = _polynomial(np.stack([np.bincount(cell, weights=logarithm) / total for logarithm in logarithms]))
    keep = np.ones(len(values), dtype=bool)
    factors: Floats | None = None
    for _ in range(ROUNDS):
        count = np.bincount(cell, weights=keep)
        full = np.flatnonzero(count >= FEW)
        if len(full) < terms.shape[1]:
            return factors
        weight = np.sqrt(count[full])
        mean = np.bincount(cell, weights=np.where(keep, values, 0.0))[full] / count[full]
        solved = np.linalg.lstsq(terms[full] * weight[:, None], mean * weight, rcond=SMALLEST_SINGULAR)[0]
        factors = np.asarray(solved, dtype=np.float64)
        deviation = values - (terms @ factors).take(cell)
        kept = deviation[keep]
        middle = median(kept)
        spread = 1.4826 * median(np.abs(kept - middle))
        keep = np.abs(deviation - middle) <= OUTLIER * spread
        factors[0] += middle
    return factors
