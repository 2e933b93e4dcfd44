"""Places of edges, and widths of frames, told from values along a line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NARROWEST_FRAME, WIDEST_FRAME = 0.02, 0.08  # metres: face width of door and window frames
FRAME_STEP = 0.004  # metres: smallest step in depth between a frame and a face that counts
SURE = 6.0  # times the standard error
REVEAL_BLUR = 0.012  # metres next to an edge where hits may lie on its reveal
LEAST_FACE = 0.05  # metres of face beyond a frame that show it to be one
FARTHEST = 0.25  # metres from an edge that are looked at
ENOUGH = 10  # hits on either side


def fewest_wrong(inside: Floats, outside: Floats) -> tuple[float, float]:
    """Thresholds that leave the smallest shares of `inside` above and of `outside` below it.

    Parameters
    ----------
    inside, outside : (n,) and (m,) float64
        Values that belong below and above.

    Returns
    -------
    low, high : float
        All thresholds between them are equally good; the widest such gap.

    Examples
    --------
    >>> fewest_wrong(np.array([0.0, 1.0, 2.0]), np.array([3.0, 4.0]))
    (2.0, 3.0)
    """
    from indoor_bim.plan.opening_loops import widest_best_gap

    begin, end = widest_best_gap(np.sort(inside), np.sort(outside))
    return float(begin), float(end)


def end_of_hits(values: Floats) -> tuple[float, float]:
    """Threshold above which values are dense and below which they are stray: the likeliest for two even densities.

    Parameters
    ----------
    values : (n,) float64
        Values.

    Returns
    -------
    low, high : float
        The values on either side of it.

    Examples
    --------
    >>> end_of_hits(np.array([-9.0, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5]))
    (-9.0, 1.0)
    """
    ordered = np.sort(values)
    below = np.arange(1, len(ordered) - 1)
    above = len(ordered) - below
    length = (ordered[below] - ordered[0], ordered[-1] - ordered[below])
    likelihood = sum(n * np.log(n / np.maximum(d, 1e-6)) for n, d in zip((below, above), length, strict=True))
    best = int(np.argmax(likelihood)) + 1
    return float(ordered[best - 1]), float(ordered[best])


def frame_width(distance: Floats, depth: Floats, *, smallest_step: float = FRAME_STEP) -> float:
    """Width of a strip next to an edge whose depth, or brightness, differs from the face beyond it; 0 where there is none.

    Parameters
    ----------
    distance : (n,) float64
        Distance of hits from the edge, metres.
    depth : (n,) float64
        Their depths, metres, or brightness.
    smallest_step : float
        Smallest difference that counts.
    """
    from indoor_bim.plan.opening_loops import frame_edge

    hits = np.ascontiguousarray(distance), np.ascontiguousarray(depth)
    bounds = (REVEAL_BLUR, FARTHEST, NARROWEST_FRAME, WIDEST_FRAME, LEAST_FACE, ENOUGH)
    return float(frame_edge(*hits, *bounds, smallest_step, SURE))
