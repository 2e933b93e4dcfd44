"""What a building is called: by the scan, unless the file is called like any other."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

TELLS_NOTHING = frozenset(
    [
        "scan",
        "scans",
        "cloud",
        "clouds",
        "point",
        "points",
        "pointcloud",
        "pcd",
        "data",
        "raw",
        "laser",
        "lidar",
        "new",
        "full",
        "merged",
        "final",
        "export",
        "exported",
        "output",
        "the",
        "my",
        "map",
        "d",
    ]
)
"""Words of file names that say nothing about the building; digits do not either."""


def building_name(scan: Any, *, source: str) -> str:
    """Name of the scan's file; of its folder where the file is called "scan", "cloud" or the like.

    Parameters
    ----------
    scan : path or other
        What the scan was read from.
    source : str
        Name of the file, or what else the scan is called.

    Examples
    --------
    >>> building_name("school/gym.laz", source="gym.laz")
    'gym'
    >>> building_name("school/point_cloud_2.laz", source="point_cloud_2.laz")
    'school'
    """
    stem = Path(source).stem
    if not isinstance(scan, str | Path) or _tells(stem):
        return stem or "Building"
    folder = Path(scan).absolute().parent.name
    return folder if _tells(folder) else stem


def _tells(name: str) -> bool:
    """Whether any word of a name says something."""
    return any(word not in TELLS_NOTHING for word in re.findall(r"[^\W\d_]+", name.lower()))
