"""The main direction of a building in plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Angle range (degrees), step (degrees) and bin (metres) of each search, coarse to fine.
_SEARCHES = ((45.0, 1.0, 0.20), (1.5, 0.1, 0.05), (0.2, 0.02, 0.03))
_ENOUGH_POINTS = 30_000  # for the searches
_SMALLEST_TURN = 5e-6  # radians; 0.2 mm on 40 m
_SMOOTHING = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16


def main_direction(xy: Floats) -> float:
    """Angle of the direction that most walls run along or across.

    For every angle the points are projected to the two axes of the turned frame; walls along or across it become
    peaks of the two histograms. The angle with the largest sum of squared counts wins, found coarse to fine; then the slope
    that the points of all strong peaks share is taken away by least squares.
    The published `slope` method has no such step but needs it, as it knows only the slopes 0, 1, -1 and vertical.

    Parameters
    ----------
    xy : (n, 2) float64
        Wall points in plan, metres, evenly thinned so that near walls do not outweigh far ones.

    Returns
    -------
    float
        Angle of the main direction against x in radians, in [-pi/4, pi/4): of the four equivalent quarter turns the smallest.

    Examples
    --------
    >>> side = np.linspace(0, 8, 400)
    >>> room = np.concatenate([np.column_stack([side, 0 * side]), np.column_stack([0 * side, side / 2])])
    >>> c, s = np.cos(0.3), np.sin(0.3)
    >>> round(main_direction(room @ np.array([[c, s], [-s, c]])), 3)
    0.3
    """
    xy = np.asarray(xy, dtype=np.float64).reshape(-1, 2)
    if len(xy) < 2:
        return 0.0
    centred = xy[np.lexsort(xy.T)] - np.median(xy, axis=0)
    sample = centred[:: -(-len(centred) // _ENOUGH_POINTS)]
    best = 0.0
    for half, step, bin_size in _SEARCHES:
        count = round(half / step)
        angles = best + np.deg2rad(step) * np.arange(-count, count + 1)
        scores = np.array([_sharpness(sample, angle, bin_size) for angle in angles])
        near_zero = np.lexsort((np.abs(angles), -scores))[0]
        best = float(angles[near_zero])
    best += _remaining_turn(sample, best, 0.06)
    for points, rounds in ((sample, 30), (centred, 5)):
        for _ in range(rounds):
            turn = _remaining_turn(points, best, 0.04)
            best += turn
            if abs(turn) < _SMALLEST_TURN:
                break
    return float((best + np.pi / 4) % (np.pi / 2) - np.pi / 4)


def _sharpness(xy: Floats, angle: float, bin_size: float) -> float:
    """Sum of squared, lightly smoothed counts of both projections."""
    c, s = np.cos(angle), np.sin(angle)
    total = 0.0
    for along in (c * xy[:, 0] + s * xy[:, 1], c * xy[:, 1] - s * xy[:, 0]):
        index = np.floor(along / bin_size).astype(np.int64)
        counts = np.bincount(index - index.min())
        total += float((np.convolve(counts, _SMOOTHING) ** 2).sum())
    return total


def _remaining_turn(xy: Floats, angle: float, reach: float) -> float:
    """Common slope of the points about the strongest lines along both axes of the frame turned by `angle`, by least squares."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = c * xy[:, 0] + s * xy[:, 1], c * xy[:, 1] - s * xy[:, 0]
    product = square = 0.0
    for along, across in ((x, y), (y, -x)):
        low = float(across.min()) - 2 * reach
        strip = ((across - low) / (reach / 2)).astype(np.int64)
        in_strip = np.bincount(strip, minlength=8)
        counts = np.convolve(in_strip, [1, 1, 1], mode="same")
        padded = np.pad(counts, 3)
        highest = np.max([padded[k : k + len(counts)] for k in range(7)], axis=0)
        by_strip = np.argsort(strip.astype(np.uint16) if len(counts) <= 2**16 else strip, kind="stable")
        starts = np.pad(np.cumsum(in_strip), (1, 0))
        for peak in (int(k) for k in np.flatnonzero((counts == highest) & (counts >= 0.3 * counts.max()))):
            rows = by_strip[starts[max(peak - 5, 0)] : starts[min(peak + 6, len(in_strip))]]
            offset = across[rows]
            middle = float(np.median(offset[np.abs(offset - (low + (peak + 0.5) * reach / 2)) < reach]))
            near = np.abs(offset - middle) < reach
            t, offset = along[rows[near]], offset[near]
            t = t - t.mean()
            product += float((t * (offset - offset.mean())).sum())
            square += float((t * t).sum())
    return float(np.arctan2(product, square)) if square > 0 else 0.0
