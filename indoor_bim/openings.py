"""Openings in the walls of a storey, found from each wall's own picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Evidence, Opening, Storey, Wall
from indoor_bim.plan.holes import Hole, blind_cell_states, cell_states, find_holes
from indoor_bim.plan.opening_edges import WINDOW
from indoor_bim.plan.opening_evidence import LOWEST_SILL
from indoor_bim.plan.openings import FoundOpening, leaf_count, name_opening
from indoor_bim.plan.shallow_doors import LARGEST_STEP, find_shallow_doors
from indoor_bim.plan.traces import traces
from indoor_bim.wall_views import WallView, each_wall, recessed

Floats = NDArray[np.float64]

DECIMALS = 4  # tenths of a millimetre
DARK_WINDOW = 1.3  # times larger than what rays show of it
WIDEST_FRAME = 0.12  # metres between the edge of a window and its panes; what is wider is a wall
SHALLOW_PROOF = 0.5  # confidence of a door that only a step of a centimetre or two shows
AROUND_HOLE = 0.6  # metres on either side of a hole that are looked at


def find_openings(
    storey: Storey,
    points: Floats,
    *,
    trajectory: Floats | None = None,
    gps_time: Floats | None = None,
    intensity: NDArray | None = None,
    min_confidence: float = 0.4,
    min_door_width: float = 0.6,
    max_door_width: float = 2.5,
    min_door_height: float = 1.8,
    max_door_height: float = 2.6,
    frame: float = 0.04,
) -> Storey:
    """Find doors, windows and passages in the walls of a storey.

    Parameters
    ----------
    storey : Storey
        Storey with walls; openings that they carry are replaced.
    points : (n, 3) float64
        All points of the scan in model coordinates, metres.
    trajectory : (m, 4) float64, optional
        Path of the scanner: time in seconds, and x, y, z in model coordinates, metres.
    gps_time : (n,) float64, optional
        Time of each point, seconds.
    intensity : (n,) array, optional
        Strength of each return, in the unit of the scanner: what lies in the plane of a wall may differ from it in brightness.
    min_confidence : float
        Openings that are less certain are left out.
    min_door_width, max_door_width, min_door_height, max_door_height : float
        Bounds of doors, metres.
    frame : float
        Width of a door frame that lies in the plane of the wall, where it cannot be seen, metres.

    Returns
    -------
    Storey
        The storey with openings in its walls.
    """
    bounds = {
        "min_door_width": min_door_width,
        "max_door_width": max_door_width,
        "min_door_height": min_door_height,
        "max_door_height": max_door_height,
        "frame": frame,
    }

    def of_wall(view: WallView) -> list[FoundOpening]:
        return _without_overlap([o for o in _wall_openings(view, **bounds) if o.confidence >= min_confidence])

    found = each_wall(of_wall, storey, points, trajectory=trajectory, gps_time=gps_time, intensity=intensity)
    return replace(storey, walls=_with_openings(storey, found))


def _wall_openings(view: WallView, **bounds: float) -> list[FoundOpening]:
    """Openings of a wall: those that go into it, those in its recesses, and closed doors in its plane."""
    openings = _openings(view, **bounds)
    sizes = {name.replace("_door", ""): value for name, value in bounds.items() if name != "frame"}
    deeper = [o for recess in recessed(view) for o in _openings(recess, **bounds)]
    openings = [o for o in openings if o.kind == "door" or not any(_contains(o, other) for other in deeper)]
    for other in (*_shallow_doors(view, **sizes), *deeper):
        if not any(_overlap(other, o) for o in openings):
            openings.append(other)
    return openings


def _openings(view: WallView, **bounds: float) -> list[FoundOpening]:
    """Openings that go into a wall."""
    holes = find_holes(*blind_cell_states(view.picture), cell=view.picture.cell)
    if view.blind:
        return _named(view, holes, blind=True, **bounds)
    by_rays = _named(view, find_holes(*cell_states(view.picture), cell=view.picture.cell), blind=False, **bounds)
    sure = [o for o in by_rays if not _may_be_part(o)]
    doubtful = [hole for hole in holes if hole.bottom > LOWEST_SILL and not any(_overlap(o, _core(hole)) for o in sure)]
    by_edges = _named(view, doubtful, blind=True, **bounds)
    return _with_dark_windows(by_rays, [o for o in by_edges if o.kind == "window" and o.bottom > LOWEST_SILL])


def _named(view: WallView, holes: list[Hole], *, blind: bool, **bounds: float) -> list[FoundOpening]:
    """Openings among the holes of a wall."""
    out = []
    for hole in holes:
        rays = view.rays.take(np.flatnonzero((view.rays.along > hole.start - AROUND_HOLE) & (view.rays.along < hole.end + AROUND_HOLE)))
        opening = name_opening(
            hole,
            view.box,
            rays,
            traces(
                rays,
                view.box,
                tolerance=view.tolerance,
                scatter=view.scatter,
                through_depth=view.through_depth,
                both_faces=view.wall.thickness_measured,
            ),
            view.around,
            tolerance=view.tolerance,
            through_depth=view.through_depth,
            walked=view.walked,
            blind=blind,
            **bounds,
        )
        if opening is not None:
            out.append(opening)
    return out


def _shallow_doors(view: WallView, **sizes: float) -> list[FoundOpening]:
    """Closed doors that hardly stand out of the wall."""
    holes = find_shallow_doors(view.box, view.rays, view.relief, scatter=view.scatter, cell=view.picture.cell, **sizes)
    out = []
    for hole in holes:
        inside = (view.rays.along_end > hole.start) & (view.rays.along_end < hole.end) & (view.rays.up_end < hole.top)
        hits = int((inside & (np.abs(view.rays.depth) < LARGEST_STEP)).sum())
        out.append(FoundOpening("door", hole.start, hole.end, 0.0, hole.top, (), True, SHALLOW_PROOF, hits, 1.0, 1))
    return out


def _with_dark_windows(by_rays: list[FoundOpening], by_edges: list[FoundOpening]) -> list[FoundOpening]:
    """Add windows through which nothing came back: they take the place of the parts of them that were found by rays."""
    out = list(by_rays)
    for window in by_edges:
        parts = [o for o in out if _overlap(o, window)]
        if all(_may_be_part(o) and _area(o) * DARK_WINDOW < _area(window) for o in parts):
            out = [o for o in out if o not in parts] + [window]
    return out


def _may_be_part(o: FoundOpening) -> bool:
    """True for windows that may be a part of a larger one."""
    return o.kind == "window" and o.edges_seen < 1


def _core(hole: Hole) -> Hole:
    """What is left of a hole, wherever its edges are placed."""
    return Hole(hole.start + WINDOW, hole.end - WINDOW, hole.bottom + WINDOW, hole.top - WINDOW)


def _area(o: FoundOpening) -> float:
    return (o.end - o.start) * (o.top - o.bottom)


def _overlap(a: FoundOpening, b: FoundOpening | Hole) -> bool:
    return min(a.end, b.end) > max(a.start, b.start) and min(a.top, b.top) > max(a.bottom, b.bottom)


def _contains(outer: FoundOpening, inner: FoundOpening) -> bool:
    """True where an opening is the recess that another one is in."""
    aside = min(inner.start - outer.start, outer.end - inner.end)
    return aside > WIDEST_FRAME and inner.bottom > outer.bottom + WIDEST_FRAME and inner.top <= outer.top


def _without_overlap(openings: list[FoundOpening]) -> list[FoundOpening]:
    """Openings that share no place, the more certain ones first, sorted along the wall."""
    kept: list[FoundOpening] = []
    for new in sorted(openings, key=lambda o: (-o.confidence, o.start, o.bottom)):
        if not any(_overlap(new, old) for old in kept):
            kept.append(new)
    return sorted(kept, key=lambda o: (o.start, o.bottom))


def _with_openings(storey: Storey, found: list[list[FoundOpening]]) -> tuple[Wall, ...]:
    """Walls of a storey with numbered openings."""
    number = {"door": 0, "window": 0, "opening": 0}
    walls = []
    for wall, of_wall in zip(storey.walls, found, strict=True):
        openings = []
        for opening in of_wall:
            number[opening.kind] += 1
            openings.append(_model_opening(opening, prefix=storey.id, number=number[opening.kind]))
        walls.append(replace(wall, openings=tuple(openings)))
    return tuple(walls)


def _model_opening(found: FoundOpening, *, prefix: str, number: int) -> Opening:
    kind = found.kind.capitalize()
    start, sill = round(max(found.start, 0.0), DECIMALS), round(max(found.bottom, 0.0), DECIMALS)
    leaf = found.leaves[0] if found.leaves else None
    return Opening(
        id=f"{prefix}-{kind}{number}",
        name=f"{kind} {number}",
        kind=found.kind,
        start=start,
        width=round(found.end - start, DECIMALS),
        sill=sill,
        height=round(found.top - sill, DECIMALS),
        hinge=leaf.hinge if leaf and found.kind == "door" and len(found.leaves) == 1 else None,
        swing=leaf.swing if leaf and found.kind == "door" else None,
        leaves=leaf_count(found),
        confidence=round(min(found.confidence, 1.0), 3),
        evidence=Evidence(support=found.rays, coverage=round(found.edges_seen, 3), sides=min(found.sides, 2)),
    )
