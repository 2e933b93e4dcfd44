"""Heights that many surface pieces share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.ordering import ascending

Floats = NDArray[np.float64]

LEVEL_TOLERANCE = 0.06


def height_peaks(height: Floats, *, share: float, step: float = 0.01) -> list[float]:
    """Heights that many surface pieces share, most first.

    Parameters
    ----------
    height : (n,) float64
        Heights, metres.
    share : float
        Least number of pieces, as a share of the largest number.
    step : float
        Width of the bins, metres.
    """
    from indoor_bim.cloud.height_loops import take_peaks

    if not len(height):
        return []
    ordered = ascending(height)
    low = float(ordered[0]) - 1.0
    histogram = np.bincount(((ordered - low) / step).astype(np.int64)).astype(float)
    histogram = np.pad(histogram, (0, 100))
    half = round(LEVEL_TOLERANCE / step)
    kernel = np.maximum(1 - (np.arange(-half, half + 1) / (half + 1)) ** 2, 0)
    smooth = np.convolve(histogram, kernel, mode="same")
    peaks, least = np.zeros(len(smooth)), max(share * float(smooth.max()), 1.0)
    count = take_peaks(smooth, ordered, low, step, least, half, LEVEL_TOLERANCE, peaks)
    return [float(height) for height in peaks[:count]]


def nearest_peak(height: Floats, peaks: Floats) -> NDArray[np.int64]:
    """Place of the nearest of some peaks for each height.

    Parameters
    ----------
    height : (n,) float64
        Heights, metres.
    peaks : (m,) float64
        At least one height, in any order, metres.

    Examples
    --------
    >>> nearest_peak(np.array([0.1, 2.0, 9.0]), np.array([2.5, 0.0])).tolist()
    [1, 0, 0]
    """
    order = np.argsort(peaks)
    between = (peaks[order][1:] + peaks[order][:-1]) / 2
    nearest: NDArray[np.int64] = order[np.searchsorted(between, height)]
    return nearest


def level_at(height: Floats, guess: float) -> float:
    """Robust mean of the surface heights around a guess, metres."""
    near = height[np.abs(height - guess) < 5 * LEVEL_TOLERANCE]
    value = guess
    for _ in range(4):
        residual = near - value
        weight = np.maximum(1 - (residual / LEVEL_TOLERANCE) ** 2, 0) ** 2
        value += float((weight * residual).sum() / max(weight.sum(), 1e-12))
    return value
