"""PCD files of the Point Cloud Library: ascii, binary and binary_compressed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.raw import RawScan
from indoor_bim.errors import ReadError

LETTERS = {"I": "i", "U": "u", "F": "f"}


def read_pcd(path: Path, progress: Callable[[float], None] | None = None) -> RawScan:
    """Read the points of a PCD file.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Raises
    ------
    ReadError
        If the header is not understood, has no x, y, z, or the body is cut short.
    """
    with path.open("rb") as file:
        header = _header(path, file)
        try:
            kind = header["DATA"][0]
            names = header["FIELDS"]
            sizes = header["SIZE"]
            types = header["TYPE"]
            counts = [int(value) for value in header.get("COUNT", ["1"] * len(names))]
            total = int(header["POINTS"][0]) if "POINTS" in header else int(header["WIDTH"][0]) * int(header["HEIGHT"][0])
            dtype = np.dtype([(f"{i}", f"<{LETTERS[t]}{s}", (c,)) for i, (t, s, c) in enumerate(zip(types, sizes, counts, strict=True))])
            position = [names.index(axis) for axis in "xyz"]
        except (KeyError, ValueError, IndexError, TypeError) as error:
            raise ReadError(f"{path}: the PCD header has no usable fields x, y, z; export it again as a point cloud") from error
        if total <= 0:
            raise ReadError(f"{path}: the file holds 0 points, expected a scan; export it again")
        if kind == "ascii":
            points = _ascii(path, file, counts, position)
        elif kind == "binary":
            points = _binary(path, file, dtype, position, total)
        elif kind == "binary_compressed":
            points = _compressed(path)
        else:
            raise ReadError(f"{path}: found PCD data of kind {kind!r}, expected ascii, binary or binary_compressed; export the file again")
    if len(points) != total:
        raise ReadError(f"{path}: found {len(points):,} of {total:,} announced points; the PCD file is cut short, copy it again")
    if progress is not None:
        progress(1.0)
    return RawScan(points)


def _header(path: Path, file: BinaryIO) -> dict[str, list[str]]:
    header: dict[str, list[str]] = {}
    for raw in iter(lambda: file.readline(4096), b""):
        words = raw.decode("ascii", errors="replace").split()
        if not words or words[0].startswith("#"):
            continue
        header[words[0]] = words[1:]
        if words[0] == "DATA":
            return header
        if len(header) > 30:
            break
    raise ReadError(f"{path}: found no PCD header at its start, expected a PCD file; check what kind of file this is")


def _ascii(path: Path, file: BinaryIO, counts: list[int], position: list[int]) -> NDArray[np.float64]:
    from indoor_bim.cloud.text import parse_rows

    rows = parse_rows(path, file)
    columns = [sum(counts[:i]) for i in position]
    if len(rows) and rows.shape[1] < sum(counts):
        raise ReadError(f"{path}: found {rows.shape[1]} columns, expected {sum(counts)} as in the PCD header; export the file again")
    return np.ascontiguousarray(rows[:, columns]) if len(rows) else np.zeros((0, 3))


def _binary(path: Path, file: BinaryIO, dtype: np.dtype, position: list[int], total: int) -> NDArray[np.float64]:
    present = min(total, (path.stat().st_size - file.tell()) // dtype.itemsize)
    table = np.fromfile(file, dtype=dtype, count=present)
    return np.stack([table[f"{i}"][:, 0].astype(np.float64) for i in position], axis=1)


def _compressed(path: Path) -> NDArray[np.float64]:
    try:
        import open3d
    except ImportError as error:
        raise ReadError(f"{path}: compressed PCD needs Open3D; install it (pip install open3d-cpu) or save as binary PCD") from error
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        cloud = open3d.io.read_point_cloud(path, format="pcd", remove_nan_points=False, remove_infinite_points=False)
    return np.array(cloud.points, dtype=np.float64)
