"""What a bent map alone turns or shifts is put back: faces square to the building, and faces of one plane on one line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_bim.plan.segments import Segments

SAME_COS = np.cos(np.radians(0.01))  # faces of one direction, but for rounding


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


def share_lines(faces: Segments, *, tolerance: float = 0.03) -> Segments:
    """Move faces that look the same way onto common lines, all through the building.

    A facade is one plane, however many rooms show a piece of it; a map that bends shows the pieces a few centimetres apart. The longest
    face takes all faces of its direction and side within `tolerance` to their mean, weighted by length; the rest follow in the same way.

    Parameters
    ----------
    faces : Segments
        Faces, metres. Those that are not sided stay.
    tolerance : float
        Distance from the line of the longest face within which faces are on it, metres.

    Returns
    -------
    Segments
        The same rows, moved across.

    Examples
    --------
    >>> faces = Segments.from_ends([[0.0, 0.0], [7.0, 0.02], [0.0, 0.1]], [[4.0, 0.0], [11.0, 0.02], [4.0, 0.1]])
    >>> shared = share_lines(replace(faces, sided=np.full(3, True)))
    >>> shared.p.tolist(), shared.q.tolist()
    ([[0.0, 0.01], [7.0, 0.01], [0.0, 0.1]], [[4.0, 0.01], [11.0, 0.01], [4.0, 0.1]])
    """
    p, q, length = faces.p.copy(), faces.q.copy(), faces.length
    order = np.lexsort(np.column_stack([np.round(np.column_stack([faces.q, faces.p]), 6), -np.round(length, 6)]).T)
    left = faces.sided.copy()
    for seed in order:
        if not left[seed]:
            continue
        normal = faces.normal[seed]
        aside = (faces.p - faces.p[seed]) @ normal
        group = left & (faces.direction @ faces.direction[seed] > SAME_COS) & (np.abs(aside) <= tolerance)
        left[group] = False
        move = (np.average(aside[group], weights=length[group]) - aside[group])[:, None] * normal
        p[group] += move
        q[group] += move
    return replace(faces, p=p, q=q)
