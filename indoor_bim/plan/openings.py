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
from indoor_bim.plan.opening_edges import Edge, place_edges
from indoor_bim.plan.opening_evidence import (
    has_pane,
    is_flush,
    is_glass,
    is_leaf,
    low_sill,
    reaches_floor,
    rows_into,
    shows_threshold,
)
from indoor_bim.plan.traces import Traces
from indoor_bim.plan.wall_points import PointsAround
from indoor_bim.plan.wall_rays import WallBox, WallRays

CEILING_GAP = 0.10  # metres: what ends closer than this to the ceiling has no lintel
THROUGH_SHARE = 0.04  # of the rays into a hole: fewer than these through it are stray
BLIND_PROOF = 0.6  # confidence at most of what is known by its edges alone
WALKED_MARGIN = 0.10  # metres
ENOUGH = 30  # rays
NARROWEST_PIER = 0.03  # metres of wall beside an opening
CLEARLY_THROUGH = 0.25  # of the rays into a window: where a wall ends too early, more go through what it cuts off
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
    around: PointsAround,
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
    around : PointsAround
        Points around the wall.
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
    threshold = blind and shows_threshold(hole, around, thickness=wall.thickness)
    edges = place_edges(hole, where, empty=threshold)
    start, end = max(edges["start"].place, 0.0), min(edges["end"].place, wall.length)
    top = min(edges["top"].place, wall.height)
    at_end = start < NARROWEST_PIER or end > wall.length - NARROWEST_PIER
    was_walked = any(start - WALKED_MARGIN < x < end + WALKED_MARGIN for x in walked)
    sill = None if was_walked else low_sill(start, end, rays, tolerance=tolerance, thickness=wall.thickness)
    glass = is_glass(hole, rays, where, tolerance=tolerance)
    if sill is not None and not (glass or blind):
        above = rays.depth.take(rows_into(rays, start, end, sill, top, deeper=tolerance))
        if _share_through(above, through_depth) <= THROUGH_SHARE:
            sill = None
    to_floor = sill is None and reaches_floor(hole, edges["bottom"], where, around, thickness=wall.thickness)
    bottom = 0.0 if to_floor else max(edges["bottom"].place, 0.0) if sill is None else sill
    to_ceiling = wall.height - top < CEILING_GAP
    inside = rows_into(rays, start, end, bottom, top, deeper=tolerance)
    depth, side = rays.depth.take(inside), rays.side.take(inside)
    through = _share_through(depth, through_depth)
    if at_end and (to_floor or blind or through < CLEARLY_THROUGH or sum(edge.seen for edge in edges.values()) < 3):
        return None
    flush = is_flush(hole, where)
    is_through = (glass and not flush) if blind else through > THROUGH_SHARE
    width = end - start
    leaves: tuple[Leaf, ...] = ()
    closed = False
    kind: Kind
    if to_floor:
        if top < min_door_height or width < min_door_width:
            return None
        closed = not is_through and not was_walked
        if closed and not is_leaf(depth, side, wall, flush=flush):
            return None
        if not closed and width <= max_door_width:
            leaves = find_leaves(around, start=start, end=end, thickness=wall.thickness)
        framed = any(edges[name].frame > 0 for name in ("start", "end", "top"))
        both_rooms = was_walked or min(int((side == s).sum()) for s in (1, -1)) >= ENOUGH
        empty = both_rooms and not (blind or closed or leaves or framed)
        if width > max_door_width or top > max_door_height or (to_ceiling and not leaves and not closed):
            pane = has_pane(hole, rays, tolerance=tolerance, thickness=wall.thickness)
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
    seen_from = len(np.unique(side))
    return FoundOpening(kind, start, end, bottom, top, leaves, closed, float(confidence), len(depth), seen_share, seen_from)


def leaf_count(found: FoundOpening) -> int:
    """Number of leaves: those of a door that is too wide for one are two."""
    if found.kind != "door":
        return 0
    return 2 if len(found.leaves) == 2 or found.end - found.start > ONE_LEAF else 1


def _is_framed(edges: dict[str, Edge], *, to_ceiling: bool, to_floor: bool) -> bool:
    """True where enough of the wall was seen around a hole: a jamb and one more edge, or both jambs of what reaches the ceiling."""
    jambs = int(edges["start"].seen) + int(edges["end"].seen)
    if to_ceiling:
        return jambs == 2 and (to_floor or edges["bottom"].seen)
    return jambs >= 1 and sum(edge.seen for edge in edges.values()) >= 2


def _share_through(depth: NDArray, through: float) -> float:
    """Share of the rays into a hole that went through the wall."""
    return float((depth > through).mean()) if len(depth) else 0.0
