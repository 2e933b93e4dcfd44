"""Edges of openings placed on the rays themselves, finer than the cells of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.edge_fits import ENOUGH, end_of_hits, fewest_wrong, frame_width
from indoor_bim.plan.holes import Hole
from indoor_bim.plan.traces import Traces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WINDOW = 0.25  # metres on either side of an edge that is looked at
BRIGHTNESS_STEP = 0.08  # logarithm of the ratio of the intensities of a frame and a face
AGREEMENT = 0.02  # metres between the views of an edge from either side
STEP_ALONG = 0.10  # metres of an edge that are looked at together
BEYOND = (0.03, 0.10)  # metres beyond an edge: no pier is narrower
MOST_RAGGED = 0.35  # share of an edge that may be open beyond it: those of stairs and rails are not straight
OUTWARD = {"start": -1, "end": 1, "bottom": -1, "top": 1}


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
    views = []
    hits = _rows_at_edge(face_across, face_along, where.face_side, place, band)
    others = _rows_at_edge(open_across, open_along, where.open_side, place, band)
    for mine, entered in zip(hits, others, strict=True):
        face, clear = (face_along.take(mine) - place) * outward, where.face_clear.take(mine)
        entered_at = (open_along.take(entered) - place) * outward
        if np.count_nonzero(clear) < ENOUGH or (len(entered_at) < ENOUGH and not empty):
            continue
        if where.sharp and not empty:
            low, high = fewest_wrong(np.concatenate([entered_at, face[~clear]]), face[clear])
        else:
            low, high = fewest_wrong(entered_at, face[clear]) if len(entered_at) >= ENOUGH else end_of_hits(face[clear])
        split = (low + high) / 2
        beyond = np.flatnonzero(face > split)
        along = _share_open(face - split, face_across.take(mine), entered_at - split, open_across.take(entered), band)
        if len(beyond) >= ENOUGH and along <= MOST_RAGGED:
            rows = mine.take(beyond)
            brightness = None if where.face_brightness is None else where.face_brightness.take(rows)
            views.append(_View(split, high - low, face.take(beyond) - split, where.face_depth.take(rows), brightness))
    return views


def _rows_at_edge(across: Floats, along: Floats, side: Floats, place: float, band: tuple[float, float]) -> tuple[Ints, Ints]:
    """Rows of what lies close to an edge, from the left and from the right."""
    from indoor_bim.plan.opening_loops import rows_at_edge

    rows = np.zeros(len(across), dtype=np.int64)
    lefts, rights = rows_at_edge(across, along, side, *band, place, WINDOW, rows)
    return rows[:lefts], rows[len(rows) - rights :][::-1]


def _share_open(face: Floats, face_across: Floats, hole: Floats, hole_across: Floats, band: tuple[float, float]) -> float:
    """Share of an edge that rays went in close beyond, of what is known of it."""
    from indoor_bim.plan.opening_loops import count_close

    steps = max(round((band[1] - band[0]) / STEP_ALONG), 1)
    counts, bounds = np.zeros((2, steps), dtype=np.int64), np.linspace(*band, steps + 1)
    for count, distance, across in ((counts[0], face, face_across), (counts[1], hole, hole_across)):
        count_close(distance, across, *BEYOND, bounds, count)
    known = counts.sum(axis=0) >= 2
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
