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
    row, column, layer = (_from_zero(axis, side) for axis, side in zip(points.T, (size, size, LAYER), strict=True))
    columns, layers = int(column.max()) + 1, int(layer.max()) + 1
    row *= columns
    row += column
    row *= layers
    row += layer
    row.sort()
    pixel = row[np.append(True, row[1:] != row[:-1])] // layers
    start = np.flatnonzero(np.append(True, pixel[1:] != pixel[:-1]))
    fill = np.diff(np.append(start, len(pixel)))
    wall = fill >= max(2.0, LEAST_FILL * layers)
    if not wall.any():
        return 0.0
    y, x = np.divmod(pixel[start[wall]], columns)
    image = np.zeros((int(y.max()) + 3, columns + 2), dtype=np.int8)
    image[y + 1, x + 1] = 1
    image = image[:-2] + image[1:-1] + image[2:]
    around = image[y, x] + image[y, x + 1] + image[y, x + 2]
    return float(fill[wall][around >= 3].sum() / fill[wall].sum())


def _from_zero(axis: Floats, side: float) -> NDArray[np.int64]:
    index = np.floor(axis / side).astype(np.int64)
    index -= index.min()
    return index
