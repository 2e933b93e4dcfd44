"""Image, skeleton and slopes (Remote Sensing 2021, 13, 4930, sections 2.2 and 2.3)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as hnp

from indoor_bim.plan.image import magnify_and_subsample, remove_burrs, thicken, wall_image
from indoor_bim.plan.skeleton import NO_SLOPE, VERTICAL, neighbour_count, pixel_slopes, remove_faults, thin_to_skeleton

images = hnp.arrays(bool, hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12))


def picture(*rows):
    return np.array([[mark == "#" for mark in row] for row in rows])


def test_rounding_error_is_below_half_a_pixel_and_nothing_is_lost():
    xy = np.random.default_rng(0).uniform(-5, 5, size=(500, 2))
    grid, low = magnify_and_subsample(xy, magnification=20)
    back = low + grid / 20
    nearest = np.abs(xy[:, None, :] - back[None]).max(axis=2).min(axis=1)
    assert nearest.max() <= 0.5 / 20 + 1e-12
    assert len(np.unique(grid, axis=0)) == len(grid)


def test_wall_image_has_its_pixels_where_the_points_are():
    xy = np.random.default_rng(1).uniform(100, 103, size=(200, 2))
    raster = wall_image(xy, magnification=25)
    assert raster.sample(xy).all()
    assert raster.image.sum() == len(magnify_and_subsample(xy, magnification=25)[0])
    assert not raster.image[:2].any()
    assert not raster.image[:, -2:].any()


@given(images)
def test_remove_burrs_equals_brute_force(image):
    expected = image.copy()
    for r, c in np.ndindex(image.shape):
        total = image[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].sum()
        expected[r, c] = image[r, c] if total == 4 else total > 4
    assert np.array_equal(remove_burrs(image), expected)


@given(images)
def test_thicken_equals_brute_force(image):
    for r, c in np.ndindex(image.shape):
        assert thicken(image)[r, c] == image[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].any()


@given(images)
def test_neighbour_count_equals_brute_force(image):
    for r, c in np.ndindex(image.shape):
        around = image[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].sum()
        assert neighbour_count(image)[r, c] == (around - 1 if image[r, c] else 0)


@given(images)
def test_thinning_stays_inside_and_is_stable(image):
    skeleton = thin_to_skeleton(image)
    assert not (skeleton & ~image).any()
    assert np.array_equal(thin_to_skeleton(skeleton), skeleton)


@pytest.mark.parametrize(
    ("skeleton", "slope"),
    [
        (picture("....", "####", "...."), 0),
        (picture(".#.", ".#.", ".#."), VERTICAL),
        (picture("#..", ".#.", "..#"), 1),
        (picture("..#", ".#.", "#.."), -1),
    ],
)
def test_straight_lines_have_their_slope(skeleton, slope):
    slopes = pixel_slopes(skeleton)
    assert (slopes[skeleton] == slope).all()
    assert (slopes[~skeleton] == NO_SLOPE).all()


@given(images)
def test_every_pixel_with_a_neighbour_gets_the_slope_of_one(image):
    slopes = pixel_slopes(image)
    assert np.array_equal(slopes != NO_SLOPE, neighbour_count(image) > 0)
    steps = {0: (0, 1), 1: (1, 1), -1: (1, -1), VERTICAL: (1, 0)}
    padded = np.pad(image, 1)
    for r, c in np.argwhere(slopes != NO_SLOPE):
        dr, dc = steps[int(slopes[r, c])]
        assert padded[1 + r + dr, 1 + c + dc] or padded[1 + r - dr, 1 + c - dc]


def test_step_in_a_line_is_a_fault_that_goes():
    skeleton = picture("####.....", "....#####")
    slopes = pixel_slopes(skeleton)
    assert (slopes == 1).sum() == 1
    assert (remove_faults(slopes)[skeleton] == 0).all()


def test_corner_is_no_fault():
    slopes = np.array([[0, 0, 0], [3, 3, 2], [3, 3, 2]], dtype=np.int8)
    assert np.array_equal(remove_faults(slopes), slopes)
