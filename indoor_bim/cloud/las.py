"""LAS and LAZ files (ASPRS LAS 1.0 to 1.4, COPC included)."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.raw import RawScan
from indoor_bim.errors import ReadError
from indoor_bim.threads import even_slices, in_threads, threads_for

CHUNK = 1_000_000
FEW_POINTS = 20_000
"""So many points are scaled in numpy, sooner than the compiled loop is loaded."""
LINEAR_UNITS = {9001: "m", 9002: "ft", 9003: "us-ft"}
PROJECTED_CRS_KEY, LINEAR_UNITS_KEY = 3072, 3076


def read_las(path: Path, progress: Callable[[float], None] | None = None) -> RawScan:
    """Read a LAS or LAZ file in chunks.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Raises
    ------
    ReadError
        If the file is no LAS, damaged or cut short.
    """
    with open_las(path) as file:
        points = np.zeros((file.count, 3))
        gps_time = np.zeros(file.count) if file.has_time else None
        classes = np.zeros(file.count, dtype=np.uint8)
        intensity = np.zeros(file.count, dtype=np.uint16)
        done = 0
        for record in file.records(size=CHUNK, progress=progress):
            part = slice(done, done + len(record))
            file.coordinates(file.steps(record), points[part])
            if gps_time is not None:
                gps_time[part] = record["gps_time"]
            classes[part] = file.class_of(record)
            intensity[part] = record["intensity"]
            done += len(record)
        crs, unit = file.reference()
    if gps_time is not None and not gps_time.any():
        gps_time = None
    measured = intensity if intensity.any() else None
    return RawScan(points, gps_time, classes if classes.any() else None, crs=crs, unit=unit, intensity=measured)


def iterate_chunks(path: str | Path, *, size: int = CHUNK) -> Iterator[NDArray[np.float64]]:
    """Coordinates of a LAS or LAZ file piece by piece, in memory that does not grow with the file.

    Parameters
    ----------
    path : str or Path
        The file.
    size : int
        Most points of a piece.

    Yields
    ------
    (k, 3) float64
        Coordinates as they stand in the file, in its unit and axes.

    Raises
    ------
    ReadError
        As `read_las`.
    """
    with open_las(Path(path)) as file:
        for record in file.records(size=size):
            yield file.coordinates(file.steps(record))


class LasFile:
    """A LAS or LAZ file that is open for reading; see `open_las`.

    Parameters
    ----------
    path : Path
        The file.
    reader : laspy.LasReader
        Its reader.
    """

    def __init__(self, path: Path, reader: Any) -> None:
        self.path, self._reader, self.header = path, reader, reader.header
        self.count = int(reader.header.point_count)
        self.kind = reader.header.point_format.dtype()
        self.has_time = "gps_time" in self.kind.names
        self.classes = "raw_classification" if "raw_classification" in self.kind.names else "classification"

    def records(
        self, *, size: int = CHUNK, at_once: int = 1, progress: Callable[[float], None] | None = None
    ) -> Iterator[NDArray[np.void]]:
        """Pieces of at most `size` point records; `ReadError` if they are fewer than announced.

        Of compressed files so many pieces are kept `at_once`; then the room of the first is used again.
        """
        done, turn = 0, cycle(range(at_once))
        room = np.zeros((at_once, min(size, self.count) * self.kind.itemsize if self.header.are_points_compressed else 0), dtype=np.uint8)
        while done < self.count:
            count = min(size, self.count - done)
            if self.header.are_points_compressed:
                piece = room[next(turn), : count * self.kind.itemsize]
                self._reader.point_source.decompressor.decompress_many(piece)
                records = piece.view(self.kind)
            else:
                records = self._reader.read_points(count).array
                if not len(records):
                    raise ReadError(_damaged(self.path, f"found {done:,} of the {self.count:,} points that the header announces"))
            yield records
            done += len(records)
            if progress is not None:
                progress(done / self.count)

    def steps(self, records: NDArray[np.void]) -> NDArray[np.int32]:
        """Whole coordinates (n, 3) of point records, a view: they stand at their beginning in every format."""
        layout = np.dtype({"names": ["xyz"], "formats": [("<i4", 3)], "offsets": [0], "itemsize": self.kind.itemsize})
        steps: NDArray[np.int32] = records.view(layout)["xyz"]
        return steps

    def class_of(self, records: Any) -> NDArray[np.uint8]:
        """Class of each of some records; in the old formats it shares its byte with flags."""
        found: NDArray[np.uint8] = records[self.classes]
        return found & np.uint8(0x1F) if self.classes == "raw_classification" else found

    def coordinates(self, steps: NDArray[np.int32], out: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """Coordinates (n, 3) of whole ones."""
        points = np.zeros(steps.shape) if out is None else out
        scales, offsets = np.array(self.header.scales, dtype=np.float64), np.array(self.header.offsets, dtype=np.float64)
        if len(steps) <= FEW_POINTS:
            np.multiply(steps, scales, out=points)
            points += offsets
            return points
        from indoor_bim.cloud.point_loops import place_steps

        threads = threads_for(len(steps))
        in_threads(lambda part: place_steps(steps[part], scales, offsets, points[part]), even_slices(len(steps), threads), threads=threads)
        return points

    def reference(self) -> tuple[str | None, str | None]:
        """Coordinate reference system and unit."""
        return _reference(self.header, list(self.header.vlrs) + list(self.header.evlrs or []))


@contextmanager
def open_las(path: Path) -> Iterator[LasFile]:
    """Open a LAS or LAZ file; it is closed when the block is left.

    Raises
    ------
    ReadError
        If the file is no LAS, damaged or cut short, also while it is read in the block.
    """
    _check_signature(path)
    with _damage_named(path), _open(path) as reader:
        yield LasFile(path, reader)


@contextmanager
def _damage_named(path: Path) -> Iterator[None]:
    """Whatever goes wrong while decoding is a `ReadError`."""
    try:
        yield
    except (ReadError, MemoryError):
        raise
    except Exception as error:
        raise ReadError(_damaged(path, str(error))) from error
    except BaseException as error:  # the LAZ decoder's panics are no Exceptions
        if type(error).__name__ != "PanicException":
            raise
        raise ReadError(_damaged(path, "the LAZ decoder gave up")) from error


def _check_signature(path: Path) -> None:
    with path.open("rb") as file:
        if file.read(4) != b"LASF":
            raise ReadError(f"{path}: found no LAS signature at its start, expected a LAS or LAZ file; check what kind of file this is")
    _check_header(path)


def _check_header(path: Path) -> None:
    """Refuse offsets and counts that the file cannot hold, before they are believed and memory is asked for."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(375)
        if len(head) < 227:
            raise ReadError(_damaged(path, f"found {size:,} bytes, less than a header"))
        header_size, start, records = struct.unpack_from("<HII", head, 94)
        extended_start, extended = struct.unpack_from("<QI", head, 235) if head[25] >= 4 and len(head) == 375 else (0, 0)
        file.seek(start)
        table = struct.unpack("<q", file.read(8).ljust(8, b"\0"))[0] if head[104] & 0x80 else 0
        room = header_size + 54 * records <= start <= size and (not extended or extended_start + 60 * extended <= size)
        if not room or not (table == -1 or 0 <= table <= size - 8 * bool(table)):
            raise ReadError(_damaged(path, f"the header points behind the end of the file at {size:,} bytes"))
        file.seek(table if table > 0 else size)
        chunks = struct.unpack("<II", file.read(8).ljust(8, b"\0"))[1]
        if chunks > size:
            raise ReadError(_damaged(path, f"its table announces {chunks:,} chunks"))


