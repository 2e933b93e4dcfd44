"""Relief of a wall's faces: how far each place of them stands before or behind the rest, freed from the drift of the scanner."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

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
    depth = rays.depth.astype(np.float64)
    left_over: list[Floats] = []
    reliefs: list[Relief] = []
    row = np.clip(np.floor(rays.up_end / cell), 0, shape[0] - 1).astype(np.int64)
    column = np.clip(np.floor(rays.along_end / cell), 0, shape[1] - 1).astype(np.int64)
    for side in (1, -1):
        here = rays.side == side
        hits = np.flatnonzero(here & (np.abs(depth) < FACE_REACH) & (rays.slant > STEEP))
        if not len(hits):
            continue
        turn = _turn(rays.along_end[hits].astype(np.float64), depth[hits])
        turned = depth - turn * (rays.along - np.median(rays.along_end[hits]))
        if abs(turn) > LEAST_TURN and _most_together(turned[hits]) > FLATTER * _most_together(depth[hits]):
            depth[here] = turned[here]
        hits = hits[np.abs(depth[hits] - _mode(depth[hits])) < FACE_REACH / 2]
        names, number = np.unique(rays.period[hits], return_inverse=True)
        place = row[hits] * shape[1] + column[hits]
        pairs, pair = np.unique(number * (shape[0] * shape[1]) + place, return_inverse=True)
        steps = np.round(depth[hits] / QUANTUM)
        count = np.bincount(pair)
        total: Floats = np.bincount(pair, weights=steps).astype(np.float64) * QUANTUM
        pair_period, pair_place = np.divmod(pairs, shape[0] * shape[1])
        offset, face = _additive(total, count, pair_period, pair_place, shape[0] * shape[1])
        enough = np.bincount(pair_period, weights=count) >= ENOUGH_HITS
        known = (names[enough], offset[enough]) if enough.any() else (names, np.full(len(names), np.median(offset)))
        depth[here] -= np.interp(rays.period[here], *known)
        left_over.append(depth[hits] - face[place])
        hit_count = np.bincount(pair_place, weights=count, minlength=shape[0] * shape[1]).astype(np.int64)
        reliefs.append(Relief(side, face.reshape(shape), hit_count.reshape(shape)))
    all_left = np.concatenate(left_over) if left_over else np.zeros(0)
    scatter = 1.4826 * float(np.median(np.abs(all_left))) if len(all_left) else 0.0
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


def _additive(total: Floats, count: Ints, period: Ints, place: Ints, places: int) -> tuple[Floats, Floats]:
    """Offsets of periods and of places whose sums are nearest to the mean of each pair."""
    per_period = np.bincount(period, weights=count)
    per_place = np.bincount(place, weights=count, minlength=places)
    face = np.zeros(places)
    offset = np.zeros(len(per_period))
    for _ in range(ROUNDS):
        offset = np.bincount(period, weights=total - count * face[place]) / per_period
        face = np.bincount(place, weights=total - count * offset[period], minlength=places) / np.maximum(per_place, 1)
        middle = _mode(face[per_place > 0])
        face -= middle
        face[per_place == 0] = 0.0
        offset += middle
    return offset, face


def _most_together(values: Floats) -> int:
    """Most values in an interval of 2 cm."""
    ordered = np.sort(values)
    return int((np.searchsorted(ordered, ordered + TOGETHER, side="right") - np.arange(len(ordered))).max())


def _mode(values: Floats) -> float:
    """Middle of the 2 cm interval that holds most values."""
    ordered = np.sort(values)
    count = np.searchsorted(ordered, ordered + TOGETHER, side="right") - np.arange(len(ordered))
    best = int(np.argmax(count))
    return float(ordered[best + count[best] // 2])
