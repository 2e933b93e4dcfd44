"""Strips of the plan filled with the height layers of points, and smoothed block by block: the compiled inner loops of `strips.sweep`.

Images are kept in blocks, as in `block_image`: the slot of each block, and its pixels there.
"""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined
from indoor_bim.plan.block_image import BLOCK, BLOCK_BITS

ONE = np.uint32(1)
DONE, USED = range(2)
"""State of a loop over points: how many are done, and how many slots are used."""

_points = types.Array(types.float64, 2, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_words, _pixels = types.Array(types.uint32, 2, "C"), types.Array(types.float32, 2, "C")
_slot, _slots = types.Array(types.int32, 2, "C", readonly=True), types.Array(types.int32, 3, "C")
_bools, _weights = types.Array(types.bool_, 1, "C"), types.Array(types.float64, 1, "C")
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
    *(types.float64, types.float64, types.int64, types.int64, types.float64, types.float64, _places, _slots, _words),
)
def set_layers(  # type: ignore[no-untyped-def]
    xy, sensor, rise, depth, cosine, sine, low_u, low_v, along, across, even, layers, fine_height, clearance, state, slots, words
):
    """Set the bit of its height layer in the strip of each point, for the side it was seen from or for both.

    Goes on where the state says, until all points are done or hardly a slot is left.
    """
    used = state[USED]
    for i in range(state[DONE], len(xy)):
        if used + 2 > len(words):
            state[DONE], state[USED] = i, used
            return
        x, y = xy[i, 0], xy[i, 1]
        u, v = int((x * cosine + y * sine - low_u) / along), int((x * -sine + y * cosine - low_v) / across)
        bit = ONE << np.uint32(layer_of(rise[i], depth[i], even, layers, fine_height, clearance))
        first, last = 0, 2
        if len(sensor):
            first = 0 if (sensor[i, 0] - x) * -sine + (sensor[i, 1] - y) * cosine > 0 else 1
            last = first + 1
        block, column = v >> BLOCK_BITS, v & (BLOCK - 1)
        for side in range(first, last):
            if slots[side, u, block] == 0:
                slots[side, u, block] = used
                used += 1
            words[slots[side, u, block], column] |= bit
    state[DONE], state[USED] = len(xy), used


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
def _bring(values, slots, first, columns, line):  # type: ignore[no-untyped-def]
    """Bring pixels of a row side by side, from the first on; those outside are reflected, the border repeated."""
    if first >= 0 and first + len(line) <= columns:
        done = 0
        while done < len(line):
            column = (first + done) & (BLOCK - 1)
            block = values[slots[(first + done) >> BLOCK_BITS]]
            count = min(BLOCK - column, len(line) - done)
            for j in range(count):
                line[done + j] = block[column + j]
            done += count
    else:
        for j in range(len(line)):
            column = _mirrored(first + j, columns)
            line[j] = values[slots[column >> BLOCK_BITS], column & (BLOCK - 1)]


@inlined
def _join_across(words, slots, block, reach, line, joined):  # type: ignore[no-untyped-def]
    """Layers hit in the strips within reach across, for those of a block."""
    before = words[slots[block - 1] if block > 0 else 0]
    after = words[slots[block + 1] if block + 1 < len(slots) else 0]
    for j in range(reach):
        line[j], line[reach + BLOCK + j] = before[BLOCK - reach + j], after[j]
    line[reach : reach + BLOCK] = words[slots[block]]
    joined[:] = line[:BLOCK]
    for k in range(1, 2 * reach + 1):
        for j in range(BLOCK):
            joined[j] |= line[j + k]


