"""Polygons drawn into an image."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled


@compiled(types.Array(types.float64, 2, "C"), types.int64, types.Array(types.int32, 2, "C"))
def fill(xy, value, image):  # type: ignore[no-untyped-def]
    """Set the pixels whose centres lie in a polygon or on its border, row by row between its crossings.

    Parameters
    ----------
    xy : (n, 2) float64
        Corners as column and row of the image, the first one again at the end; pixel centres have whole numbers.
    value : int
        Value to set.
    image : (rows, columns) int32
        Image to draw into.
    """
    rows, columns = image.shape
    crossings = np.zeros(len(xy))
    lowest, highest = np.inf, -np.inf
    for k in range(len(xy)):
        lowest, highest = min(lowest, xy[k, 1]), max(highest, xy[k, 1])
    first = max(int(np.ceil(lowest)), 0)
    last = min(int(np.floor(highest)), rows - 1)
    for row in range(first, last + 1):
        count = 0
        for k in range(len(xy) - 1):
            x0, y0, x1, y1 = xy[k, 0], xy[k, 1], xy[k + 1, 0], xy[k + 1, 1]
            if (y0 <= row) != (y1 <= row):
                crossing = x0 + (row - y0) / (y1 - y0) * (x1 - x0)
                place = count
                while place > 0 and crossings[place - 1] > crossing:
                    crossings[place] = crossings[place - 1]
                    place -= 1
                crossings[place] = crossing
                count += 1
            elif y0 == row and y1 == row:
                for column in range(max(int(np.ceil(min(x0, x1))), 0), min(int(np.floor(max(x0, x1))), columns - 1) + 1):
                    image[row, column] = value
        for k in range(0, count - 1, 2):
            for column in range(max(int(np.ceil(crossings[k])), 0), min(int(np.floor(crossings[k + 1])), columns - 1) + 1):
                image[row, column] = value
