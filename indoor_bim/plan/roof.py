"""The underside of a roof: the surface overhead where no level ceiling is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.overhead import overhead_surface
from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]

FINER = 4
"""Pixels of the result per cell of the surface, along each side."""
LEAST_COVER = 0.35
"""Share of what lies as high as the floor that has a roof above it, if there is one."""
AROUND = np.array([[0.1, 0.1, 0.1], [0.1, 1.0, 0.1], [0.1, 0.1, 0.1]])
"""Weight of the points of a cell and of those around, for the plane of the cell."""
THICKNESS = 0.25
"""Points this close to the surface in a cell are looked at for its height, metres."""


def roof_surface(points: Floats, *, floor: float, top: float) -> Raster | None:
    """Height of sloped and level surfaces overhead, by a plane around every cell.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned points in model coordinates, metres.
    floor : float
        Floor height, metres.
    top : float
        Nothing above this height is looked at, metres.

    Returns
    -------
    Raster or None
        Heights in metres, NaN where nothing was seen; None where most of the floor has nothing overhead.
    """
    from scipy import ndimage

    coarse = overhead_surface(points, floor=floor, top=top, sloped=True)
    if coarse is None:
        return None
    known = _largest(~np.isnan(coarse.image))
    coarse = Raster(np.where(known, coarse.image, np.nan), coarse.origin, coarse.cell)
    ground = points[np.abs(points[:, 2] - floor) < 0.06, :2]
    near = Raster(ndimage.binary_dilation(known, np.ones((3, 3))), coarse.origin, coarse.cell)
    if not len(ground) or near.sample(ground).mean() < LEAST_COVER:
        return None
    high = points[(points[:, 2] > floor + 0.3) & (points[:, 2] < top)]
    high = high[np.abs(high[:, 2] - coarse.sample(high[:, :2], outside=np.nan)) < THICKNESS]
    return _planes(high, coarse)


def ridge_height(roof: Raster) -> float:
    """Highest point under a roof, metres; a hundredth of its area may be noise."""
    return float(np.nanquantile(roof.image, 0.99))


def under_the_eaves(p: Floats, q: Floats, roof: Raster, *, floor: float, lowest: float = 0.9) -> NDArray[np.bool_]:
    """Faces over which the roof comes down so far that they are no walls of the storey.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends, free space to the left of p -> q, metres.
    roof : Raster
        Height of the roof, NaN where nothing was seen, metres.
    floor : float
        Floor height, metres.
    lowest : float
        Least height of a wall, metres.

    Examples
    --------
    >>> slope = Raster(np.tile([[0.5], [1.5], [2.5]], (1, 4)), np.zeros(2), 1.0)
    >>> ends = np.array([[0.0, 0.2], [4.0, 2.8]])
    >>> under_the_eaves(ends, ends[:, ::-1] * 0 + [[4.0, 0.2], [0.0, 2.8]], slope, floor=0.0).tolist()
    [True, False]
    """
    if not len(p):
        return np.zeros(0, dtype=bool)
    along = q - p
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    share = (np.arange(9) + 0.5) / 9
    spots = p[:, None] + share[:, None] * along[:, None] + 0.1 * left[:, None]
    height = roof.sample(spots.reshape(-1, 2), outside=np.nan).reshape(len(p), -1)
    highest = np.where(np.isnan(height), -np.inf, height).max(axis=1)
    low: NDArray[np.bool_] = np.isfinite(highest) & (highest < floor + lowest)
    return low


def _largest(known: NDArray[np.bool_], *, share: float = 0.1) -> NDArray[np.bool_]:
    """The largest connected part, and parts that are not much smaller."""
    from scipy import ndimage

    labels, number = ndimage.label(known, np.ones((3, 3)))
    area = np.bincount(labels.ravel(), minlength=number + 1)
    area[0] = 0
    large: NDArray[np.bool_] = (area >= share * area.max())[labels] & known
    return large


def _planes(points: Floats, cells: Raster) -> Raster:
    """Surface of a plane through the points in and around every known cell."""
    from scipy import ndimage

    shape = cells.image.shape
    place = np.ravel_multi_index(tuple(cells.pixel(points[:, :2]).T), shape)
    x, y = (points[:, :2] - cells.origin).T
    z = points[:, 2]

    def around(values: Floats) -> NDArray[np.floating]:
        sums: NDArray[np.floating] = ndimage.convolve(np.bincount(place, values, cells.image.size).reshape(shape), AROUND, mode="constant")
        return sums

    number = np.maximum(around(np.ones(len(z))), 1e-9)
    mx, my, mz = (around(v) / number for v in (x, y, z))
    xx, xy, yy = around(x * x) / number - mx * mx, around(x * y) / number - mx * my, around(y * y) / number - my * my
    xz, yz = around(x * z) / number - mx * mz, around(y * z) / number - my * mz
    xx, yy = xx + 1e-4, yy + 1e-4
    determinant = xx * yy - xy * xy
    slope_x, slope_y = (xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant
    rows, columns = np.meshgrid(*((np.arange(size * FINER) + 0.5) / FINER * cells.cell for size in shape), indexing="ij")
    fine = np.ones((FINER, FINER))
    mx, my, mz, slope_x, slope_y = (np.kron(v, fine) for v in (mx, my, mz, slope_x, slope_y))
    height = mz + slope_x * (columns - mx) + slope_y * (rows - my)
    height[np.kron(np.isnan(cells.image), fine) > 0] = np.nan
    return Raster(height, cells.origin, cells.cell / FINER)
