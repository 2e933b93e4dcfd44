"""The file formats that a scan can come in: one registry from extension to reader."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from indoor_bim.cloud.density_limit import DensityLimit
from indoor_bim.cloud.e57 import read_e57
from indoor_bim.cloud.las import read_las
from indoor_bim.cloud.pcd import read_pcd
from indoor_bim.cloud.ply import read_ply
from indoor_bim.cloud.raw import RawScan
from indoor_bim.cloud.text import read_pts, read_text
from indoor_bim.errors import ReadError

Reader = Callable[[Path, Callable[[float], None] | None], RawScan]

READERS: Mapping[str, Reader] = MappingProxyType(
    {
        ".las": read_las,
        ".laz": read_las,
        ".ply": read_ply,
        ".pcd": read_pcd,
        ".xyz": read_text,
        ".txt": read_text,
        ".asc": read_text,
        ".csv": read_text,
        ".pts": read_pts,
        ".e57": read_e57,
    }
)


def read_raw(
    path: Path, progress: Callable[[float], None] | None = None, *, unit: str = "auto", limit: DensityLimit | None = None
) -> RawScan:
    """Read a scan in its own coordinates with the reader that its extension names.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable, optional
        Told the share that has been read, 0 to 1.
    unit : str
        Unit of the coordinates, see `indoor_bim.read`.
    limit : DensityLimit, optional
        How many points to keep, as far as the format can be read piece by piece: LAS and LAZ. Other files are read whole.

    Raises
    ------
    ReadError
        If the file is missing, empty, damaged or of an unknown kind.
    """
    known = ", ".join(READERS)
    if path.is_dir():
        raise ReadError(f"{path}: found a folder, expected a scan file ({known}); name the file itself")
    reader = READERS.get(path.suffix.lower())
    if not path.exists():
        raise ReadError(f"{path}: no such file, expected a scan ({known}); check the path")
    if reader is None:
        raise ReadError(f"{path}: found the extension {path.suffix or '(none)'!r}, expected one of {known}; convert or rename the file")
    try:
        if path.stat().st_size == 0:
            raise ReadError(f"{path}: the file is empty (0 bytes), expected a scan; copy or export it again")
        if limit is not None and reader is read_las:
            from indoor_bim.cloud.las_sample import sample_las

            return sample_las(path, limit=limit, unit=unit, progress=progress)
        return reader(path, progress)
    except OSError as error:
        raise ReadError(f"{path}: cannot be read ({error.strerror or error}); check its permissions and the disk") from error
