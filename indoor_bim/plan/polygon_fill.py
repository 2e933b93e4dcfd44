"""Polygons drawn into an image."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled


@compiled(types.Array(types.float64, 2, "C"), types.int64, types.Array(types.int64, 2, "C"))
def fill(xy, value, image):  # type: ignore[no-untyped-def]
    """Set the pixels whose centres lie in a polygon or on its border, row by row between its crossings.

    Parameters
    ----------
    xy : (n, 2) float64
        Corners as column and row of the image, the first one again at the end; pixel centres have whole numbers.
    value : int
        Value to set.
    image : (rows, columns) int64
        Image to draw into.
    """
    rows, columns = image.shape
    crossings = np.zeros(len(xy))
    first = max(int(np.ceil(xy[:, 1].min())), 0)
    last = min(int(np.floor(xy[:, 1].max())), rows - 1)
    for row in range(first, last + 1):
        count = 0
        for k in range(len(xy) - 1):
            x0, y0, x1, y1 = xy[k, 0], xy[k, 1], xy[k + 1, 0], xy[k + 1, 1]
            if (y0 <= row) != (y1 <= row):
                crossings[count] = x0 + (row - y0) / (y1 - y0) * (x1 - x0)
                count += 1
            elif y0 == row and y1 == row:
                for column in range(max(int(np.ceil(min(x0, x1))), 0), min(int(np.floor(max(x0, x1))), columns - 1) + 1):
                    image[row, column] = value
        ordered = np.sort(crossings[:count])
        for k in range(0, count - 1, 2):
            for column in range(max(int(np.ceil(ordered[k])), 0), min(int(np.floor(ordered[k + 1])), columns - 1) + 1):
                image[row, column] = value
