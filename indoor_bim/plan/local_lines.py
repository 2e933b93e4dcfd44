"""Points drawn onto the line through their neighbourhood, so that noisy walls become thin enough to follow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PIXELS_PER_RADIUS = 3  # of the images that moments are summed in
FINEST = 0.005  # metres
AREA_LIKE = 0.9  # of it: corners are less wide, areas more
LEAST_EXTENT = 0.3  # of the radius: what has less around it is alone
LINE_LIKE = 0.6  # of the standard deviation along a neighbourhood: one that is wider has no direction


def local_lines(xy: Floats, *, radius: float) -> tuple[Floats, Floats, Floats]:
    """Line through the neighbourhood of each point.

    Neighbours are weighted by a normal distribution, those in one pixel by the root of their number. Their moments are summed in an
    image and smoothed there, so that the cost grows with the area and not with the number of neighbours.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    radius : float
        Standard deviation of the weights, metres.

    Returns
    -------
    mean : (n, 2) float64
        Mean of the neighbours, metres.
    direction : (n, 2) float64
        Unit direction in which they spread most.
    spread : (n, 2) float64
        Their standard deviations along it and across it, metres.
    """
    from scipy.ndimage import gaussian_filter

    pixel = max(radius / PIXELS_PER_RADIUS, FINEST)
    cell = np.floor(xy / pixel).astype(np.int64)
    cell -= cell.min(axis=0)
    columns, rows = cell.max(axis=0) + 1
    key = cell[:, 1] * columns + cell[:, 0]
    occupied, at, count = np.unique(key, return_inverse=True, return_counts=True)
    # sums of whole micrometres do not depend on the order of the points
    local = np.rint((xy - xy.min(axis=0)) * 1e6)
    centre = np.column_stack([np.bincount(at, weights=local[:, k]) for k in (0, 1)]) / count[:, None] * 1e-6

    def smooth(values: Floats) -> Floats:
        image = np.zeros((rows, columns))
        image.ravel()[occupied] = values
        out: Floats = gaussian_filter(image, radius / pixel, mode="constant", truncate=2.5).ravel()[occupied]
        return out

    x, y = centre.T
    weight = np.maximum(smooth(count.astype(np.float64)), 1e-12)
    mx, my = smooth(count * x) / weight, smooth(count * y) / weight
    xx, xy_, yy = (
        smooth(count * x * x) / weight - mx * mx,
        smooth(count * x * y) / weight - mx * my,
        smooth(count * y * y) / weight - my * my,
    )
    angle = np.arctan2(2 * xy_, xx - yy) / 2
    middle, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy_)
    spread = np.sqrt(np.maximum(np.column_stack([middle + half, middle - half]), 0.0))
    mean = np.column_stack([mx, my]) + xy.min(axis=0)
    return mean[at], np.column_stack([np.cos(angle), np.sin(angle)])[at], spread[at]


def wall_scatter(xy: Floats, *, radius: float = 0.06) -> float:
    """How far points of a wall scatter across it: the median of the neighbourhoods that have a direction, metres.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    radius : float
        Size of the neighbourhoods, metres; larger than the scatter, smaller than the distance of the faces of a wall.
    """
    _, _, spread = local_lines(xy, radius=radius)
    linear = spread[:, 1] < LINE_LIKE * spread[:, 0]
    return float(np.median(spread[linear, 1])) if linear.any() else 0.0


def line_like(xy: Floats, *, radius: float) -> NDArray[np.bool_]:
    """Points (n,) that are not in the midst of an area: undersides of lintels and beams, shelves, and single points are left out."""
    _, _, spread = local_lines(xy, radius=radius)
    return (spread[:, 1] < AREA_LIKE * spread[:, 0]) & (spread[:, 0] > LEAST_EXTENT * radius)


def draw_to_lines(xy: Floats, *, radius: float) -> Floats:
    """Points moved across to the line through their neighbourhood; those whose neighbourhood has no direction stay.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    radius : float
        Size of the neighbourhood, metres.

    Returns
    -------
    (n, 2) float64
        Metres.
    """
    mean, direction, spread = local_lines(xy, radius=radius)
    offset = xy - mean
    along = (offset * direction).sum(axis=1)
    linear = spread[:, 1] < LINE_LIKE * spread[:, 0]
    return np.where(linear[:, None], mean + along[:, None] * direction, xy)
