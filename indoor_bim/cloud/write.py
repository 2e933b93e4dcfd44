"""Write point clouds: LAS, LAZ and PLY with the same bytes for the same points."""

from __future__ import annotations

import os
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import ArrayLike

from indoor_bim.errors import WriteError
from indoor_bim.frame import Frame

CREATION_DATE = date(2000, 1, 1)


def write_las(
    path: str | Path,
    points: ArrayLike,
    *,
    gps_time: ArrayLike | None = None,
    classification: ArrayLike | None = None,
    intensity: ArrayLike | None = None,
    frame: Frame | None = None,
    resolution: float = 0.001,
) -> None:
    """Write points as LAS 1.4 (point format 6), compressed where the extension is ``.laz``.

    The file appears whole or not at all, and holds the same bytes for the same points on every day.

    Parameters
    ----------
    path : str or Path
        The file.
    points : (n, 3) array_like
        Local coordinates, metres.
    gps_time : (n,) array_like, optional
        Time of each point, seconds.
    classification : (n,) array_like, optional
        ASPRS class of each point.
    intensity : (n,) array_like, optional
        Intensity, 0 to 65535.
    frame : Frame, optional
        Frame of the points; the file then holds scan coordinates.
    resolution : float
        Step of the written coordinates, in the unit of the file.

    Raises
    ------
    WriteError
        If the points do not fit the format or the file cannot be written.
    """
    import laspy

    path = Path(path)
    local = np.asarray(points, dtype=np.float64)
    xyz = local if frame is None else frame.to_scan(local)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or not np.isfinite(xyz).all():
        raise WriteError(f"{path}: found points of shape {xyz.shape}, expected finite points of shape (n, 3)")
    low = xyz.min(axis=0) if len(xyz) else np.zeros(3)
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.creation_date = CREATION_DATE
    header.system_identifier = header.generating_software = "indoor_bim"
    header.scales = np.full(3, resolution)
    header.offsets = np.floor(low)
    extent = float(np.ptp(xyz, axis=0).max()) if len(xyz) else 0.0
    if extent / resolution > 2**31 - 2:
        raise WriteError(f"{path}: found an extent of {extent:g}, too large for steps of {resolution:g}; take larger steps")
    record = laspy.ScaleAwarePointRecord.zeros(len(xyz), header=header)
    steps = np.rint((xyz - header.offsets) / resolution).astype(np.int32)
    record["X"], record["Y"], record["Z"] = steps[:, 0], steps[:, 1], steps[:, 2]
    record["return_number"] = record["number_of_returns"] = np.ones(len(xyz), dtype=np.uint8)
    for name, values in (("gps_time", gps_time), ("classification", classification), ("intensity", intensity)):
        if values is not None:
            record[name] = np.asarray(values)

    def write(file: BinaryIO) -> None:
        with laspy.open(file, mode="w", header=header, do_compress=path.suffix.lower() == ".laz", closefd=False) as writer:
            writer.write_points(record)

    _replace(path, write)


def write_ply(path: str | Path, points: ArrayLike, *, colours: ArrayLike | None = None) -> None:
    """Write points as a binary little-endian PLY file.

    Parameters
    ----------
    path : str or Path
        The file.
    points : (n, 3) array_like
        Coordinates; written as double.
    colours : (n, 3) array_like of uint8, optional
        Red, green and blue of each point, 0 to 255.

    Raises
    ------
    WriteError
        If the shapes do not fit or the file cannot be written.
    """
    path = Path(path)
    xyz = np.asarray(points, dtype=np.float64)
    rgb = None if colours is None else np.asarray(colours, dtype=np.uint8)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or (rgb is not None and rgb.shape != xyz.shape):
        raise WriteError(f"{path}: found points of shape {xyz.shape}, expected (n, 3) and as many colours")
    names = ["x", "y", "z"] + ([] if rgb is None else ["red", "green", "blue"])
    table = np.zeros(len(xyz), dtype=[(name, "<f8" if name in "xyz" else "u1") for name in names])
    for name, column in zip(names, np.hstack([xyz, *([] if rgb is None else [rgb])]).T, strict=True):
        table[name] = column
    properties = "".join(f"property {'double' if name in 'xyz' else 'uchar'} {name}\n" for name in names)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(xyz)}\n{properties}end_header\n".encode()

    def write(file: BinaryIO) -> None:
        file.write(head)
        file.write(table.tobytes())

    _replace(path, write)


def _replace(path: Path, write: Callable[[BinaryIO], None]) -> None:
    """Write a file beside its place, then move it there."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            with beside.open("wb") as file:
                write(file)
            os.replace(beside, path)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise WriteError(f"{path}: cannot be written ({error.strerror or error}); check the folder and the disk") from error
