"""What the layers hit along faces tell: how high they reach, how full they are, and whether they go on up to the ceiling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.layer_image import LayerImage, hits_along, layer_image
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]

CEILING_NOISE = 0.05  # metres: points this close to the ceiling may be its own
SURE = 0.05  # probability of what may still be chance
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


def ends_lower(segments: Segments, image: LayerImage, *, height: float, reach: float) -> NDArray[np.bool_]:
    """Tell which short faces end below the ceiling for sure: from what is hit of them, they should have been hit above their top as well.

    Parameters
    ----------
    segments : Segments
        Faces, metres. Their ends, where other faces begin, are not looked at.
    image : LayerImage
        Layers hit in plan.
    height : float
        From floor to ceiling, metres.
    reach : float
        Points within this distance of a face lie on it, metres.
    """
    inset = np.minimum(1.5 * reach, segments.length / 4)[:, None] * segments.direction
    last = int((height - CEILING_NOISE) / image.layer)  # layers above hold points of the ceiling
    lower = np.zeros(len(segments), dtype=bool)
    for k, hit in enumerate(hits_along(image, segments.p + inset, segments.q - inset, reach=reach)):
        seen = np.flatnonzero(hit[:, :last].any(axis=0))
        if not len(seen):
            continue
        share = float(hit[:, seen[0] : seen[-1] + 1].mean())
        lower[k] = (1 - share) ** (len(hit) * (last - 1 - seen[-1])) < SURE
    return lower


def share_at_ceiling(segments: Segments, points: Floats, *, height: float, reach: float, depth: float) -> Floats:
    """Share (m,) of the length of faces that is hit right below the ceiling.

    Panes, door leaves and most furniture end lower.

    Parameters
    ----------
    segments : Segments
        Faces, metres.
    points : (n, 3) float64
        Points, metres, z above the floor.
    height : float
        From floor to ceiling, metres.
    reach : float
        Points within this distance of a face lie on it, metres.
    depth : float
        How far below the ceiling is looked, metres: the less, the better walls are told from door leaves and panes; the more, the
        fewer points are needed.
    """
    band = points[(points[:, 2] > height - depth) & (points[:, 2] < height - CEILING_NOISE)] - [0.0, 0.0, height - depth]
    if not len(band):
        return np.zeros(len(segments))
    image = layer_image(band, height=depth)
    return np.array([hit.any(axis=1).mean() for hit in hits_along(image, segments.p, segments.q, reach=reach)])
