"""Edges of openings placed on the rays themselves, finer than the cells of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.holes import Hole
from indoor_bim.plan.wall_rays import WallRays

Floats = NDArray[np.float64]

WINDOW = 0.25  # metres on either side of an edge that is looked at
NARROWEST_FRAME, WIDEST_FRAME = 0.02, 0.08  # metres: face width of door and window frames
FRAME_STEP = 0.004  # metres: smallest step in depth between a frame and a face that counts
SURE = 6.0  # times the standard error
REVEAL_BLUR = 0.012  # metres next to an edge where hits may lie on its reveal
LEAST_FACE = 0.05  # metres of face beyond a frame that show it to be one
END_SLACK = 0.02  # metres: what the ends of a wall are known to
AGREEMENT = 0.02  # metres between the views of an edge from either side
REVEAL_SHARE = 0.3  # of the tolerance
ENOUGH = 10  # hits or rays on either side


@dataclass(frozen=True, slots=True, eq=False)
class Traces:
    """Where rays met a wall, split into those that ended on a face and those that went in; metres.

    Parameters
    ----------
    face_along, face_up, face_depth, face_side : (n,) float64
        Hits on the faces, their depth and side.
    face_clear : (n,) bool
        False for hits so far behind a face that they may lie on a reveal.
    open_along, open_up, open_depth, open_side : (m,) float64
        Where the others met a face, how far behind it they ended, and its side.
    """

    face_along: Floats
    face_up: Floats
    face_depth: Floats
    face_side: Floats
    face_clear: NDArray[np.bool_]
    open_along: Floats
    open_up: Floats
    open_depth: Floats
    open_side: Floats


def traces(rays: WallRays, *, length: float, tolerance: float, through_depth: float, both_faces: bool, steep: float = 0.2) -> Traces:
    """Split rays into hits on faces and rays that went in.

    Parameters
    ----------
    rays : WallRays
        Rays at one wall, with corrected depths.
    length : float
        Length of the wall, metres: hits beyond its ends are not on its faces.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    through_depth : float
        Rays that ended this far behind the nearer face went through, metres.
    both_faces : bool
        True where the thickness was measured: rays through the wall then show the hole in the farther face too.
    steep : float
        Rays with a smaller cosine to the normal do not tell where they met a face.
    """
    face = (np.abs(rays.depth) <= tolerance) & (rays.along_end > -END_SLACK) & (rays.along_end < length + END_SLACK)
    went_in = (rays.depth > tolerance) & (rays.slant > steep)
    through = went_in & (rays.depth > through_depth) & both_faces
    none = np.full(int(through.sum()), np.inf)
    return Traces(
        face_along=rays.along_end[face].astype(np.float64),
        face_up=rays.up_end[face].astype(np.float64),
        face_depth=rays.depth[face].astype(np.float64),
        face_side=rays.side[face].astype(np.float64),
        face_clear=rays.depth[face] <= REVEAL_SHARE * tolerance,
        open_along=np.concatenate([rays.along[went_in], rays.along_far[through]]).astype(np.float64),
        open_up=np.concatenate([rays.up[went_in], rays.up_far[through]]).astype(np.float64),
        open_depth=np.concatenate([rays.depth[went_in].astype(np.float64), none]),
        open_side=np.concatenate([rays.side[went_in], -rays.side[through]]).astype(np.float64),
    )


@dataclass(frozen=True, slots=True)
class Edge:
    """One edge of an opening.

    Parameters
    ----------
    place : float
        Metres.
    seen : bool
        True when the face next to it was hit.
    frame : float
        Width of the frame that was told from the face and is part of the opening, metres; 0 where none was.
    """

    place: float
    seen: bool
    frame: float


def place_edges(hole: Hole, where: Traces) -> dict[str, Edge]:
    """Edges of a hole: start, end, bottom and top.

    Each lies where the fewest hits are on its wrong side; a frame that stands before or behind the face there is part of the
    opening.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    where : Traces
        Rays at the wall.
    """
    inset_x, inset_z = min(0.1, hole.width / 4), min(0.1, hole.height / 4)
    band_z = (hole.bottom + inset_z, hole.top - inset_z)
    band_x = (hole.start + inset_x, hole.end - inset_x)
    return {
        "start": _edge(hole.start, -1, band_z, where, upright=True),
        "end": _edge(hole.end, 1, band_z, where, upright=True),
        "bottom": _edge(hole.bottom, -1, band_x, where, upright=False),
        "top": _edge(hole.top, 1, band_x, where, upright=False),
    }


def _edge(place: float, outward: int, band: tuple[float, float], where: Traces, *, upright: bool) -> Edge:
    """One edge as each side shows it: their mean, or the outer one where something stands before the other."""
    face_across, face_along = (where.face_up, where.face_along) if upright else (where.face_along, where.face_up)
    open_across, open_along = (where.open_up, where.open_along) if upright else (where.open_along, where.open_up)
    near = (face_across > band[0]) & (face_across < band[1]) & (np.abs(face_along - place) < WINDOW)
    inside = (open_across > band[0]) & (open_across < band[1]) & (np.abs(open_along - place) < WINDOW)
    views = []
    for side in (1.0, -1.0):
        mine, entered = near & (where.face_side == side), inside & (where.open_side == side)
        view = _edge_from(
            (face_along[mine] - place) * outward,
            where.face_depth[mine],
            where.face_clear[mine],
            (open_along[entered] - place) * outward,
        )
        if view is not None:
            views.append(view)
    if not views:
        return Edge(place, False, 0.0)
    views.sort(reverse=True)
    agreeing = [view for view in views if view[0] > views[0][0] - AGREEMENT]
    split = float(np.mean([view[0] for view in agreeing]))
    return Edge(place + outward * split, True, max(view[1] for view in agreeing))


def _edge_from(face: Floats, depth: Floats, clear: NDArray[np.bool_], hole: Floats) -> tuple[float, float] | None:
    """Place of an edge, with its frame, and the width of that frame, as one side shows them; distances outward."""
    if clear.sum() < ENOUGH or len(hole) < ENOUGH:
        return None
    split = fewest_wrong(hole, face[clear])
    beyond = face > split
    if beyond.sum() < ENOUGH:
        return None
    frame = frame_width(face[beyond] - split, depth[beyond])
    return split + frame, frame


def fewest_wrong(inside: Floats, outside: Floats) -> float:
    """Threshold that leaves the smallest shares of `inside` above and of `outside` below it.

    Parameters
    ----------
    inside, outside : (n,) and (m,) float64
        Values that belong below and above.

    Returns
    -------
    float
        The threshold; in the middle of the widest gap where several are equally good.

    Examples
    --------
    >>> fewest_wrong(np.array([0.0, 1.0, 2.0]), np.array([3.0, 4.0]))
    2.5
    """
    low, high = np.sort(inside), np.sort(outside)
    cuts = np.unique(np.concatenate([low, high]))
    middles = (cuts[1:] + cuts[:-1]) / 2
    if not len(middles):
        return float(cuts[0])
    wrong = (len(low) - np.searchsorted(low, middles)) + np.searchsorted(high, middles)
    best = np.flatnonzero(wrong == wrong.min())
    runs = np.split(best, np.flatnonzero(np.diff(best) > 1) + 1)
    begin, end = max(((cuts[run[0]], cuts[run[-1] + 1]) for run in runs), key=lambda gap: gap[1] - gap[0])
    return float((begin + end) / 2)


def frame_width(distance: Floats, depth: Floats) -> float:
    """Width of a strip next to an edge whose depth differs from the face beyond it; 0 where there is none.

    Parameters
    ----------
    distance : (n,) float64
        Distance of hits from the edge, metres.
    depth : (n,) float64
        Their depths, metres.
    """
    keep = (distance > REVEAL_BLUR) & (distance < WINDOW)
    order = np.argsort(distance[keep], kind="stable")
    x, y = distance[keep][order], depth[keep][order]
    count = np.arange(1, len(x))
    width = (x[:-1] + x[1:]) / 2
    possible = (width >= NARROWEST_FRAME) & (width <= min(WIDEST_FRAME, x[-1] - LEAST_FACE)) if len(x) else np.zeros(0, dtype=bool)
    possible &= (count >= ENOUGH) & (len(x) - count >= ENOUGH)
    if not possible.any():
        return 0.0
    total, square = np.cumsum(y), np.cumsum(y**2)
    near, far = total[:-1] / count, (total[-1] - total[:-1]) / (len(x) - count)
    spread = (square[-1] - count * near**2 - (len(x) - count) * far**2) / len(x)
    error = np.sqrt(np.maximum(spread, 1e-8) * (1 / count + 1 / (len(x) - count)))
    score = np.where(possible & (np.abs(near - far) > FRAME_STEP), np.abs(near - far) / error, 0.0)
    best = int(np.argmax(score))
    return float(width[best]) if score[best] > SURE else 0.0
