"""Means and maxima of square windows of an image, tile by tile: the compiled inner loop of `hit_images.local_density`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled, inlined

TILE = 128
"""Side of the tiles, pixels: one and its margins fit into the processor's cache."""

_flags, _image = types.Array(types.boolean, 2, "C", readonly=True), types.Array(types.float32, 2, "C")


@inlined
def _mirrored(i, count):  # type: ignore[no-untyped-def]
    """Index that an index outside is reflected to, the border repeated."""
    i = i % (2 * count)
    return i if i < count else 2 * count - 1 - i


@inlined
def _any_in(flags, top, bottom, left, right):  # type: ignore[no-untyped-def]
    """Whether a flag is set in a rectangle, as far as it lies in the image."""
    found = False
    for i in range(max(top, 0), min(bottom, flags.shape[0])):
        for j in range(max(left, 0), min(right, flags.shape[1])):
            found |= flags[i, j]
        if found:
            break
    return found


@inlined
def _share_of_tile(seen, known, top, left, reach, least, column, share):  # type: ignore[no-untyped-def]
    """Share that is seen of what is known around each pixel of a tile and its margin; -inf outside the image.

    Means are those of `scipy.ndimage.uniform_filter`: first of columns, then of rows. Their sums are exact, so nothing depends on where
    they begin.
    """
    rows, columns = seen.shape
    size, wide = 2 * reach + 1, len(share)
    count, count_known = np.zeros(len(column), np.int64), np.zeros(len(column), np.int64)
    mean, mean_known = np.zeros(len(column), np.float32), np.zeros(len(column), np.float32)
    first, last = max(top, 0), min(top + wide, rows)
    share[:] = -np.inf
    for k in range(first - reach, first + reach + 1):
        row, row_known = seen[_mirrored(k, rows)], known[_mirrored(k, rows)]
        for c in range(len(column)):
            count[c] += row[column[c]]
            count_known[c] += row_known[column[c]]
    for i in range(first, last):
        for c in range(len(column)):
            mean[c], mean_known[c] = count[c] / size, count_known[c] / size
        gone, come = _mirrored(i - reach, rows), _mirrored(i + reach + 1, rows)
        gone_row, come_row, gone_known, come_known = seen[gone], seen[come], known[gone], known[come]
        for c in range(len(column)):
            count[c] += np.int64(come_row[column[c]]) - np.int64(gone_row[column[c]])
            count_known[c] += np.int64(come_known[column[c]]) - np.int64(gone_known[column[c]])
        total = total_known = 0.0
        for c in range(size - 1):
            total, total_known = total + mean[c], total_known + mean_known[c]
        for c in range(wide):
            total, total_known = total + mean[c + size - 1], total_known + mean_known[c + size - 1]
            if left + c >= 0 and left + c < columns:
                share[i - top, c] = np.float32(total / size) / max(np.float32(total_known / size), least)
            total, total_known = total - mean[c], total_known - mean_known[c]


@compiled(_flags, _flags, types.int64, types.float32, _image)
def best_share_around(seen, known, reach, least, out):  # type: ignore[no-untyped-def]
    """Largest share that is seen of what is known (`least` at least) around the pixels around each pixel that is known.

    Both windows reach so many pixels to each side. The largest of a window is that of two, four, eight rows or columns, then of two such
    that overlap. Where nothing was seen near a tile, nothing is written.
    """
    rows, columns = seen.shape
    size, wide = 2 * reach + 1, TILE + 2 * reach
    share, line = np.zeros((wide, wide), np.float32), np.zeros(wide, np.float32)
    column = np.zeros(wide + 2 * reach, np.int64)
    for top in range(0, rows, TILE):
        for left in range(0, columns, TILE):
            if not _any_in(seen, top - 2 * reach, top + TILE + 2 * reach, left - 2 * reach, left + TILE + 2 * reach):
                continue
            for c in range(len(column)):
                column[c] = _mirrored(left - 2 * reach + c, columns)
            _share_of_tile(seen, known, top - reach, left - reach, reach, least, column, share)
            step = 1
            while 2 * step <= size:
                for i in range(wide - step):
                    for c in range(wide):
                        share[i, c] = share[i + step, c] if share[i + step, c] > share[i, c] else share[i, c]
                step *= 2
            rest = size - step
            for i in range(min(TILE, rows - top)):
                for c in range(wide):
                    line[c] = share[i, c] if share[i, c] > share[i + rest, c] else share[i + rest, c]
                width = 1
                while 2 * width <= size:
                    for c in range(wide - width):
                        line[c] = line[c + width] if line[c + width] > line[c] else line[c]
                    width *= 2
                for c in range(min(TILE, columns - left)):
                    if known[top + i, left + c]:
                        out[top + i, left + c] = line[c] if line[c] > line[c + rest] else line[c + rest]
