"""From a file, an Open3D cloud or an array to the cloud that all stages share."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.density_limit import DensityLimit, kept_rows
from indoor_bim.cloud.extent import bounds
from indoor_bim.cloud.formats import READERS, read_raw
from indoor_bim.cloud.open3d import as_points
from indoor_bim.cloud.raw import RawScan
from indoor_bim.cloud.trajectory import read_trajectory
from indoor_bim.cloud.units import METRES_PER_UNIT, UP_ROTATIONS, looks_like_millimetres, looks_y_up
from indoor_bim.errors import ReadError
from indoor_bim.frame import Frame
from indoor_bim.threads import even_slices, in_threads, threads_for

FEW_POINTS = 20_000
"""So many points are shifted in numpy, sooner than the compiled loop is loaded."""

logger = logging.getLogger(__name__)

Progress = Callable[[float], None]
Trajectory = str | Path | ArrayLike | Literal[False] | None

__all__ = ["READERS", "as_cloud", "read", "read_trajectory"]


def read(
    path: str | Path,
    *,
    unit: str = "auto",
    up: str = "auto",
    crs: str | None = None,
    trajectory: Trajectory = None,
    limit: DensityLimit | None = None,
    progress: Progress | None = None,
) -> Cloud:
    """Read a scan: LAS, LAZ, PLY, PCD, XYZ, TXT, ASC, CSV, PTS or E57.

    The points come back in metres, z up, about a local origin: the centre of their bounding box, rounded to a whole metre,
    which `Cloud.frame` keeps, so that large coordinates lose nothing.

    Parameters
    ----------
    path : str or Path
        The file.
    unit : str
        Unit of the coordinates: ``m``, ``dm``, ``cm``, ``mm``, ``ft``, ``us-ft``, ``in``; ``auto``: what the file declares, millimetres
        where nothing else makes sense, else metres.
    up : str
        Axis that points up: ``x``, ``y``, ``z``; ``auto``: y where evident, else z.
    crs : str, optional
        Coordinate reference system as ``EPSG:code``; none: what the file declares.
    trajectory : str, Path, (m, 3 or 4) array_like or False, optional
        Scanner path (file or array: time, x, y, z) in the scan's coordinates; none: ``trajectory.csv`` beside the scan if there is one;
        False: no path.
    limit : DensityLimit, optional
        How many points to keep; none: all. LAS and LAZ files are then read in memory that does not grow with them.
    progress : callable, optional
        Told the share that has been read, 0 to 1.

    Returns
    -------
    Cloud

    Raises
    ------
    ReadError
        If the file is missing, empty, damaged, of an unknown kind or holds fewer than two different points; or if the
        trajectory is no table of positions.
    """
    path = Path(path)
    raw = read_raw(path, progress, unit=unit, limit=limit)
    if trajectory is None and (path.parent / "trajectory.csv").is_file() and path.name != "trajectory.csv":
        trajectory = path.parent / "trajectory.csv"
    return _cloud(raw, source=path.name, where=str(path), unit=unit, up=up, crs=crs, trajectory=trajectory, limit=limit, own=True)


def as_cloud(
    scan: Any,
    *,
    unit: str = "auto",
    up: str = "auto",
    crs: str | None = None,
    trajectory: Trajectory = None,
    limit: DensityLimit | None = None,
    progress: Progress | None = None,
) -> Cloud:
    """Cloud of whatever a user has at hand.

    Parameters
    ----------
    scan : str, Path, Cloud, open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 3) array_like
        The scan; not modified. A `Cloud` is returned as it is.
    unit, up, crs, trajectory, limit, progress
        As for `read`.

    Returns
    -------
    Cloud

    Raises
    ------
    ReadError
        As `read`; also if the object is no cloud.

    Examples
    --------
    >>> cloud = as_cloud([[500000.0, 5800000.0, 30.0], [500004.0, 5800003.0, 32.5], [500000.0, 5800003.0, 30.0]])
    >>> cloud.points[1].tolist(), cloud.frame.origin.tolist()
    ([2.0, 1.0, 1.5], [500002.0, 5800002.0, 31.0])
    """
    if isinstance(scan, Cloud):
        if trajectory is None:
            return scan
        path = None if trajectory is False else _local_path(trajectory, scan.frame)
        return replace(scan, trajectory=path)
    if isinstance(scan, (str, Path)):
        return read(scan, unit=unit, up=up, crs=crs, trajectory=trajectory, limit=limit, progress=progress)
    try:
        points = as_points(scan)
    except (TypeError, ValueError) as error:
        raise ReadError(f"scan: {error}; pass a path, an Open3D cloud or an (n, 3) array") from error
    if points.shape[1] != 3:
        raise ReadError(f"scan: found points with {points.shape[1]} coordinates, expected x, y and z; pass an (n, 3) array")
    return _cloud(RawScan(points), source="scan", where="scan", unit=unit, up=up, crs=crs, trajectory=trajectory, limit=limit, own=False)


def _cloud(
    raw: RawScan,
    *,
    source: str,
    where: str,
    unit: str,
    up: str,
    crs: str | None,
    trajectory: Trajectory,
    limit: DensityLimit | None,
    own: bool,
) -> Cloud:
    if unit != "auto" and unit not in METRES_PER_UNIT:
        raise ReadError(f"{where}: found the unit {unit!r}, expected auto or one of {', '.join(METRES_PER_UNIT)}; correct the option")
    if up != "auto" and up not in UP_ROTATIONS:
        raise ReadError(f"{where}: found the up axis {up!r}, expected auto or one of {', '.join(UP_ROTATIONS)}; correct the option")
    warnings: list[str] = []
    points = raw.points
    finite: slice | NDArray[np.bool_] = slice(None)
    low, high = _corners(points)
    kind = "not numbers" if np.isnan([low, high]).any() else "infinite"
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        finite = np.logical_and.reduce(np.isfinite(points), axis=1)
        dropped = len(points) - len(points[finite])
        warnings.append(f"{dropped:,} of {len(points):,} points have coordinates that are not finite; they were left out")
        points = points[finite]
        low, high = _corners(points)
    _check_points(points, low, high, where=where, dropped=len(raw.points) - len(points), kind=kind)
    axis = up if up != "auto" else "y" if looks_y_up(points) else "z"
    if up == "auto" and axis == "y":
        warnings.append("the scan has its floors and ceilings across the y axis: y was taken as up (option up)")
    name = unit if unit != "auto" else raw.unit or "m"
    if unit == "auto" and name == "m" and looks_like_millimetres(points, up=axis):
        name = "mm"
        height = float(high["xyz".index(axis)] - low["xyz".index(axis)])
        warnings.append(f"the scan is {height:,.0f} units high: the unit was taken as millimetres (option unit)")
    elif unit == "auto" and name != "m":
        warnings.append(f"the file declares the unit {name}: it was taken (option unit)")
    scale = METRES_PER_UNIT[name]
    origin = np.round(0.5 * (low + high) * scale) / scale + 0.0
    frame = Frame(origin, np.array(UP_ROTATIONS[axis]), scale, np.zeros(3))
    times = None if raw.gps_time is None else raw.gps_time[finite]
    classes = None if raw.classification is None else raw.classification[finite]
    intensity = None if raw.intensity is None else raw.intensity[finite]
    per_cube = raw.per_cube
    if limit is not None and per_cube is None and len(points) > limit.above:
        kept, per_cube = kept_rows(points, limit=limit, metres=scale)
        points = points[kept]
        times, classes = None if times is None else times[kept], None if classes is None else classes[kept]
        intensity = None if intensity is None else intensity[kept]
    path = None
    if trajectory is not None and trajectory is not False:
        path = _local_path(trajectory, frame)
    elif trajectory is None and raw.stations is not None:
        path = _local_path(raw.stations, frame)
    for message in warnings:
        logger.info("%s: %s", source, message)
    return Cloud(
        points=_to_local(points, frame, own=own),
        frame=frame,
        gps_time=times,
        classification=classes,
        trajectory=path,
        source=source,
        crs=crs or raw.crs,
        warnings=tuple(warnings),
        derived={} if per_cube is None else {"read.per_cube": per_cube},
        intensity=intensity,
    )


def _corners(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return bounds(points) if len(points) else (np.zeros(3), np.zeros(3))


def _check_points(points: NDArray, low: NDArray, high: NDArray, *, where: str, dropped: int, kind: str) -> None:
    advice = "expected a scan of a building; check the file or export it again"
    if len(points) == 0 and dropped:
        raise ReadError(f"{where}: found no point with finite coordinates among {dropped:,} ({kind}), {advice}")
    if len(points) == 0:
        raise ReadError(f"{where}: found 0 points, {advice}")
    if len(points) == 1:
        raise ReadError(f"{where}: found a single point, {advice}")
    if (low == high).all():
        raise ReadError(f"{where}: found {len(points):,} points that are all equal, {advice}")


def _to_local(points: NDArray[np.float64], frame: Frame, *, own: bool) -> NDArray[np.float64]:
    """Points in the local frame, in place if they may be changed; turning by quarter turns is a choice of columns: nothing is rounded."""
    if len(points) > FEW_POINTS:
        from indoor_bim.cloud.point_loops import localise

        source = np.ascontiguousarray(points)
        local = source if own and source.flags.writeable else np.zeros(points.shape)
        threads = threads_for(len(points))
        in_threads(
            lambda part: localise(source[part], frame.origin, frame.scale, local[part]), even_slices(len(points), threads), threads=threads
        )
    else:
        local = (points - frame.origin) * frame.scale
    if not np.array_equal(frame.rotation, np.eye(3)):
        column = np.argmax(np.abs(frame.rotation), axis=1)
        local = local[:, column] * frame.rotation[np.arange(3), column]
    return local


def _local_path(trajectory: Trajectory, frame: Frame) -> NDArray[np.float64]:
    if isinstance(trajectory, (str, Path)):
        path = read_trajectory(trajectory)
    else:
        path = np.asarray(trajectory, dtype=np.float64)
        if path.ndim != 2 or path.shape[1] not in (3, 4):
            raise ReadError(f"trajectory: found an array of shape {path.shape}, expected (m, 4): t, x, y, z, or (m, 3): x, y, z")
    times = path[:, :1] if path.shape[1] == 4 else np.full((len(path), 1), np.nan)
    return np.concatenate([times, frame.to_local(path[:, -3:])], axis=1)
