"""Points as text: XYZ, TXT, ASC, CSV and PTS."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.raw import RawScan
from indoor_bim.errors import ReadError

HEAD_LINES = 50
TIME_COLUMNS = frozenset({"t", "time", "gps_time", "gpstime", "timestamp"})


@dataclass(frozen=True, slots=True)
class TableLayout:
    """How a text table is written: lines before the numbers, delimiter (None: white space), names and number of the columns."""

    skip: int
    delimiter: str | None
    decimal_comma: bool
    names: tuple[str, ...]
    columns: int


def read_text(path: Path, progress: Callable[[float], None] | None = None) -> RawScan:
    """Read points from a text table, one point a line.

    The columns are found by their names if there is a header with x, y and z; otherwise they are the first three.

    Parameters
    ----------
    path : Path
        The file: white space, comma, semicolon or tab between the numbers; ``#`` and ``//`` begin comments.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Raises
    ------
    ReadError
        If a line is no row of numbers or there are fewer than three columns.
    """
    layout, rows = read_table(path, expected="x, y, z")
    named = {name: i for i, name in reversed(list(enumerate(layout.names)))}
    wanted = [named.get(axis, i) for i, axis in enumerate("xyz")] if {"x", "y", "z"} <= set(named) else [0, 1, 2]
    time = next((rows[:, i].copy() for name, i in named.items() if name in TIME_COLUMNS), None)
    if progress is not None:
        progress(1.0)
    return RawScan(np.ascontiguousarray(rows[:, wanted]), time)


def read_pts(path: Path, progress: Callable[[float], None] | None = None) -> RawScan:
    """Read a PTS file: a line with the number of points, then x, y, z and more a line; several such blocks may follow each other.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Raises
    ------
    ReadError
        If the counts and the lines do not agree.
    """
    blocks: list[NDArray[np.float64]] = []
    line = 0
    with path.open("rb") as file:
        while head := file.readline():
            line += 1
            if not head.strip():
                continue
            try:
                count = int(head)
            except ValueError:
                if blocks:
                    raise ReadError(f"{path}, line {line}: found more points than the count announces; export the PTS file again") from None
                return read_text(path, progress)
            rows = parse_rows(path, itertools.islice(file, count), first_line=line + 1) if count else np.zeros((0, 3))
            if len(rows) < count:
                raise ReadError(f"{path}: found {len(rows):,} of {count:,} announced points; the PTS file is cut short, copy it again")
            blocks.append(rows[:, :3])
            line += count
    if progress is not None:
        progress(1.0)
    return RawScan(np.concatenate(blocks) if blocks else np.zeros((0, 3)))


def read_table(path: Path, *, expected: str) -> tuple[TableLayout, NDArray[np.float64]]:
    """Read a text table of numbers with or without a header.

    Parameters
    ----------
    path : Path
        The file.
    expected : str
        Columns that are wanted at least, for messages.

    Returns
    -------
    layout : TableLayout
        How the table was written.
    rows : (n, c) float64
        The numbers.

    Raises
    ------
    ReadError
        If a line is no row of numbers or there are fewer than three columns; names the line.
    """
    layout = find_layout(path, expected=expected)
    with path.open("rb") as file:
        lines: Iterable[bytes] = itertools.islice(file, layout.skip, None)
        if layout.decimal_comma:
            lines = (line.replace(b",", b".") for line in lines)
        return layout, parse_rows(path, lines, delimiter=layout.delimiter, first_line=layout.skip + 1)


def find_layout(path: Path, *, expected: str) -> TableLayout:
    """Find header, delimiter and columns of a text table from its first lines.

    Parameters
    ----------
    path : Path
        The file.
    expected : str
        Columns that are wanted at least, for messages.

    Raises
    ------
    ReadError
        If the file is not text or no row of three numbers is found at its start.
    """
    names: tuple[str, ...] = ()
    with path.open("rb") as file:
        head = [file.readline(65536) for _ in range(HEAD_LINES)]
    if any(b"\0" in line for line in head):
        raise ReadError(f"{path}: found binary data, expected text with {expected} on each line; check what kind of file this is")
    first = ""
    for number, raw in enumerate(head):
        line = raw.decode("utf-8-sig", errors="replace").strip()
        content = line.lstrip("#/").strip()
        if not content:
            continue
        first = first or line
        delimiter = next((mark for mark in (";", "\t", ",") if mark in content), None)
        cells = [cell.strip() for cell in content.split(delimiter)]
        decimal_comma = delimiter == ";" and "," in content
        numbers = [_is_number(cell.replace(",", ".") if decimal_comma else cell) for cell in cells]
        if line == content and len(cells) >= 3 and all(numbers):
            return TableLayout(number, delimiter, decimal_comma, names, len(cells))
        if line == content and any(numbers):
            break
        names = tuple(re.sub(r"[^a-z0-9_].*$", "", cell.lower().strip('"')) for cell in cells)
    raise ReadError(f"{path}: found {first[:60]!r} at its start, expected {expected} as numbers on each line; check the file's columns")


def parse_rows(
    path: Path, lines: Iterable[bytes] | BinaryIO, *, delimiter: str | None = None, first_line: int = 1, max_rows: int | None = None
) -> NDArray[np.float64]:
    """Parse lines of numbers.

    Parameters
    ----------
    path : Path
        File that the lines come from, for messages.
    lines : iterable of bytes
        The lines.
    delimiter : str, optional
        Sign between the numbers; none: white space.
    first_line : int
        Number of the first line in the file, for messages.
    max_rows : int, optional
        Rows to read at most.

    Returns
    -------
    (n, c) float64

    Raises
    ------
    ReadError
        If a line is no row of numbers.
    """
    try:
        rows = np.loadtxt(lines, dtype=np.float64, delimiter=delimiter, comments="#", ndmin=2, max_rows=max_rows, encoding="utf-8")
    except ValueError as error:
        text = str(error)
        row = re.search(r"at row (\d+)", text)
        where = f", line {first_line + int(row.group(1))}" if row else ""
        found = re.match(r"could not convert string (.*) to float64", text)
        what = f"found {found.group(1)}" if found else f"the columns change ({text.split(';')[0]})" if "columns" in text else "found text"
        raise ReadError(f"{path}{where}: {what}, expected the same number of numbers on every line; correct or remove the line") from error
    return rows


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
