"""Strips of the plan filled with the height layers of points, and smoothed block by block: the compiled inner loops of `strips.sweep`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

ONE = np.uint32(1)
BLOCK = 64
"""Strips across that are worked on together; where a block and those around it hold nothing, there is no work."""

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_masks, _volume = types.Array(types.uint32, 2, "C"), types.Array(types.uint32, 3, "C")
_image, _bools = types.Array(types.float32, 2, "C"), types.Array(types.bool_, 1, "C")
_table, _weights = types.Array(types.float32, 2, "C"), types.Array(types.float64, 1, "C")
_blocks, _hit, _places = types.Array(types.int64, 2, "C"), types.Array(types.bool_, 2, "C"), types.Array(types.int64, 1, "C")
_given, _shown = types.Array(types.int64, 1, "C", readonly=True), types.Array(types.float32, 1, "C", readonly=True)


@compiled(_points, types.float64, types.float64)
def turned_bounds(xy, cosine, sine):  # type: ignore[no-untyped-def]
    """Smallest and largest coordinates along a direction and to the left of it."""
    u0 = v0 = np.inf
    u1 = v1 = -np.inf
    for i in range(len(xy)):
        u, v = xy[i, 0] * cosine + xy[i, 1] * sine, xy[i, 0] * -sine + xy[i, 1] * cosine
        u0, v0, u1, v1 = min(u0, u), min(v0, v), max(u1, u), max(v1, v)
    return u0, v0, u1, v1


@inlined
def layer_of(rise, depth, even, layers, fine_height, clearance):  # type: ignore[no-untyped-def]
    """Height layer of a point: fine ones right below the overhead surface, even ones from the floor up to these."""
    layer = layers - 1 - int(np.floor((depth - clearance) / fine_height))
    return min(layer, layers - 1) if layer >= even else min(max(int(rise * even), 0), even - 1)


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
        bit = ONE << np.uint32(layer_of(rise[i], depth[i], even, layers, fine_height, clearance))
        if len(sensor) == 0:
            masks[0, u, v] |= bit
            masks[1, u, v] |= bit
        elif (sensor[i, 0] - x) * -sine + (sensor[i, 1] - y) * cosine > 0:
            masks[0, u, v] |= bit
        else:
            masks[1, u, v] |= bit


@inlined
def ones(word):  # type: ignore[no-untyped-def]
    """Number of bits that are set."""
    word = word - ((word >> np.uint32(1)) & np.uint32(0x55555555))
    word = (word & np.uint32(0x33333333)) + ((word >> np.uint32(2)) & np.uint32(0x33333333))
    word = (word + (word >> np.uint32(4))) & np.uint32(0x0F0F0F0F)
    return (word * np.uint32(0x01010101)) >> np.uint32(24) & np.uint32(0xFF)


@inlined
def _mirrored(i, count):  # type: ignore[no-untyped-def]
    """Index that an index outside is reflected to, the border repeated."""
    if i < 0 or i >= count:
        i = i % (2 * count)
        return i if i < count else 2 * count - 1 - i
    return i


@inlined
def _joined(row, j, reach, columns):  # type: ignore[no-untyped-def]
    """Layers hit in the strips within reach across."""
    word = row[j]
    for k in range(1, reach + 1):
        word |= row[j - k] if j >= k else np.uint32(0)
        word |= row[j + k] if j + k < columns else np.uint32(0)
    return word


@inlined
def _sum_along(image, i, first, last, size, total):  # type: ignore[no-untyped-def]
    """Sums of `size` rows around one, for some columns."""
    rows = len(image)
    total[:] = 0
    for k in range(i - size // 2, i + size - size // 2):
        row = image[_mirrored(k, rows)]
        for j in range(first, last):
            total[j - first] += row[j]


@inlined
def _sum_across(row, first, last, size, total):  # type: ignore[no-untyped-def]
    """Sums of `size` columns around some of a row; the sums are exact, so nothing depends on where they begin."""
    columns = len(row)
    before, after = size // 2, size - size // 2 - 1
    here = 0.0
    for j in range(first - before, first + after + 1):
        here += row[_mirrored(j, columns)]
    for j in range(first, last):
        total[j - first] = here
        gone = row[j - before] if j >= before else row[_mirrored(j - before, columns)]
        come = row[j + after + 1] if j + after + 1 < columns else row[_mirrored(j + after + 1, columns)]
        here += np.float64(come) - np.float64(gone)


@inlined
def _largest(row, first, last):  # type: ignore[no-untyped-def]
    """Largest value of some columns of a row."""
    largest = row[first]
    for j in range(first + 1, last):
        largest = max(largest, row[j])
    return largest


@compiled(_masks, types.int64, types.uint32, _hit)
def hit_blocks(masks, reach, band, hit):  # type: ignore[no-untyped-def]
    """Blocks in which the band was hit, or within reach across of them."""
    rows, columns = masks.shape
    for i in range(rows):
        row = masks[i]
        for block in range(hit.shape[1]):
            word = np.uint32(0)
            for j in range(max(block * BLOCK - reach, 0), min(block * BLOCK + BLOCK + reach, columns)):
                word |= row[j]
            hit[i, block] = word & band != 0


@compiled(_masks, _blocks, types.int64, types.uint32, types.uint32, types.uint32, _bools, _table, _image, _image, _hit)
def fill(masks, blocks, reach, band, below, tall, tall_enough, filled, best, thinly, some):  # type: ignore[no-untyped-def]
    """How far the band is filled in the strips within reach across, and in those and their neighbours along if they are tall.

    `some`: the blocks in which either is not zero somewhere.
    """
    rows, columns = masks.shape
    for n in range(len(blocks)):
        i, first = blocks[n, 0], blocks[n, 1] * BLOCK
        largest = np.float32(0)
        for j in range(first, min(first + BLOCK, columns)):
            word = _joined(masks[i], j, reach, columns)
            best[i, j] = filled[ones(word & band), ones(word & below)]
            if i > 0:
                word |= _joined(masks[i - 1], j, reach, columns)
            if i + 1 < rows:
                word |= _joined(masks[i + 1], j, reach, columns)
            thinly[i, j] = filled[ones(word & band), ones(word & below)] if tall_enough[ones(word & tall)] else np.float32(0)
            largest = max(largest, best[i, j], thinly[i, j])
        some[i, blocks[n, 1]] = largest > 0


@compiled(_image, _image, _blocks, types.int64, types.int64, types.int64, _image, _image)
def leave_out(best, thinly, blocks, width, short, long, kept, long_enough):  # type: ignore[no-untyped-def]
    """Leave out what only crosses the direction, and thin evidence that is short along it."""
    columns = best.shape[1]
    along, across, lengthwise = np.zeros(BLOCK), np.zeros(BLOCK), np.zeros(BLOCK)
    for n in range(len(blocks)):
        i, first = blocks[n, 0], blocks[n, 1] * BLOCK
        last = min(first + BLOCK, columns)
        for j in range(first, last):
            kept[i, j] = best[i, j]
        _sum_across(best[i], first, last, width, across)
        if np.float32(_largest(across, 0, last - first) / width) > np.float32(0.3):
            _sum_along(best, i, first, last, short, along)
            for j in range(first, last):
                if np.float32(across[j - first] / width) > max(np.float32(along[j - first] / short), np.float32(0.3)):
                    kept[i, j] = 0
        if _largest(thinly[i], first, last) > 0:
            _sum_along(thinly, i, first, last, long, lengthwise)
            for j in range(first, last):
                if not np.float32(lengthwise[j - first] / long) < np.float32(0.5):
                    long_enough[i, j] = thinly[i, j]


@compiled(_image, _image, _blocks, types.int64)
def join(best, thinly, blocks, width):  # type: ignore[no-untyped-def]
    """The larger evidence of both kinds in the place of the first; thin evidence that only crosses the direction is left out."""
    columns = best.shape[1]
    crosswise = np.zeros(BLOCK)
    for n in range(len(blocks)):
        i, first = blocks[n, 0], blocks[n, 1] * BLOCK
        last = min(first + BLOCK, columns)
        if _largest(thinly[i], first, last) == 0:
            continue
        _sum_across(thinly[i], first, last, width, crosswise)
        for j in range(first, last):
            if not np.float32(crosswise[j - first] / width) > np.float32(0.5):
                best[i, j] = max(best[i, j], thinly[i, j])


@compiled(_image, _blocks, types.float32, _image, _hit)
def smooth(image, blocks, least, out, strong):  # type: ignore[no-untyped-def]
    """Median of five along, and the blocks in which it is strong somewhere."""
    rows, columns = image.shape
    for n in range(len(blocks)):
        i, first = blocks[n, 0], blocks[n, 1] * BLOCK
        r0, r1, r2 = image[_mirrored(i - 2, rows)], image[_mirrored(i - 1, rows)], image[i]
        r3, r4 = image[_mirrored(i + 1, rows)], image[_mirrored(i + 2, rows)]
        any_strong = False
        for j in range(first, min(first + BLOCK, columns)):
            a, b, c, d, e = r0[j], r1[j], r2[j], r3[j], r4[j]
            low, high = max(min(a, b), min(d, e)), min(max(a, b), max(d, e))
            out[i, j] = max(min(low, high), min(max(low, high), c))
            any_strong |= out[i, j] >= least
        strong[i, blocks[n, 1]] = any_strong


@compiled(_masks, _blocks, types.uint32, _table, _weights, types.int64, types.int64, _image, types.float32, _places)
def crest_places(masks, blocks, band, weight, kernel, size, apart, evidence, least, places):  # type: ignore[no-untyped-def]
    """Places with evidence where more layers are hit than in any strip within `apart` across; returns their number.

    Layers are weighted, smoothed across by a symmetric kernel (its middle and right half), and averaged over `size` rows.
    """
    rows, columns = masks.shape
    reach = len(kernel) - 1
    line = np.zeros(BLOCK + 2 * (apart + reach))
    total, density = np.zeros(BLOCK + 2 * apart), np.zeros(BLOCK + 2 * apart, np.float32)
    count = 0
    for n in range(len(blocks)):
        i, first = blocks[n, 0], blocks[n, 1] * BLOCK
        total[:] = 0
        for k in range(i - size // 2, i + size - size // 2):
            row = masks[_mirrored(k, rows)]
            for j in range(len(line)):
                word = row[_mirrored(first - apart - reach + j, columns)]
                line[j] = weight[ones(word), ones(word & band)]
            for j in range(len(total)):
                mean = line[reach + j] * kernel[0]
                for m in range(reach, 0, -1):
                    mean += (line[reach + j - m] + line[reach + j + m]) * kernel[m]
                total[j] += np.float32(mean)
        for j in range(len(total)):
            inside = first - apart + j >= 0 and first - apart + j < columns
            density[j] = np.float32(total[j] / size) if inside else np.float32(-1)
        for j in range(first, min(first + BLOCK, columns)):
            largest = evidence[i, j] >= least
            value = density[j - first + apart]
            for k in range(j - first, j - first + 2 * apart + 1):
                largest &= density[k] <= value
            if largest:
                places[count] = i * columns + j
                count += 1
    return count


@compiled(*(_given, _shown, types.int64, types.int64, types.int64, _values, _values, _weights))
def largest_near(places, values, side, rows, columns, u, v, out):  # type: ignore[no-untyped-def]
    """Largest value of a sparse image within three strips across of spots, 0 at its border and outside."""
    for n in range(len(u)):
        row, column = int(np.floor(u[n])), int(np.floor(v[n]))
        if row < 0 or row >= rows or column < 3 or column >= columns - 3:
            continue
        last = (side * rows + row) * columns + column + 3
        k = np.searchsorted(places, last - 6)
        while k < len(places) and places[k] <= last:
            out[n] = max(out[n], values[k])
            k += 1
