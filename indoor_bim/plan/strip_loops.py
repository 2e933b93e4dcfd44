"""Strips of the plan filled with the height layers of points, and smoothed: the compiled inner loops of `strips.sweep`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

ONE = np.uint32(1)

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_masks, _volume = types.Array(types.uint32, 2, "C"), types.Array(types.uint32, 3, "C")
_image, _bools = types.Array(types.float32, 2, "C"), types.Array(types.bool_, 1, "C")
_table, _weights = types.Array(types.float32, 2, "C"), types.Array(types.float64, 1, "C")
_crest = types.Array(types.bool_, 2, "C")


@compiled(_points, types.float64, types.float64)
def turned_bounds(xy, cosine, sine):  # type: ignore[no-untyped-def]
    """Smallest and largest coordinates along a direction and to the left of it."""
    u0 = v0 = np.inf
    u1 = v1 = -np.inf
    for i in range(len(xy)):
        u, v = xy[i, 0] * cosine + xy[i, 1] * sine, xy[i, 0] * -sine + xy[i, 1] * cosine
        u0, v0, u1, v1 = min(u0, u), min(v0, v), max(u1, u), max(v1, v)
    return u0, v0, u1, v1


@compiled(
    *(_points, _points, _values, _values, types.float64, types.float64, types.float64, types.float64),
    *(types.float64, types.float64, types.int64, types.int64, types.float64, types.float64, _volume),
)
def set_layers(  # type: ignore[no-untyped-def]
    xy, sensor, rise, depth, cosine, sine, low_u, low_v, along, across, even, layers, fine_height, clearance, masks
):
    """Set the bit of its height layer in the strip of each point, for the side it was seen from or for both."""
    for i in range(len(xy)):
        x, y = xy[i, 0], xy[i, 1]
        u, v = int((x * cosine + y * sine - low_u) / along), int((x * -sine + y * cosine - low_v) / across)
        layer = layers - 1 - int(np.floor((depth[i] - clearance) / fine_height))
        layer = min(layer, layers - 1) if layer >= even else min(max(int(rise[i] * even), 0), even - 1)
        bit = ONE << np.uint32(layer)
        if len(sensor) == 0:
            masks[0, u, v] |= bit
            masks[1, u, v] |= bit
        elif (sensor[i, 0] - x) * -sine + (sensor[i, 1] - y) * cosine > 0:
            masks[0, u, v] |= bit
        else:
            masks[1, u, v] |= bit


@inlined
def _ones(word):  # type: ignore[no-untyped-def]
    word = word - ((word >> np.uint32(1)) & np.uint32(0x55555555))
    word = (word & np.uint32(0x33333333)) + ((word >> np.uint32(2)) & np.uint32(0x33333333))
    word = (word + (word >> np.uint32(4))) & np.uint32(0x0F0F0F0F)
    return (word * np.uint32(0x01010101)) >> np.uint32(24) & np.uint32(0xFF)


@inlined
def _mirrored(i, count):  # type: ignore[no-untyped-def]
    """Index that an index outside is reflected to, the border repeated."""
    i = i % (2 * count)
    return i if i < count else 2 * count - 1 - i


@compiled(_image, types.int64, _image)
def mean_along(image, size, out):  # type: ignore[no-untyped-def]
    """Mean of `size` rows around each; the sums are exact, so nothing depends on where they begin."""
    rows, columns = image.shape
    before, after = size // 2, size - size // 2 - 1
    total = np.zeros(columns)
    for i in range(-before, after + 1):
        row = image[_mirrored(i, rows)]
        for j in range(columns):
            total[j] += row[j]
    for i in range(rows):
        for j in range(columns):
            out[i, j] = total[j] / size
        gone, come = image[_mirrored(i - before, rows)], image[_mirrored(i + after + 1, rows)]
        for j in range(columns):
            total[j] += np.float64(come[j]) - np.float64(gone[j])


@compiled(_image, types.int64, _image)
def mean_across(image, size, out):  # type: ignore[no-untyped-def]
    """Mean of `size` columns around each."""
    rows, columns = image.shape
    before, after = size // 2, size - size // 2 - 1
    for i in range(rows):
        row = image[i]
        total = 0.0
        for j in range(-before, after + 1):
            total += row[_mirrored(j, columns)]
        for j in range(columns):
            out[i, j] = total / size
            gone = row[j - before] if j >= before else row[_mirrored(j - before, columns)]
            come = row[j + after + 1] if j + after + 1 < columns else row[_mirrored(j + after + 1, columns)]
            total += np.float64(come) - np.float64(gone)


@compiled(_masks, types.int64, types.uint32, types.uint32, types.uint32, _bools, _table, _image, _image)
def fill(masks, reach, band, below, tall, tall_enough, filled, best, thinly):  # type: ignore[no-untyped-def]
    """How far the band is filled in the strips within reach across, and in those and their neighbours along if they are tall."""
    rows, columns = masks.shape
    joined = np.zeros((3, columns), np.uint32)
    for i in range(-1, rows):
        if i + 1 < rows:
            row, line = masks[i + 1], joined[(i + 1) % 3]
            for j in range(columns):
                word = row[j]
                for k in range(1, reach + 1):
                    word |= row[j - k] if j >= k else np.uint32(0)
                    word |= row[j + k] if j + k < columns else np.uint32(0)
                line[j] = word
                best[i + 1, j] = filled[_ones(word & band), _ones(word & below)]
        else:
            joined[(i + 1) % 3] = 0
        if i >= 0:
            for j in range(columns):
                word = joined[0, j] | joined[1, j] | joined[2, j] if i > 0 else joined[0, j] | joined[1, j]
                thinly[i, j] = filled[_ones(word & band), _ones(word & below)] if tall_enough[_ones(word & tall)] else np.float32(0)


@compiled(_image, _image, _image, _image, _image)
def leave_out(best, along, across, thinly, lengthwise):  # type: ignore[no-untyped-def]
    """Leave out what only crosses the direction, and thin evidence that is short along it."""
    rows, columns = best.shape
    for i in range(rows):
        for j in range(columns):
            if across[i, j] > max(along[i, j], np.float32(0.3)):
                best[i, j] = 0
            if lengthwise[i, j] < np.float32(0.5):
                thinly[i, j] = 0


@compiled(_image, _image, _image, _image)
def join_and_smooth(best, thinly, crosswise, out):  # type: ignore[no-untyped-def]
    """The larger evidence of both kinds, median of five along."""
    rows, columns = best.shape
    for i in range(rows):
        for j in range(columns):
            if crosswise[i, j] > np.float32(0.5):
                thinly[i, j] = 0
            best[i, j] = max(best[i, j], thinly[i, j])
    for i in range(rows):
        r0, r1, r2 = best[_mirrored(i - 2, rows)], best[_mirrored(i - 1, rows)], best[i]
        r3, r4 = best[_mirrored(i + 1, rows)], best[_mirrored(i + 2, rows)]
        for j in range(columns):
            a, b, c, d, e = r0[j], r1[j], r2[j], r3[j], r4[j]
            low, high = max(min(a, b), min(d, e)), min(max(a, b), max(d, e))
            out[i, j] = max(min(low, high), min(max(low, high), c))


@compiled(_masks, types.uint32, _table, _weights, _image)
def weigh_layers(masks, band, weight, kernel, out):  # type: ignore[no-untyped-def]
    """Weighted number of layers hit, smoothed across by a symmetric kernel (its middle and right half)."""
    rows, columns = masks.shape
    reach = len(kernel) - 1
    line = np.zeros(columns + 2 * reach)
    for i in range(rows):
        for j in range(columns):
            line[reach + j] = weight[_ones(masks[i, j]), _ones(masks[i, j] & band)]
        for j in range(1, reach + 1):
            line[reach - j] = line[reach + _mirrored(-j, columns)]
            line[reach + columns - 1 + j] = line[reach + _mirrored(columns - 1 + j, columns)]
        for j in range(columns):
            total = line[reach + j] * kernel[0]
            for k in range(reach, 0, -1):
                total += (line[reach + j - k] + line[reach + j + k]) * kernel[k]
            out[i, j] = total


@compiled(_image, types.int64, _crest)
def largest_across(image, reach, out):  # type: ignore[no-untyped-def]
    """Whether no value within reach across is larger."""
    rows, columns = image.shape
    for i in range(rows):
        row = image[i]
        for j in range(columns):
            value, largest = row[j], True
            for k in range(max(j - reach, 0), min(j + reach + 1, columns)):
                largest &= row[k] <= value
            out[i, j] = largest
