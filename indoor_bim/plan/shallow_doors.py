"""Closed doors whose leaf lies so near to the plane of the wall that only the mean of many hits shows it."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.holes import Hole, find_holes
from indoor_bim.plan.relief import STEEP, Relief
from indoor_bim.plan.wall_rays import WallBox, WallRays

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SMALLEST_STEP = 0.004  # metres: plaster is not flatter
LARGEST_STEP = 0.06  # metres: what stands farther out of a wall is furniture; what lies deeper is seen ray by ray
WINDOWS = ((0.0, 0.0), (0.5, 0.2))  # metres up and along: steps of two centimetres show in few hits, smaller ones in many
SURE = 4.0  # times the standard error of a cell
SURE_STEP = 5.0  # times the standard error of a step
STRIP = (0.04, 0.25)  # metres beyond an edge: the wall beside a door
LINTEL = 0.10  # metres of wall at least above a door
ENOUGH = 30  # hits on each strip
FLAT = 1.4  # times the scatter of the wall: a leaf is as flat
FLOOR = 0.25  # metres: a door begins lower


def find_shallow_doors(
    wall: WallBox,
    rays: WallRays,
    relief: tuple[Relief, ...],
    *,
    scatter: float,
    cell: float,
    min_width: float = 0.6,
    max_width: float = 2.5,
    min_height: float = 1.8,
    max_height: float = 2.6,
) -> list[Hole]:
    """Rectangles of a face, of the size of doors and down to the floor, that stand a little before or behind the wall around them.

    Parameters
    ----------
    wall : WallBox
        Wall.
    rays : WallRays
        Rays at it, with corrected depths.
    relief : tuple of Relief
        Relief of its faces.
    scatter : float
        Standard deviation of the hits about the relief, metres.
    cell : float
        Side of a cell of the relief, metres.
    min_width, max_width, min_height, max_height : float
        Bounds of doors, metres.
    """
    found: list[Hole] = []
    for face, window in itertools.product(relief, WINDOWS):
        hits = _box_sums(face.hits, window, cell=cell)
        depth = _box_sums(face.depth * face.hits, window, cell=cell) / np.maximum(hits, 1)
        sure = (hits >= 3) & (np.abs(depth) > np.maximum(SMALLEST_STEP, SURE * scatter / np.sqrt(np.maximum(hits, 1))))
        mine = rays.take((rays.side == face.side) & (np.abs(rays.depth) < LARGEST_STEP + 3 * scatter) & (rays.slant > STEEP))
        for sign in (1, -1):
            stepped = sure & (depth * sign > 0)
            for hole in find_holes(stepped, (hits >= 3) & ~stepped, cell=cell, min_width=min_width, min_height=min_height - FLOOR):
                if hole.bottom > FLOOR or hole.width > max_width or not min_height <= hole.top <= max_height:
                    continue
                if wall.height - hole.top < LINTEL:
                    continue
                door = _measured(hole, mine, scatter=scatter)
                if door is not None and min_width <= door.width <= max_width:
                    found.append(door)
    return sorted(found, key=lambda hole: (hole.start, hole.end))


def _box_sums(values: NDArray, window: tuple[float, float], *, cell: float) -> NDArray:
    """Sums over the cells within half a window, up and along, of each cell."""
    low, wide = (max(round(side / cell / 2), 1) for side in window)
    total = np.cumsum(np.cumsum(np.pad(values, ((low + 1, low), (wide + 1, wide))), axis=0), axis=1)
    high, broad = 2 * low + 1, 2 * wide + 1
    sums: NDArray = total[high:, broad:] - total[:-high, broad:] - total[high:, :-broad] + total[:-high, :-broad]
    return sums


def _measured(hole: Hole, rays: WallRays, *, scatter: float) -> Hole | None:
    """Edges where the depth steps, if it does so by the same sign at both jambs and at the head."""
    x, z, depth = (values.astype(np.float64) for values in (rays.along_end, rays.up_end, rays.depth))
    level = (z > 0.1) & (z < hole.top - 0.1)
    between = (x > hole.start + 0.1) & (x < hole.end - 0.1)
    inside = depth[level & between]
    if len(inside) < ENOUGH:
        return None
    middle = float(np.median(inside))
    if abs(middle) > LARGEST_STEP or 1.4826 * float(np.median(np.abs(inside - middle))) > FLAT * scatter + 0.001:
        return None
    places, signs = [], set()
    for distance, rows in ((hole.start - x, level), (x - hole.end, level), (z - hole.top, between)):
        strip = depth[rows & (distance > STRIP[0]) & (distance < STRIP[1])]
        if len(strip) < ENOUGH:
            return None
        step = middle - float(np.median(strip))
        error = 1.25 * scatter * np.sqrt(1 / len(strip) + 1 / len(inside))
        if abs(step) < max(SMALLEST_STEP, SURE_STEP * error):
            return None
        signs.add(step > 0)
        near = rows & (np.abs(distance) < STRIP[1])
        places.append(_step_place(distance[near], depth[near]))
    if len(signs) > 1:
        return None
    return Hole(hole.start - places[0], hole.end + places[1], 0.0, hole.top + places[2])


def _step_place(distance: Floats, depth: Floats) -> float:
    """Place that parts values into two groups of the least squared deviation."""
    order = np.lexsort((depth, distance))
    x, y = distance[order], depth[order]
    count = np.arange(1, len(x))
    total = np.cumsum(y)
    gain = total[:-1] ** 2 / count + (total[-1] - total[:-1]) ** 2 / (len(x) - count)
    best = int(np.argmax(gain[4:-4])) + 4 if len(gain) > 8 else int(np.argmax(gain))
    return float((x[best] + x[best + 1]) / 2)
