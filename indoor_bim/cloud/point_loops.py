"""Compiled loops over points, one small piece of arithmetic each."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_points = types.Array(types.float64, 2, "C", readonly=True)
_floats, _table = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
_steps = types.Array(types.int32, 2, "A", readonly=True, aligned=False)
_words, _factors = types.Array(types.uint64, 2, "C", readonly=True), types.Array(types.uint64, 1, "C")
_MINUS_ZERO = np.uint64(1 << 63)
_bytes = types.Array(types.uint8, 1, "C")


@compiled(_points)
def extent(points):  # type: ignore[no-untyped-def]
    """Smallest and largest coordinates (2, 3) of points (n, 2 or 3); NaN where any coordinate is NaN."""
    corners = np.zeros((2, 3))
    numbers = True
    flat = points.shape[1] == 2
    x0 = y0 = z0 = np.inf
    x1 = y1 = z1 = -np.inf
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], 0.0 if flat else points[i, 2]
        numbers &= (x == x) & (y == y) & (z == z)
        x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
        x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
    if not numbers:
        return np.full((2, 3), np.nan)
    corners[0, 0], corners[0, 1], corners[0, 2] = x0, y0, z0
    corners[1, 0], corners[1, 1], corners[1, 2] = x1, y1, z1
    return corners


@compiled(_points, _table, _floats, _table)
def move(points, rotation, shift, out):  # type: ignore[no-untyped-def]
    """Turn and shift points (n, 3)."""
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        for k in range(3):
            out[i, k] = x * rotation[k, 0] + y * rotation[k, 1] + z * rotation[k, 2] + shift[k]


@compiled(_steps, _floats, _floats, _table)
def place_steps(steps, scales, offsets, out):  # type: ignore[no-untyped-def]
    """Coordinates of whole steps (n, 3)."""
    for i in range(len(steps)):
        for k in range(3):
            out[i, k] = steps[i, k] * scales[k] + offsets[k]


@compiled(_points, _floats, types.float64, _table)
def localise(points, origin, scale, out):  # type: ignore[no-untyped-def]
    """Shift and scale points (n, 3); `out` may be the points themselves."""
    for i in range(len(points)):
        for k in range(3):
            out[i, k] = (points[i, k] - origin[k]) * scale


@compiled(_words, _factors, types.uint64, types.Array(types.bool_, 1, "C"))
def choose(words, factors, limit, out):  # type: ignore[no-untyped-def]
    """Whether the mixed bits of points (n, 3) are below a limit; zero is the same with either sign."""
    for i in range(len(words)):
        mixed = np.uint64(0)
        for k in range(3):
            word = words[i, k]
            mixed = (mixed ^ (np.uint64(0) if word == _MINUS_ZERO else word)) * factors[k]
            mixed ^= mixed >> np.uint64(32)
        mixed *= factors[0]
        out[i] = mixed ^ (mixed >> np.uint64(29)) < limit


@compiled(_points, _floats, types.float64, _factors, types.uint64, types.Array(types.bool_, 1, "C"))
def choose_blocks(points, low, edge, factors, limit, out):  # type: ignore[no-untyped-def]
    """Whether the mixed places of the blocks of points (n, 3) are below a limit."""
    for i in range(len(points)):
        mixed = np.uint64(0)
        for k in range(3):
            mixed = (mixed ^ np.uint64(np.int64(np.floor((points[i, k] - low[k]) / edge)))) * factors[k]
            mixed ^= mixed >> np.uint64(32)
        mixed *= factors[0]
        out[i] = mixed ^ (mixed >> np.uint64(29)) < limit


@compiled(_points, _floats, _bytes, types.float64, _bytes)
def label_heights(points, heights, labels, tolerance, out):  # type: ignore[no-untyped-def]
    """Label points (n, 3) that are closer than the tolerance to a height; the last such height counts."""
    for i in range(len(points)):
        for k in range(len(heights)):
            if abs(points[i, 2] - heights[k]) < tolerance:
                out[i] = labels[k]


@compiled(_table, _floats, types.float64, types.float64, types.float64)
def histogram_energy(xy, weight, cosine, sine, width):  # type: ignore[no-untyped-def]
    """Sum of the squared bins of the weights over the distances along a direction; a weight is shared by the two nearest bins."""
    low = high = (xy[0, 0] * cosine + xy[0, 1] * sine) / width
    for i in range(len(xy)):
        place = (xy[i, 0] * cosine + xy[i, 1] * sine) / width
        low, high = min(low, place), max(high, place)
    first = np.floor(low)
    bins = np.zeros(int(np.floor(high) - first) + 2)
    for i in range(len(xy)):
        place = (xy[i, 0] * cosine + xy[i, 1] * sine) / width
        below = np.floor(place)
        fraction = place - below
        k = int(below - first)
        bins[k] += weight[i] * (1 - fraction)
        bins[k + 1] += weight[i] * fraction
    return (bins * bins).sum()
