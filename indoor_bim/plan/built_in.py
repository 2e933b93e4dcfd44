"""Furniture built in up to the ceiling: boxes in front of a wall that shows beside them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEPTH = (0.28, 0.68)
"""Metres: wardrobes, shelves and kitchen units are 0.3 to 0.6 m deep (EN 1116: 0.6 m) and stand up to some centimetres off the wall."""
WIDEST = 2.7
"""Widest box, metres: no outline grows by more."""
CLOSEST_CURTAIN = 0.04
SLACK = 0.05


def without_built_ins(
    corners: Sequence[tuple[float, float]], *, folded: Sequence[bool] | None = None, others: shapely.Geometry | None = None
) -> tuple[tuple[float, float], ...]:
    """Outline of a room that runs along the wall behind built-in furniture.

    A box that stands in front of one side, or in a corner, is as deep as furniture and no wider than it; the side
    beside it goes on behind it.

    Parameters
    ----------
    corners : sequence of (float, float)
        Counter-clockwise outline, metres.
    folded : sequence of bool, optional
        Sides whose points scatter more than those of a wall do: curtains, which may be close to the wall.
    others : shapely.Geometry, optional
        What the room must not run into: the other rooms.

    Returns
    -------
    tuple of (float, float)
        Corners of the outline.

    Examples
    --------
    >>> room = [(0, 0), (1, 0), (1, 0.6), (2, 0.6), (2, 0), (4, 0), (4, 3), (0, 3)]
    >>> without_built_ins(room)
    ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    """
    ring = [np.asarray(corner, dtype=np.float64) for corner in corners]
    soft = list(folded) if folded is not None else [False] * len(ring)
    first = 0
    while first < len(ring) and len(ring) > 4:
        candidate = _without_box(ring, first, least=CLOSEST_CURTAIN if soft[first] else DEPTH[0])
        if candidate is not None and _is_free(ring, list(candidate.values()), others):
            soft = [soft[k] for k in candidate]
            ring, first = list(candidate.values()), 0
        else:
            first += 1
    return tuple((float(x), float(y)) for x, y in ring)


def without_bare_niches(corners: Sequence[tuple[float, float]], *, bare: Sequence[bool]) -> tuple[tuple[float, float], ...]:
    """Outline of a room that does not run out into a doorway: through a niche in a wall whose back is no wall.

    Parameters
    ----------
    corners : sequence of (float, float)
        Counter-clockwise outline, metres.
    bare : sequence of bool
        Sides along which no face of a wall was found.

    Returns
    -------
    tuple of (float, float)
        Corners of the outline.

    Examples
    --------
    >>> room = [(0, 0), (1, 0), (1, -0.3), (2, -0.3), (2, 0), (4, 0), (4, 3), (0, 3)]
    >>> without_bare_niches(room, bare=[side == 2 for side in range(8)])
    ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    >>> len(without_bare_niches(room, bare=[False] * 8))
    8
    """
    ring = [np.asarray(corner, dtype=np.float64) for corner in corners][::-1]
    open_behind = [bare[len(ring) - 2 - side] for side in range(len(ring))]
    first = 0
    while first < len(ring) and len(ring) > 4:
        candidate = _without_box(ring, first, least=CLOSEST_CURTAIN) if open_behind[first] else None
        if candidate is not None and shapely.Polygon(list(candidate.values())).is_valid:
            open_behind = [open_behind[side] for side in candidate]
            ring, first = list(candidate.values()), 0
        else:
            first += 1
    return tuple((float(x), float(y)) for x, y in ring[::-1])


def _without_box(ring: list[Floats], k: int, *, least: float) -> dict[int, Floats] | None:
    """Corners, by their number in the ring, without the box whose front is side k; None where there is no such box."""
    count = len(ring)
    at = [ring[(k + step) % count] for step in range(-2, 4)]
    before, near, front, back, far, after = at[0], at[1], at[2], at[3], at[4], at[5]
    side = [_unit(b - a) for a, b in pairwise(at)]
    turns = [float(a[0] * b[1] - a[1] * b[0]) for a, b in pairwise(side)]
    width, left, right = (float(np.hypot(*(b - a))) for a, b in ((front, back), (near, front), (back, far)))
    most = DEPTH[1]
    parallel = np.cos(np.radians(5.0))
    drop: set[int] = set()
    moved: dict[int, Floats] = {}
    into_left, into_right = turns[0] > 0.9 and turns[1] < -0.9, turns[2] < -0.9 and turns[3] > 0.9
    if into_left and into_right:
        level = abs(float((far - near) @ np.array([-side[0][1], side[0][0]]))) < SLACK
        if (
            DEPTH[0] <= width <= WIDEST
            and least <= min(left, right)
            and max(left, right) <= most
            and level
            and side[0] @ side[4] > parallel
        ):
            drop = {k - 1, k, k + 1, k + 2}
    elif into_left and turns[2] > 0.9 and side[0] @ side[2] > parallel and _is_box(left, width, least):
        drop, moved = {k - 1, k}, {k + 1: _meet(before, near, back, far)}
    elif turns[1] > 0.9 and into_right and side[2] @ side[4] > parallel and _is_box(right, width, least):
        drop, moved = {k + 1, k + 2}, {k: _meet(near, front, far, after)}
    if not drop:
        return None
    gone, placed = {i % count for i in drop}, {i % count: point for i, point in moved.items()}
    kept = {i: placed.get(i, corner) for i, corner in enumerate(ring) if i not in gone}
    return kept if len(kept) >= 4 else None


def _is_box(first: float, second: float, least: float) -> bool:
    """Whether the sides of a box in a corner are those of furniture."""
    return least <= min(first, second) <= DEPTH[1] and DEPTH[0] <= max(first, second) <= WIDEST


def _is_free(ring: list[Floats], candidate: list[Floats], others: shapely.Geometry | None) -> bool:
    """Whether the larger outline is simple and stays clear of other rooms."""
    polygon = shapely.Polygon(candidate)
    if not polygon.is_valid:
        return False
    return others is None or polygon.difference(shapely.Polygon(ring).buffer(1e-6)).intersection(others).area < 1e-4


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / max(float(np.hypot(*vector)), 1e-12)
    return unit


def _meet(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Intersection of the lines a-b and c-d, which are not parallel."""
    u, v, w = b - a, d - c, c - a
    point: Floats = a + u * (w[0] * v[1] - w[1] * v[0]) / (u[0] * v[1] - u[1] * v[0])
    return point