def _damaged(path: Path, found: str) -> str:
    return f"{path}: the LAS/LAZ file is damaged or cut short ({found.strip().rstrip('.')}); copy or export it again"


def _open(path: Path) -> Any:
    """Reader of a file that can hold what its header says; it decodes coordinates, time, class and intensity only."""
    import laspy

    wanted = laspy.DecompressionSelection
    needed = wanted.XY_RETURNS_CHANNEL | wanted.Z | wanted.CLASSIFICATION | wanted.GPS_TIME | wanted.INTENSITY
    reader = laspy.open(path, decompression_selection=needed)
    header, size = reader.header, path.stat().st_size
    scales, offsets = np.asarray(header.scales), np.asarray(header.offsets)
    fault = None
    if not (np.isfinite(scales).all() and np.isfinite(offsets).all() and (scales != 0).all()):
        fault = f"scale factors {scales.tolist()}, offsets {offsets.tolist()}"
    elif header.point_count * header.point_format.size > 200 * max(size, 1) + 10_000_000:
        fault = f"the header announces {header.point_count:,} points, far more than {size:,} bytes can hold"
    if fault or header.point_count == 0:
        reader.close()
        raise ReadError(_damaged(path, fault) if fault else f"{path}: the file holds 0 points, expected a scan; export it again")
    return reader


