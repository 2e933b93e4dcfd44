"""How many points of a scan are kept, and which of those that are in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.extent import bounds

SIDE = 0.10
"""Side of the cubes, metres."""
FINEST_STEP = 1e-4
"""Steps that points in memory are told apart by, metres."""
WITHOUT_POINTS, MEMORY_PER_POINT = 550e6, 220
"""Bytes that a run takes, and that it takes more for each point that is kept."""
PIECE = 1_000_000
ENOUGH = 64
"""Points of a cube that show its surfaces."""
MOST_PER_CUBE = 30_000
"""Points of a cube that can be counted."""
MANY_POINTS = 4_000_000
"""Scans of more points are thinned to `ENOUGH` points a cube if nothing else is asked for."""


@dataclass(frozen=True, slots=True)
class DensityLimit:
    """How many points of a scan are kept.

    Parameters
    ----------
    per_cube : int
        Most points of a cube of 10 cm; no more than `MOST_PER_CUBE`.
    points : int
        Most points altogether; where there would be more, `per_cube` is halved until there are not.
    least_per_cube : int
        `per_cube` is not halved below this; the cubes are made larger instead.
    above : int
        Scans of no more points than this are kept whole.
    """

    per_cube: int
    points: int
    least_per_cube: int = 16
    above: int = 0


def limit_for(*, per_cube: int | None, max_memory: float | None) -> DensityLimit:
    """Limit that keeps a run within its memory.

    Parameters
    ----------
    per_cube : int, optional
        Most points of a cube of 10 cm; none: `ENOUGH`, for scans of more than `MANY_POINTS`.
    max_memory : float, optional
        Most memory, gigabytes; none: no limit.

    Examples
    --------
    >>> limit_for(per_cube=None, max_memory=2.0).points < limit_for(per_cube=None, max_memory=4.0).points
    True
    """
    points = 2**31 if max_memory is None else max(int((max_memory * 1e9 - WITHOUT_POINTS) / MEMORY_PER_POINT), 100_000)
    return DensityLimit(ENOUGH if per_cube is None else per_cube, points, above=min(MANY_POINTS, points) if per_cube is None else 0)


def kept_rows(points: NDArray[np.float64], *, limit: DensityLimit, metres: float) -> tuple[NDArray[np.int64], int]:
    """Rows of the points that stay, ascending, and how many of each cube do.

    Parameters
    ----------
    points : (n, 3) float64
        Finite points in any unit.
    limit : DensityLimit
        How many points to keep.
    metres : float
        Metres per unit.
    """
    from indoor_bim.cloud.density import DensitySample, TooManyCubesError

    low, high = bounds(points)
    step = max(FINEST_STEP / metres, float((high - low).max()) / 2**31)
    side = SIDE / metres
    while True:
        sample = DensitySample(side=np.full(3, max(round(side / step), 1)), limit=limit, kind=np.dtype([("row", np.int64)]))
        try:
            for start in range(0, len(points), PIECE):
                piece = points[start : start + PIECE]
                steps = np.rint((piece - low) / step - 2**30).astype(np.int32)
                sample.add(steps, np.arange(start, start + len(piece)).view([("row", np.int64)]))
        except TooManyCubesError:
            side *= 2
            continue
        return sample.attribute("row", sample.kept()), sample.most
