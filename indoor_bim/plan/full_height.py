"""What the layers hit along faces tell: how high they reach, how full they are, and whether they go on up to the ceiling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.layer_image import LayerImage, hits_along
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]

CEILING_NOISE = 0.05  # metres: points this close to the ceiling may be its own
SNAP = 0.15  # metres: tops closer than this to the ceiling are at it


def with_heights(segments: Segments, image: LayerImage, *, height: float, reach: float) -> Segments:
    """Segments with coverage and top from the layers that are hit along them.

    Parameters
    ----------
    segments : Segments
        Faces, metres.
    image : LayerImage
        Layers hit in plan.
    height : float
        From floor to ceiling, metres.
    reach : float
        Points within this distance of a face lie on it, metres.

    Returns
    -------
    Segments
        The same rows; `coverage` is the share of the layers hit between floor and ceiling, `top` the highest layer that at least a
        quarter of the face's fullest layer is hit in.
    """
    coverage, top = np.zeros(len(segments)), np.full(len(segments), np.nan)
    for k, hit in enumerate(hits_along(image, segments.p, segments.q, reach=reach)):
        share = hit.mean(axis=0)
        coverage[k] = share.mean()
        if share.any():
            top[k] = (np.flatnonzero(share >= 0.25 * share.max())[-1] + 1) * image.layer
    top = np.where(np.abs(top - height) < SNAP, height, np.minimum(top, height))
    return replace(segments, coverage=coverage, top=top)


def share_at_ceiling(segments: Segments, image: LayerImage, *, height: float, reach: float, depth: float) -> Floats:
    """Share (m,) of the length of faces that is hit right below the ceiling.

    Panes, door leaves and most furniture end lower.

    Parameters
    ----------
    segments : Segments
        Faces, metres.
    image : LayerImage
        Layers hit in plan.
    height : float
        From floor to ceiling, metres.
    reach : float
        Points within this distance of a face lie on it, metres.
    depth : float
        How far below the ceiling is looked, metres: the less, the better walls are told from door leaves and panes; the more, the fewer points are
        needed.
    """
    band = image.rows(height - depth, height - CEILING_NOISE)
    return np.array([hit[:, band].any(axis=1).mean() for hit in hits_along(image, segments.p, segments.q, reach=reach)])
