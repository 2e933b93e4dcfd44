"""Skeleton of the wall image and the slope of each of its pixels (Remote Sensing 2021, 13, 4930, section 2.3, algorithm 4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.bool_]
Slopes = NDArray[np.int8]

VERTICAL = 2
"""Slope of pixels whose neighbour lies above or below."""
NO_SLOPE = 3
"""Marks background and pixels without neighbours."""

_STEPS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
_SLOPE_OF_STEP = {(0, -1): 0, (0, 1): 0, (-1, 0): VERTICAL, (1, 0): VERTICAL, (1, 1): 1, (-1, -1): 1, (1, -1): -1, (-1, 1): -1}


def thin_to_skeleton(image: Image) -> Image:
    """Skeleton one pixel wide by the thinning of Zhang and Suen (section 2.3).

    Parameters
    ----------
    image : (rows, columns) bool
        Binary image.

    Returns
    -------
    (rows, columns) bool
        Skeleton; lines are 8-connected.

    Examples
    --------
    >>> cross = np.array([[0, 1, 1, 0], [1, 1, 1, 1], [1, 1, 1, 1], [0, 1, 1, 0]], dtype=bool)
    >>> int(thin_to_skeleton(cross).sum())
    2
    """
    from skimage.morphology import skeletonize

    skeleton: Image = skeletonize(np.ascontiguousarray(image), method="zhang")  # type: ignore[no-untyped-call]
    return skeleton


def neighbour_count(skeleton: Image) -> NDArray[np.int8]:
    """Count the 8-neighbours (rows, columns) of every pixel of the skeleton; 0 on the background."""
    count = np.zeros(skeleton.shape, dtype=np.int8)
    for shifted in _neighbours(skeleton, False):
        count += shifted
    return np.where(skeleton, count, np.int8(0))


def pixel_slopes(skeleton: Image) -> Slopes:
    """Slope of every pixel towards its nearest neighbour (section 2.3, equation 15, figure 13).

    A walk starts at a seed, goes to the nearest 8-neighbour whose slope is not yet known, gives the pixel the slope of that
    step, and goes on until no neighbour is left; then the next seed follows. The paper draws seeds and equally near neighbours at
    random. Here ends of lines are the first seeds, then all other pixels, each by row and column; of equally near neighbours
    the one straight ahead is taken, else the first by row and column.

    Parameters
    ----------
    skeleton : (rows, columns) bool
        Skeleton one pixel wide; rows run along y, columns along x.

    Returns
    -------
    (rows, columns) int8
        0, 1, -1 or `VERTICAL`; `NO_SLOPE` on the background and on pixels without neighbours.

    Examples
    --------
    >>> pixel_slopes(np.eye(3, dtype=bool))[1].tolist()
    [3, 1, 3]
    """
    slopes = np.full(skeleton.shape, NO_SLOPE, dtype=np.int8)
    count = neighbour_count(skeleton)
    pixels = [(int(r), int(c)) for r, c in np.argwhere(skeleton)]
    seeds = [pixel for pixel in pixels if count[pixel] == 1] + pixels
    unknown = set(pixels)
    present = frozenset(pixels)
    for seed in seeds:
        if seed not in unknown:
            continue
        unknown.discard(seed)
        pixel, slope, ahead = seed, NO_SLOPE, (0, 0)
        while (step := _nearest_step(pixel, unknown, ahead)) is not None:
            slope = _SLOPE_OF_STEP[step]
            slopes[pixel] = slope
            pixel, ahead = (pixel[0] + step[0], pixel[1] + step[1]), step
            unknown.discard(pixel)
        if slope == NO_SLOPE and (step := _nearest_step(pixel, present, ahead)) is not None:
            slope = _SLOPE_OF_STEP[step]
        slopes[pixel] = slope
    return slopes


def _nearest_step(
    pixel: tuple[int, int], candidates: set[tuple[int, int]] | frozenset[tuple[int, int]], ahead: tuple[int, int]
) -> tuple[int, int] | None:
    row, column = pixel
    steps = [step for step in _STEPS if (row + step[0], column + step[1]) in candidates]
    return min(steps, key=lambda step: (abs(step[0]) + abs(step[1]), step != ahead, step)) if steps else None


def remove_faults(slopes: Slopes) -> Slopes:
    """Slopes without single deviating pixels (section 2.3, figure 14).

    A pixel with exactly two neighbours of equal slope takes that slope. All pixels are judged by the slopes before this step, so
    that their order does not matter.

    Parameters
    ----------
    slopes : (rows, columns) int8
        Slopes of the skeleton, as `pixel_slopes` gives them.

    Returns
    -------
    (rows, columns) int8
        Corrected slopes.

    Examples
    --------
    >>> remove_faults(np.array([[0, 0, 1, 0, 0]], dtype=np.int8)).tolist()
    [[0, 0, 0, 0, 0]]
    """
    skeleton = slopes != NO_SLOPE
    count = neighbour_count(skeleton)
    out = slopes.copy()
    for slope in (0, 1, -1, VERTICAL):
        equal = np.zeros(slopes.shape, dtype=np.int8)
        for shifted in _neighbours(slopes, NO_SLOPE):
            equal += shifted == slope
        out[skeleton & (count == 2) & (equal == 2)] = slope
    return out


def _neighbours(image: NDArray, background: int) -> list[NDArray]:
    padded = np.pad(image, 1, constant_values=background)
    rows, columns = image.shape
    return [padded[1 + r : 1 + r + rows, 1 + c : 1 + c + columns] for r, c in _STEPS]
