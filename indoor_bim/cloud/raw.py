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


def as_intensity(values: NDArray) -> NDArray[np.uint16] | None:
    """Strengths of returns as 16 bits: whole numbers that fit as they are, others scaled so that the strongest is 65535.

    Parameters
    ----------
    values : (n,) array
        Strengths in any unit; what is not finite counts as none.

    Returns
    -------
    (n,) uint16 or None
        None where all are equal and tell nothing.

    Examples
    --------
    >>> as_intensity(np.array([0.0, 0.5, 1.0])).tolist()
    [0, 32768, 65535]
    >>> as_intensity(np.array([-2048, 0, 2047])).tolist()
    [0, 2048, 4095]
    """
    strength = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(strength)
    if not finite.any():
        return None
    low, high = float(strength[finite].min()), float(strength[finite].max())
    if low == high:
        return None
    base = min(low, 0.0)
    strength = np.where(finite, strength, base) - base
    if high - base > np.iinfo(np.uint16).max or (strength != np.floor(strength)).any():
        strength *= np.iinfo(np.uint16).max / (high - base)
    return np.rint(strength).astype(np.uint16)
