"""Horizontal surfaces of a scan: the vertical that makes them sharpest, their heights, and the planes of floor and ceiling.

Source: Remote Sensing 2021, 13, 4930, section 2.1 (algorithms 1 and 2), for `vertical_axis`, `alone_in_cell` and `horizontal_plane`;
the others make them robust.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.filters import statistical_inliers
from indoor_bim.cloud.plane import Plane, fit_plane, principal_axes, rotation_to_z
from indoor_bim.cloud.thinning import MICROMETRE

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]

LARGEST_TILT = np.deg2rad(35)
"""Tilt beyond which the axis that the principal components offer as vertical is not believed."""


def vertical_axis(points: Points) -> tuple[Points, Points, str | None]:
    """Mid point and normal of the plane that splits the scan into an upper and a lower half (section 2.1).

    The paper takes the third principal axis, whatever its direction. It is not vertical for clouds that are as high as
    wide; then the axis closest to +z is taken, or +z itself, with a word of warning. The normal always points to +z.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z roughly up.

    Returns
    -------
    mean : (3,) float64
        Point on the mid plane.
    normal : (3,) float64
        Its unit normal, towards +z.
    warning : str or None
        What was assumed.
    """
    mean, axes, _ = principal_axes(points)
    tilt = np.arccos(np.clip(np.abs(axes[:, 2]), 0, 1))
    nearest = int(np.argmin(tilt))
    if tilt[2] <= LARGEST_TILT:
        normal, warning = axes[2], None
    elif tilt[nearest] <= LARGEST_TILT:
        normal = axes[nearest]
        warning = (
            f"the cloud's third principal axis is {np.degrees(tilt[2]):.0f}° off the vertical; "
            f"took the principal axis that is {np.degrees(tilt[nearest]):.0f}° off"
        )
    else:
        normal = np.array([0.0, 0.0, 1.0])
        warning = (
            f"no principal axis of the cloud is nearer than {np.degrees(tilt[nearest]):.0f}° to the vertical; took the scan's own z axis"
        )
    return mean, normal * (1.0 if normal[2] >= 0 else -1.0), warning


def alone_in_cell(xy: Points, *, grid_count: int) -> Mask:
    """Points that have a cell of the grid to themselves (section 2.1, grid threshold method, equations 2 to 4).

    A wall stacks many points in a cell, a floor or ceiling about one. The grid covers the range of the points (the paper
    prints the maximum instead of the range); cell numbers are rounded, then clamped to 1 ... `grid_count`.

    Parameters
    ----------
    xy : (n, 2) float64
        Points projected to the plane, metres.
    grid_count : int
        Cells along each side of the grid (n_fac).

    Returns
    -------
    (n,) bool
        True where a point is the only one of its cell.

    Examples
    --------
    >>> alone_in_cell(np.array([[0.0, 0.0], [0.1, 0.0], [5.0, 9.0], [10.0, 10.0]]), grid_count=10).tolist()
    [False, False, True, True]
    """
    low = xy.min(axis=0)
    step = np.maximum((xy.max(axis=0) - low) / grid_count, MICROMETRE)
    i, j = np.clip(np.rint((xy - low) / step).astype(np.int64), 1, grid_count).T
    cell = (i - 1) * grid_count + (j - 1)
    alone: Mask = np.bincount(cell, minlength=1)[cell] == 1
    return alone


def horizontal_plane(half: Points, *, normal: Points, grid_count: int) -> Plane | None:
    """Floor or ceiling of one half of the scan (section 2.1, algorithm 2, steps 3 to 11).

    The half is projected to its plane, points alone in their cell are kept, statistical outliers are removed, and the rest is fitted
    by principal components.

    Parameters
    ----------
    half : (n, 3) float64
        Upper or lower half of the scan, metres.
    normal : (3,) float64
        Normal of the mid plane.
    grid_count : int
        Cells along each side of the grid (n_fac).

    Returns
    -------
    Plane or None
        Plane with its normal on the side of `normal`; None if fewer than 30 points are left.
    """
    across = np.linalg.svd(normal[None, :])[2][1:]
    flat = half[alone_in_cell(half @ across.T, grid_count=grid_count)]
    if len(flat) < 30:
        return None
    flat = flat[statistical_inliers(flat, nb_neighbors=20, std_ratio=2.0)]
    return fit_plane(flat).facing(normal) if len(flat) >= 30 else None


def sharpest_normal(points: Points, normal: Points) -> Points:
    """Return the normal near a first guess along which horizontal surfaces pile up most sharply.

    The paper fits each plane once to all points that are alone in their cell; stairs, furniture and surfaces at several heights
    tilt that fit by degrees. Here tilts about the guess are searched coarse to fine for the largest sum of squared counts
    of the heights.

    Parameters
    ----------
    points : (n, 3) float64
        Points, evenly thinned, metres.
    normal : (3,) float64
        First guess, within some 8 degrees.

    Returns
    -------
    (3,) float64
        Unit normal on the side of the guess.
    """
    sample = points[:: max(1, len(points) // 30_000)]
    sample = sample - np.median(sample, axis=0)
    turn = rotation_to_z(normal)
    for half, step, layer, every in ((8.0, 1.0, 0.15, 4), (1.0, 0.25, 0.08, 1), (0.25, 0.05, 0.04, 1)):
        x, y, z = turn @ sample[::every].T
        slopes = np.tan(np.deg2rad(step)) * np.arange(-round(half / step), round(half / step) + 1)
        tilts = [(a * a + b * b, a, b) for a in slopes for b in slopes]
        _, _, a, b = max((_peakedness((a * x + b * y + z) / np.sqrt(1 + r), layer), -r, a, b) for r, a, b in tilts)
        best = turn.T @ np.array([a, b, 1.0])
        turn = rotation_to_z(best / np.linalg.norm(best))
    upright: Points = turn[2]
    return upright


def _peakedness(height: Points, layer: float) -> float:
    index = np.floor(height / layer).astype(np.int64)
    counts = np.bincount(index - index.min())
    return float((np.convolve(counts, [0.5, 1.0, 0.5]) ** 2).sum())


def horizontal_layers(height: Points, *, layer: float = 0.05, contrast: float = 2.5, share: float = 0.25) -> tuple[Points, Points]:
    """Heights at which horizontal surfaces lie, from the bottom up.

    Parameters
    ----------
    height : (n,) float64
        Heights of evenly thinned points, metres.
    layer : float
        Thickness of the layers that are counted, metres.
    contrast : float
        Least number of points in a layer against the median of the layers within half a metre.
    share : float
        Least number of points in a layer against the fullest layer.

    Returns
    -------
    levels : (m,) float64
        Median height of the points of each layer that stands out, metres.
    counts : (m,) float64
        Number of its points.
    """
    from scipy import ndimage

    low, high = np.quantile(height, [0.002, 0.998])
    step = layer / 2
    first = np.floor(low / step) - 2
    index = np.floor(height / step).astype(np.int64) - int(first)
    inside = (index >= 0) & (index <= (high / step - first) + 2)
    counts = np.bincount(index[inside], minlength=5)
    window = np.convolve(counts, [1, 1], mode="full")[: len(counts)].astype(np.float64)
    usual = ndimage.median_filter(window, size=2 * round(0.5 / step) + 1, mode="constant")
    enough = np.maximum(contrast * usual, share * window.max())
    levels: list[float] = []
    sizes: list[float] = []
    padded = np.pad(window, 2)
    for i in np.flatnonzero(window >= enough):
        if window[i] == padded[i : i + 5].max() and not (levels and (first + i) * step - levels[-1] < 2 * layer):
            near = np.abs(height - (first + i) * step) <= layer
            levels.append(float(np.median(height[near])))
            sizes.append(float(window[i]))
    return np.array(levels), np.array(sizes)
