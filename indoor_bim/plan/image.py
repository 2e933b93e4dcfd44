"""Wall points to a binary image (Remote Sensing 2021, 13, 4930, section 2.2, algorithm 3, and section 2.3, equation 14)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]
Image = NDArray[np.bool_]


def magnify_and_subsample(xy: Floats, *, magnification: float) -> tuple[NDArray[np.int64], Floats]:
    """Points enlarged, rounded to whole numbers and without duplicates (section 2.2, equation 10, grid subsampling).

    Parameters
    ----------
    xy : (n, 2) float64
        Wall points in plan, metres; at least one.
    magnification : float
        Pixels per metre (n_moc; n_a in equation 10).

    Returns
    -------
    grid : (m, 2) int64
        Distinct grid points x, y, sorted by x, then y. They start at 0; the paper's shift from 0 to 1 (equation 11) serves images that are
        counted from 1.
    low : (2,) float64
        Point that became (0, 0), metres. A grid point lies within half a pixel of the points that it stands for.

    Examples
    --------
    >>> grid, low = magnify_and_subsample(np.array([[5.0, 1.0], [5.04, 1.02], [5.26, 1.1]]), magnification=10)
    >>> grid.tolist(), low.tolist()
    ([[0, 0], [3, 1]], [5.0, 1.0])
    """
    x, y = xy.T
    low = np.array([x.min(), y.min()])
    column, row = (np.rint((axis - start) * magnification).astype(np.int64) for axis, start in zip((x, y), low, strict=True))
    rows = int(row.max()) + 1
    key = np.sort(column * rows + row)
    return np.column_stack(np.divmod(key[np.append(True, key[1:] != key[:-1])], rows)), low


def wall_image(xy: Floats, *, magnification: float, margin: int = 2) -> Raster:
    """Binary image of wall points (section 2.2, equations 12 and 13).

    Parameters
    ----------
    xy : (n, 2) float64
        Wall points in plan, metres; at least one.
    magnification : float
        Pixels per metre (n_moc).
    margin : int
        Empty pixels around the points.

    Returns
    -------
    Raster
        Image (rows along y, columns along x), True where points lie; the centres of its pixels are the grid points.

    Examples
    --------
    >>> wall_image(np.array([[0.0, 0.0], [0.2, 0.1]]), magnification=10, margin=0).image.astype(int).tolist()
    [[1, 0, 0], [0, 0, 1]]
    """
    grid, low = magnify_and_subsample(xy, magnification=magnification)
    columns, rows = grid.max(axis=0) + 1 + 2 * margin
    image = np.zeros((rows, columns), dtype=bool)
    image[grid[:, 1] + margin, grid[:, 0] + margin] = True
    return Raster(image=image, origin=low - (margin + 0.5) / magnification, cell=1 / magnification)


def remove_burrs(image: Image) -> Image:
    """Image without burrs: pixels follow the majority of their 3 x 3 neighbourhood (section 2.3, equation 14).

    Parameters
    ----------
    image : (rows, columns) bool
        Binary image.

    Returns
    -------
    (rows, columns) bool
        False where fewer than four of the nine pixels are set, True where more than four are, else unchanged. Beyond the border
        lies background.

    Examples
    --------
    >>> remove_burrs(np.array([[0, 0, 1, 0], [1, 1, 1, 1], [1, 1, 1, 1]], dtype=bool)).astype(int).tolist()
    [[0, 0, 1, 0], [1, 1, 1, 1], [1, 1, 1, 1]]
    """
    padded = np.pad(image.astype(np.int8), 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    total = rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]
    return np.where(total == 4, image, total > 4)


def thicken(image: Image) -> Image:
    """Image with every set pixel grown to its 3 x 3 neighbourhood.

    The removal of burrs and the thinning expect lines several pixels thick; a scan without noise draws walls of one pixel,
    which the removal of burrs would take for a burr. The skeleton stays where it was.

    Parameters
    ----------
    image : (rows, columns) bool
        Binary image.

    Returns
    -------
    (rows, columns) bool

    Examples
    --------
    >>> thicken(np.array([[0, 0, 0, 0], [0, 0, 0, 1]], dtype=bool)).astype(int).tolist()
    [[0, 0, 1, 1], [0, 0, 1, 1]]
    """
    padded = np.pad(image, 1)
    rows = padded[:-2] | padded[1:-1] | padded[2:]
    grown: Image = rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]
    return grown
