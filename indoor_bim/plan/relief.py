"""Relief of a wall's faces: how far each place of them stands before or behind the rest, freed from the drift of the scanner."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.ordering import ascending, median
from indoor_bim.plan.wall_rays import WallRays

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FACE_REACH = 0.10  # metres: hits farther from the mean place of a face tell nothing about where it is
TURN_STEP, TURN_LAG = 0.05, 6  # metres along a face, and steps between the places of a pair
ENOUGH_PAIRS = 10
FLATTER = 1.3  # times more hits together on a face that is turned back
TOGETHER = 0.02  # metres
LEAST_TURN = 0.01  # metres per metre: faces that are turned by less have been squared
ENOUGH_HITS = 40  # to place a face for one period
STEEP = 0.20  # cosine: rays closer to the face than this do not tell where they met it
QUANTUM = 2.0**-14  # metres: depths are counted in it, so that sums do not depend on the order
ROUNDS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Relief:
    """Depth of one face, cell by cell.

    Parameters
    ----------
    side : int
        1 for the left face, -1 for the right one.
    depth : (rows, columns) float64
        Mean depth of the hits in each cell behind the greater part of the face, metres; 0 where there are none.
    hits : (rows, columns) int64
        Number of hits.
    """

    side: int
    depth: Floats
    hits: Ints


def level_faces(rays: WallRays, *, cell: float, shape: tuple[int, int]) -> tuple[WallRays, float, tuple[Relief, ...]]:
    """Rays with depths from where each face was at that time, the scatter of the hits, and the relief of the faces.

    A walking scanner's positions drift by centimetres, and a reconstructed face is off by a few millimetres. The depth of a hit is
    taken for the sum of an offset of its period and of the relief of its cell; both are found by turns, as means over the other. A
    face that was reconstructed askew, because a large leaf lies behind it, is turned back first.

    Parameters
    ----------
    rays : WallRays
        Rays at one wall.
    cell : float
        Side of a cell, metres.
    shape : (int, int)
        Rows and columns of cells.

    Returns
    -------
    rays : WallRays
        The same rays with corrected `depth`.
    scatter : float
        Robust standard deviation of the hits about the relief, metres.
    relief : tuple of Relief
        Of the faces that were hit.
    """
    from indoor_bim.plan.relief_loops import hits_on_face, take_off

    depth = rays.depth.astype(np.float64)
    left_over: list[Floats] = []
    reliefs: list[Relief] = []
    places = shape[0] * shape[1]
    for side in (1, -1):
        hits = np.zeros(len(rays), dtype=np.int64)
        hits = hits[: hits_on_face(rays.side, rays.depth, rays.slant, side, FACE_REACH, STEEP, hits)]
        if not len(hits):
            continue
        along, mine = rays.along_end.take(hits), depth.take(hits)
        turn = _turn(along.astype(np.float64), mine)
        if abs(turn) > LEAST_TURN:
            turned = depth - turn * (rays.along - median(along.astype(np.float64)))
            if _most_together(turned[hits]) > FLATTER * _most_together(mine):
                depth = np.where(rays.side == side, turned, depth)
                mine = depth.take(hits)
        near = np.flatnonzero(np.abs(mine - _mode(mine)) < FACE_REACH / 2)
        hits, mine, along = hits.take(near), mine.take(near), along.take(near)
        row = np.clip(np.floor(rays.up_end.take(hits) / cell), 0, shape[0] - 1).astype(np.int64)
        place = row * shape[1] + np.clip(np.floor(along / cell), 0, shape[1] - 1).astype(np.int64)
        names, number = _numbered(rays.period.take(hits))
        pair_period, pair_place, count, total = _pairs(number, len(names), place, places, mine)
        offset, face = _additive(total, count, pair_period, pair_place, places)
        enough = np.bincount(pair_period, weights=count) >= ENOUGH_HITS
        known = (names[enough], offset[enough]) if enough.any() else (names, np.full(len(names), np.median(offset)))
        take_off(rays.side, side, rays.period, *known, depth)
        left_over.append(depth.take(hits) - face.take(place))
        hit_count = np.bincount(pair_place, weights=count, minlength=places).astype(np.int64)
        reliefs.append(Relief(side, face.reshape(shape), hit_count.reshape(shape)))
    all_left = np.concatenate(left_over) if left_over else np.zeros(0)
    scatter = 1.4826 * median(np.abs(all_left)) if len(all_left) else 0.0
    return replace(rays, depth=depth.astype(np.float32)), scatter, tuple(reliefs)


def _turn(along: Floats, depth: Floats) -> float:
    """Change of depth along a face, metres per metre: the median over pairs of places, which no leaf or recess changes."""
    column = np.floor((along - along.min()) / TURN_STEP).astype(np.int64)
    count = np.bincount(column)
    name = np.flatnonzero(count >= ENOUGH_HITS)
    mean = np.bincount(column, weights=np.round(depth / QUANTUM))[name] * QUANTUM / count[name]
    partner = np.searchsorted(name, name + TURN_LAG)
    paired = np.flatnonzero((partner < len(name)) & (name[np.minimum(partner, len(name) - 1)] == name + TURN_LAG))
    if len(paired) < ENOUGH_PAIRS:
        return 0.0
    return float(np.median(mean[partner[paired]] - mean[paired])) / (TURN_LAG * TURN_STEP)


def _numbered(periods: Ints) -> tuple[Ints, Ints]:
    """Different periods in ascending order, and the number of each hit's among them; fast where they come in runs."""
    begin = np.flatnonzero(np.diff(periods, prepend=periods[0] - 1))
    names, number = np.unique(periods[begin], return_inverse=True)
    return names, np.repeat(number, np.diff(begin, append=len(periods)))


def _pairs(period: Ints, periods: int, place: Ints, places: int, depth: Floats) -> tuple[Ints, Ints, Ints, Floats]:
    """Period, place, number of hits and sum of their depths, of every pair of period and place that has hits; by period and place."""
    from indoor_bim.plan.relief_loops import pair_sums

    pair_period, pair_place, count = (np.zeros(len(place), dtype=np.int64) for _ in range(3))
    total = np.zeros(len(place))
    pairs = pair_sums(period, periods, place, places, np.round(depth / QUANTUM), pair_period, pair_place, count, total)
    return pair_period[:pairs], pair_place[:pairs], count[:pairs], total[:pairs] * QUANTUM


def _additive(total: Floats, count: Ints, period: Ints, place: Ints, places: int) -> tuple[Floats, Floats]:
    """Offsets of periods and of places whose sums are nearest to the mean of each pair; most places have none."""
    from indoor_bim.plan.relief_loops import alternate_means

    per_period = np.bincount(period, weights=count)
    per_place = np.bincount(place, weights=count, minlength=places)
    face, offset = np.zeros(places), np.zeros(len(per_period))
    alternate_means(total, count, period, place, per_period, per_place, ROUNDS, offset, face)
    middle = _mode(face[per_place > 0])
    return offset + middle, np.where(per_place > 0, face - middle, 0.0)


def _most_together(values: Floats) -> int:
    """Most values in an interval of 2 cm."""
    from indoor_bim.plan.relief_loops import densest

    return int(densest(ascending(values), TOGETHER)[1])


def _mode(values: Floats) -> float:
    """Middle of the 2 cm interval that holds most values."""
    from indoor_bim.plan.relief_loops import densest

    ordered = ascending(values)
    first, count = densest(ordered, TOGETHER)
    return float(ordered[first + count // 2])
