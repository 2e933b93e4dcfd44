"""Neighbours within a radius, counted tile by tile: the compiled inner loops of the radius filter.

Cells are cubes whose side is just longer than the radius, so that all neighbours of a point lie in its cell or in one that touches it.
An eighth of a cell has a diagonal shorter than the radius: where one holds enough points, no distance is taken. Elsewhere the points around
a line of cells are brought together, layer by layer, and distances between whole steps are taken in single precision, some at a time, until
there are enough neighbours; only pairs whose distance is the radius within rounding are looked at in double precision. Points that are read
beyond the last layer do no harm: they are too far away.
"""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from indoor_bim.cloud.margins import CELL, CELL_BITS, TILE, sort_with_margins
from indoor_bim.cloud.tiles import load, most_points, sort_into_tiles
from indoor_bim.compiled import compiled, inlined
from indoor_bim.threads import in_threads, threads_for

AT_ONCE = 64
"""Points of the cells around that are looked at together."""
LONGER = 1 + 2.0**-16
"""Side of a cell in radii: neighbours are never two cells apart, however they are rounded to steps."""
MOST_POINTS = 2**31
CELLS_PER_POINT = 32
"""Cells are made wider where there would be more of them."""

EMPTY = -1
_1, _2, _3, _4, _5, _6, _7, _8 = (np.uint64(number) for number in range(1, 9))
_HALF = np.uint64(32)
_AWAY = np.float32(1e9)
_RADIUS = CELL / LONGER
_ROUNDING = 2.5
"""Steps that a distance between whole steps is off at most."""
_SURE, _AT_MOST = np.float32((_RADIUS - _ROUNDING) ** 2), np.float32((_RADIUS + _ROUNDING) ** 2)
_WIDEST = TILE + 2

_points = types.Array(types.float64, 2, "C", readonly=True)
_i64, _bool, _f32 = (types.Array(kind, 1, "C") for kind in (types.int64, types.bool_, types.float32))
_records = types.Array(types.uint64, 2, "C")


def count_within(points: NDArray[np.float64], *, more_than: int, radius: float, threads: int | None = None) -> NDArray[np.bool_] | None:
    """Points with more than a number of points, themselves included, strictly within a radius.

    Parameters
    ----------
    points : (n, 2 or 3) float64
        At least one point, fewer than `MOST_POINTS`.
    more_than : int
        Number that has to be exceeded.
    radius : float
        Radius, same unit.
    threads : int, optional
        Threads; None: as many as there are processors. The result is the same.

    Returns
    -------
    (n,) bool or None
        None if a coordinate is not finite or the extent is more than some 30 million radii.
    """
    points = np.ascontiguousarray(points)
    threads = threads_for(len(points)) if threads is None else threads
    keep = np.ones(len(points), dtype=np.bool_)
    steps_per_unit = _RADIUS / radius
    if not np.isfinite(steps_per_unit):
        return None
    origin = np.append(points[0], 0.0)[:3]
    tiles = sort_into_tiles(points, sort_with_margins, (origin, steps_per_unit), threads=threads) if np.isfinite(origin).all() else None
    if tiles is None:
        return None
    chains = (tiles.first_run, tiles.count, tiles.records)
    in_threads(
        lambda part: _search(points, tiles.first_chain[part.start : part.stop + 1], *chains, more_than, radius * radius, keep),
        tiles.shares(threads),
        threads=threads,
    )
    return keep


@inlined
def _closer(xs, ys, zs, first, x, y, z, square):  # type: ignore[no-untyped-def]
    """Number of `AT_ONCE` points that are closer to a point than the root of a square; unsigned indices let it be vectorised."""
    near, first = np.int32(0), np.uint64(first)
    for j in range(np.uint64(AT_ONCE)):
        dx, dy, dz = xs[first + j] - x, ys[first + j] - y, zs[first + j] - z
        near = np.int32(near + np.int32(dx * dx + dy * dy + dz * dz < square))
    return np.int64(near)


