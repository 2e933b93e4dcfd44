"""Edges of openings placed on the rays themselves, finer than the cells of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.holes import Hole
from indoor_bim.plan.wall_rays import WallBox, WallRays

Floats = NDArray[np.float64]

WINDOW = 0.25  # metres on either side of an edge that is looked at
NARROWEST_FRAME, WIDEST_FRAME = 0.02, 0.08  # metres: face width of door and window frames
FRAME_STEP = 0.004  # metres: smallest step in depth between a frame and a face that counts
BRIGHTNESS_STEP = 0.08  # logarithm of the ratio of the intensities of a frame and a face
SURE = 6.0  # times the standard error
REVEAL_BLUR = 0.012  # metres next to an edge where hits may lie on its reveal
LEAST_FACE = 0.05  # metres of face beyond a frame that show it to be one
END_SLACK = 0.02  # metres: what the ends of a wall are known to
RIM = 0.03  # metres above the floor and below the ceiling: hits there may not be on the wall
AGREEMENT = 0.02  # metres between the views of an edge from either side
SHARP = 0.005  # metres: hits that scatter by less are clear unless they lie on frames and reveals
REVEAL_SHARE = 0.3  # of the tolerance
STEP_ALONG = 0.10  # metres of an edge that are looked at together
BEYOND = (0.03, 0.10)  # metres beyond an edge: no pier is narrower
MOST_RAGGED = 0.35  # share of an edge that may be open beyond it: those of stairs and rails are not straight
ENOUGH = 10  # hits or rays on either side
OUTWARD = {"start": -1, "end": 1, "bottom": -1, "top": 1}


@dataclass(frozen=True, slots=True, eq=False)
class Traces:
    """Where rays met a wall, split into those that ended on a face and those that went in; metres.

    Parameters
    ----------
    face_along, face_up, face_depth, face_side : (n,) float64
        Hits on the faces, their depth and side.
    face_clear : (n,) bool
        False for hits so far behind a face that they may lie on a reveal.
    face_brightness : (n,) float64, optional
        Brightness of the hits on the faces.
    sharp : bool
        True where hits scatter so little that those which are not clear lie on frames and reveals.
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
    face_brightness: Floats | None = None
    sharp: bool = False


def traces(
    rays: WallRays, wall: WallBox, *, tolerance: float, scatter: float, through_depth: float, both_faces: bool, steep: float = 0.2
) -> Traces:
    """Split rays into hits on faces and rays that went in.

    Parameters
    ----------
    rays : WallRays
        Rays at one wall, with corrected depths.
    wall : WallBox
        Wall: hits beyond its ends, or on the floor or the ceiling, are not on its faces.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    scatter : float
        Standard deviation of the hits on the faces, metres.
    through_depth : float
        Rays that ended this far behind the nearer face went through, metres.
    both_faces : bool
        True where the thickness was measured: rays through the wall then show the hole in the farther face too.
    steep : float
        Rays with a smaller cosine to the normal do not tell where they met a face.
    """
    face = (np.abs(rays.depth) <= tolerance) & (rays.along_end > -END_SLACK) & (rays.along_end < wall.length + END_SLACK)
    face &= (rays.up_end > RIM) & (rays.up_end < wall.height - RIM)
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
        face_brightness=None if rays.brightness is None else rays.brightness[face].astype(np.float64),
        sharp=scatter <= SHARP,
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


def place_edges(hole: Hole, where: Traces, *, empty: bool = False) -> dict[str, Edge]:
    """Edges of a hole: start, end, bottom and top.

    Each lies where the fewest hits are on its wrong side; a frame that stands before or behind the face there is part of the
    opening.

    Parameters
    ----------
    hole : Hole
        Rectangle to the nearest cell.
    where : Traces
        Rays at the wall.
    empty : bool
        True where it is known that the hole is one, though nothing in it was hit: its edges are then where the hits on the face end.
    """
    inset_x, inset_z = min(0.1, hole.width / 4), min(0.1, hole.height / 4)
    band_z = (hole.bottom + inset_z, hole.top - inset_z)
    band_x = (hole.start + inset_x, hole.end - inset_x)
    views = {
        "start": _views(hole.start, -1, band_z, where, upright=True, empty=empty),
        "end": _views(hole.end, 1, band_z, where, upright=True, empty=empty),
        "bottom": _views(hole.bottom, -1, band_x, where, upright=False, empty=empty),
        "top": _views(hole.top, 1, band_x, where, upright=False, empty=empty),
    }
    place = {"start": hole.start, "end": hole.end, "bottom": hole.bottom, "top": hole.top}
    return {name: _joined(place[name], OUTWARD[name], seen) for name, seen in views.items()}


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """Edge as one side shows it: its place, how far it may be off, and the face beyond it; distances outward."""

    split: float
    slack: float
    distance: Floats
    depth: Floats
    brightness: Floats | None


