"""What rays and points tell of a hole in a wall: whether it reaches the floor, is glazed, or is filled by a leaf."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.holes import Hole
from indoor_bim.plan.opening_edges import Edge
from indoor_bim.plan.traces import Traces
from indoor_bim.plan.wall_points import PointsAround
from indoor_bim.plan.wall_rays import WallBox, WallRays

Ints = NDArray[np.int64]

THRESHOLD = 0.25  # metres: what begins lower than this reaches the floor
LOWEST_HIT = 0.08  # metres above the floor: lower points may be the floor's own
STRAY_SHARE = 0.1  # of the hits on the other face: a face with fewer was not seen
GLASS_DENSITY = 0.4  # of the hits on the wall around: panes return fewer rays than that, the back of a niche all
GLASS_INSET = 0.12  # metres next to the edges of a hole that frames and reveals take
PANE_SHARE = 0.05  # of the rays: panes return about a tenth, stray points are a hundredth
DEEPEST_PANE = 0.30  # metres behind a face
RING = 0.3  # metres around a hole
THICKEST_LEAF = 0.07  # metres
LEAF_SPREAD = 0.03  # metres: scatter of the depths of a closed leaf
FEW = 3  # rays
LOWEST_SILL = 0.05  # metres: what begins lower is a threshold
SILL_BAND = 0.03  # metres
FEW_ON_SILL = 8  # hits
HIDDEN_SHARE = 0.2  # of the rays per area that go into a hole: fewer below it are stray
HIDING_COLUMN = 0.05  # metres along a wall


def reaches_floor(hole: Hole, bottom: Edge, where: Traces, around: PointsAround, *, thickness: float) -> bool:
    """True where below the hole no face was hit, unless something hides it and hardly a ray went in there.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    bottom : Edge
        Its lower edge.
    where : Traces
        Rays at the wall.
    around : PointsAround
        Points around the wall.
    thickness : float
        Thickness of the wall, metres.
    """
    if hole.bottom < THRESHOLD:
        return True
    inset = min(0.1, hole.width / 4)
    start, end, low, high = hole.start + inset, hole.end - inset, LOWEST_HIT, min(bottom.place, hole.bottom) - 0.03

    below = (start, end, low, high)
    hits, entered = sum(where.hits_within(*below)), sum(where.entered_within(*below))
    if hits >= FEW and hits > entered:
        return False
    along, across, _ = around.within(*below)
    before = along[np.abs(across) > thickness / 2 + LEAF_SPREAD]
    columns = np.unique(np.floor((before - start) / HIDING_COLUMN))
    if len(columns) * HIDING_COLUMN < (end - start) / 2:
        return True
    inside = sum(where.entered_within(start, end, hole.bottom, hole.top))
    return entered / (high - low) > HIDDEN_SHARE * inside / hole.height


def low_sill(start: float, end: float, rays: WallRays, *, tolerance: float, thickness: float) -> float | None:
    """Level of the sill of a window that begins close above the floor; None where the floor goes on into the wall.

    Parameters
    ----------
    start, end : float
        Jambs, metres along the wall.
    rays : WallRays
        Rays at the wall, with corrected depths.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    thickness : float
        Thickness of the wall, metres.
    """
    inset = min(GLASS_INSET, (end - start) / 4)
    low = np.flatnonzero((rays.up_end < THRESHOLD) & (rays.depth > tolerance))
    along, depth = rays.along_end.take(low), rays.depth.take(low)
    within = (depth < thickness - tolerance) & (along > start + inset) & (along < end - inset)
    level = np.sort(rays.up_end.take(low)[within].astype(np.float64))
    on_floor = int(np.searchsorted(level, LOWEST_SILL))
    if len(level) - on_floor < FEW_ON_SILL or on_floor > STRAY_SHARE * len(level):
        return None
    above = level[on_floor:]
    hits = np.searchsorted(above, above + SILL_BAND, side="right") - np.arange(len(above))
    first = int(np.argmax(hits))
    return float(np.median(above[first : first + hits[first]]))


def shows_threshold(hole: Hole, around: PointsAround, *, thickness: float) -> bool:
    """True where the floor goes on through the wall below a hole.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    around : PointsAround
        Points around the wall.
    thickness : float
        Thickness of the wall, metres.
    """
    along, across, _ = around.within(hole.start, hole.end, -LOWEST_SILL, LOWEST_SILL)
    within = np.abs(across) < thickness / 2 - LEAF_SPREAD
    columns = max(round(hole.width / HIDING_COLUMN), 1)
    halves = [np.histogram(along[within & side], columns, (hole.start, hole.end))[0] > 0 for side in (across > 0, across <= 0)]
    return float(np.mean(halves[0] & halves[1])) > 0.5


def is_flush(hole: Hole, where: Traces) -> bool:
    """True where one face runs on over a hole that the other side shows.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    where : Traces
        Rays at the wall.
    """
    inset = GLASS_INSET
    over = where.hits_within(hole.start + inset, hole.end - inset, hole.bottom + inset, hole.top - inset)
    hits = zip(over, where.entered_within(hole.start, hole.end, hole.bottom, hole.top), strict=True)
    return any(face > entered for face, entered in hits if face >= FEW)


def is_leaf(depth: NDArray, side: NDArray, wall: WallBox, *, flush: bool) -> bool:
    """True where rays ended on one plane within the wall; no farther from a face that runs on behind it than a leaf is thick.

    Parameters
    ----------
    depth, side : (n,) array
        How far behind the face the rays into the hole ended, metres, and the side that they came from: 1 left, -1 right.
    wall : WallBox
        Wall.
    flush : bool
        True where one face runs on over the hole.
    """
    for mine in (depth[side == 1], depth[side == -1]):
        if len(mine) < FEW:
            continue
        middle = float(np.median(mine))
        on_plane = float(np.mean(np.abs(mine - middle) < 2 * LEAF_SPREAD))
        if middle < max(wall.thickness, 0.1) and on_plane > 0.6 and not (flush and wall.thickness - middle > THICKEST_LEAF):
            return True
    return False


def is_glass(hole: Hole, rays: WallRays, where: Traces, *, tolerance: float) -> bool:
    """True where far fewer rays returned from within the hole than from the wall around it, from either side.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    rays : WallRays
        Rays at the wall, with corrected depths.
    where : Traces
        The same rays, split.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    """
    inset = min(GLASS_INSET, hole.width / 4, hole.height / 4)
    inside = rows_into(rays, hole.start + inset, hole.end - inset, hole.bottom + inset, hole.top - inset, deeper=tolerance)
    area = (hole.width - 2 * inset) * (hole.height - 2 * inset)
    ring = where.hits_within(hole.start - RING, hole.end + RING, hole.bottom - RING, hole.top + RING)
    ring_area = (hole.width + 2 * RING) * (hole.height + 2 * RING) - hole.width * hole.height
    left = int(np.count_nonzero(rays.side.take(inside) == 1))
    counts = [*zip((left, len(inside) - left), ring, strict=True)]
    most = max(face for _, face in counts)
    return all(returned / area < GLASS_DENSITY * face / ring_area for returned, face in counts if face > most * STRAY_SHARE)


def has_pane(hole: Hole, rays: WallRays, *, tolerance: float, thickness: float) -> bool:
    """True where some of the rays into the middle of a hole ended there within the wall: on glass, mullions or transoms.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    rays : WallRays
        Rays at the wall, with corrected depths.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    thickness : float
        Thickness of the wall, metres.
    """
    inset = min(GLASS_INSET, hole.width / 4, hole.height / 4)

    middle = (hole.start + inset, hole.end - inset, hole.bottom + inset, hole.top - inset)
    entered = rows_into(rays, *middle, deeper=tolerance)
    along, up = rays.along_end.take(entered), rays.up_end.take(entered)
    stopped = (along > middle[0]) & (along < middle[1]) & (up > middle[2]) & (up < middle[3])
    stopped &= rays.depth.take(entered) < max(thickness, DEEPEST_PANE)
    return int(stopped.sum()) > PANE_SHARE * len(entered)


def rows_into(rays: WallRays, start: float, end: float, bottom: float, top: float, *, deeper: float) -> Ints:
    """Rows of the rays that met the face within a rectangle and ended deeper than so far behind it.

    Parameters
    ----------
    rays : WallRays
        Rays at the wall, with corrected depths.
    start, end, bottom, top : float
        Sides of the rectangle, metres.
    deeper : float
        Metres behind the face.

    Returns
    -------
    (m,) int64
    """
    from indoor_bim.plan.opening_loops import rays_into

    rows = np.zeros(len(rays), dtype=np.int64)
    return rows[: rays_into(rays.along, rays.up, rays.depth, deeper, start, end, bottom, top, rows)]
