"""Footprints as published: slice, grid, chain of nearest neighbours, simplification by angle.

Sensors 2024, 24, 5723, section 2.1. The default way of this package is another one; this one is kept exact.
"""

from __future__ import annotations

from math import floor

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def slice_points(points: Floats, above_ground: Floats, *, low: float = 1.5, high: float = 1.7) -> Floats:
    """Wall points in a slice above the local ground, in plan (step 2).

    Parameters
    ----------
    points : (n, 3) float64
        Wall points, metres.
    above_ground : (n,) float64
        Height of each above the ground, metres.
    low, high : float
        Borders of the slice, metres.

    Returns
    -------
    (m, 2) float64
    """
    return points[(above_ground >= low) & (above_ground <= high), :2]


def grid_centroids(xy: Floats, *, cell: float = 0.2) -> Floats:
    """Centroid of the points in each cell of a grid from the least x and y (step 3, equations 1 to 3).

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    cell : float
        Side of a cell, metres.

    Returns
    -------
    (m, 2) float64
        Sorted by row and column.

    Examples
    --------
    >>> grid_centroids(np.array([[0.0, 0.0], [0.1, 0.1], [0.5, 0.0]])).round(3).tolist()
    [[0.05, 0.05], [0.5, 0.0]]
    """
    if not len(xy):
        return np.zeros((0, 2))
    index = np.floor((xy - xy.min(axis=0)) / cell).astype(np.int64)
    rows = int(index[:, 1].max()) + 1
    _, owner, count = np.unique(index[:, 0] * rows + index[:, 1], return_inverse=True, return_counts=True)
    return np.column_stack([np.bincount(owner, xy[:, axis]) / count for axis in (0, 1)])


def chains(points: Floats, *, neighbours: int = 8) -> list[Ints]:
    """Order points into outlines: always on to the nearest point not yet recorded, until the first one comes up again (step 4).

    Parameters
    ----------
    points : (n, 2) float64
        Grid centroids, metres.
    neighbours : int
        K: the next point is one of the K nearest. The paper does not say how many.

    Returns
    -------
    list of (m,) int64
        Indices of each outline in order. A chain also ends where none of the K nearest is free: that is how a gap wider than the
        neighbourhood shows. The first point may be recorded again as soon as the chain has more than K points.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [2.1, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]])
    >>> chains(square, neighbours=4)[0].tolist()
    [0, 1, 2, 3, 4, 5, 6, 7]
    """
    from scipy.spatial import cKDTree

    if not len(points):
        return []
    count = min(neighbours, len(points) - 1)
    _, nearest = cKDTree(points).query(points, k=np.arange(2, count + 2)) if count else (None, np.zeros((1, 0), dtype=np.int64))
    near = nearest.tolist()
    recorded = [False] * len(points)
    outlines = []
    for first in range(len(points)):
        if recorded[first]:
            continue
        chain, at = [first], first
        recorded[first] = True
        while True:
            closes = len(chain) > neighbours
            step = next((j for j in near[at] if not recorded[j] or (closes and j == first)), None)
            if step is None or step == first:
                break
            recorded[step] = True
            chain.append(step)
            at = step
        outlines.append(np.array(chain, dtype=np.int64))
    return outlines


def simplify(ring: Floats, *, angle: float = 179.5) -> Floats:
    """Drop corners at which the outline goes almost straight on (step 5).

    Parameters
    ----------
    ring : (n, 2) float64
        Outline, metres, first corner not repeated.
    angle : float
        A corner with a larger angle between its two sides goes, degrees.

    Returns
    -------
    (m, 2) float64

    Notes
    -----
    One round: each corner is judged by the last corner kept and the next one; the side that the two then share is new. At the end
    the first corner is judged, too.

    Examples
    --------
    >>> simplify(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 1.0]])).tolist()
    [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
    """
    corners = [tuple(corner) for corner in ring.tolist()]
    kept = corners[:1]
    for i in range(1, len(corners)):
        if corner_angle(kept[-1], corners[i], corners[(i + 1) % len(corners)]) <= angle:
            kept.append(corners[i])
    if len(kept) > 3 and corner_angle(kept[-1], kept[0], kept[1]) > angle:
        kept = kept[1:]
    return np.array(kept)


def corner_angle(before: tuple[float, ...], at: tuple[float, ...], after: tuple[float, ...]) -> float:
    """Angle between the sides of a corner, 0 to 180 degrees.

    Examples
    --------
    >>> corner_angle((0, 0), (1, 0), (1, 1))
    90.0
    """
    a, b = np.subtract(before, at), np.subtract(after, at)
    return float(np.degrees(np.abs(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))))


def whole_storeys(top: float, bottom: float, *, storey_height: float = 3.0) -> int:
    """Whole storeys between the highest and the lowest wall point, rounded down (step 7, equation 5).

    Examples
    --------
    >>> whole_storeys(6.1, 0.0), whole_storeys(5.9, 0.0)
    (2, 1)
    """
    return floor((top - bottom) / storey_height)


def outlines(
    walls: Floats,
    above_ground: Floats,
    *,
    low: float = 1.5,
    high: float = 1.7,
    cell: float = 0.2,
    neighbours: int = 8,
    angle: float = 179.5,
    least_area: float = 8.0,
) -> list[Floats]:
    """Footprints of all houses by the published way.

    Parameters
    ----------
    walls : (n, 3) float64
        Wall points, metres.
    above_ground : (n,) float64
        Height of each above the local ground, metres.
    low, high : float
        Borders of the slice, metres.
    cell : float
        Side of a grid cell, metres.
    neighbours : int
        K of the chain.
    angle : float
        Threshold of the simplification, degrees.
    least_area : float
        Smaller outlines are no houses, square metres.

    Returns
    -------
    list of (m, 2) float64
        Corners of each footprint, counter-clockwise.
    """
    from indoor_bim.outdoor.model import shoelace

    centroids = grid_centroids(slice_points(walls, above_ground, low=low, high=high), cell=cell)
    found = []
    for chain in chains(centroids, neighbours=neighbours):
        if len(chain) < 4:
            continue
        ring = simplify(centroids[chain], angle=angle)
        area = shoelace(tuple(map(tuple, ring.tolist())))[0]
        if len(ring) >= 3 and abs(area) >= least_area:
            found.append(ring if area > 0 else ring[::-1])
    return found
