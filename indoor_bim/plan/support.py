"""What the points say about segments that were found on an image: how many there are, how close, how much of the face they hit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]


def measure_support(segments: Segments, points: Floats, *, reach: float, height: float, patch: float = 0.10) -> Segments:
    """Segments with support, rmse and coverage from the wall points close to them.

    Parameters
    ----------
    segments : Segments
        Faces, metres. They are treated direction by direction: made for few directions.
    points : (n, 3) float64
        Wall points, metres, z above the floor.
    reach : float
        Points within this distance of a face belong to it, metres.
    height : float
        Height of the storey, metres.
    patch : float
        The face is divided in patches of about this side, metres; its coverage is the share of them with a point.

    Returns
    -------
    Segments
        The same rows with `support`, `rmse` and `coverage`.
    """
    support = np.zeros(len(segments), dtype=np.int64)
    rmse = np.full(len(segments), np.nan)
    coverage = np.zeros(len(segments))
    layers = max(round(height / patch), 1)
    layer = np.clip((points[:, 2] / height * layers).astype(np.int64), 0, layers - 1)
    angle = np.round(np.arctan2(segments.direction[:, 1], segments.direction[:, 0]) % np.pi, 6) % round(np.pi, 6)
    for value in np.unique(angle):
        rows = np.flatnonzero(angle == value)
        along_axis = segments.direction[rows[0]]
        along = points[:, 0] * along_axis[0] + points[:, 1] * along_axis[1]
        across = points[:, 1] * along_axis[0] - points[:, 0] * along_axis[1]
        order = np.argsort(across, kind="stable")
        sorted_across = across[order]
        for row in rows:
            p, q = segments.p[row], segments.q[row]
            offset = p[1] * along_axis[0] - p[0] * along_axis[1]
            start, end = sorted([float(p @ along_axis), float(q @ along_axis)])
            near = order[np.searchsorted(sorted_across, offset - reach) : np.searchsorted(sorted_across, offset + reach)]
            near = near[(along[near] >= start) & (along[near] <= end)]
            if not len(near):
                continue
            columns = max(round((end - start) / patch), 1)
            column = np.minimum(((along[near] - start) / (end - start) * columns).astype(np.int64), columns - 1)
            support[row] = len(near)
            rmse[row] = np.sqrt(np.sort((across[near] - offset) ** 2).mean())
            coverage[row] = len(np.unique(column * layers + layer[near])) / (columns * layers)
    return replace(segments, support=support, rmse=rmse, coverage=coverage)
