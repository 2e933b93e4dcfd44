"""Support of faces by many points, beside the twin in numpy."""

import numpy as np
import pytest

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_loops import middle_points
from indoor_bim.plan.face_support import FEW_POINTS, measure, measure_by_sorting
from indoor_bim.plan.segments import Segments


@pytest.mark.parametrize("sided", [True, False])
def test_many_points_give_what_their_twin_gives(sided):
    rng = np.random.default_rng(4)
    count = 2 * FEW_POINTS
    xy = rng.uniform(-3, 3, (count, 2))
    xy[: count // 2, 1] = rng.normal(1.0, 0.01, count // 2)
    points = WallPoints(xy, rng.random(count), rng.random(count), rng.uniform(-3, 3, (count, 2)) if sided else None)
    p, q = rng.uniform(-4, 4, (2, 40, 2))
    p[0], q[0] = (-2, 1), (2, 1)
    p[1], q[1] = (9, 9), (10, 9)
    faces = Segments.from_ends(p, q)
    found, twin = measure(faces, points), measure_by_sorting(faces, points)
    assert np.array_equal(found.support, twin.support)
    assert found.support[0] > 1000 > 0 == found.support[1]
    np.testing.assert_allclose(found.rmse, twin.rmse, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.coverage, twin.coverage, rtol=0, atol=1e-12)
    assert np.isfinite(found.deviation[0])
    np.testing.assert_allclose(found.deviation, twin.deviation, rtol=0, atol=2e-5)
    np.testing.assert_allclose(found.covariance[0], twin.covariance[0], rtol=0.02)
    shuffled = rng.permutation(count)
    again = measure(faces, WallPoints(xy[shuffled], points.rise[shuffled], points.depth, points.sensor[shuffled] if sided else None))
    assert np.array_equal(again.rmse, found.rmse, equal_nan=True)


def test_points_around_a_face_and_in_the_middle_of_the_height():
    rng = np.random.default_rng(7)
    xy, rise = rng.uniform(-3, 3, (5000, 2)), rng.random(5000)
    p, d = np.array([-1.0, 0.5]), np.array([0.8, 0.6])
    out = np.zeros((5000, 3))
    ranges = np.array([[100, 2000], [2500, 4900]])
    count = middle_points(xy, rise, ranges, p, d, 2.5, 0.25, 0.1, 0.8, out)
    rows = np.r_[100:2000, 2500:4900]
    along, across = (xy[rows] - p) @ d, (xy[rows] - p) @ [-d[1], d[0]]
    on = (np.abs(across) < 0.25) & (along > 0) & (along < 2.5) & (rise[rows] > 0.1) & (rise[rows] < 0.8)
    assert count == on.sum() > 50
    np.testing.assert_allclose(out[:count], np.column_stack([along, across, rise[rows]])[on], rtol=0, atol=1e-12)
