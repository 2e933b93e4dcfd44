"""The point cloud as stages pass it on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.frame import Frame

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Points in metres, near the origin, z roughly up, with the frame that leads back to the scan.

    Parameters
    ----------
    points : (n, 3) float64
        Finite local coordinates, metres.
    frame : Frame
        Takes the scan's own coordinates to `points`.
    gps_time : (n,) float64, optional
        Time of each point, seconds.
    classification : (n,) uint8, optional
        ASPRS class of each point.
    trajectory : (m, 4) float64, optional
        Scanner path: time in seconds (NaN where not known) and local x, y, z in metres.
    source : str
        Name of the file, for messages and reports.
    crs : str, optional
        Coordinate reference system of the scan as ``EPSG:code``.
    warnings : tuple of str
        What was assumed or left out while reading.
    derived : dict of str to value
        Values of parameters that were derived while reading, by ``stage.name``.
    intensity : (n,) uint16, optional
        Strength of each return, in the unit of the scanner.
    """

    points: Points
    frame: Frame = field(default_factory=Frame.identity)
    gps_time: NDArray[np.float64] | None = None
    classification: NDArray[np.uint8] | None = None
    trajectory: NDArray[np.float64] | None = None
    source: str = "scan"
    crs: str | None = None
    warnings: tuple[str, ...] = ()
    derived: dict[str, Any] = field(default_factory=dict)
    intensity: NDArray[np.uint16] | None = None

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True, slots=True)
class StoreyLevels:
    """Floor and ceiling height of one storey in model coordinates, metres; None where it was not seen."""

    floor: float | None
    ceiling: float | None


@dataclass(frozen=True, slots=True, eq=False)
class LevelledCloud:
    """A cloud turned upright and into the building's main direction, split into floor, ceiling and the rest.

    Parameters
    ----------
    points : (n, 3) float64
        Model coordinates, metres: z up, lowest floor at z = 0, x along a main direction.
    frame : Frame
        Takes the scan's own coordinates to `points`.
    part : (n,) uint8
        `WALL`, `FLOOR` or `CEILING` (module constants) for each point; WALL is everything that is neither.
    storeys : tuple of StoreyLevels
        Levels from the bottom up.
    trajectory : (m, 4) float64, optional
        Scanner path in model coordinates.
    warnings : tuple of str
        What was not seen or is doubtful.
    """

    points: Points
    frame: Frame
    part: NDArray[np.uint8]
    storeys: tuple[StoreyLevels, ...]
    trajectory: NDArray[np.float64] | None = None
    warnings: tuple[str, ...] = ()


WALL, FLOOR, CEILING = np.uint8(0), np.uint8(1), np.uint8(2)
