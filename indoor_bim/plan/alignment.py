"""Faces that are square to the building are drawn square: what a bent map alone turns is turned back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_bim.plan.segments import Segments


def align_faces(faces: Segments, *, tolerance: float | None = None, steepest: float = 0.6) -> Segments:
    """Turn faces parallel to the axes where they are so within the accuracy of the map.

    Simultaneous localisation and mapping bends its maps by centimetres over a room, which turns walls by tenths of a degree. A
    face is turned about its middle when neither of its ends moves by more than `tolerance`; a longer face that is off by the same
    angle is off on purpose and stays.

    Parameters
    ----------
    faces : Segments
        Faces with x along the building's main direction, metres.
    tolerance : float, optional
        Largest movement of an end, metres; default: the median distance of the points from their faces.
    steepest : float
        Largest turn, degrees.

    Returns
    -------
    Segments
        The same rows.

    Examples
    --------
    >>> faces = Segments.from_ends([[0.0, 0.0], [0.0, 0.0]], [[4.0, 0.02], [9.0, 0.2]])
    >>> square = align_faces(faces, tolerance=0.02)
    >>> square.p.tolist(), square.q.tolist()
    ([[0.0, 0.01], [0.0, 0.0]], [[4.0, 0.01], [9.0, 0.2]])
    """
    if tolerance is None:
        tolerance = float(np.median(faces.rmse[np.isfinite(faces.rmse)])) if np.isfinite(faces.rmse).any() else 0.0
    p, q = faces.p.copy(), faces.q.copy()
    half = (faces.q - faces.p) / 2
    for axis in (0, 1):
        across = np.abs(half[:, 1 - axis])
        square = (across <= tolerance) & (across <= np.tan(np.radians(steepest)) * np.abs(half[:, axis]))
        middle = (faces.p[square, 1 - axis] + faces.q[square, 1 - axis]) / 2
        p[square, 1 - axis] = q[square, 1 - axis] = middle
    return replace(faces, p=p, q=q)
