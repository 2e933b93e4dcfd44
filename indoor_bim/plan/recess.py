"""Recesses of a wall: parts of its face that lie deeper, as between pilasters or in the niche of a window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.relief import STEEP
from indoor_bim.plan.wall_rays import FRONT, WallRays

Floats = NDArray[np.float64]

DEEPEST = 0.35  # metres behind a face
LEAST_SHARE = 0.15  # of the hits on the face: a smaller recess holds no opening
COLUMN = 0.10  # metres along a wall
NARROWEST = 1.0  # metres: a recess with an opening in it is wider


def recess_depth(rays: WallRays, *, side: int, tolerance: float) -> float | None:
    """Depth behind the face at which most hits lie, if they are as many as those of a recess.

    Parameters
    ----------
    rays : WallRays
        Rays at one wall, with corrected depths.
    side : int
        Side that they came from: 1 left, -1 right.
    tolerance : float
        Hits closer than this to a face are on it, metres.

    Returns
    -------
    float or None
        Metres; None where there is no recess.
    """
    steep = (rays.slant > STEEP) & (rays.side == side)
    behind = steep & (rays.depth > tolerance) & (rays.depth < DEEPEST)
    depth = np.sort(rays.depth[behind].astype(np.float64))
    if not len(depth):
        return None
    count = np.searchsorted(depth, depth + tolerance, side="right") - np.arange(len(depth))
    first = int(np.argmax(count))
    middle = float(np.median(depth[first : first + count[first]]))
    on_it = behind & (np.abs(rays.depth - middle) < tolerance / 2)
    columns = np.unique(np.floor(rays.along_end[on_it] / COLUMN))
    on_face = steep & (np.abs(rays.depth) <= tolerance)
    if len(columns) * COLUMN < NARROWEST or int(on_it.sum()) < LEAST_SHARE * int(on_face.sum()):
        return None
    return middle


def rays_at_recess(rays: WallRays, *, depth: float, thickness: float) -> WallRays:
    """Rays measured from the bottom of a recess as if it were the face.

    Parameters
    ----------
    rays : WallRays
        Rays at one wall from one side.
    depth : float
        Depth of the recess, metres.
    thickness : float
        Thickness of the wall, metres.
    """
    inside = rays.take(np.flatnonzero(rays.depth > depth - FRONT))
    share = np.float32(depth / thickness)
    return replace(
        inside,
        depth=inside.depth - np.float32(depth),
        along=inside.along + share * (inside.along_far - inside.along),
        up=inside.up + share * (inside.up_far - inside.up),
    )
