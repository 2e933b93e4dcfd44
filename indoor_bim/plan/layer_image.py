"""Which heights are hit where in plan: an image whose pixels hold one bit for each layer of a storey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Layers = NDArray[np.bool_]

MOST_LAYERS = 63  # bits of a pixel
LAYER = 0.025  # metres: height of a layer where the storey is not too tall for it
SAMPLING = 0.05  # metres along a line: what one step of it is about as long as


@dataclass(frozen=True, slots=True, eq=False)
class LayerImage:
    """Layers of a storey that hold a point, pixel by pixel.

    Parameters
    ----------
    bits : Raster
        Bit k is set where a point lies in layer k.
    layer : float
        Height of a layer, metres; layer 0 stands on the floor.
    count : int
        Number of layers up to the ceiling.
    """

    bits: Raster
    layer: float
    count: int

    def rows(self, low: float, high: float) -> slice:
        """Layers whose middle lies between two heights above the floor, metres; at least one."""
        first = int(np.clip(np.ceil(low / self.layer - 0.5), 0, self.count - 1))
        last = int(np.clip(np.ceil(high / self.layer - 0.5), first + 1, self.count))
        return slice(first, last)


def layer_image(points: Floats, *, height: float, cell: float = 0.025) -> LayerImage:
    """Image of the layers that points lie in.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z above the floor; at least one.
    height : float
        From floor to ceiling, metres.
    cell : float
        Side of a pixel, metres.

    Examples
    --------
    >>> image = layer_image(np.array([[0.01, 0.01, 0.07], [0.01, 0.01, 0.99]]), height=1.0)
    >>> hits_along(image, np.zeros((1, 2)), np.array([[0.02, 0.0]]), reach=0.0)[0].nonzero()[1].tolist()
    [2, 39]
    """
    layer = max(LAYER, height / MOST_LAYERS)
    count = max(int(np.ceil(round(height / layer, 6))), 1)
    level = np.floor(points[:, 2] / layer).astype(np.int64)
    inside = (level >= 0) & (level < count)
    place = np.floor(points[inside, :2] / cell).astype(np.int64)
    low: Ints = place.min(axis=0) if len(place) else np.zeros(2, dtype=np.int64)
    columns, rows = place.max(axis=0) - low + 1 if len(place) else (1, 1)
    pixel = (place[:, 1] - low[1]) * columns + place[:, 0] - low[0]
    level = level[inside]
    image = np.zeros(int(rows * columns), dtype=np.int64)
    for k in range(count):
        image[pixel[level == k]] |= np.int64(1) << k
    return LayerImage(Raster(image.reshape(int(rows), int(columns)), np.array(low * cell, dtype=np.float64), cell), layer, count)


def hits_along(image: LayerImage, p: Floats, q: Floats, *, reach: float, shift: float = 0.0) -> list[Layers]:
    """Layers hit along lines, step by step.

    Parameters
    ----------
    image : LayerImage
        Layers hit in plan.
    p, q : (m, 2) float64
        Ends of the lines, metres.
    reach : float
        Points within this distance to both sides count, metres.
    shift : float
        The lines are moved to their left by this, metres.

    Returns
    -------
    list of (k, layers) bool
        For each line, and each of k equal steps of about `SAMPLING` along it, the layers hit.
    """
    if not len(p):
        return []
    cell = image.bits.cell
    length = np.maximum(np.hypot(*(q - p).T), 1e-9)
    steps = np.maximum(np.rint(length / SAMPLING).astype(np.int64), 1)
    direction = (q - p) / length[:, None]
    normal = np.column_stack([-direction[:, 1], direction[:, 0]])
    # samples a pixel apart, some in each step
    each = max(int(np.ceil(SAMPLING / cell)), 1)
    row = np.repeat(np.arange(len(p)), steps * each)
    first = np.cumsum(steps * each) - steps * each
    at = (np.arange(len(row)) - first[row] + 0.5) / (steps * each)[row]
    on_line = p[row] + at[:, None] * (q - p)[row]
    bits = np.zeros(len(row), dtype=np.int64)
    sideways = int(np.ceil(reach / cell))
    for k in range(-sideways, sideways + 1):
        off = shift + (reach * k / sideways if sideways else 0.0)
        bits |= image.bits.sample(on_line + off * normal[row])
    bits = np.bitwise_or.reduceat(bits, np.arange(0, len(bits), each))
    hit = (bits[:, None] >> np.arange(image.count)) & 1 > 0
    return np.split(hit, np.cumsum(steps)[:-1])
