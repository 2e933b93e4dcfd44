"""Connected cells of a grid: the compiled inner loop of `holes` and `overhead`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

_cells = types.Array(types.boolean, 3, "C", readonly=True)
_labels, _boxes = types.Array(types.int32, 3, "C"), types.Array(types.int64, 2, "C")


@compiled(_cells, _labels, _boxes)
def label_cells(cells, labels, boxes):  # type: ignore[no-untyped-def]
    """Number the connected parts of cells, corners included, by their first cells, from 1; return how many there are.

    `boxes` takes for each part the first index along each axis, and one more than the last.
    """
    planes, rows, columns = cells.shape
    waiting = np.zeros((cells.sum(), 3), np.int64)
    parts = 0
    for p in range(planes):
        for r in range(rows):
            for c in range(columns):
                if not cells[p, r, c] or labels[p, r, c]:
                    continue
                box = boxes[parts]
                parts += 1
                labels[p, r, c] = parts
                box[0], box[1], box[2], box[3], box[4], box[5] = p, r, c, p + 1, r + 1, c + 1
                waiting[0, 0], waiting[0, 1], waiting[0, 2] = p, r, c
                left = 1
                while left:
                    left -= 1
                    plane, row, column = waiting[left, 0], waiting[left, 1], waiting[left, 2]
                    box[0], box[3] = min(box[0], plane), max(box[3], plane + 1)
                    box[1], box[4] = min(box[1], row), max(box[4], row + 1)
                    box[2], box[5] = min(box[2], column), max(box[5], column + 1)
                    for i in range(max(plane - 1, 0), min(plane + 2, planes)):
                        for j in range(max(row - 1, 0), min(row + 2, rows)):
                            for k in range(max(column - 1, 0), min(column + 2, columns)):
                                if cells[i, j, k] and not labels[i, j, k]:
                                    labels[i, j, k] = parts
                                    waiting[left, 0], waiting[left, 1], waiting[left, 2] = i, j, k
                                    left += 1
    return parts
