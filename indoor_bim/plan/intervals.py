"""Intervals on a line."""

from __future__ import annotations

from collections.abc import Iterable

Interval = tuple[float, float]


def merge_intervals(intervals: Iterable[Interval], *, gap: float = 0.0, barriers: Iterable[float] = ()) -> list[Interval]:
    """Union of intervals, closing gaps that are no wider than `gap` and hold no barrier.

    Parameters
    ----------
    intervals : iterable of (float, float)
        Intervals (lower, upper).
    gap : float
        Widest gap to close.
    barriers : iterable of float
        Places that no closed gap may hold.

    Examples
    --------
    >>> merge_intervals([(4, 5), (0, 1), (1.5, 2)], gap=0.5)
    [(0, 2), (4, 5)]
    >>> merge_intervals([(0, 1), (1.5, 2)], gap=0.5, barriers=[1.2])
    [(0, 1), (1.5, 2)]
    """
    out: list[Interval] = []
    stops = tuple(barriers)
    for lo, hi in sorted(intervals):
        if out and lo - out[-1][1] <= gap and not any(out[-1][1] <= stop <= lo for stop in stops):
            out[-1] = (out[-1][0], max(out[-1][1], hi))
        else:
            out.append((lo, hi))
    return out


def overlap(a: Interval, b: Interval) -> float:
    """Length that two intervals share; 0 where they do not meet.

    Examples
    --------
    >>> overlap((0, 2), (1.5, 4)), overlap((0, 1), (2, 3))
    (0.5, 0.0)
    """
    return max(0.0, min(a[1], b[1]) - max(a[0], b[0]))
