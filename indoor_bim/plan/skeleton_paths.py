"""Order along the skeleton of an image: the pixels of each of its branches one after another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Image = NDArray[np.bool_]


def skeleton_paths(skeleton: Image) -> tuple[Ints, Ints]:
    """Pixels of a skeleton in the order of walks along it.

    A walk starts at an end of a line, else at the first pixel left over, and goes on to the nearest neighbour not walked on yet, of
    equally near ones straight ahead. Where lines branch, it follows one of them; the rest are walks of their own.

    Parameters
    ----------
    skeleton : (rows, columns) bool
        Skeleton one pixel wide.

    Returns
    -------
    pixels : (n, 2) int64
        Row and column of every pixel of the skeleton, walk by walk.
    walk : (n,) int64
        Number of the walk of each.

    Examples
    --------
    >>> pixels, walk = skeleton_paths(np.array([[1, 1, 0, 1], [0, 0, 0, 1]], dtype=bool))
    >>> pixels.tolist(), walk.tolist()
    ([[0, 0], [0, 1], [0, 3], [1, 3]], [0, 0, 1, 1])
    """
    padded = np.pad(skeleton, 1)
    width = padded.shape[1]
    count = sum(np.roll(padded, (i, j), axis=(0, 1)).astype(np.int8) for i in (-1, 0, 1) for j in (-1, 0, 1)) - 1
    place = np.flatnonzero(padded)
    ends = place[np.asarray(count).ravel()[place] <= 1]
    steps = (-width, -1, 1, width, -width - 1, -width + 1, width - 1, width + 1)
    left = set(place.tolist())
    order: list[int] = []
    walk: list[int] = []
    number = 0
    for seed in [*ends.tolist(), *place.tolist()]:
        if seed not in left:
            continue
        pixel, ahead = seed, 0
        while True:
            left.discard(pixel)
            order.append(pixel)
            walk.append(number)
            near = [step for step in steps if pixel + step in left]
            if not near:
                break
            straight = ahead in near and (ahead in steps[:4] or not any(step in steps[:4] for step in near))
            ahead = ahead if straight else near[0]
            pixel += ahead
        number += 1
    rows, columns = np.divmod(np.array(order, dtype=np.int64), width)
    return np.column_stack([rows - 1, columns - 1]), np.array(walk, dtype=np.int64)
