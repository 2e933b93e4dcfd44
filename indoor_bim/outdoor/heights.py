"""Foot, eave and storeys of a house."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from indoor_bim.outdoor.edges import FittedEdge, near_segment
from indoor_bim.outdoor.terrain import Terrain

Floats = NDArray[np.float64]

STEP, CHUNK = 0.1, 0.25
LOWEST_EAVE = 1.8
TALLEST = 40.0
LEAST_POINTS = 20
SAME_EAVE = 0.25


def base_height(terrain: Terrain, corners: Floats) -> float:
    """Height of the ground a house stands on: the mean over its outline, metres.

    Parameters
    ----------
    terrain : Terrain
        Ground heights.
    corners : (m, 2) float64
        Outline, metres.
    """
    ends = np.roll(corners, -1, axis=0)
    steps = np.linspace(0.0, 1.0, 9)[:-1]
    along = (corners[:, None] * (1 - steps)[:, None] + ends[:, None] * steps[:, None]).reshape(-1, 2)
    weight = np.repeat(np.hypot(*(ends - corners).T), len(steps))
    return float(np.average(terrain.at(along), weights=weight))


def wall_top(edge: FittedEdge, points: Floats, *, foot: float, band: float = 0.08) -> float | None:
    """Height at which the points of one wall end; see `common_top`."""
    return common_top([edge], points, foot=foot, band=band)


def common_top(edges: Sequence[FittedEdge], points: Floats, *, foot: float, band: float = 0.08) -> float | None:
    """Height at which the points of walls end, all taken together.

    Parameters
    ----------
    edges : sequence of FittedEdge
        Sides of a house.
    points : (n, 3) float64
        Points of buildings about it, metres.
    foot : float
        Height of the ground, metres.
    band : float
        Points on the wall are at most this far from its line, metres.

    Returns
    -------
    float or None
        Where the number of points for each height falls to less than half for good; None with too few points. A roof above
        gives points, too, but few heights of it lie in the plane of the wall.
    """
    places, levels, reached = [], [], 0.0
    for edge in edges:
        along, _, rows = near_segment(points[:, :2], edge.start, edge.end, band=band, margin=min(0.15, 0.1 * edge.length))
        places.append(along + reached)
        levels.append(points[rows, 2] - foot)
        reached += ceil(edge.length / CHUNK) * CHUNK
    along, z = (np.concatenate(parts) if parts else np.zeros(0) for parts in (places, levels))
    keep = (z > 0.3) & (z < TALLEST)
    along, z = along[keep], z[keep]
    if len(z) < LEAST_POINTS:
        return None
    filled = _filled(along, z, step=STEP)
    total = np.concatenate([[0.0], np.cumsum(filled)])
    below, above, resumed = 5, 4, 10
    steps = np.arange(round(LOWEST_EAVE / STEP), len(filled) - resumed)
    reference = (total[steps] - total[steps - below]) / below
    ahead = (total[steps + above] - total[steps]) / above
    later = (total[steps + resumed] - total[steps]) / resumed
    after = np.maximum.accumulate(later[::-1])[::-1]
    ends = (ahead < 0.4 * reference) & (after < 0.5 * reference) & (reference * below >= 3)
    if not ends.any():
        return None
    return foot + _edge_of(along, z, steps[ends.argmax()] * STEP)


def _filled(along: Floats, z: Floats, *, step: float) -> Floats:
    """Number of stretches of the wall with points, for each step of height above the foot."""
    steps = round(TALLEST / step)
    columns = np.floor(along / CHUNK).astype(np.int64)
    cells = np.unique(columns * steps + np.floor(z / step).astype(np.int64))
    return np.bincount(cells % steps, minlength=steps).astype(np.float64)


def _edge_of(along: Floats, z: Floats, near: float) -> float:
    """Height about `near` at which the points become fewest, at most half."""
    fine, window, reach = 0.02, 8, 0.6
    count = _filled(along, z, step=fine)
    total = np.concatenate([[0.0], np.cumsum(count)])
    places = np.arange(max(window, round((near - reach) / fine)), min(round((near + reach) / fine), len(count) - window) + 1)
    under, over = total[places] - total[places - window], total[places + window] - total[places]
    fall = np.where(over <= 0.5 * under, under - over, 0.0)
    best = np.flatnonzero(fall == fall.max())
    return float(places[best].mean() * fine)


def eave_height(tops: Floats, lengths: Floats) -> float | None:
    """Height that most of the walls end at, metres; None without any.

    Parameters
    ----------
    tops : (k,) float64
        Upper ends of the walls, metres.
    lengths : (k,) float64
        Lengths of the walls, metres.

    Examples
    --------
    >>> round(eave_height(np.array([6.02, 5.98, 7.4, 7.6]), np.array([10.0, 10.0, 8.0, 8.0])), 3)
    6.0
    """
    if not len(tops):
        return None
    order = np.lexsort((lengths, tops))
    tops, lengths = tops[order], lengths[order]
    total = np.concatenate([[0.0], np.cumsum(lengths)])
    last = np.searchsorted(tops, tops + SAME_EAVE, side="right")
    best = int((total[last] - total[:-1]).argmax())
    return float(np.average(tops[best : last[best]], weights=lengths[best : last[best]]))


def count_storeys(height: float, storey_height: float) -> int:
    """Whole storeys that come nearest to a wall's height, at least one.

    Examples
    --------
    >>> count_storeys(5.9, 3.0), count_storeys(2.2, 3.0)
    (2, 1)
    """
    return max(1, floor(height / storey_height + 0.5))
