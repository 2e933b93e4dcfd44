"""Work on slices of arrays by threads; only for compiled functions that let go of Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")
Other = TypeVar("Other")

MOST_THREADS = 8
POINTS_PER_THREAD = 50_000


def most_threads() -> int:
    """As many threads as this process may use processors, at most `MOST_THREADS`."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(usable, MOST_THREADS)


def threads_for(points: int) -> int:
    """Threads for a number of points: `most_threads`, fewer for few points."""
    return max(1, min(most_threads(), points // POINTS_PER_THREAD))


def in_threads(work: Callable[[Item], Outcome], items: Sequence[Item], *, threads: int) -> list[Outcome]:
    """Outcomes of `work` for every item, in the order of the items; the calling thread works too.

    Parameters
    ----------
    work : callable
        Takes one item.
    items : sequence
        Items.
    threads : int
        Number of threads, this one among them.

    Returns
    -------
    list

    Raises
    ------
    Exception
        The first that the work raised, in the order of the items.

    Examples
    --------
    >>> in_threads(abs, [-1, 2, -3], threads=2)
    [1, 2, 3]
    """
    if threads < 2 or len(items) < 2:
        return [work(item) for item in items]
    done: dict[int, Outcome] = {}
    failed: dict[int, Exception] = {}
    waiting = iter(range(len(items)))

    def work_on() -> None:
        for place in waiting:
            try:
                done[place] = work(items[place])
            except Exception as error:
                failed[place] = error

    helpers = [_helpers(most_threads()).submit(work_on) for _ in range(min(threads, len(items)) - 1)]
    try:
        work_on()
    finally:
        for _ in waiting:  # none is left, unless the work was interrupted
            pass
        for helper in helpers:
            if not helper.cancel():
                helper.result()
    if failed:
        raise failed[min(failed)]
    return [done[place] for place in range(len(items))]


def in_parts(work: Callable[[slice], object], count: int) -> None:
    """Do work on slices of so many points, a share in each thread.

    Examples
    --------
    >>> in_parts(print, 3)
    slice(0, 3, None)
    """
    threads = threads_for(count)
    in_threads(work, even_slices(count, threads), threads=threads)


def both(first: Callable[[], Outcome], second: Callable[[], Other], *, threads: int) -> tuple[Outcome, Other]:
    """Outcomes of two works that do not wait for one another; the first is to be the longer one, and may have work in threads.

    Examples
    --------
    >>> both(lambda: 1, lambda: "one", threads=2)
    (1, 'one')
    """
    one: Any
    other: Any
    one, other = in_threads(lambda work: work(), (first, second), threads=threads)
    return one, other


@cache
def _helpers(threads: int) -> ThreadPoolExecutor:
    """Threads that stand by for whoever has work; a caller whose helpers are busy elsewhere does all of it itself."""
    return ThreadPoolExecutor(max(threads - 1, 1))


def even_slices(length: int, count: int) -> list[slice]:
    """`count` slices of about equal size that cover a length.

    Examples
    --------
    >>> even_slices(5, 2)
    [slice(0, 2, None), slice(2, 5, None)]
    """
    return [slice(length * i // count, length * (i + 1) // count) for i in range(count)]
