"""On which side of a wall face the free space lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]


def orient_by_free_space(
    segments: Segments, free: Raster, *, near: float = 0.04, far: float = 0.24, step: float = 0.04, contrast: float = 0.15
) -> Segments:
    """Segments turned so that free space lies to the left of p -> q.

    Both sides are sampled between `near` and `far`; the share of samples with floor or ceiling says how free a side is. Samples
    weigh the less the farther they are, so that the room behind a thin wall does not count for its other side.

    Parameters
    ----------
    segments : Segments
        Faces, metres.
    free : Raster
        Image that is true (or not 0) where floor or ceiling was seen.
    near, far : float
        Distances from the face between which both sides are looked at, metres.
    step : float
        Spacing of the samples, metres.
    contrast : float
        Least difference between the shares of both sides for the side to count as known.

    Returns
    -------
    Segments
        Rows in the same order; `sided` is False, and the direction unchanged, where both sides or neither are free.

    Examples
    --------
    >>> free = Raster(np.array([[True] * 20] * 10 + [[False] * 20] * 10), np.zeros(2), 0.1)
    >>> turned = orient_by_free_space(Segments.from_ends([[0.0, 1.0]], [[2.0, 1.0]]), free)
    >>> turned.p.tolist(), turned.q.tolist(), turned.sided.tolist()
    ([[2.0, 1.0]], [[0.0, 1.0]], [True])
    """
    m = len(segments)
    if not m:
        return segments
    left, right = (_share_free(segments, free, side * np.arange(near, far + 1e-9, step), step) for side in (1, -1))
    sided = np.abs(left - right) >= contrast
    turn = (sided & (right > left))[:, None]
    return replace(segments, p=np.where(turn, segments.q, segments.p), q=np.where(turn, segments.p, segments.q), sided=sided)


def _share_free(segments: Segments, free: Raster, offsets: Floats, step: float) -> Floats:
    """Share (m,) of the samples at signed `offsets` to the left that are free."""
    count = np.maximum(np.ceil(segments.length / step).astype(np.int64), 1)
    row = np.repeat(np.arange(len(segments)), count)
    place = (np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[row]
    on_line = segments.p[row] + place[:, None] * (segments.q - segments.p)[row]
    samples = on_line[:, None, :] + offsets[None, :, None] * segments.normal[row][:, None, :]
    weight = 1 / np.abs(offsets) / (1 / np.abs(offsets)).sum()
    hit = (free.sample(samples.reshape(-1, 2)) != 0).reshape(len(row), -1) @ weight
    return np.bincount(row, weights=hit, minlength=len(segments)) / count
