"""Frames of doors: part of the hole in the wall, whether they stand in it or lie in the plane of its face."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.opening_edges import Edge
from indoor_bim.plan.wall_rays import WallRays

NARROWEST_FRAME = 0.025  # metres
JAMB_REACH = 0.12  # metres
JAMBS = ("start", "end")
OUTWARD = {"start": -1, "end": 1, "top": 1}
SMALLEST_STEP = 0.015  # metres between the front of a frame and the leaf in it
LEAF_BAND = 0.2  # metres from the other edges of a door: where one of them is looked at
LEAF_REACH = 0.4  # metres next to an edge where the leaf of a closed door is looked at


def with_frame(
    edges: dict[str, Edge], rays: WallRays, *, tolerance: float, thickness: float, closed: bool, frame: float
) -> dict[str, float]:
    """Start, end and top of a door with its frame.

    Where the clear passage is narrower than the hole in the face, the frame stands in the hole and is part of it already. Otherwise
    it was told from the face by its depth, or lies in the plane of the face and has the given width.

    Parameters
    ----------
    edges : dict of str to Edge
        Start, end, bottom and top of the door.
    rays : WallRays
        Rays around it, with corrected depths.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    thickness : float
        Thickness of the wall, metres.
    closed : bool
        True where the leaf was seen in the hole.
    frame : float
        Width of a frame in the plane of the face, metres.

    Returns
    -------
    dict of str to float
        Start, end and top, metres.
    """
    level = (rays.up > LEAF_BAND) & (rays.up < edges["top"].place - LEAF_BAND)
    hole = {name: edges[name].place - outward * edges[name].frame for name, outward in OUTWARD.items()}
    if closed:
        entered = level & (rays.depth > tolerance)
        in_hole = any(_steps_back((hole[name] - rays.along[entered]) * OUTWARD[name], rays.depth[entered]) for name in JAMBS)
    else:
        within = level & (rays.depth > thickness / 4) & (rays.depth < thickness * 3 / 4)
        jambs = [_jamb_surface((hole[name] - rays.along_end[within]) * OUTWARD[name]) for name in JAMBS]
        in_hole = float(np.mean(jambs)) > NARROWEST_FRAME
    if in_hole:
        return hole
    told = [edges[name].frame for name in OUTWARD if edges[name].frame > 0]
    usual = float(np.median(told)) if told else frame
    return {name: hole[name] + outward * (edges[name].frame or usual) for name, outward in OUTWARD.items()}


def _jamb_surface(inward: NDArray) -> float:
    """Distance from an edge of the face to the surface of the jamb in the depth of the wall; 0 where too little was seen."""
    near = inward[np.abs(inward) < JAMB_REACH]
    return float(np.median(near)) if len(near) >= 10 else 0.0


def _steps_back(inward: NDArray, depth: NDArray) -> bool:
    """True where the strip next to an edge stands before the leaf of a closed door."""
    strip, leaf = depth[(inward > 0) & (inward < 0.04)], depth[(inward > 0.12) & (inward < LEAF_REACH)]
    if len(strip) < 10 or len(leaf) < 10:
        return False
    return float(np.median(leaf)) - float(np.median(strip)) > SMALLEST_STEP
