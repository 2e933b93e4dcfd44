"""Groups of equal keys are those that numpy finds by sorting."""

import numpy as np
import pytest

from indoor_bim.plan.grouping import group_keys


@pytest.mark.parametrize(("count", "largest"), [(1, 0), (1, 99), (500, 40), (500, 3_000), (500, 10**12), (0, 1)])
def test_groups_are_those_of_numpy(count, largest):
    keys = np.random.default_rng(count).integers(0, largest + 1, count)
    _, *expected = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    for found, one in zip(group_keys(keys), expected, strict=True):
        assert np.array_equal(found, one)
