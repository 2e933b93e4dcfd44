"""Pictures of where a scan has points in plan, to lie under the plan that was made of it."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.export.plan_style import Underlay
from indoor_bim.frame import Frame
from indoor_bim.model import Building, Storey

CELL = 0.02
MARGIN = 0.5
_INK = (70, 110, 160)
_FULL = 0.6  # share of the height bins of a cell that must be hit for full ink
_BIN = 0.10
_MOST_PIXELS = 6000


def scan_underlays(building: Building, cloud: Cloud) -> dict[str, Underlay]:
    """Draw the scan behind each storey of a building.

    Parameters
    ----------
    building : Building
        Model of the scan, metres.
    cloud : Cloud
        The scan.

    Returns
    -------
    dict of str to Underlay
        Pictures by the identifier of the storey; storeys without points have none.
    """
    to_model = Frame.from_matrix(building.transform_cloud_to_model).matrix @ np.linalg.inv(cloud.frame.matrix)
    points = cloud.points @ to_model[:3, :3].T + to_model[:3, 3]
    pictures = ((storey.id, storey_density(storey, points)) for storey in building.storeys)
    return {id: picture for id, picture in pictures if picture is not None}


def storey_density(storey: Storey, points: NDArray[np.float64]) -> Underlay | None:
    """Draw how much of the height between floor and ceiling has points, cell by cell.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    points : (n, 3) float64
        Scan in model coordinates, metres.

    Returns
    -------
    Underlay or None
        Picture with a clear background; None when the storey has no points.
    """
    from PIL import Image

    low, high = storey.elevation + _BIN, storey.elevation + storey.height - _BIN
    corners = np.array([corner for wall in storey.walls for corner in wall.footprint] or points[:, :2])
    least, most = corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN
    inside = (points[:, 2] > low) & (points[:, 2] < high) & (points[:, :2] > least).all(axis=1) & (points[:, :2] < most).all(axis=1)
    if not inside.any():
        return None
    cell = max(CELL, float((most - least).max()) / _MOST_PIXELS)
    width, height = np.ceil((most - least) / cell).astype(int)
    bins = max(1, int((high - low) / _BIN))
    column = ((points[inside, 0] - least[0]) / cell).astype(np.int64)
    row = ((most[1] - points[inside, 1]) / cell).astype(np.int64)
    level = np.minimum(((points[inside, 2] - low) / (high - low) * bins).astype(np.int64), bins - 1)
    hit = np.unique((np.minimum(row, height - 1) * width + np.minimum(column, width - 1)) * bins + level) // bins
    count = np.bincount(hit, minlength=width * height).reshape(height, width)
    picture = np.zeros((height, width, 4), dtype=np.uint8)
    picture[..., :3] = _INK
    picture[..., 3] = (255 * np.clip(count / (_FULL * bins), 0, 1) ** 0.5).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(picture, "RGBA").save(stream, "PNG")
    bounds = (float(least[0]), float(most[1] - height * cell), float(least[0] + width * cell), float(most[1]))
    return Underlay(stream.getvalue(), bounds)
