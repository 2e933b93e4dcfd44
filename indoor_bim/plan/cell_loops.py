"""What floor and ceiling say about each cell, summed pixel by pixel: the compiled inner loop of `free_space.cell_space`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

ZERO, ONE, HALF_SURE = np.float32(0), np.float32(1), np.float32(0.02)

_labels, _hits = types.Array(types.int32, 2, "C", readonly=True), types.Array(types.boolean, 2, "C", readonly=True)
_image = types.Array(types.float32, 2, "C", readonly=True)
_table = types.Array(types.float64, 2, "C")


@compiled(_labels, _hits, _hits, _image, _image, types.float64, _table)
def sum_in_cells(cells, ceiling, floor, ceiling_density, floor_density, least, sums):  # type: ignore[no-untyped-def]
    """Sums over the pixels of each cell.

    Columns of the sums: pixels; hit; ceiling hit and expected; certainty of the ceiling, and of it alone; floor hit and expected where
    nothing is overhead, and the certainty of that.
    """
    rows, columns = cells.shape
    for i in range(rows):
        for j in range(columns):
            if cells[i, j] < 0:
                continue
            row = sums[cells[i, j]]
            density, below = ceiling_density[i, j], floor_density[i, j]
            sure = density / (density + HALF_SURE)
            open_above = ONE - sure
            expected = max(np.float64(below), least) if below > 0 else 0.0
            row[0] += 1
            row[1] += ceiling[i, j] | floor[i, j]
            row[2] += ceiling[i, j]
            row[3] += density
            row[4] += sure
            row[5] += sure * (ONE - below / (below + HALF_SURE))
            row[6] += open_above if floor[i, j] else ZERO
            row[7] += expected * open_above
            row[8] += open_above * below / (below + HALF_SURE)
