"""Inside and outside of the whole building in plan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

if TYPE_CHECKING:
    import shapely

PROBE = 1.0  # metres behind a face: what lies there is the outside, if nothing of the building does
SAMPLES = 10  # places along a face that are probed


def building_hull(parts: Sequence[shapely.Polygon], *, reach: float = 2.0) -> shapely.Geometry:
    """Everything that belongs to a building: its rooms, and the gaps, bays and courts too narrow to be outside.

    Parameters
    ----------
    parts : sequence of shapely.Polygon
        Rooms, and walls where they are known, metres.
    reach : float
        Half the width of the widest gap that is filled, metres.

    Examples
    --------
    >>> import shapely
    >>> building_hull([shapely.box(0, 0, 4, 4), shapely.box(7, 0, 11, 4)]).bounds
    (0.0, 0.0, 11.0, 4.0)
    """
    import shapely

    grown = shapely.union_all(list(parts)).buffer(reach, join_style="mitre").buffer(-reach, join_style="mitre")
    return shapely.union_all([shapely.Polygon(part.exterior) for part in shapely.get_parts(grown) if part.geom_type == "Polygon"])


def looks_outside(faces: Segments, hull: shapely.Geometry, *, depth: float = PROBE) -> NDArray[np.bool_]:
    """Tell which faces have the outside behind them.

    Parameters
    ----------
    faces : Segments
        Faces with free space to the left, metres.
    hull : shapely geometry
        The building (`building_hull`).
    depth : float
        Distance behind the face that is probed, metres.

    Returns
    -------
    (m,) bool
        True where most of what lies behind the face is not part of the building.
    """
    import shapely

    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    if hull.is_empty:
        return np.zeros(len(faces), dtype=bool)
    line = faces.p[:, None] + share[None, :, None] * (faces.q - faces.p)[:, None]
    behind = line - depth * faces.normal[:, None]
    inside = shapely.contains_xy(hull, behind[..., 0], behind[..., 1])
    outside: NDArray[np.bool_] = inside.mean(axis=1) < 0.2
    return outside
