"""How surely the line of a face is known."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_support import COLUMN, measure, measure_by_sorting
from indoor_bim.plan.polar_fit import fit_lines
from indoor_bim.plan.segments import Segments

SIGMA = 0.012


def scanned(p, q, *, noise=SIGMA, points=40, seed=0):
    """Evenly scanned wall, seen from its left."""
    rng = np.random.default_rng(seed)
    p, q = np.asarray(p, float), np.asarray(q, float)
    length = np.hypot(*(q - p))
    d = (q - p) / length
    normal = np.array([-d[1], d[0]])
    count = round(length / COLUMN)
    along = np.repeat((np.arange(count) + 0.5) * COLUMN, points)
    xy = p + along[:, None] * d + rng.normal(0, noise, len(along))[:, None] * normal
    rise = np.tile((np.arange(points) + 0.5) / points, count)
    return WallPoints(xy, rise, 2.5 * (1 - rise), xy + 2 * normal)


@pytest.mark.parametrize(("p", "q"), [((0, 0), (6, 0)), ((12, 5), (9, 9)), ((-7, 3), (-7, -5))])
@pytest.mark.parametrize("how", [measure, measure_by_sorting])
def test_the_covariance_is_that_of_a_least_squares_line_through_the_columns(p, q, how):
    points = scanned(p, q)
    face = how(Segments.from_ends(np.array([p], float), np.array([q], float)), points)
    length = float(face.length[0])
    columns = (np.arange(round(length / COLUMN)) + 0.5)[:, None] * COLUMN * face.direction + face.p
    alike = np.tile(np.eye(2) * float(face.rmse[0]) ** 2, (len(columns), 1, 1))
    exact = fit_lines(columns, np.zeros(len(columns), dtype=np.int64), alike)
    if exact.normal[0] @ face.normal[0] < 0:
        exact = exact.facing(columns[:1] + face.normal)
    assert face.rmse[0] == pytest.approx(SIGMA, rel=0.1)
    np.testing.assert_allclose(face.covariance[0], exact.covariance[0], rtol=0.02)


def test_a_face_that_nobody_saw_has_no_covariance():
    points = scanned((0, 0), (6, 0))
    face = measure(Segments.from_ends(np.array([[0.0, 9.0]]), np.array([[6.0, 9.0]])), points)
    assert np.isnan(face.covariance).all()