def _reference(header: Any, records: list[Any]) -> tuple[str | None, str | None]:
    """Coordinate reference system and unit from the WKT record or the GeoTIFF keys."""
    for record in records:
        text = getattr(record, "string", None)
        if record.record_id == 2112 and record.user_id.startswith("LASF_Projection") and text:
            return parse_wkt(text)
    for record in records:
        if record.record_id == 34735 and hasattr(record, "geo_keys"):
            keys = {key.id: key.value_offset for key in record.geo_keys if key.tiff_tag_location == 0}
            code = keys.get(PROJECTED_CRS_KEY)
            return f"EPSG:{code}" if code and code != 32767 else None, LINEAR_UNITS.get(keys.get(LINEAR_UNITS_KEY, 0))
    return None, None


def parse_wkt(text: str) -> tuple[str | None, str | None]:
    """Coordinate reference system and unit of the projected part of a well-known text.

    Parameters
    ----------
    text : str
        WKT 1 or WKT 2 of a projected, geographic or compound system.

    Returns
    -------
    crs : str or None
        ``EPSG:code``.
    unit : str or None
        ``m``, ``ft`` or ``us-ft``.

    Examples
    --------
    >>> parse_wkt('PROJCS["UTM 32N",GEOGCS["ETRS89",AUTHORITY["EPSG","4258"]],UNIT["metre",1],AUTHORITY["EPSG","25832"]]')
    ('EPSG:25832', 'm')
    """
    start = re.search(r"\b(?:PROJCS|PROJCRS|PROJECTEDCRS)\s*\[", text)
    body = _node(text, start.end()) if start else text[text.find("[") + 1 :]
    own = _drop_children(body)
    code = re.findall(r'(?:AUTHORITY|ID)\s*\[\s*"EPSG"\s*,\s*"?(\d+)"?', own)
    factors = [float(value) for value in re.findall(r'UNIT\s*\[\s*"[^"]*"\s*,\s*([0-9.eE+-]+)', own)] if start else []
    known = {"m": 1.0, "ft": 0.3048, "us-ft": 1200 / 3937}
    unit = next((name for factor in factors for name, metres in known.items() if abs(factor / metres - 1) < 1e-7), None)
    return (f"EPSG:{code[-1]}" if code else None), unit


def _node(text: str, start: int) -> str:
    """Text of a WKT node from behind its opening bracket to the closing one."""
    depth = 1
    for match in re.finditer(r'"[^"]*"|[\[\]]', text[start:]):
        depth += {"[": 1, "]": -1}.get(match.group(), 0)
        if depth == 0:
            return text[start : start + match.start()]
    return text[start:]


def _drop_children(body: str) -> str:
    """WKT node without the parts that carry codes and units of their own."""
    for name in ("GEOGCS", "GEOGCRS", "GEODCRS", "BASEGEOGCRS", "BASEGEODCRS", "CONVERSION", "VERT_CS", "VERTCRS"):
        while match := re.search(rf"\b{name}\s*\[", body):
            body = body[: match.start()] + body[match.end() + len(_node(body, match.end())) + 1 :]
    return body
