"""Connected parts of a grid of cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def connected_cells(cells: NDArray[np.bool_]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Number the parts of cells that touch one another, at corners too; as `scipy.ndimage.label`, which takes its time for few cells.

    Parameters
    ----------
    cells : (rows, columns) or (planes, rows, columns) bool
        Cells that are set.

    Returns
    -------
    labels : (rows, columns) or (planes, rows, columns) int32
        Part of each cell, from 1 in the order of their first cells; 0 where none is set.
    boxes : (k, 2, 2 or 3) int64
        First index of each part along each axis, and one more than the last.

    Examples
    --------
    >>> labels, boxes = connected_cells(np.array([[True, False, False], [False, True, False], [False, False, False], [True, True, True]]))
    >>> labels.tolist(), boxes.tolist()
    ([[1, 0, 0], [0, 1, 0], [0, 0, 0], [2, 2, 2]], [[[0, 0], [2, 2]], [[3, 0], [4, 3]]])
    """
    from indoor_bim.plan.label_loops import label_cells

    deep = np.ascontiguousarray(cells[None] if cells.ndim == 2 else cells)
    labels = np.zeros(deep.shape, dtype=np.int32)
    boxes = np.zeros((np.count_nonzero(deep), 6), dtype=np.int64)
    found = boxes[: label_cells(deep, labels, boxes)].reshape(-1, 2, 3)
    return labels.reshape(cells.shape), found[:, :, 3 - cells.ndim :]
