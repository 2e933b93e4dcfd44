"""LAS and LAZ files of any size, read in bounded memory into as many points as later stages can hold."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.density_limit import PIECE, SIDE, DensityLimit
from indoor_bim.cloud.las import LasFile, open_las, read_las
from indoor_bim.cloud.raw import RawScan
from indoor_bim.cloud.units import METRES_PER_UNIT, TALLEST_SCAN
from indoor_bim.threads import even_slices, in_threads, threads_for

if TYPE_CHECKING:
    from indoor_bim.cloud.density import DensitySample

logger = logging.getLogger(__name__)


def sample_las(path: Path, *, limit: DensityLimit, unit: str = "auto", progress: Callable[[float], None] | None = None) -> RawScan:
    """Read a LAS or LAZ file and keep no more points than a limit allows.

    Parameters
    ----------
    path : Path
        The file.
    limit : DensityLimit
        How many points to keep.
    unit : str
        Unit of the coordinates; ``auto``: what the file declares, or what its extent suggests.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Returns
    -------
    RawScan
        The kept points in the order of the file; all of them, and `RawScan.per_cube` None, if there are few.

    Raises
    ------
    ReadError
        As `read_las`.
    """
    with open_las(path) as file:
        few = file.count <= limit.above
    if few:
        return read_las(path, progress)
    from indoor_bim.cloud.density import TooManyCubesError

    side = SIDE
    while True:
        with open_las(path) as file:
            try:
                return _sample(file, limit, side, unit, progress)
            except TooManyCubesError:
                side *= 2


def _sample(file: LasFile, limit: DensityLimit, side: float, unit: str, progress: Callable[[float], None] | None) -> RawScan:
    from indoor_bim.cloud.density import DensitySample

    crs, declared = file.reference()
    metres = np.abs(file.header.scales) * _metres_per_unit(file, unit, declared)
    kind = np.dtype([(name, file.kind[name]) for name in ("intensity", file.classes, "gps_time") if name in (file.kind.names or ())])
    sample = DensitySample(side=np.maximum(np.rint(side / metres), 1).astype(np.int64), limit=limit, kind=kind)
    records = file.records(size=PIECE, at_once=2, progress=progress)
    record = next(records, None)
    with ThreadPoolExecutor(1) as pool:
        while record is not None:
            adding = _begin_to_add(sample, file.steps(record), record, pool)
            record = next(records, None)
            adding.result()
    kept = sample.kept()
    points = _coordinates(file, sample, kept)
    logger.info("kept %s of %s points, %d or fewer of each cube of %.0f cm", f"{len(points):,}", f"{file.count:,}", sample.most, 100 * side)
    values = {name: sample.attribute(name, kept) for name in kind.names or ()}
    times, classes, intensity = values.get("gps_time"), file.class_of(values), values["intensity"]
    return RawScan(
        points,
        gps_time=times if times is not None and times.any() else None,
        classification=classes if classes.any() else None,
        crs=crs,
        unit=declared,
        per_cube=sample.most,
        intensity=intensity if intensity.any() else None,
    )


def _begin_to_add(sample: DensitySample, steps: NDArray[np.int32], records: NDArray[np.void], pool: Executor) -> Future[None]:
    """Points being added, once that needs Python's lock no more: the decoder keeps the lock while it works on the next piece."""
    begun = Event()
    adding = pool.submit(sample.add, steps, records, begun.set)
    adding.add_done_callback(lambda _: begun.set())
    begun.wait()
    return adding


def _coordinates(file: LasFile, sample: DensitySample, places: NDArray[np.int32], *, at_once: int = 1 << 15) -> NDArray[np.float64]:
    """Coordinates (k, 3) of the points at some places, some at a time: whole ones of all of them would take half as much memory again."""
    points, threads = np.zeros((len(places), 3)), threads_for(len(places))

    def place(part: slice) -> None:
        for start in range(part.start, part.stop, at_once):
            few = slice(start, min(start + at_once, part.stop))
            file.coordinates(sample.steps(places[few]), points[few])

    in_threads(place, even_slices(len(places), threads), threads=threads)
    return points


def _metres_per_unit(file: LasFile, unit: str, declared: str | None) -> float:
    if unit != "auto":
        return METRES_PER_UNIT[unit]
    extent: NDArray[np.float64] = np.asarray(file.header.maxs) - np.asarray(file.header.mins)
    if declared is None and (extent > TALLEST_SCAN).all():
        return METRES_PER_UNIT["mm"]
    return METRES_PER_UNIT[declared or "m"]
