"""Slope lines moved onto the points that they were drawn from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster
from indoor_bim.plan.slope_lines import SlopeLines

Floats = NDArray[np.float64]


def place_on_points(lines: SlopeLines, raster: Raster, xy: Floats, *, reach: float, rounds: int = 3) -> SlopeLines:
    """Lines moved sideways to the median of the wall points along them; slopes and ends stay.

    The published method takes the mean of a line's pixels (section 2.3). The skeleton runs midway through everything that was hit,
    which noise on one side of a wall shifts by a centimetre or two; the median of the points does not care.

    Parameters
    ----------
    lines : SlopeLines
        Lines, pixels.
    raster : Raster
        Image that they were found on.
    xy : (n, 2) float64
        Wall points in plan, evenly thinned, metres.
    reach : float
        Distance across the line within which points take part, metres.
    rounds : int
        How often the median is taken.

    Returns
    -------
    SlopeLines
        The same lines with other midpoints.
    """
    total = lines.total.copy()
    pixels = (xy - raster.origin) / raster.cell - 0.5
    direction, midpoint = lines.direction, lines.midpoint
    for slope in np.unique(lines.slope):
        rows = np.flatnonzero(lines.slope == slope)
        dx, dy = direction[rows[0]]
        along = pixels[:, 0] * dx + pixels[:, 1] * dy
        across = pixels[:, 1] * dx - pixels[:, 0] * dy
        order = np.argsort(across)
        along, across = along[order], across[order]
        for row in rows:
            start, end = float(lines.first[row] @ (dx, dy)), float(lines.last[row] @ (dx, dy))
            first = offset = float(midpoint[row, 1] * dx - midpoint[row, 0] * dy)
            for _ in range(rounds):
                low, high = np.searchsorted(across, [offset - reach / raster.cell, offset + reach / raster.cell])
                beside = across[low:high][(along[low:high] >= start - 0.5) & (along[low:high] <= end + 0.5)]
                if len(beside) < 10:
                    break
                offset = float(np.median(beside))
            total[row] += (offset - first) * lines.count[row] * np.array([-dy, dx])
    return replace(lines, total=total)
