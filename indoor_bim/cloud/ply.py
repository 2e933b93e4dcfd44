"""PLY files, ascii and binary."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.raw import RawScan, as_intensity
from indoor_bim.errors import ReadError

TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
TIME_NAMES = ("gps_time", "gpstime", "time", "timestamp", "scalar_gpstime", "scalar_time", "scalar_timestamp")
INTENSITY_NAMES = ("intensity", "scalar_intensity", "reflectance", "scalar_reflectance")
CLASS_NAMES = ("classification", "class", "label", "scalar_classification")


@dataclass(frozen=True, slots=True)
class Element:
    """One element of a PLY header: its name, count and scalar properties; None for a list property."""

    name: str
    count: int
    properties: tuple[tuple[str, str | None], ...]


def read_ply(path: Path, progress: Callable[[float], None] | None = None) -> RawScan:
    """Read the vertices of a PLY file.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Raises
    ------
    ReadError
        If the header is no PLY header, has no x, y, z, or the body is cut short.
    """
    with path.open("rb") as file:
        kind, elements = _header(path, file)
        before = elements[: next((i for i, e in enumerate(elements) if e.name == "vertex"), 0)]
        vertex = next((element for element in elements if element.name == "vertex"), None)
        names = [name for name, _ in vertex.properties] if vertex else []
        if vertex is None or not {"x", "y", "z"} <= set(names):
            raise ReadError(f"{path}: found no vertices with x, y and z in the PLY header, expected a point cloud; export it as points")
        if vertex.count == 0:
            raise ReadError(f"{path}: the file holds 0 points, expected a scan; export it again")
        if any(dtype is None for element in (*before, vertex) for _, dtype in element.properties) and kind != "ascii":
            raise ReadError(f"{path}: the PLY file has lists before or in its vertices; export it as plain points")
        table: Any = _ascii(path, file, before, vertex) if kind == "ascii" else _binary(path, file, ORDERS[kind], before, vertex)
    column = {name.lower(): table[name] for name in names}
    points = np.stack([np.asarray(column[axis], dtype=np.float64) for axis in "xyz"], axis=1)
    time = next((np.asarray(column[name], dtype=np.float64) for name in TIME_NAMES if name in column), None)
    classes = next((column[name] for name in CLASS_NAMES if name in column), None)
    strength = next((as_intensity(column[name]) for name in INTENSITY_NAMES if name in column), None)
    if progress is not None:
        progress(1.0)
    return RawScan(points, time, as_classes(classes), intensity=strength)


def as_classes(values: NDArray | None) -> NDArray[np.uint8] | None:
    """Classification codes as uint8, or None where the values are no codes from 0 to 255."""
    if values is None or not ((values >= 0) & (values <= 255)).all() or not (values == np.floor(values)).all():
        return None
    return values.astype(np.uint8)


def _header(path: Path, file: BinaryIO) -> tuple[str, list[Element]]:
    if file.readline().strip() != b"ply":
        raise ReadError(f"{path}: found no PLY signature at its start, expected a PLY file; check what kind of file this is")
    kind = ""
    elements: list[Element] = []
    for raw in iter(lambda: file.readline(4096), b""):
        words = raw.decode("ascii", errors="replace").split()
        if words[:1] == ["end_header"]:
            if kind not in ORDERS:
                break
            return kind, elements
        try:
            if words[:1] == ["format"]:
                kind = words[1]
            elif words[:1] == ["element"]:
                elements.append(Element(words[1], int(words[2]), ()))
            elif words[:1] == ["property"]:
                entry = (words[-1], None) if words[1] == "list" else (words[2], TYPES[words[1]])
                last = elements.pop()
                elements.append(Element(last.name, last.count, (*last.properties, entry)))
        except (IndexError, KeyError, ValueError) as error:
            raise ReadError(
                f"{path}: found {' '.join(words)!r} in the PLY header, expected a property or element; export it again"
            ) from error
    raise ReadError(f"{path}: the PLY header has no end or no known format, expected {', '.join(ORDERS)}; export the file again")


def _cut_short(path: Path, found: int, expected: int) -> ReadError:
    return ReadError(f"{path}: found {found:,} of the {expected:,} announced points; the PLY file is cut short, copy it again")


def _binary(path: Path, file: BinaryIO, order: str, before: list[Element], vertex: Element) -> NDArray:
    def dtype(element: Element) -> np.dtype:
        return np.dtype([(name, order + str(kind)) for name, kind in element.properties])

    file.seek(sum(element.count * dtype(element).itemsize for element in before), io.SEEK_CUR)
    size = dtype(vertex).itemsize
    left = path.stat().st_size - file.tell()
    if left < vertex.count * size:
        raise _cut_short(path, max(left, 0) // size, vertex.count)
    return np.fromfile(file, dtype=dtype(vertex), count=vertex.count)


def _ascii(path: Path, file: BinaryIO, before: list[Element], vertex: Element) -> dict[str, NDArray]:
    from indoor_bim.cloud.text import parse_rows

    if any(kind is None for _, kind in vertex.properties):
        raise ReadError(f"{path}: the PLY file has lists in its vertices; export it as plain points")
    for _ in range(sum(element.count for element in before)):
        file.readline()
    rows = parse_rows(path, file, max_rows=vertex.count)
    if len(rows) < vertex.count:
        raise _cut_short(path, len(rows), vertex.count)
    if rows.shape[1] < len(vertex.properties):
        raise ReadError(f"{path}: found {rows.shape[1]} columns, expected {len(vertex.properties)} as in the PLY header; export it again")
    return {name: rows[:, i] for i, (name, _) in enumerate(vertex.properties)}
