"""Order of whole numbers: as numpy sorts them."""

import numpy as np
import pytest

from indoor_bim.cloud.key_order import FEW_KEYS, order_of


@pytest.mark.parametrize("largest", [0, 1, 2**11 - 1, 2**11, 2**22, 2**40, 2**62])
@pytest.mark.parametrize("count", [1, FEW_KEYS, FEW_KEYS + 1, 30_000])
def test_order_is_that_of_a_stable_sort(largest, count):
    keys = np.random.default_rng(count).integers(0, largest + 1, count)
    keys[-1] = largest
    assert np.array_equal(order_of(keys), np.argsort(keys, kind="stable"))
