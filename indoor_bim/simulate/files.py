"""Files of a simulated scan: the scan, the path of the sensor, and the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from indoor_bim.cloud.write import write_las
from indoor_bim.errors import WriteError
from indoor_bim.export.files import replace_file
from indoor_bim.export.json import write_json
from indoor_bim.simulate.scanner import SimulatedScan

_RESOLUTION = 1e-4


def write_scan(scan: SimulatedScan, folder: str | Path) -> None:
    """Write ``scan.laz``, ``trajectory.csv`` (t, x, y, z) and ``truth.json`` into a folder; the same scan gives the same bytes.

    Parameters
    ----------
    scan : SimulatedScan
        Scan and truth.
    folder : path
        Folder to create or to write into.

    Raises
    ------
    WriteError
        If the folder or a file in it cannot be written.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(f"{folder}: cannot make this folder ({error.strerror}); name a folder you may write to.") from error
    write_las(folder / "scan.laz", scan.points, gps_time=scan.gps_time, resolution=_RESOLUTION)
    with replace_file(folder / "trajectory.csv") as draft:
        np.savetxt(
            draft, scan.trajectory, fmt=["%.3f", "%.4f", "%.4f", "%.4f"], delimiter=",", header="t,x,y,z", comments="", encoding="utf-8"
        )
    write_json(scan.truth, folder / "truth.json")
