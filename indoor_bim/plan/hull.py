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


def stand_before_others(faces: Segments, rooms: shapely.Geometry, *, away: float = 0.3, far: float = 15.0) -> NDArray[np.bool_]:
    """Tell which faces away from all rooms have something of the building farther behind them: they belong to inner walls.

    Parameters
    ----------
    faces : Segments
        Faces with free space to the left, metres.
    rooms : shapely geometry
        Closed rooms.
    away : float
        Faces whose middle is nearer to a room belong to it, metres.
    far : float
        How far behind the face is looked, metres.

    Returns
    -------
    (m,) bool
        True where a room, or another face, lies behind most of the face.

    Examples
    --------
    >>> import shapely
    >>> three = Segments.from_ends(np.array([[20.0, 0], [26, 0], [20, 8]]), np.array([[20.0, 8], [26, 8], [26, 8]]))
    >>> stand_before_others(three, shapely.box(0, -5, 10, -1)).tolist()
    [True, False, False]
    """
    import shapely

    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    lines = shapely.linestrings(np.stack([faces.p, faces.q], axis=1))
    loose = (
        shapely.distance(shapely.points((faces.p + faces.q) / 2), rooms) > away if not rooms.is_empty else np.ones(len(faces), dtype=bool)
    )
    found = np.zeros(len(faces), dtype=bool)
    for k in np.flatnonzero(loose):
        spots = faces.p[k] + share[:, None] * (faces.q[k] - faces.p[k])
        rays = shapely.linestrings(np.stack([spots - 0.7 * faces.normal[k], spots - far * faces.normal[k]], axis=1))
        others = shapely.union_all([*np.delete(lines, k), rooms])
        found[k] = shapely.intersects(rays, others).mean() > 0.5
    return found
