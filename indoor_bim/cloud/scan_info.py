"""What a scan holds, before anything is made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from indoor_bim.cloud.read import Trajectory, as_cloud


@dataclass(frozen=True, slots=True)
class ScanInfo:
    """What a scan holds, before anything is made of it.

    Parameters
    ----------
    source : str
        Name of the file.
    points : int
        Number of finite points.
    extent : (3,) tuple of float
        Size along the local x, y and z axes, metres.
    origin : (3,) tuple of float
        Local origin in the scan's coordinates and unit.
    unit_metres : float
        Metres per unit of the scan.
    up : str
        Axis of the scan that points up.
    spacing : float
        Median distance to the nearest neighbour, metres.
    has_time : bool
        Whether the points have a time.
    classes : dict of int to int
        Number of points of each ASPRS class; empty without classification.
    crs : str or None
        Coordinate reference system, ``EPSG:code``.
    trajectory : int
        Number of scanner positions.
    warnings : tuple of str
        What was assumed or left out.
    """

    source: str
    points: int
    extent: tuple[float, float, float]
    origin: tuple[float, float, float]
    unit_metres: float
    up: str
    spacing: float
    has_time: bool
    classes: dict[int, int]
    crs: str | None
    trajectory: int
    warnings: tuple[str, ...]


def info(scan: Any, *, unit: str = "auto", up: str = "auto", crs: str | None = None, trajectory: Trajectory = None) -> ScanInfo:
    """Describe a scan.

    Parameters
    ----------
    scan : str, Path, Cloud, open3d.geometry.PointCloud, open3d.t.geometry.PointCloud or (n, 3) array_like
        The scan.
    unit, up, crs, trajectory
        As for `read`.

    Returns
    -------
    ScanInfo

    Raises
    ------
    ReadError
        As `read`.
    """
    from indoor_bim.cloud.spacing import point_spacing

    cloud = as_cloud(scan, unit=unit, up=up, crs=crs, trajectory=trajectory)
    size = np.ptp(cloud.points, axis=0)
    counts = np.bincount(cloud.classification) if cloud.classification is not None else np.zeros(0, dtype=np.int64)
    return ScanInfo(
        source=cloud.source,
        points=len(cloud),
        extent=(float(size[0]), float(size[1]), float(size[2])),
        origin=(float(cloud.frame.origin[0]), float(cloud.frame.origin[1]), float(cloud.frame.origin[2])),
        unit_metres=cloud.frame.scale,
        up="xyz"[int(np.argmax(np.abs(cloud.frame.rotation[2])))],
        spacing=point_spacing(cloud.points),
        has_time=cloud.gps_time is not None,
        classes={code: int(count) for code, count in enumerate(counts) if count},
        crs=cloud.crs,
        trajectory=0 if cloud.trajectory is None else len(cloud.trajectory),
        warnings=cloud.warnings,
    )
