"""What a file format reader hands on: coordinates as they stand in the file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class RawScan:
    """A scan in its own coordinates, unit and axes.

    Parameters
    ----------
    points : (n, 3) float64
        Coordinates as written, finite or not.
    gps_time : (n,) float64, optional
        Time of each point, seconds.
    classification : (n,) uint8, optional
        ASPRS class of each point.
    stations : (m, 3) float64, optional
        Scanner positions that the file itself names.
    crs : str, optional
        ``EPSG:code`` that the file declares.
    unit : str, optional
        Unit that the file declares, by its short name.
    per_cube : int, optional
        Most points kept of a cube of 10 cm, where not all were kept.
    intensity : (n,) uint16, optional
        Strength of each return, in the unit of the scanner.
    """

    points: NDArray[np.float64]
    gps_time: NDArray[np.float64] | None = None
    classification: NDArray[np.uint8] | None = None
    stations: NDArray[np.float64] | None = None
    crs: str | None = None
    unit: str | None = None
    per_cube: int | None = None
    intensity: NDArray[np.uint16] | None = None
