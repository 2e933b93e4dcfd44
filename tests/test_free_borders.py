"""Borders of free space along which no wall line runs."""

from __future__ import annotations

import numpy as np
import pytest
from face_lines import lines_between

from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.free_borders import free_borders
from indoor_bim.plan.raster import Raster

CELL = 0.025


def terrace(*, arm=False, slit=False):
    """A ceiling from (2, 1) to (8, 5) in an image of 10 m by 6 m."""
    image = np.zeros((240, 400), dtype=bool)
    image[40:200, 80:320] = True
    if slit:
        image[:, 200:208] = False
    if arm:
        image[120:132, 320:400] = True
    return Raster(image, np.zeros(2), CELL)


def sides(borders):
    """Borders by the coordinate that they keep, metres."""
    found = []
    for p, q in zip(*borders, strict=True):
        axis = int(abs(q[0] - p[0]) > abs(q[1] - p[1]))
        found.append(("xy"[axis], round(float(p[axis]), 1)))
    return sorted(found)


@pytest.mark.parametrize("odd", [{}, {"arm": True}, {"slit": True}])
def test_all_sides_of_a_ceiling_without_walls_are_borders(odd):
    p, q = free_borders(terrace(**odd), FaceLines.none())
    assert sides((p, q)) == [("x", 2.0), ("x", 8.0), ("y", 1.0), ("y", 5.0)]
    middle, d = (p + q) / 2, (q - p) / np.hypot(*(q - p).T)[:, None]
    inside = middle + 0.3 * np.column_stack([-d[:, 1], d[:, 0]])
    assert ((inside > [2, 1]) & (inside < [8, 5])).all(), "free space to the left"
    assert np.hypot(*(q - p).T) == pytest.approx(np.where(np.abs(d[:, 0]) > 0.5, 6, 4) + 2.0, abs=0.3)


def test_where_a_wall_runs_there_is_no_border():
    walls = lines_between(((2, 1.1), (8, 1.1)), ((8.1, 1), (8.1, 5)))
    assert sides(free_borders(terrace(), walls)) == [("x", 2.0), ("y", 5.0)]


def test_no_ceiling_no_border():
    assert len(free_borders(Raster(np.zeros((40, 40), dtype=bool), np.zeros(2), CELL), FaceLines.none())[0]) == 0
