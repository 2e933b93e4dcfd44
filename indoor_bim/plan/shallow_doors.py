"""Closed doors in the plane of a wall: only the mean of many hits shows that they stand a little out of it, or are darker or brighter."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.holes import Hole, around, find_holes
from indoor_bim.plan.relief import STEEP, Relief
from indoor_bim.plan.wall_rays import WallBox, WallRays

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SMALLEST_STEP = 0.004  # metres: plaster is not flatter
ON_FACE = 0.03  # metres: hits closer than this to a face lie on it
LARGEST_STEP = 0.06  # metres: what stands farther out of a wall is furniture; what lies deeper is seen ray by ray
SMALLEST_CONTRAST = 0.08  # of the logarithm of the intensity: paint is not more even
WINDOWS = ((0.0, 0.0), (0.5, 0.2))  # metres up and along: steps of two centimetres show in few hits, smaller ones in many
SURE = 4.0  # times the standard error of a cell
SURE_STEP = 5.0  # times the standard error of a step
STRIP = (0.04, 0.25)  # metres beyond an edge: the wall beside a door
LEAST_AREA = 0.2  # of the smallest door: where less stands out nothing is looked for
LINTEL = 0.10  # metres of wall at least above a door
ENOUGH = 30  # hits on each strip
FLAT = 1.4  # times the scatter of the wall: a leaf is as flat
FLOOR = 0.25  # metres: a door begins lower


@dataclass(frozen=True, slots=True, eq=False)
class _Face:
    """Depth or brightness of one face, hit by hit and cell by cell, and what differences of it count."""

    along: Floats
    up: Floats
    value: Floats
    mean: Floats
    hits: NDArray[np.int64]
    scatter: float
    smallest: float
    largest: float


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
    """Rectangles of a face, of the size of doors and down to the floor, that differ a little from the wall around them.

    They stand a little before or behind it, or return more or less light.

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
    for window, face in itertools.product(WINDOWS, [*_faces(rays, relief, scatter=scatter, cell=cell)]):
        hits = _box_sums(face.hits, window, cell=cell)
        mean = _box_sums(face.mean * face.hits, window, cell=cell) / np.maximum(hits, 1)
        sure = (hits >= 3) & (np.abs(mean) > np.maximum(face.smallest, SURE * face.scatter / np.sqrt(np.maximum(hits, 1))))
        for sign in (1, -1):
            stepped = sure & (mean * sign > 0)
            if int(stepped.sum()) * cell**2 < LEAST_AREA * min_width * min_height:
                continue
            for hole in find_holes(stepped, (hits >= 3) & ~stepped, cell=cell, min_width=min_width, min_height=min_height - FLOOR):
                if hole.bottom > FLOOR or hole.width > max_width or not min_height <= hole.top <= max_height:
                    continue
                if wall.height - hole.top < LINTEL:
                    continue
                door = _measured(hole, face)
                if door is None or not min_width <= door.width <= max_width:
                    continue
                if not any(door.start < other.end and other.start < door.end for other in found):
                    found.append(door)
    return sorted(found, key=lambda hole: (hole.start, hole.end))