def _views(place: float, outward: int, band: tuple[float, float], where: Traces, *, upright: bool, empty: bool) -> list[_View]:
    """One edge as each side shows it."""
    face_across, face_along = (where.face_up, where.face_along) if upright else (where.face_along, where.face_up)
    open_across, open_along = (where.open_up, where.open_along) if upright else (where.open_along, where.open_up)
    near = (face_across > band[0]) & (face_across < band[1]) & (np.abs(face_along - place) < WINDOW)
    inside = (open_across > band[0]) & (open_across < band[1]) & (np.abs(open_along - place) < WINDOW)
    views = []
    for side in (1.0, -1.0):
        mine, entered = near & (where.face_side == side), inside & (where.open_side == side)
        face, clear = (face_along[mine] - place) * outward, where.face_clear[mine]
        entered_at = (open_along[entered] - place) * outward
        if clear.sum() < ENOUGH or (len(entered_at) < ENOUGH and not empty):
            continue
        low, high = fewest_wrong(entered_at, face[clear]) if len(entered_at) >= ENOUGH else end_of_hits(face[clear])
        if where.sharp and not empty:
            low, high = fewest_wrong(np.concatenate([entered_at, face[~clear]]), face[clear])
        split = (low + high) / 2
        beyond = face > split
        along = _share_open(face - split, face_across[mine], entered_at - split, open_across[entered], band)
        if beyond.sum() >= ENOUGH and along <= MOST_RAGGED:
            brightness = None if where.face_brightness is None else where.face_brightness[mine][beyond]
            views.append(_View(split, high - low, face[beyond] - split, where.face_depth[mine][beyond], brightness))
    return views


def _share_open(face: Floats, face_across: Floats, hole: Floats, hole_across: Floats, band: tuple[float, float]) -> float:
    """Share of an edge that rays went in close beyond, of what is known of it."""
    steps = max(round((band[1] - band[0]) / STEP_ALONG), 1)
    counts = []
    for distance, across in ((face, face_across), (hole, hole_across)):
        close = across[(distance > BEYOND[0]) & (distance < BEYOND[1])]
        counts.append(np.histogram(close, steps, band)[0])
    known = counts[0] + counts[1] >= 2
    return float((counts[1] > counts[0])[known].mean()) if known.any() else 0.0


def _joined(place: float, outward: int, views: list[_View]) -> Edge:
    """Edge from what each side shows of it: their mean, or the outer one where something stands before the other."""
    if not views:
        return Edge(place, False, 0.0)
    sharpest = min(view.slack for view in views)
    found = []
    for view in views:
        if view.slack <= sharpest + AGREEMENT:
            frame = frame_width(view.distance, view.depth)
            if not frame and view.brightness is not None:
                known = np.isfinite(view.brightness)
                frame = frame_width(view.distance[known], view.brightness[known], smallest_step=BRIGHTNESS_STEP)
            found.append((view.split + frame, frame))
    found.sort(reverse=True)
    agreeing = [edge for edge, _ in found if edge > found[0][0] - AGREEMENT]
    return Edge(place + outward * float(np.mean(agreeing)), True, max(frame for _, frame in found[: len(agreeing)]))


def fewest_wrong(inside: Floats, outside: Floats) -> tuple[float, float]:
    """Thresholds that leave the smallest shares of `inside` above and of `outside` below it.

    Parameters
    ----------
    inside, outside : (n,) and (m,) float64
        Values that belong below and above.

    Returns
    -------
    low, high : float
        All thresholds between them are equally good; the widest such gap.

    Examples
    --------
    >>> fewest_wrong(np.array([0.0, 1.0, 2.0]), np.array([3.0, 4.0]))
    (2.0, 3.0)
    """
    low, high = np.sort(inside), np.sort(outside)
    cuts = np.unique(np.concatenate([low, high]))
    middles = (cuts[1:] + cuts[:-1]) / 2
    if not len(middles):
        return float(cuts[0]), float(cuts[0])
    wrong = (len(low) - np.searchsorted(low, middles)) + np.searchsorted(high, middles)
    best = np.flatnonzero(wrong == wrong.min())
    runs = np.split(best, np.flatnonzero(np.diff(best) > 1) + 1)
    begin, end = max(((cuts[run[0]], cuts[run[-1] + 1]) for run in runs), key=lambda gap: gap[1] - gap[0])
    return float(begin), float(end)


def end_of_hits(values: Floats) -> tuple[float, float]:
    """Threshold above which values are dense and below which they are stray: the likeliest for two even densities.

    Parameters
    ----------
    values : (n,) float64
        Values.

    Returns
    -------
    low, high : float
        The values on either side of it.

    Examples
    --------
    >>> end_of_hits(np.array([-9.0, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5]))
    (-9.0, 1.0)
    """
    ordered = np.sort(values)
    below = np.arange(1, len(ordered) - 1)
    above = len(ordered) - below
    length = (ordered[below] - ordered[0], ordered[-1] - ordered[below])
    likelihood = sum(n * np.log(n / np.maximum(d, 1e-6)) for n, d in zip((below, above), length, strict=True))
    best = int(np.argmax(likelihood)) + 1
    return float(ordered[best - 1]), float(ordered[best])


def frame_width(distance: Floats, depth: Floats, *, smallest_step: float = FRAME_STEP) -> float:
    """Width of a strip next to an edge whose depth, or brightness, differs from the face beyond it; 0 where there is none.

    Parameters
    ----------
    distance : (n,) float64
        Distance of hits from the edge, metres.
    depth : (n,) float64
        Their depths, metres, or brightness.
    smallest_step : float
        Smallest difference that counts.
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
    score = np.where(possible & (np.abs(near - far) > smallest_step), np.abs(near - far) / error, 0.0)
    best = int(np.argmax(score))
    return float(width[best]) if score[best] > SURE else 0.0
