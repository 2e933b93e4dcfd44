"""Faces that may be walls: tall and well filled, not furniture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

LEAST_FILL = 0.5  # of the fill of the building's typical wall: what is emptier is no wall


def wall_like(faces: Segments, *, storey_height: float, least_height: float = 0.8, least_length: float = 0.2) -> NDArray[np.bool_]:
    """Tell faces that reach up towards the ceiling and are hit all over from furniture and clutter.

    How full a wall is depends on the scan; so a face is compared with the upper quartile, weighted by length, of all tall faces.

    Parameters
    ----------
    faces : Segments
        Faces with `coverage` and `top`, metres.
    storey_height : float
        From floor to ceiling, metres.
    least_height : float
        Share of the storey height that a wall reaches up to at least.
    least_length : float
        Shortest face, metres.

    Returns
    -------
    (m,) bool
        True for faces that may be walls.

    Examples
    --------
    >>> from dataclasses import replace
    >>> faces = Segments.from_ends([[0, 0], [1, 1]], [[4, 0], [2, 1]])
    >>> faces = replace(faces, coverage=np.array([0.9, 0.8]), top=np.array([2.5, 0.9]))
    >>> wall_like(faces, storey_height=2.5).tolist()
    [True, False]
    """
    top = np.where(np.isfinite(faces.top), faces.top, np.inf)
    tall = (top >= least_height * storey_height) & (faces.length >= least_length)
    if not tall.any():
        return tall
    order = np.flatnonzero(tall)[np.argsort(faces.coverage[tall], kind="stable")]
    weight = np.cumsum(faces.length[order])
    typical = faces.coverage[order][np.searchsorted(weight, 0.75 * weight[-1])]
    filled: NDArray[np.bool_] = tall & (faces.coverage >= LEAST_FILL * typical)
    return filled
