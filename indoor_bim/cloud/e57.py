"""E57 files (ASTM E2807), all scans in the file's common coordinates."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from indoor_bim.cloud.raw import RawScan, as_intensity
from indoor_bim.errors import ReadError


def read_e57(path: Path, progress: Callable[[float], None] | None = None) -> RawScan:
    """Read all scans of an E57 file with their poses applied.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Raises
    ------
    ReadError
        If the E57 reader is not installed or the file is damaged.
    """
    with path.open("rb") as file:
        if file.read(8) != b"ASTM-E57":
            raise ReadError(f"{path}: found no E57 signature at its start, expected an E57 file; check what kind of file this is")
    try:
        import pye57
    except ImportError as error:
        raise ReadError(f"{path}: reading E57 needs the package pye57; install it (pip install pye57) or save the scan as LAZ") from error
    points, strengths, stations = [], [], []
    try:
        file57 = pye57.E57(str(path))
        try:
            for index in range(file57.scan_count):
                header = file57.get_header(index)
                scan = file57.read_scan(index, intensity=True, transform=True, ignore_missing_fields=True)
                points.append(np.stack([np.asarray(scan[f"cartesian{axis}"], dtype=np.float64) for axis in "XYZ"], axis=1))
                if "intensity" in scan:
                    strengths.append(np.asarray(scan["intensity"], dtype=np.float64))
                if header.has_pose():
                    stations.append(np.asarray(header.translation, dtype=np.float64))
                if progress is not None:
                    progress((index + 1) / file57.scan_count)
        finally:
            file57.close()
    except Exception as error:
        raise ReadError(f"{path}: the E57 file is damaged or cut short ({' '.join(str(error).split())[:120]}); export it again") from error
    told = bool(points) and len(strengths) == len(points)
    return RawScan(
        np.concatenate(points) if points else np.zeros((0, 3)),
        stations=np.array(stations) if stations else None,
        intensity=as_intensity(np.concatenate(strengths)) if told else None,
    )
