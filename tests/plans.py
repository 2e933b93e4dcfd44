"""Faces of known floor plans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_bim.plan.segments import Segments


def faces_of_rooms(*rooms: list[tuple[float, float]]) -> Segments:
    """Faces of rooms given as counter-clockwise rings: free space to the left."""
    p = [corner for room in rooms for corner in room]
    q = [corner for room in rooms for corner in (*room[1:], room[0])]
    faces = Segments.from_ends(np.array(p), np.array(q))
    n = len(faces)
    return replace(
        faces, sided=np.ones(n, dtype=bool), support=np.full(n, 1000), coverage=np.full(n, 0.9), rmse=np.full(n, 0.01), top=np.full(n, 2.5)
    )


def box(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float]]:
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def turned(faces: Segments, degrees: float, shift: tuple[float, float] = (0.0, 0.0)) -> Segments:
    a = np.radians(degrees)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    return replace(faces, p=faces.p @ turn + shift, q=faces.q @ turn + shift)


TWO_ROOMS = (box(0, 0, 4, 3), box(4.12, 0, 9, 3))
FLAT = (box(0, 0, 4, 3), box(4.12, 0, 9, 3), box(0, 3.2, 9, 5.2), [(0.0, 5.4), (9.0, 5.4), (9.0, 8.0), (8.0, 9.0), (0.0, 9.0)])
