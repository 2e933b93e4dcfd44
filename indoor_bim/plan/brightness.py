"""Brightness of what rays hit: intensity freed from distance and angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.relief import FACE_REACH, STEEP
from indoor_bim.plan.wall_rays import WallRays

Floats = NDArray[np.float64]

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
        The same rays with `brightness`, NaN where the intensity is 0; without `intensity`. Without brightness where too few faces
        were hit.
    """
    unknown = [replace(rays, intensity=None) for rays in walls]
    given = [(rays, rays.intensity) for rays in walls if rays.intensity is not None]
    if not given:
        return unknown
    on_face = [(np.abs(rays.depth) < FACE_REACH) & (rays.slant > STEEP) & (intensity > 0) for rays, intensity in given]
    terms = np.vstack([_terms(rays.take(rows)) for (rays, _), rows in zip(given, on_face, strict=True)])
    values = np.concatenate([np.log(intensity[rows], dtype=np.float64) for (_, intensity), rows in zip(given, on_face, strict=True)])
    factors = _robust_fit(terms, values)
    if factors is None:
        return unknown
    out = []
    for rays in walls:
        known = rays.intensity if rays.intensity is not None else np.zeros(len(rays))
        with np.errstate(divide="ignore"):
            measured = np.where(known > 0, np.log(known, dtype=np.float64), np.nan)
        brightness = np.round((measured - _terms(rays) @ factors) / RESOLUTION) * RESOLUTION
        out.append(replace(rays, intensity=None, brightness=brightness.astype(np.float32)))
    return out


def _terms(rays: WallRays) -> Floats:
    length = np.log(np.maximum(rays.length, 1e-3).astype(np.float64))
    cosine = np.log(np.maximum(rays.slant, 1e-3).astype(np.float64))
    return np.column_stack([np.ones(len(rays)), length, length**2, cosine, cosine**2])


def _robust_fit(terms: Floats, values: Floats) -> Floats | None:
    """Factors of the terms nearest to the values, cell by cell, without what deviates most."""
    if not len(values):
        return None
    cells = np.floor((terms[:, [1, 3]] - terms[:, [1, 3]].min(axis=0)) / CELL).astype(np.int64)
    cell = cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]
    keep = np.ones(len(values), dtype=bool)
    factors: Floats | None = None
    for _ in range(ROUNDS):
        count = np.bincount(cell[keep])
        full = np.flatnonzero(count >= FEW)
        if len(full) < terms.shape[1]:
            return factors
        weight = np.sqrt(count[full])[:, None]
        means = [np.bincount(cell[keep], weights=column[keep])[full] / count[full] for column in (*terms.T, values)]
        table = np.column_stack(means) * weight
        factors = np.asarray(np.linalg.lstsq(table[:, :-1], table[:, -1], rcond=SMALLEST_SINGULAR)[0], dtype=np.float64)
        deviation = values - terms @ factors
        middle = float(np.median(deviation[keep]))
        spread = 1.4826 * float(np.median(np.abs(deviation[keep] - middle)))
        keep = np.abs(deviation - middle) <= OUTLIER * spread
        factors[0] += middle
    return factors
