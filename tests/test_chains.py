"""Chains of points are simplified as scikit-image does it."""

import numpy as np
import pytest
from skimage.measure import approximate_polygon

from indoor_bim.plan.chain_loops import corners_of


@pytest.mark.parametrize("tolerance", [0.3, 1.2, 50.0])
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_corners_are_those_of_scikit_image(seed, closed, tolerance):
    chain = np.cumsum(np.random.default_rng(seed).choice([-0.5, 0.0, 0.5, 1.0], (400, 2)), axis=0)
    if closed:
        chain = np.vstack([chain, chain[0]])
    corners = chain[corners_of(chain, tolerance)]
    assert np.array_equal(corners, approximate_polygon(chain, tolerance))
    assert 2 <= len(corners) < len(chain)


def test_two_points_stay():
    assert corners_of(np.array([[0.0, 0.0], [1.0, 1.0]]), 1.0).tolist() == [True, True]
