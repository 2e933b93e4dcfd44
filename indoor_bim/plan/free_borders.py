"""Borders of free space where no wall runs: glass, railings, curtain walls."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]


def free_borders(seen: Raster, lines: FaceLines, *, shortest: float = 1.0, near: float = 0.30, reach: float = 1.0) -> tuple[Floats, Floats]:
    """Straight borders of the overhead surface where no wall line runs: glass, railings, curtain walls.

    Parameters
    ----------
    seen : Raster
        Hits of the overhead surface.
    lines : FaceLines
        Wall lines.
    shortest : float
        Shortest border, metres.
    near : float
        A wall line this close makes a border superfluous, metres.
    reach : float
        Borders are prolonged by this much, metres.

    Returns
    -------
    p, q : (m, 2) float64
        Ends, free space to the left, metres.
    """
    import shapely
    from scipy import ndimage
    from skimage.measure import find_contours

    from indoor_bim.plan.chain_loops import corners_of

    step = 4
    rows, columns = (np.array(seen.image.shape) // step) * step
    lines_hit = np.maximum.reduce([seen.image[k:rows:step, :columns] for k in range(step)])
    coarse = np.maximum.reduce([lines_hit[:, k::step] for k in range(step)]) > 0
    mask = np.pad(coarse, 3).astype(np.uint8)
    for narrow_or_widen in (ndimage.maximum_filter, ndimage.minimum_filter, ndimage.minimum_filter, ndimage.maximum_filter):
        mask = narrow_or_widen(mask, 5, mode="constant")
    cell = seen.cell * step
    p, q = lines.ends(0.3)
    walls = shapely.linestrings(np.stack([p, q], axis=1))
    tree = shapely.STRtree(walls)
    found = []
    for contour in find_contours(mask.astype(np.float64), 0.5):  # type: ignore[no-untyped-call]
        ring = contour[corners_of(np.ascontiguousarray(contour), 1.2)]
        xy = seen.origin + (ring[:, ::-1] - 3 + 0.5) * cell
        for a, b in itertools.pairwise(xy):
            length = float(np.hypot(*(b - a)))
            turn = np.mod(np.arctan2(*(b - a)[::-1]) + np.pi / 4, np.pi / 2) - np.pi / 4
            if length < shortest or abs(turn) > np.radians(4):
                continue
            axis = int(abs((b - a)[1]) > abs((b - a)[0]))
            a, b = a.copy(), b.copy()
            a[1 - axis] = b[1 - axis] = (a[1 - axis] + b[1 - axis]) / 2
            border = shapely.LineString([a, b])
            beside = walls[tree.query(border, predicate="dwithin", distance=near)]
            if border.intersection(shapely.union_all(shapely.buffer(beside, near))).length < 0.5 * length:
                d = (b - a) / length
                middle = (a + b) / 2
                left = middle + 0.2 * np.array([-d[1], d[0]])
                i, j = np.floor((left - seen.origin) / cell).astype(int)[::-1] + 3
                a, b = a - reach * d, b + reach * d
                free_left = 0 <= i < mask.shape[0] and 0 <= j < mask.shape[1] and mask[i, j]
                found.append((a, b) if free_left else (b, a))
    if not found:
        return np.zeros((0, 2)), np.zeros((0, 2))
    return np.array([a for a, _ in found]), np.array([b for _, b in found])
