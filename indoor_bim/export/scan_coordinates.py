"""From model coordinates back to those of the scan."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_bim.model import Matrix4


def to_scan(points: ArrayLike, transform: Matrix4) -> NDArray[np.float64]:
    """Take model coordinates back to scan coordinates.

    Parameters
    ----------
    points : (n, 3) array_like
        Model coordinates, metres.
    transform : 4 x 4 matrix
        Takes scan coordinates to model coordinates.

    Returns
    -------
    (n, 3) float64
        Scan coordinates, in the scan's unit, to a tenth of a millimetre or its like.

    Examples
    --------
    >>> to_scan([[1.0, 2.0, 3.0]], ((1, 0, 0, -500000), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))).tolist()
    [[500001.0, 2.0, 3.0]]
    """
    matrix = np.asarray(transform, dtype=np.float64)
    scan = np.linalg.solve(matrix[:3, :3], (np.asarray(points, dtype=np.float64) - matrix[:3, 3]).T).T
    return np.asarray(scan, dtype=np.float64)