@inlined
def _copy(values, start, stop, out, place):  # type: ignore[no-untyped-def]
    """Copy some values, and up to seven more that are not wanted; eight are read before any is written: two instructions."""
    i, stop, j = np.uint64(start), np.uint64(stop), np.uint64(place)
    while i < stop:
        a, b, c, d = values[i], values[i + _1], values[i + _2], values[i + _3]
        e, f, g, h = values[i + _4], values[i + _5], values[i + _6], values[i + _7]
        out[j], out[j + _1], out[j + _2], out[j + _3] = a, b, c, d
        out[j + _4], out[j + _5], out[j + _6], out[j + _7] = e, f, g, h
        i += _8
        j += _8


@inlined
def _eighth(x, y, z):  # type: ignore[no-untyped-def]
    """Eighth of its cell that a point lies in."""
    half, one = np.uint32(CELL_BITS - 1), np.uint32(1)
    return ((np.uint32(x) >> half) & one) << np.uint32(2) | ((np.uint32(y) >> half) & one) << one | (np.uint32(z) >> half) & one


@inlined
def _exactly_near(points, a, b, square):  # type: ignore[no-untyped-def]
    """Whether two points are closer than the root of a square."""
    dx, dy = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1]
    dz = points[a, 2] - points[b, 2] if points.shape[1] == 3 else 0.0
    return dx * dx + dy * dy + dz * dz < square


