"""The path of the scanner."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.text import TIME_COLUMNS, read_table
from indoor_bim.errors import ReadError

EXPECTED = "the columns t, x, y, z or x, y, z"


def read_trajectory(path: str | Path) -> NDArray[np.float64]:
    """Read the path of the scanner from a CSV or text file.

    Parameters
    ----------
    path : str or Path
        Table with the columns t, x, y, z or x, y, z, with or without a header; comma, semicolon, tab or white space between them.

    Returns
    -------
    (m, 4) float64
        Time in seconds (NaN where the file has none) and x, y, z in the scan's coordinates, sorted by time where there is one.

    Raises
    ------
    ReadError
        If the file is missing or holds no such table; names the line.
    """
    path = Path(path)
    if not path.is_file():
        raise ReadError(f"{path}: no such trajectory file, expected a table with {EXPECTED}; check the path")
    try:
        layout, rows = read_table(path, expected=EXPECTED)
    except OSError as error:
        raise ReadError(f"{path}: cannot be read ({error.strerror or error}); check its permissions and the disk") from error
    named = {name: i for i, name in reversed(list(enumerate(layout.names)))}
    if {"x", "y", "z"} <= set(named):
        time = next((i for name, i in named.items() if name in TIME_COLUMNS), None)
        columns = [named["x"], named["y"], named["z"]]
    elif rows.shape[1] == 3:
        time, columns = None, [0, 1, 2]
    elif rows.shape[1] == 4:
        time, columns = 0, [1, 2, 3]
    else:
        raise ReadError(f"{path}: found {rows.shape[1]} columns without names, expected {EXPECTED}; add a header line")
    seconds = rows[:, time] if time is not None else np.full(len(rows), np.nan)
    positions = rows[:, columns]
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        found = f"row {bad[0] + 1} of the table: found a position that is not finite"
        raise ReadError(f"{path}, {found}, expected {EXPECTED}; correct or remove the line")
    order = np.argsort(seconds, kind="stable") if np.isfinite(seconds).all() else slice(None)
    table: NDArray[np.float64] = np.column_stack([seconds, positions])[order]
    return table
