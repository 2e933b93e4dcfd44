"""Polygons in images, beside those of scikit-image."""

import numpy as np
import pytest

from indoor_bim.plan.polygon_fill import fill


def drawn(xy, shape):
    image = np.zeros(shape, dtype=np.int32)
    fill(np.ascontiguousarray(np.vstack([xy, xy[:1]]), dtype=float), 7, image)
    return image


@pytest.mark.parametrize("seed", range(30))
def test_same_pixels_as_scikit_image(seed):
    from skimage.draw import polygon

    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 12)))
    xy = 20 + rng.uniform(3, 30, len(angle))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    expected = np.zeros((40, 50), dtype=np.int64)
    expected[polygon(xy[:, 1], xy[:, 0], expected.shape)] = 7
    assert expected.any()
    assert np.array_equal(drawn(xy, expected.shape), expected)


def test_the_border_belongs_to_it():
    image = drawn(np.array([[2, 1], [5, 1], [5, 4], [2, 4]]), (7, 8))
    assert image.sum() == 7 * 16
    assert (image[1:5, 2:6] == 7).all()