@compiled(_points, _i64, _i64, _i64, _records, types.int64, types.float64, _bool)
def _search(points, first_chain, first_run, count, records, more_than, square, keep):  # type: ignore[no-untyped-def]
    """Decide on the points of some tiles."""
    most = most_points(first_chain, count)
    lx, ly, lz, lrow = np.zeros(most, np.uint32), np.zeros(most, np.uint32), np.zeros(most, np.uint32), np.zeros(most, np.uint32)
    row, cell_of = np.zeros(most, np.uint32), np.zeros(most, np.uint32)
    xs, ys, zs = np.zeros(most + 8, np.float32), np.zeros(most + 8, np.float32), np.zeros(most + 8, np.float32)
    bx, by, bz = np.zeros(most + AT_ONCE, np.float32), np.zeros(most + AT_ONCE, np.float32), np.zeros(most + AT_ONCE, np.float32)
    line_of = np.zeros(_WIDEST**2, np.int64)
    fill = np.zeros(min(_WIDEST**3, CELLS_PER_POINT * most) + 2, np.uint32)
    from_layer, around, eighths = np.zeros(_WIDEST + 3, np.int64), np.zeros(9, np.int64), np.zeros(8, np.int64)
    inner, outer = np.float32(CELL), np.float32(CELL * (TILE + 1))
    for tile in range(len(first_chain) - 1):
        total = load(first_chain[tile : tile + 2], first_run, count, records, lx, ly, lz, lrow)
        if total <= more_than:
            for i in range(total):
                if CELL <= lx[i] < CELL * (TILE + 1) and CELL <= ly[i] < CELL * (TILE + 1) and CELL <= lz[i] < CELL * (TILE + 1):
                    keep[lrow[i]] = False
            continue
        low_x, low_y, low_z = lx[:total].min(), ly[:total].min(), lz[:total].min()
        high_x, high_y, high_z = lx[:total].max(), ly[:total].max(), lz[:total].max()
        bits = np.uint32(CELL_BITS)
        while True:  # wider cells where there are few points
            x0, y0, z0 = low_x >> bits, low_y >> bits, low_z >> bits
            wide, deep, tall = np.int64(high_x >> bits) - x0 + 1, np.int64(high_y >> bits) - y0 + 1, np.int64(high_z >> bits) - z0 + 1
            lines = 0
            if wide * deep <= CELLS_PER_POINT * total:
                line_of[: wide * deep] = EMPTY
                for i in range(total):
                    line_of[((lx[i] >> bits) - x0) * deep + (ly[i] >> bits) - y0] = 0
                for i in range(wide * deep):
                    if line_of[i] != EMPTY:
                        line_of[i] = lines
                        lines += 1
                if lines * tall <= CELLS_PER_POINT * total:
                    break
            bits += np.uint32(1)
        cells = lines * tall
        fill[: cells + 2] = 0
        for i in range(total):
            line_here = np.uint32(line_of[((lx[i] >> bits) - x0) * deep + (ly[i] >> bits) - y0])
            cell_here = np.uint32(line_here * tall + (lz[i] >> bits) - z0)
            cell_of[i] = cell_here
            fill[cell_here + 2] += np.uint32(1)
        before = np.uint32(0)
        for cell in range(2, cells + 2):
            before += fill[cell]
            fill[cell] = before
        for i in range(total):
            to = fill[cell_of[i] + 1]
            fill[cell_of[i] + 1] = to + np.uint32(1)
            xs[to], ys[to], zs[to], row[to] = lx[i], ly[i], lz[i], lrow[i]
        fine = bits == CELL_BITS
        for line in range(wide * deep):
            if line_of[line] == EMPTY:
                continue
            base = line_of[line] * tall
            column, depth = line // deep, line % deep
            if fine and not (1 <= column + x0 <= TILE and 1 <= depth + y0 <= TILE):
                continue
            ranges, candidates = 0, np.int64(0)
            for i in range(max(column - 1, 0), min(column + 2, wide)):
                for j in range(max(depth - 1, 0), min(depth + 2, deep)):
                    if line_of[i * deep + j] != EMPTY:
                        other = line_of[i * deep + j] * tall
                        candidates += np.int64(fill[other + tall]) - np.int64(fill[other])
                        around[ranges] = other
                        ranges += 1
            together = tall if candidates <= 2 * AT_ONCE else 1  # layers
            filled = False
            for layer in range(0, tall, together):
                a, b = np.int64(fill[base + layer]), np.int64(fill[base + layer + together])
                if a == b:
                    continue
                eighth = b - a > more_than and fine and together == 1
                if eighth:
                    eighths[:] = 0
                    for i in range(a, b):
                        eighths[_eighth(xs[i], ys[i], zs[i])] += 1
                    if eighths.min() > more_than:
                        continue
                if not filled:
                    filled = True
                    place = np.int64(0)
                    for k in range(0, tall, together):
                        from_layer[k] = place
                        for other in around[:ranges]:
                            start, stop = np.int64(fill[other + k]), np.int64(fill[other + k + together])
                            if start < stop:
                                _copy(xs, start, stop, bx, place)
                                _copy(ys, start, stop, by, place)
                                _copy(zs, start, stop, bz, place)
                                place += stop - start
                    from_layer[tall] = from_layer[tall + 1] = place
                    bx[place : place + AT_ONCE] = _AWAY
                low, high = np.int64(0), candidates
                if together == 1:
                    low, high = from_layer[max(layer - 1, 0)], from_layer[layer + 2]
                enough = high - low > more_than
                for i in range(a, b):
                    if eighth and eighths[_eighth(xs[i], ys[i], zs[i])] > more_than:
                        continue
                    within, at = np.int64(0), low
                    while enough and within <= more_than and at < high:
                        within += _closer(bx, by, bz, at, xs[i], ys[i], zs[i], _SURE)
                        at += AT_ONCE
                    if within > more_than or not (inner <= xs[i] < outer and inner <= ys[i] < outer and inner <= zs[i] < outer):
                        continue
                    within = np.int64(0)
                    if enough:
                        for block in range(low, high, AT_ONCE):
                            within += _closer(bx, by, bz, block, xs[i], ys[i], zs[i], _AT_MOST)
                    if within > more_than:  # as far as rounding goes
                        within, first, last = np.int64(0), max(layer - 1, 0), min(layer + together + 1, tall)
                        for other in around[:ranges]:
                            for j in range(fill[other + first], fill[other + last]):
                                within += _exactly_near(points, np.int64(row[j]), np.int64(row[i]), square)
                    if within <= more_than:
                        keep[row[i]] = False