def _faces(rays: WallRays, relief: tuple[Relief, ...], *, scatter: float, cell: float) -> Iterator[_Face]:
    """Brightness of the faces of a wall, where it is known, and their depth."""
    steep = rays.slant > STEEP
    brightness = rays.brightness if rays.brightness is not None else np.full(len(rays), np.nan, dtype=np.float32)
    on_face = np.isfinite(brightness) & (np.abs(rays.depth) < max(ON_FACE, 2 * scatter)) & steep
    for face in relief if on_face.any() else ():
        mine = np.flatnonzero(on_face & (rays.side == face.side))
        value = brightness[mine].astype(np.float64)
        along, up = _places(rays, mine)
        rows, columns = face.hits.shape
        row, column = np.clip(up // cell, 0, rows - 1), np.clip(along // cell, 0, columns - 1)
        place = row.astype(np.int64) * columns + column.astype(np.int64)
        hits = np.bincount(place, minlength=rows * columns)
        mean = np.bincount(place, weights=value, minlength=rows * columns) / np.maximum(hits, 1)
        spread = 1.4826 * float(np.median(np.abs(value - mean[place]))) if len(value) else 0.0
        cells = (mean.reshape(rows, columns), hits.reshape(rows, columns))
        yield _Face(along, up, value, *cells, scatter=spread, smallest=SMALLEST_CONTRAST, largest=np.inf)
    for face in relief:
        mine = np.flatnonzero((rays.side == face.side) & (np.abs(rays.depth) < LARGEST_STEP + 3 * scatter) & steep)
        depth = rays.depth[mine].astype(np.float64)
        yield _Face(*_places(rays, mine), depth, face.depth, face.hits, scatter=scatter, smallest=SMALLEST_STEP, largest=LARGEST_STEP)


def _places(rays: WallRays, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
    return rays.along_end[rows].astype(np.float64), rays.up_end[rows].astype(np.float64)


def _box_sums(values: NDArray, window: tuple[float, float], *, cell: float) -> NDArray:
    """Sums over the cells within half a window, up and along, of each cell."""
    low, wide = (max(round(side / cell / 2), 1) for side in window)
    if low == wide == 1:
        return around(values)
    padded = np.zeros((values.shape[0] + 2 * low + 1, values.shape[1] + 2 * wide + 1), dtype=values.dtype)
    padded[low + 1 : -low, wide + 1 : -wide] = values
    total = np.cumsum(np.cumsum(padded, axis=0), axis=1)
    high, broad = 2 * low + 1, 2 * wide + 1
    sums: NDArray = total[high:, broad:] - total[:-high, broad:] - total[high:, :-broad] + total[:-high, :-broad]
    return sums


def _measured(hole: Hole, face: _Face) -> Hole | None:
    """Edges where the values step, if they do so by the same sign at both jambs and at the head."""
    x, z, value = face.along, face.up, face.value
    level = (z > 0.1) & (z < hole.top - 0.1)
    between = (x > hole.start + 0.1) & (x < hole.end - 0.1)
    inside = value[level & between]
    if len(inside) < ENOUGH:
        return None
    middle = float(np.median(inside))
    flat = 1.4826 * float(np.median(np.abs(inside - middle)))
    if abs(middle) > face.largest or flat > FLAT * face.scatter + face.smallest / 4:
        return None
    places, signs = [], set()
    for distance, rows in ((hole.start - x, level), (x - hole.end, level), (z - hole.top, between)):
        strip = value[rows & (distance > STRIP[0]) & (distance < STRIP[1])]
        if len(strip) < ENOUGH:
            return None
        step = middle - float(np.median(strip))
        error = 1.25 * face.scatter * np.sqrt(1 / len(strip) + 1 / len(inside))
        if abs(step) < max(face.smallest, SURE_STEP * error):
            return None
        signs.add(step > 0)
        near = rows & (np.abs(distance) < STRIP[1])
        places.append(_step_place(distance[near], value[near]))
    if len(signs) > 1:
        return None
    return Hole(hole.start - places[0], hole.end + places[1], 0.0, hole.top + places[2])


def _step_place(distance: Floats, value: Floats) -> float:
    """Place that parts values into two groups of the least squared deviation."""
    order = np.lexsort((value, distance))
    x, y = distance[order], value[order]
    count = np.arange(1, len(x))
    total = np.cumsum(y)
    gain = total[:-1] ** 2 / count + (total[-1] - total[:-1]) ** 2 / (len(x) - count)
    best = int(np.argmax(gain[4:-4])) + 4 if len(gain) > 8 else int(np.argmax(gain))
    return float((x[best] + x[best + 1]) / 2)
