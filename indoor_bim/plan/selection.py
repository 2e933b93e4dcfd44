"""Faces that may be walls: tall and well filled, not furniture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

LEAST_FILL = 0.5  # of the fill of the building's typical wall: what is emptier is no wall by itself
LEAST_FILL_IN_LINE = 0.25  # the same, of what goes on in line with a wall
PARALLEL_COS = np.cos(np.radians(1.0))


def wall_like(faces: Segments, *, storey_height: float, least_height: float = 0.8, least_length: float = 0.2) -> NDArray[np.bool_]:
    """Tell faces that reach up towards the ceiling and are hit all over from furniture and clutter.

    How full a wall is depends on the scan; so a face is compared with the upper quartile, weighted by length, of all tall faces.

    Parameters
    ----------
    faces : Segments
        Faces with `coverage` and `top`, metres.
    storey_height : float
        From floor to ceiling, metres.
    least_height : float
        Share of the storey height that a wall reaches up to at least.
    least_length : float
        Shortest face, metres.

    Returns
    -------
    (m,) bool
        True for faces that may be walls.

    Examples
    --------
    >>> from dataclasses import replace
    >>> faces = Segments.from_ends([[0, 0], [1, 1]], [[4, 0], [2, 1]])
    >>> faces = replace(faces, coverage=np.array([0.9, 0.8]), top=np.array([2.5, 0.9]))
    >>> wall_like(faces, storey_height=2.5).tolist()
    [True, False]
    """
    tall = _tall(faces, storey_height=storey_height, least_height=least_height, least_length=least_length)
    filled: NDArray[np.bool_] = tall & (faces.coverage >= LEAST_FILL * _typical(faces, tall))
    return filled


def seen_in_parts(faces: Segments, *, storey_height: float, least_height: float = 0.8, least_length: float = 0.2) -> NDArray[np.bool_]:
    """Tell faces that were hit too sparsely to tell walls from furniture by their fill, as through a door.

    Parameters
    ----------
    faces : Segments
        Faces with `coverage` and `top`, metres.
    storey_height, least_height, least_length : float
        As in `wall_like`.

    Returns
    -------
    (m,) bool
        True for faces that are emptier than any wall seen from close by.
    """
    tall = _tall(faces, storey_height=storey_height, least_height=least_height, least_length=least_length)
    sparse: NDArray[np.bool_] = (faces.coverage < LEAST_FILL * _typical(faces, tall)) & (faces.length >= least_length)
    return sparse


def typical_coverage(faces: Segments, *, storey_height: float, least_height: float = 0.8, least_length: float = 0.2) -> float:
    """Coverage of a wall of the building that was seen well: the upper quartile of all tall faces, weighted by length.

    Parameters
    ----------
    faces : Segments
        Faces with `coverage` and `top`, metres.
    storey_height, least_height, least_length : float
        As in `wall_like`.
    """
    return _typical(faces, _tall(faces, storey_height=storey_height, least_height=least_height, least_length=least_length))


def walls_in_line(
    walls: Segments, others: Segments, *, typical_coverage: float, tolerance: float, widest_gap: float = 1.0, shortest: float = 0.6
) -> Segments:
    """Walls and those other faces that go on in line with them: a parapet below windows, a wall half hidden.

    Furniture stands before a wall, not in line with it.

    Parameters
    ----------
    walls, others : Segments
        Faces that are walls, and those that may be parts of them, metres.
    typical_coverage : float
        That of a wall of the building, as `typical_coverage` tells.
    tolerance : float
        Distance within which faces are on one line, metres.
    widest_gap : float
        Between a wall and its continuation, metres.
    shortest : float
        Shortest face that counts on either side, metres.

    Returns
    -------
    Segments
        The walls, then the others that continue one of them, directly or through each other.

    Examples
    --------
    >>> from dataclasses import replace
    >>> walls = Segments.from_ends([[0.0, 0.0]], [[4.0, 0.0]])
    >>> others = Segments.from_ends([[7.0, 0.0], [4.5, 0.01], [4.5, 0.3]], [[8.0, 0.0], [6.5, 0.01], [6.5, 0.3]])
    >>> others = replace(others, coverage=np.full(3, 0.4))
    >>> walls_in_line(walls, others, typical_coverage=0.8, tolerance=0.03).p.tolist()
    [[0.0, 0.0], [7.0, 0.0], [4.5, 0.01]]
    """
    usable = (others.length >= shortest) & (others.coverage >= LEAST_FILL_IN_LINE * typical_coverage)
    grown = np.zeros(len(others), dtype=bool)
    while True:
        found = stacked(walls, others.take(grown))
        more = np.array(
            [usable[k] and not grown[k] and _goes_on(others, k, found, tolerance, widest_gap, shortest) for k in range(len(others))]
        )
        if not more.any():
            return found
        grown |= more


def _goes_on(others: Segments, k: int, walls: Segments, tolerance: float, widest_gap: float, shortest: float) -> bool:
    """Tell whether face k is in line with a wall, looks to no other side and begins where that ends."""
    d, n, length = others.direction[k], others.normal[k], others.length[k]
    p, q = (walls.p - others.p[k]) @ d, (walls.q - others.p[k]) @ d
    along = walls.direction @ d
    alike = (np.abs(along) > PARALLEL_COS) & ((along > 0) | ~walls.sided | ~others.sided[k]) & (walls.length >= shortest)
    in_line = (np.abs((walls.p - others.p[k]) @ n) <= tolerance) & (np.abs((walls.q - others.p[k]) @ n) <= tolerance)
    gap = np.maximum(np.minimum(p, q) - length, -np.maximum(p, q))
    return bool((alike & in_line & (gap <= widest_gap)).any())


def _tall(faces: Segments, *, storey_height: float, least_height: float, least_length: float) -> NDArray[np.bool_]:
    top = np.where(np.isfinite(faces.top), faces.top, np.inf)
    tall: NDArray[np.bool_] = (top >= least_height * storey_height) & (faces.length >= least_length)
    return tall


def _typical(faces: Segments, tall: NDArray[np.bool_]) -> float:
    """Upper quartile of the coverage of tall faces, weighted by length; 0 without any."""
    if not tall.any():
        return 0.0
    order = np.flatnonzero(tall)[np.argsort(faces.coverage[tall], kind="stable")]
    weight = np.cumsum(faces.length[order])
    return float(faces.coverage[order][np.searchsorted(weight, 0.75 * weight[-1])])


def stacked(first: Segments, second: Segments) -> Segments:
    """Rows of both tables, those of the first one first."""
    return Segments(**{name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in Segments.__slots__})
