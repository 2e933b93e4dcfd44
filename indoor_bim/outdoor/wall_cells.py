"""Places in plan where something upright fills the column above the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class WallCells:
    """Cells in plan that upright things fill.

    Parameters
    ----------
    xy : (m, 2) float64
        Mean of the points of each cell, metres.
    fill : (m,) float64
        Height that is filled with points, metres.
    normal : (m, 2) float64
        Direction across the things in the neighbourhood, of unit length; the sign means nothing.
    flatness : (m,) float64
        1 where the neighbours lie on a line, 0 where they lie all about.
    """

    xy: Floats
    fill: Floats
    normal: Floats
    flatness: Floats

    def __len__(self) -> int:
        return len(self.xy)

    def take(self, rows: Ints | NDArray[np.bool_]) -> WallCells:
        """Cells of the given rows (indices or mask)."""
        return WallCells(self.xy[rows], self.fill[rows], self.normal[rows], self.flatness[rows])


def find_wall_cells(
    points: Floats,
    above_ground: Floats,
    *,
    cell: float = 0.1,
    bin_height: float = 0.2,
    lowest: float = 0.4,
    least_fill: float = 1.0,
    least_top: float = 1.8,
    radius: float = 0.35,
) -> WallCells:
    """Find cells with points at many heights above one another.

    Parameters
    ----------
    points : (n, 3) float64
        Points that are not ground, metres.
    above_ground : (n,) float64
        Height of each above the ground, metres.
    cell : float
        Side of a cell, metres.
    bin_height : float
        Height is counted in bins of this size, metres.
    lowest : float
        Points lower than this above the ground are left out, metres.
    least_fill : float
        Filled height that makes a cell upright, metres.
    least_top : float
        Height above the ground that the cell reaches, metres.
    radius : float
        Neighbourhood for the direction, metres.

    Returns
    -------
    WallCells
        Sorted by place.
    """
    keep = above_ground > lowest
    xy, height = points[keep, :2], above_ground[keep]
    if not len(xy):
        return WallCells(np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2)), np.zeros(0))
    index = np.floor(xy / cell).astype(np.int64)
    index -= index.min(axis=0)
    key = index[:, 0] * (index[:, 1].max() + 1) + index[:, 1]
    distinct, owner, count = np.unique(key, return_inverse=True, return_counts=True)
    bins = np.floor(height / bin_height).astype(np.int64)
    levels = int(bins.max()) + 1
    filled = np.unique(owner * levels + bins) // levels
    fill = np.bincount(filled, minlength=len(distinct)) * bin_height
    top = np.zeros(len(distinct))
    np.maximum.at(top, owner, height)
    mean = np.column_stack([np.bincount(owner, xy[:, axis]) / count for axis in (0, 1)])
    upright = (fill >= least_fill - 1e-9) & (top >= least_top)
    mean, fill = mean[upright], np.minimum(fill[upright], 6.0)
    normal, flatness = _directions(mean, fill, radius=radius)
    return WallCells(mean, fill, normal, flatness)


def upright_points(points: Floats, above_ground: Floats, *, cell: float = 0.1) -> NDArray[np.bool_]:
    """Points in cells that upright things fill: walls without roofs.

    Parameters
    ----------
    points : (n, 3) float64
        Points that are not ground, metres.
    above_ground : (n,) float64
        Height of each above the ground, metres.
    cell : float
        Side of a cell, metres.

    Returns
    -------
    (n,) bool
    """
    upright = find_wall_cells(points, above_ground, cell=cell)
    keys = np.unique(_keys(upright.xy, cell))
    asked = _keys(points[:, :2], cell)
    if not len(keys):
        return np.zeros(len(points), dtype=np.bool_)
    found: NDArray[np.bool_] = keys[np.minimum(np.searchsorted(keys, asked), len(keys) - 1)] == asked
    return found


def _keys(xy: Floats, cell: float) -> Ints:
    index = np.floor(xy / cell).astype(np.int64)
    key: Ints = index[:, 0] * (1 << 31) + index[:, 1]
    return key


def clusters(xy: Floats, *, gap: float) -> Ints:
    """Number the groups of points that are chains of steps of at most `gap` metres; (n,) int64."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not len(xy):
        return np.zeros(0, dtype=np.int64)
    pairs = cKDTree(xy).query_pairs(gap, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(xy), len(xy)))
    numbers: Ints = connected_components(links, directed=False)[1].astype(np.int64)
    return numbers


def _directions(xy: Floats, weight: Floats, *, radius: float) -> tuple[Floats, Floats]:
    """Direction across the weighted neighbours of each point, and how much they lie on a line."""
    from scipy.spatial import cKDTree

    count = len(xy)
    if not count:
        return np.zeros((0, 2)), np.zeros(0)
    pairs = cKDTree(xy).query_pairs(radius, output_type="ndarray")
    one = np.concatenate([np.arange(count), pairs[:, 0], pairs[:, 1]])
    other = np.concatenate([np.arange(count), pairs[:, 1], pairs[:, 0]])
    w = weight[other]

    def total(values: Floats) -> Floats:
        sums = np.bincount(one, values, count)
        return np.asarray(sums, dtype=np.float64)

    offset = xy[other] - xy[one]
    mass = total(w)
    mx, my = total(w * offset[:, 0]) / mass, total(w * offset[:, 1]) / mass
    xx = total(w * offset[:, 0] ** 2) / mass - mx**2
    yy = total(w * offset[:, 1] ** 2) / mass - my**2
    xy_ = total(w * offset[:, 0] * offset[:, 1]) / mass - mx * my
    angle = 0.5 * np.arctan2(2 * xy_, xx - yy)
    spread = np.hypot(xx - yy, 2 * xy_)
    flatness = spread / np.maximum(xx + yy, 1e-12)
    return np.column_stack([-np.sin(angle), np.cos(angle)]), flatness
