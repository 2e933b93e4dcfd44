"""The robust line through the strips around a crest, beside its twin in numpy."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan.block_image import BlockImage
from indoor_bim.plan.crest_loops import LONG, WINDOW, fit_crest
from indoor_bim.plan.strips import BELOW_CEILING, layer_bits

BAND = layer_bits(BELOW_CEILING.band)
ALONG, ACROSS = BELOW_CEILING.along, BELOW_CEILING.across


def crest(rows, *, slope, seed):
    """Strips hit along a line that is askew, some strips beside it, and the path of the crest."""
    rng = np.random.default_rng(seed)
    masks = np.zeros((rows + 8, 90), dtype=np.uint32)
    path = 40 + slope * np.arange(rows) + rng.normal(0, 0.7, rows)
    for i, v in enumerate(path):
        for strip in np.rint(v + rng.normal(0, 1.2, 12)).astype(int):
            masks[3 + i, strip] |= np.uint32(rng.integers(0, 2**24))
        masks[3 + i, rng.integers(0, 90, 3)] |= np.uint32(rng.integers(0, 2**24))
    return masks, 3, path


def fitted(masks, first, path):
    image = BlockImage.of(masks)
    return fit_crest(image.slot, image.values, masks.shape[1], first, path, BAND, ALONG, ACROSS)


def twin(masks, first, path):
    """Slope, middle, level and scatter in numpy."""
    rows = first + np.arange(len(path))
    strips = np.clip(np.rint(path)[:, None].astype(int) + np.arange(-WINDOW, WINDOW + 1), 0, masks.shape[1] - 1)
    bits = masks[rows[:, None], strips]
    upper, whole = np.bitwise_count(bits & BAND).astype(float), np.bitwise_count(bits).astype(float)
    x, y = np.broadcast_to((rows[:, None] + 0.5) * ALONG, bits.shape), (strips + 0.5) * ACROSS
    middle = np.average(x, weights=upper)
    slope, level = 0.0, (np.median(path) + 0.5) * ACROSS
    if len(path) > LONG:
        slope, level = np.polyfit(x[:, 0] - middle, (path + 0.5) * ACROSS, 1)
    weight, width, spread = upper, 0.06, 0.02
    for step in range(8):
        if step == 4:
            weight, width = whole, np.clip(3 * spread, 0.02, 0.05)
        residual = y - level - slope * (x - middle)
        w = weight * np.maximum(1 - (residual / width) ** 2, 0) ** 2
        mx, my = np.average(x, weights=w), np.average(y, weights=w)
        if len(path) > LONG:
            slope = (w * (x - mx) * (y - my)).sum() / (w * (x - mx) ** 2).sum()
        level = my + slope * (middle - mx)
        spread = np.sqrt(np.average(residual**2, weights=w))
        inner = weight * (np.abs(residual) < width)
        if step < 4:
            width = np.clip(4 * 1.4826 * np.sqrt((inner * residual**2).sum() / inner.sum()) / 1.2, 0.015, 0.06)
    return slope, middle, level, spread


@pytest.mark.parametrize("rows", [4, 7, 60])
@pytest.mark.parametrize("slope", [0.0, 0.3])
@pytest.mark.parametrize("seed", [1, 2])
def test_line_is_that_of_the_twin(rows, slope, seed):
    masks, first, path = crest(rows, slope=slope, seed=seed)
    found, *line = fitted(masks, first, path)
    assert found
    assert line == pytest.approx(twin(masks, first, path), abs=1e-9)


def test_few_layers_are_no_line():
    masks = np.zeros((9, 30), dtype=np.uint32)
    masks[4, 10] = 1 << 21
    assert not fitted(masks, 2, np.full(5, 10.0))[0]
