"""What the holes of a wall are: doors, windows, passages, or niches that are none of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.door_frames import with_frame
from indoor_bim.plan.door_leaves import Leaf, find_leaves
from indoor_bim.plan.holes import Hole
from indoor_bim.plan.opening_edges import Edge, Traces, place_edges
from indoor_bim.plan.wall_rays import WallBox, WallRays

Floats = NDArray[np.float64]

THRESHOLD = 0.25  # metres: what begins lower than this reaches the floor
CEILING_GAP = 0.10  # metres: what ends closer than this to the ceiling has no lintel
LOWEST_HIT = 0.08  # metres above the floor: lower points may be the floor's own
THROUGH_SHARE = 0.04  # of the rays into a hole: fewer than these through it are stray
STRAY_SHARE = 0.1  # of the hits on the other face: a face with fewer was not seen
GLASS_DENSITY = 0.4  # of the hits on the wall around: panes return fewer rays than that, the back of a niche all
GLASS_INSET = 0.12  # metres next to the edges of a hole that frames and reveals take
PANE_SHARE = 0.05  # of the rays: panes return about a tenth, stray points are a hundredth
DEEPEST_PANE = 0.30  # metres behind a face
RING = 0.3  # metres around a hole
BLIND_PROOF = 0.6  # confidence at most of what is known by its edges alone
WALKED_MARGIN = 0.10  # metres
THICKEST_LEAF = 0.07  # metres
LEAF_SPREAD = 0.03  # metres: scatter of the depths of a closed leaf
FEW, ENOUGH = 3, 30  # rays
NARROWEST_PIER = 0.03  # metres of wall beside an opening
CLEARLY_THROUGH = 0.25  # of the rays into a window: where a wall ends too early, more go through what it cuts off
LOWEST_SILL = 0.05  # metres: what begins lower is a threshold
SILL_BAND = 0.03  # metres
FEW_ON_SILL = 8  # hits
HIDDEN_SHARE = 0.2  # of the rays per area that go into a hole: fewer below it are stray
HIDING_COLUMN = 0.05  # metres along a wall
ONE_LEAF = 1.35  # metres: no single leaf is wider

Kind = Literal["door", "window", "opening"]


@dataclass(frozen=True, slots=True)
class FoundOpening:
    """Opening of a wall, metres along its axis and up from its foot.

    Parameters
    ----------
    kind : {"door", "window", "opening"}
        Opening stands for a passage up to the ceiling.
    start, end, bottom, top : float
        Its sides.
    leaves : tuple of Leaf
        Leaves that were seen standing open.
    closed : bool
        True for a door whose leaf was seen in the hole.
    confidence : float
        0 to 1.
    rays : int
        Rays that went into it.
    edges_seen : float
        Share of its edges next to which the face was hit.
    sides : int
        Sides of the wall that it was seen from.
    """

    kind: Kind
    start: float
    end: float
    bottom: float
    top: float
    leaves: tuple[Leaf, ...]
    closed: bool
    confidence: float
    rays: int
    edges_seen: float
    sides: int


def name_opening(
    hole: Hole,
    wall: WallBox,
    rays: WallRays,
    where: Traces,
    around: tuple[Floats, Floats, Floats],
    *,
    tolerance: float,
    through_depth: float,
    walked: Sequence[float] = (),
    blind: bool = False,
    min_door_width: float = 0.6,
    max_door_width: float = 2.5,
    min_door_height: float = 1.8,
    max_door_height: float = 2.6,
    frame: float = 0.04,
) -> FoundOpening | None:
    """Tell what a hole is and measure it.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    wall : WallBox
        Wall that it is in.
    rays : WallRays
        Rays at the wall, with corrected depths.
    where : Traces
        The same rays, split.
    around : ((n,), (n,), (n,)) float64
        Points around the wall: along, across, up; metres.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    through_depth : float
        Rays that ended this far behind the nearer face went through the wall, metres.
    walked : sequence of float
        Places along the wall where the scanner was carried through it, metres.
    blind : bool
        True where the path of the scanner is not known: what rays went through is then not known either, and openings are told by
        the hits on their reveals and frames.
    min_door_width, max_door_width, min_door_height, max_door_height : float
        Bounds of doors, metres.
    frame : float
        Width of the frame of a door that lies in the plane of the face, where it cannot be seen, metres.

    Returns
    -------
    FoundOpening or None
        None for a niche, a gap, or too little evidence.
    """
    threshold = blind and _shows_threshold(hole, around, thickness=wall.thickness)
    edges = place_edges(hole, where, empty=threshold)
    start, end = max(edges["start"].place, 0.0), min(edges["end"].place, wall.length)
    top = min(edges["top"].place, wall.height)
    at_end = start < NARROWEST_PIER or end > wall.length - NARROWEST_PIER
    was_walked = any(start - WALKED_MARGIN < x < end + WALKED_MARGIN for x in walked)
    sill = None if was_walked else _low_sill(start, end, rays, tolerance=tolerance, thickness=wall.thickness)
    glass = _is_glass(hole, rays, where, tolerance=tolerance)
    if sill is not None and not (glass or blind) and _share_through(rays, start, end, sill, top, tolerance, through_depth) <= THROUGH_SHARE:
        sill = None
    to_floor = sill is None and _reaches_floor(hole, edges["bottom"], where, around, thickness=wall.thickness)
    bottom = 0.0 if to_floor else max(edges["bottom"].place, 0.0) if sill is None else sill
    to_ceiling = wall.height - top < CEILING_GAP
    inside = (rays.depth > tolerance) & (rays.along > start) & (rays.along < end) & (rays.up > bottom) & (rays.up < top)
    depth = rays.depth[inside]
    through = _share_through(rays, start, end, bottom, top, tolerance, through_depth)
    if at_end and (to_floor or blind or through < CLEARLY_THROUGH or sum(edge.seen for edge in edges.values()) < 3):
        return None
    flush = _is_flush(hole, where)
    is_through = (glass and not flush) if blind else through > THROUGH_SHARE
    width = end - start
    leaves: tuple[Leaf, ...] = ()
    closed = False
    kind: Kind
    if to_floor:
        if top < min_door_height or width < min_door_width:
            return None
        closed = not is_through and not was_walked
        if closed and not _is_leaf(depth, rays.side[inside], wall, flush=flush):
            return None
        if not closed and width <= max_door_width:
            leaves = find_leaves(*around, start=start, end=end, thickness=wall.thickness)
        framed = any(edges[name].frame > 0 for name in ("start", "end", "top"))
        both_rooms = was_walked or min(int((rays.side[inside] == side).sum()) for side in (1, -1)) >= ENOUGH
        empty = both_rooms and not (blind or closed or leaves or framed)
        if width > max_door_width or top > max_door_height or (to_ceiling and not leaves and not closed):
            pane = _has_pane(hole, rays, tolerance=tolerance, thickness=wall.thickness)
            kind = "window" if (glass or pane) and width > max_door_width and not (was_walked or threshold) else "opening"
        else:
            kind = "opening" if empty else "door"
    else:
        if not is_through and (flush or not glass):
            return None
        kind = "window"
    if kind == "door" and (leaves or closed):
        sides = with_frame(edges, rays, tolerance=tolerance, thickness=wall.thickness, closed=closed, frame=frame)
        start, end, top = max(sides["start"], 0.0), min(sides["end"], wall.length), min(sides["top"], wall.height)
    seen = [edges["start"].seen, edges["end"].seen, edges["top"].seen or to_ceiling, edges["bottom"].seen or to_floor]
    if blind and not all(seen):
        return None
    if not _is_framed(edges, to_ceiling=to_ceiling, to_floor=to_floor):
        return None
    seen_share = float(np.mean(seen))
    proof = BLIND_PROOF if blind else 1.0 if was_walked else 0.9 if is_through else 0.7
    confidence = proof * (1 - np.exp(-len(depth) / 50)) * (0.4 + 0.6 * seen_share)
    seen_from = len(np.unique(rays.side[inside]))
    return FoundOpening(kind, start, end, bottom, top, leaves, closed, float(confidence), len(depth), seen_share, seen_from)


def leaf_count(found: FoundOpening) -> int:
    """Number of leaves: those of a door that is too wide for one are two."""
    if found.kind != "door":
        return 0
    return 2 if len(found.leaves) == 2 or found.end - found.start > ONE_LEAF else 1


def _reaches_floor(hole: Hole, bottom: Edge, where: Traces, around: tuple[Floats, Floats, Floats], *, thickness: float) -> bool:
    """True where below the hole no face was hit, unless something hides it and hardly a ray went in there."""
    if hole.bottom < THRESHOLD:
        return True
    inset = min(0.1, hole.width / 4)
    start, end, low, high = hole.start + inset, hole.end - inset, LOWEST_HIT, min(bottom.place, hole.bottom) - 0.03

    def below(along: Floats, up: Floats) -> NDArray[np.bool_]:
        return (along > start) & (along < end) & (up > low) & (up < high)

    hits = int(below(where.face_along, where.face_up).sum())
    entered = int(below(where.open_along, where.open_up).sum())
    if hits >= FEW and hits > entered:
        return False
    before = below(around[0], around[2]) & (np.abs(around[1]) > thickness / 2 + LEAF_SPREAD)
    columns = np.unique(np.floor((around[0][before] - start) / HIDING_COLUMN))
    if len(columns) * HIDING_COLUMN < (end - start) / 2:
        return True
    inside = (where.open_along > start) & (where.open_along < end) & (where.open_up > hole.bottom) & (where.open_up < hole.top)
    return entered / (high - low) > HIDDEN_SHARE * int(inside.sum()) / hole.height


def _low_sill(start: float, end: float, rays: WallRays, *, tolerance: float, thickness: float) -> float | None:
    """Level of the sill of a window that begins close above the floor; None where the floor goes on into the wall."""
    inset = min(GLASS_INSET, (end - start) / 4)
    within = (rays.depth > tolerance) & (rays.depth < thickness - tolerance)
    within &= (rays.along_end > start + inset) & (rays.along_end < end - inset) & (rays.up_end < THRESHOLD)
    level = np.sort(rays.up_end[within].astype(np.float64))
    on_floor = int(np.searchsorted(level, LOWEST_SILL))
    if len(level) - on_floor < FEW_ON_SILL or on_floor > STRAY_SHARE * len(level):
        return None
    above = level[on_floor:]
    hits = np.searchsorted(above, above + SILL_BAND, side="right") - np.arange(len(above))
    first = int(np.argmax(hits))
    return float(np.median(above[first : first + hits[first]]))


def _shows_threshold(hole: Hole, around: tuple[Floats, Floats, Floats], *, thickness: float) -> bool:
    """True where the floor goes on through the wall below a hole."""
    along, across, up = around
    on_floor = (np.abs(up) < LOWEST_SILL) & (along > hole.start) & (along < hole.end) & (np.abs(across) < thickness / 2 - LEAF_SPREAD)
    columns = max(round(hole.width / HIDING_COLUMN), 1)
    halves = [np.histogram(along[on_floor & side], columns, (hole.start, hole.end))[0] > 0 for side in (across > 0, across <= 0)]
    return float(np.mean(halves[0] & halves[1])) > 0.5


def _is_framed(edges: dict[str, Edge], *, to_ceiling: bool, to_floor: bool) -> bool:
    """True where enough of the wall was seen around a hole: a jamb and one more edge, or both jambs of what reaches the ceiling."""
    jambs = int(edges["start"].seen) + int(edges["end"].seen)
    if to_ceiling:
        return jambs == 2 and (to_floor or edges["bottom"].seen)
    return jambs >= 1 and sum(edge.seen for edge in edges.values()) >= 2


def _share_through(rays: WallRays, start: float, end: float, bottom: float, top: float, tolerance: float, through: float) -> float:
    """Share of the rays into a rectangle that went through the wall."""
    inside = (rays.depth > tolerance) & (rays.along > start) & (rays.along < end) & (rays.up > bottom) & (rays.up < top)
    return float((rays.depth[inside] > through).mean()) if inside.any() else 0.0


def _is_flush(hole: Hole, where: Traces) -> bool:
    """True where one face runs on over a hole that the other side shows."""
    over = (where.face_along > hole.start + GLASS_INSET) & (where.face_along < hole.end - GLASS_INSET)
    over &= (where.face_up > hole.bottom + GLASS_INSET) & (where.face_up < hole.top - GLASS_INSET)
    inside = (where.open_along > hole.start) & (where.open_along < hole.end) & (where.open_up > hole.bottom) & (where.open_up < hole.top)
    hits = [(int((over & (where.face_side == side)).sum()), int((inside & (where.open_side == side)).sum())) for side in (1, -1)]
    return any(face > entered for face, entered in hits if face >= FEW)


def _is_leaf(depth: NDArray, side: NDArray, wall: WallBox, *, flush: bool) -> bool:
    """True where rays ended on one plane within the wall; no farther from a face that runs on behind it than a leaf is thick."""
    for mine in (depth[side == 1], depth[side == -1]):
        if len(mine) < FEW:
            continue
        middle = float(np.median(mine))
        on_plane = float(np.mean(np.abs(mine - middle) < 2 * LEAF_SPREAD))
        if middle < max(wall.thickness, 0.1) and on_plane > 0.6 and not (flush and wall.thickness - middle > THICKEST_LEAF):
            return True
    return False


def _is_glass(hole: Hole, rays: WallRays, where: Traces, *, tolerance: float) -> bool:
    """True where far fewer rays returned from within the hole than from the wall around it, from either side."""
    inset = min(GLASS_INSET, hole.width / 4, hole.height / 4)
    inside = (rays.depth > tolerance) & (rays.along > hole.start + inset) & (rays.along < hole.end - inset)
    inside &= (rays.up > hole.bottom + inset) & (rays.up < hole.top - inset)
    area = (hole.width - 2 * inset) * (hole.height - 2 * inset)
    ring = (where.face_along > hole.start - RING) & (where.face_along < hole.end + RING)
    ring &= (where.face_up > hole.bottom - RING) & (where.face_up < hole.top + RING)
    ring_area = (hole.width + 2 * RING) * (hole.height + 2 * RING) - hole.width * hole.height
    counts = [(int((inside & (rays.side == side)).sum()), int((ring & (where.face_side == side)).sum())) for side in (1, -1)]
    most = max(face for _, face in counts)
    return all(returned / area < GLASS_DENSITY * face / ring_area for returned, face in counts if face > most * STRAY_SHARE)


def _has_pane(hole: Hole, rays: WallRays, *, tolerance: float, thickness: float) -> bool:
    """True where some of the rays into the middle of a hole ended there within the wall: on glass, mullions or transoms."""
    inset = min(GLASS_INSET, hole.width / 4, hole.height / 4)

    def in_middle(along: NDArray, up: NDArray) -> NDArray[np.bool_]:
        middle: NDArray[np.bool_] = (along > hole.start + inset) & (along < hole.end - inset)
        return middle & (up > hole.bottom + inset) & (up < hole.top - inset)

    entered = (rays.depth > tolerance) & in_middle(rays.along, rays.up)
    stopped = entered & in_middle(rays.along_end, rays.up_end) & (rays.depth < max(thickness, DEEPEST_PANE))
    return int(stopped.sum()) > PANE_SHARE * int(entered.sum())
