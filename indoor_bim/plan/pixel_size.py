"""How fine an image the points of a scan support."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LAYER = 0.10  # metres; layers in which a pixel's column may be hit
LEAST_FILL = 0.25  # share of the layers that a wall's pixel is hit in at least
LEAST_CONNECTED = 0.9  # of the best share of connected wall pixels


def connected_pixel(points: Floats, *, sizes: Sequence[float]) -> float:
    """Smallest pixel at which walls are unbroken lines.

    In an image of walls nearly every pixel has two neighbours or more; in one that is too fine for the scan, walls fall apart
    into dots. Pixels count by how many layers of their column are hit, so noise and furniture hardly matter.

    Parameters
    ----------
    points : (n, 3) float64
        Wall points of one storey, metres.
    sizes : sequence of float
        Sizes to choose from, ascending, metres.

    Returns
    -------
    float
        The first size at which the share of connected pixels comes within a tenth of the best.

    Examples
    --------
    >>> x, z = np.meshgrid(np.arange(0, 4, 0.05), np.arange(0, 2.5, 0.05))
    >>> wall = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    >>> connected_pixel(wall, sizes=(0.02, 0.05, 0.1))
    0.05
    """
    shares = [_connected_share(points, size) for size in sizes]
    return next(size for size, share in zip(sizes, shares, strict=True) if share >= LEAST_CONNECTED * max(shares))


def _connected_share(points: Floats, size: float) -> float:
    """Share of the wall pixels, weighted by the layers hit, that have at least two neighbours."""
    from scipy.ndimage import uniform_filter

    index = np.floor(np.column_stack([points[:, :2] / size, points[:, 2] / LAYER])).astype(np.int64)
    index -= index.min(axis=0)
    rows, columns, layers = index.max(axis=0) + 1
    key = np.sort((index[:, 0] * columns + index[:, 1]) * layers + index[:, 2])
    pixel = key[np.concatenate([[True], key[1:] != key[:-1]])] // layers
    hit, start = np.unique(pixel, return_index=True)
    fill = np.diff(np.append(start, len(pixel)))
    image = np.zeros((rows + 2, columns + 2), dtype=np.float64)
    image[hit // columns + 1, hit % columns + 1] = fill
    wall = image >= max(2.0, LEAST_FILL * layers)
    if not wall.any():
        return 0.0
    around = np.round(uniform_filter(wall.astype(np.float64), size=3, mode="constant") * 9)
    return float(image[wall & (around >= 3)].sum() / image[wall].sum())
