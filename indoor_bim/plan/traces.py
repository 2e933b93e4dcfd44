"""Where rays met a wall: on a face, or on their way into it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.wall_rays import WallBox, WallRays

Floats = NDArray[np.float64]

END_SLACK = 0.02  # metres: what the ends of a wall are known to
RIM = 0.03  # metres above the floor and below the ceiling: hits there may not be on the wall
SHARP = 0.005  # metres: hits that scatter by less are clear unless they lie on frames and reveals
REVEAL_SHARE = 0.3  # of the tolerance


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
    open_along, open_up, open_side : (m,) float64
        Where the others met a face, and its side.
    """

    face_along: Floats
    face_up: Floats
    face_depth: Floats
    face_side: Floats
    face_clear: NDArray[np.bool_]
    open_along: Floats
    open_up: Floats
    open_side: Floats
    face_brightness: Floats | None = None
    sharp: bool = False

    def hits_within(self, start: float, end: float, bottom: float, top: float) -> tuple[int, int]:
        """Number of hits on the faces within a rectangle, from the left and from the right."""
        from indoor_bim.plan.opening_loops import count_within

        left, right = count_within(self.face_along, self.face_up, self.face_side, start, end, bottom, top)
        return int(left), int(right)

    def entered_within(self, start: float, end: float, bottom: float, top: float) -> tuple[int, int]:
        """Number of rays that went in within a rectangle, from the left and from the right."""
        from indoor_bim.plan.opening_loops import count_within

        left, right = count_within(self.open_along, self.open_up, self.open_side, start, end, bottom, top)
        return int(left), int(right)


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
    from indoor_bim.plan.opening_loops import FACE, THROUGH, WENT_IN, kinds_of_rays

    kinds = np.zeros(len(rays), dtype=np.uint8)
    limits = (-END_SLACK, wall.length + END_SLACK, RIM, wall.height - RIM)
    ends = (rays.depth, rays.slant, rays.along_end, rays.up_end)
    kinds_of_rays(*ends, tolerance, steep, through_depth if both_faces else np.inf, *limits, kinds)
    face, went_in, through = (np.flatnonzero(kinds & kind) for kind in (FACE, WENT_IN, THROUGH))

    def of(values: NDArray, rows: NDArray[np.int64]) -> Floats:
        return values.take(rows).astype(np.float64)

    depth = rays.depth.take(face)
    return Traces(
        face_along=of(rays.along_end, face),
        face_up=of(rays.up_end, face),
        face_depth=depth.astype(np.float64),
        face_side=of(rays.side, face),
        face_clear=depth <= REVEAL_SHARE * tolerance,
        open_along=np.concatenate([of(rays.along, went_in), of(rays.along_far, through)]),
        open_up=np.concatenate([of(rays.up, went_in), of(rays.up_far, through)]),
        open_side=np.concatenate([of(rays.side, went_in), -of(rays.side, through)]),
        face_brightness=None if rays.brightness is None else of(rays.brightness, face),
        sharp=scatter <= SHARP,
    )
