"""Support of faces by many points, beside the twin in numpy."""

import numpy as np
import pytest

from indoor_bim.plan.evidence import WallPoints
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