@inlined
def _sum_along(values, slot, i, block, size, total):  # type: ignore[no-untyped-def]
    """Sums of `size` rows around one, for the columns of a block."""
    total[:] = 0
    for k in range(i - size // 2, i + size - size // 2):
        place = slot[_mirrored(k, len(slot)), block]
        if place:
            row = values[place]
            for j in range(BLOCK):
                total[j] += row[j]


@inlined
def _sum_across(values, slots, block, size, columns, line, total):  # type: ignore[no-untyped-def]
    """Sums of `size` columns around those of a block; the sums are exact, so nothing depends on where they begin."""
    _bring(values, slots, block * BLOCK - size // 2, columns, line)
    here = 0.0
    for j in range(size):
        here += line[j]
    for j in range(BLOCK):
        total[j] = here
        here += np.float64(line[j + size]) - np.float64(line[j])


@inlined
def _any_above(row, count, least):  # type: ignore[no-untyped-def]
    """Whether one of the first values of a row is larger."""
    above = False
    for j in range(count):
        above |= row[j] > least
    return above


@compiled(_slot, _words, types.int64, types.uint32, _hit)
def hit_blocks(slot, words, reach, band, hit):  # type: ignore[no-untyped-def]
    """Blocks in which the band was hit, or within reach across of them."""
    for i in range(len(slot)):
        for block in range(slot.shape[1]):
            if slot[i, block]:
                row = words[slot[i, block]]
                word, left, right = np.uint32(0), np.uint32(0), np.uint32(0)
                for j in range(BLOCK):
                    word |= row[j]
                for j in range(reach):
                    left |= row[j]
                    right |= row[BLOCK - 1 - j]
                hit[i, block] |= word & band != 0
                if block > 0:
                    hit[i, block - 1] |= left & band != 0
                if block + 1 < slot.shape[1]:
                    hit[i, block + 1] |= right & band != 0


@compiled(
    *(_slot, _words, types.int64, _blocks, types.int64, types.uint32, types.uint32, types.uint32, _bools, _pixels),
    *(_pixels, _pixels, _bools),
)
def fill(slot, words, columns, blocks, reach, band, below, tall, tall_enough, filled, best, thinly, some):  # type: ignore[no-untyped-def]
    """How far the band is filled in the strips within reach across, and in those and their neighbours along if they are tall.

    Block n is written to slot n + 1 of `best` and `thinly`; `some`: whether either is not zero somewhere.
    """
    rows = len(slot)
    line, near, beside = np.zeros(BLOCK + 2 * reach, np.uint32), np.zeros(BLOCK, np.uint32), np.zeros(BLOCK, np.uint32)
    for n in range(len(blocks)):
        i, block = blocks[n, 0], blocks[n, 1]
        width = min(BLOCK, columns - block * BLOCK)
        own, own_thinly = best[n + 1], thinly[n + 1]
        _join_across(words, slot[i], block, reach, line, near)
        for j in range(width):
            own[j] = filled[ones(near[j] & band), ones(near[j] & below)]
        for k in range(max(i - 1, 0), min(i + 2, rows)):
            if k != i:
                _join_across(words, slot[k], block, reach, line, beside)
                for j in range(BLOCK):
                    near[j] |= beside[j]
        for j in range(width):
            if tall_enough[ones(near[j] & tall)]:
                own_thinly[j] = filled[ones(near[j] & band), ones(near[j] & below)]
        some[n] = _any_above(own, width, 0) or _any_above(own_thinly, width, 0)


@compiled(_pixels, _pixels, _slot, types.int64, _blocks, types.int64, types.int64, types.int64, _pixels, _pixels)
def leave_out(best, thinly, slot, columns, blocks, size, short, long, kept, long_enough):  # type: ignore[no-untyped-def]
    """Leave out what only crosses the direction, and thin evidence that is short along it."""
    along, across, lengthwise = np.zeros(BLOCK), np.zeros(BLOCK), np.zeros(BLOCK)
    line = np.zeros(BLOCK + size, np.float32)
    for n in range(len(blocks)):
        i, block = blocks[n, 0], blocks[n, 1]
        width, place = min(BLOCK, columns - block * BLOCK), slot[i, block]
        kept[place] = best[place]
        _sum_across(best, slot[i], block, size, columns, line, across)
        for j in range(BLOCK):
            across[j] = np.float32(across[j] / size)
        if _any_above(across, width, np.float32(0.3)):
            _sum_along(best, slot, i, block, short, along)
            for j in range(width):
                if across[j] > max(np.float32(along[j] / short), np.float32(0.3)):
                    kept[place, j] = 0
        if _any_above(thinly[place], width, 0):
            _sum_along(thinly, slot, i, block, long, lengthwise)
            for j in range(width):
                if not np.float32(lengthwise[j] / long) < np.float32(0.5):
                    long_enough[place, j] = thinly[place, j]


@compiled(_pixels, _pixels, _slot, types.int64, _blocks, types.int64)
def join(best, thinly, slot, columns, blocks, size):  # type: ignore[no-untyped-def]
    """The larger evidence of both kinds in the place of the first; thin evidence that only crosses the direction is left out."""
    crosswise, line = np.zeros(BLOCK), np.zeros(BLOCK + size, np.float32)
    for n in range(len(blocks)):
        i, block = blocks[n, 0], blocks[n, 1]
        width, place = min(BLOCK, columns - block * BLOCK), slot[i, block]
        if not _any_above(thinly[place], width, 0):
            continue
        _sum_across(thinly, slot[i], block, size, columns, line, crosswise)
        for j in range(width):
            if not np.float32(crosswise[j] / size) > np.float32(0.5):
                best[place, j] = max(best[place, j], thinly[place, j])


@compiled(_pixels, _slot, _blocks, _pixels)
def smooth(values, slot, blocks, out):  # type: ignore[no-untyped-def]
    """Median of five along, that of block n in slot n + 1."""
    rows = len(slot)
    for n in range(len(blocks)):
        i, block = blocks[n, 0], blocks[n, 1]
        r0, r1, r2 = values[slot[_mirrored(i - 2, rows), block]], values[slot[_mirrored(i - 1, rows), block]], values[slot[i, block]]
        r3, r4 = values[slot[_mirrored(i + 1, rows), block]], values[slot[_mirrored(i + 2, rows), block]]
        for j in range(BLOCK):
            a, b, c, d, e = r0[j], r1[j], r2[j], r3[j], r4[j]
            low, high = max(min(a, b), min(d, e)), min(max(a, b), max(d, e))
            out[n + 1, j] = max(min(low, high), min(max(low, high), c))


@compiled(
    *(_slot, _words, types.int64, _blocks, types.uint32, _pixels, _weights, types.int64, types.int64),
    *(_slot, _pixels, types.float32, _places),
)
def crest_places(slot, words, columns, blocks, band, weight, kernel, size, apart, shown, evidence, least, places):  # type: ignore[no-untyped-def]
    """Places with evidence where more layers are hit than in any strip within `apart` across; returns their number.

    Layers are weighted, smoothed across by a symmetric kernel (its middle and right half), and averaged over `size` rows.
    """
    rows = len(slot)
    reach = len(kernel) - 1
    line, word = np.zeros(BLOCK + 2 * (apart + reach)), np.zeros(BLOCK + 2 * (apart + reach), np.uint32)
    total, density = np.zeros(BLOCK + 2 * apart), np.zeros(BLOCK + 2 * apart, np.float32)
    count = 0
    for n in range(len(blocks)):
        i, block = blocks[n, 0], blocks[n, 1]
        first = block * BLOCK
        total[:] = 0
        for k in range(i - size // 2, i + size - size // 2):
            _bring(words, slot[_mirrored(k, rows)], first - apart - reach, columns, word)
            for j in range(len(line)):
                line[j] = weight[ones(word[j]), ones(word[j] & band)]
            for j in range(len(total)):
                mean = line[reach + j] * kernel[0]
                for m in range(reach, 0, -1):
                    mean += (line[reach + j - m] + line[reach + j + m]) * kernel[m]
                total[j] += np.float32(mean)
        for j in range(len(total)):
            inside = first - apart + j >= 0 and first - apart + j < columns
            density[j] = np.float32(total[j] / size) if inside else np.float32(-1)
        own = evidence[shown[i, block]]
        for j in range(min(BLOCK, columns - first)):
            largest = own[j] >= least
            for k in range(j, j + 2 * apart + 1):
                largest &= density[k] <= density[j + apart]
            if largest:
                places[count] = i * columns + first + j
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
