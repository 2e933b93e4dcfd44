"""Numbers in ascending order and the one in their middle: as numpy sorts them."""

import numpy as np
import pytest

from indoor_bim.ordering import FEW, ascending, ascending_in_groups, median, order_of


@pytest.mark.parametrize("largest", [0, 1, 2**11 - 1, 2**11, 2**22, 2**40, 2**62])
@pytest.mark.parametrize("count", [1, FEW, FEW + 1, 30_000])
def test_order_is_that_of_a_stable_sort(largest, count):
    keys = np.random.default_rng(count).integers(0, largest + 1, count)
    keys[-1] = largest
    assert np.array_equal(order_of(keys), np.argsort(keys, kind="stable"))


@pytest.mark.parametrize("count", [1, FEW, FEW + 1, 30_000])
@pytest.mark.parametrize("exponent", [0, 1, 7])
def test_values_ascend_whether_spread_or_crowded(count, exponent):
    values = np.random.default_rng(count).normal(0, 1, count) ** exponent
    assert np.array_equal(ascending(values), np.sort(values))
    assert np.array_equal(ascending(np.repeat(values, 3)), np.repeat(np.sort(values), 3))


def test_values_that_differ_by_less_than_can_be_told_apart_ascend():
    for values in (np.nextafter(1.0, np.array([0.0, 2.0] * FEW)), np.nextafter(0.0, np.array([-1.0, 1.0] * FEW))):
        assert np.array_equal(ascending(values), np.sort(values))


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf, 1.7e308])
def test_values_that_are_not_finite_or_too_far_apart_ascend_as_well(odd):
    values = np.random.default_rng(1).normal(0, 1, 2 * FEW)
    values[7], values[8] = odd, -1.7e308
    assert np.array_equal(ascending(values), np.sort(values), equal_nan=True)


@pytest.mark.parametrize("count", [1, 2, FEW, FEW + 1, 30_000, 30_001])
@pytest.mark.parametrize("exponent", [0, 1, 7])
def test_the_median_is_that_of_numpy(count, exponent):
    values = np.random.default_rng(count).normal(0, 1, count) ** exponent
    assert median(values) == np.median(values)
    assert median(values[::-1]) == np.median(values)


@pytest.mark.parametrize("low", [FEW - 1, FEW, FEW + 1])
def test_the_two_in_the_middle_may_lie_far_apart(low):
    values = np.concatenate([np.full(low, -3.0), np.full(FEW, 8.0)])
    assert median(np.random.default_rng(1).permutation(values)) == np.median(values)


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf, 1.7e308])
def test_the_median_of_values_that_are_not_finite_or_too_far_apart_is_that_of_numpy(odd):
    values = np.random.default_rng(2).normal(0, 1, 2 * FEW)
    values[7], values[8] = odd, -1.7e308
    assert np.array_equal(median(values), np.median(values), equal_nan=True)


@pytest.mark.parametrize("groups", [1, 40, 5000])
@pytest.mark.parametrize("count", [0, 1, 20_000])
def test_values_ascend_within_their_groups(count, groups):
    rng = np.random.default_rng(count)
    group, values = rng.integers(0, groups, count), np.round(rng.normal(0, 1, count), 2)
    first, ordered = ascending_in_groups(group, values, groups)
    rows = np.lexsort((values, group))
    assert np.array_equal(ordered, values[rows])
    assert np.array_equal(first, np.searchsorted(group[rows], np.arange(groups + 1)))
