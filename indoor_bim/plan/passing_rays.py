"""Rays of the scanner that pass through an upright plane, or were stopped by it: what was seen through is no wall."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from indoor_bim.threads import even_slices, in_threads, threads_for

Floats = NDArray[np.float64]

FEW_RAYS = 20_000
"""So many rays are looked at by numpy, sooner than the compiled loop is loaded."""
NEAR = 0.06
"""Points this close to a plane were stopped by it, metres."""
SHARE = 0.1
"""Rays that pass per metre of a wall's hidden part, of those that were stopped per metre where it was seen: fewer are reflections."""


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """Where rays began and ended, and between which heights they count.

    Parameters
    ----------
    hits, origins : (n, 3) float64
        Points, and the scanner's position at each, metres.
    low, high : float
        Lowest and highest height, metres.
    """

    hits: Floats
    origins: Floats
    low: float
    high: float
    boxes: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Boxes around rays that follow one another, so that most of them need no look each time."""
        if len(self.hits) <= FEW_RAYS:
            object.__setattr__(self, "boxes", np.zeros((0, 4)))
            return
        from indoor_bim.plan.passing_ray_loops import BLOCK, boxes_around

        hits, origins = np.ascontiguousarray(self.hits), np.ascontiguousarray(self.origins)
        boxes = np.zeros((-(-len(hits) // BLOCK), 4))
        parts = even_slices(len(boxes), threads_for(len(hits)))
        in_threads(lambda part: boxes_around(*_of_blocks(hits, origins, part), boxes[part]), parts, threads=len(parts))
        for name, values in (("hits", hits), ("origins", origins), ("boxes", boxes)):
            object.__setattr__(self, name, values)

    def met(self, p: Floats, q: Floats, *, both_sides: bool = False, enough: float = np.inf) -> tuple[int, int]:
        """Rays that an upright plane from p to q stopped, and rays that went through it.

        Parameters
        ----------
        p, q : (2,) float64
            Ends, metres.
        both_sides : bool
            Count rays from the right of p -> q as well as those from the left.
        enough : float
            Where more rays pass than that, it does not matter how many: counting may end.

        Examples
        --------
        >>> hits = np.array([[0.5, 3.0, 1.0], [1.5, 3.01, 1.0], [1.0, 5.0, 1.0]])
        >>> rays = Rays(hits, np.tile([1.0, 0.0, 1.0], (3, 1)), 0.0, 2.5)
        >>> rays.met(np.array([2.0, 3.0]), np.array([0.0, 3.0]))
        (2, 1)
        """
        length = float(np.hypot(*(q - p)))
        if length < 1e-9:
            return 0, 0
        d = (q - p) / length
        if len(self.hits) > FEW_RAYS:
            return self._met_by_many(np.asarray(p, dtype=np.float64), d, length, both_sides=both_sides, enough=enough)
        normal = np.array([-d[1], d[0]])
        before = (self.origins[:, :2] - p) @ normal
        behind = (self.hits[:, :2] - p) @ normal
        crosses = (before > NEAR) & (behind < NEAR)
        if both_sides:
            crosses |= (before < -NEAR) & (behind > -NEAR)
        rows = np.flatnonzero(crosses)
        before, behind = before[rows], behind[rows]
        share = before / (before - np.where(before * behind > 0, 0.0, behind))
        spot = self.origins[rows] + share[:, None] * (self.hits[rows] - self.origins[rows])
        along = (spot[:, :2] - p) @ d
        on = (along > 0) & (along < length) & (spot[:, 2] > self.low) & (spot[:, 2] < self.high)
        stopped = int(np.count_nonzero(on & (np.abs(behind) < NEAR)))
        return stopped, int(np.count_nonzero(on)) - stopped

    def _met_by_many(self, p: Floats, d: Floats, length: float, *, both_sides: bool, enough: float) -> tuple[int, int]:
        """As `met`, a share of the rays in each thread."""
        from indoor_bim.plan.passing_ray_loops import count_rays

        place = (np.ascontiguousarray(p), d, length, self.low, self.high, NEAR, both_sides, enough)
        parts = even_slices(len(self.boxes), threads_for(len(self.hits)))
        counts = in_threads(
            lambda part: count_rays(*_of_blocks(self.hits, self.origins, part), self.boxes[part], *place), parts, threads=len(parts)
        )
        stopped = sum(count for _, count in counts)
        return stopped, sum(count for count, _ in counts) - stopped

    def seen_through(self, p: Floats, q: Floats, *, stopped: float) -> bool:
        """Whether more rays pass from p to q, from either side, than reflections may.

        Parameters
        ----------
        p, q : (2,) float64
            Ends of the part of a wall that was not seen, metres.
        stopped : float
            Rays stopped per metre of the part that was seen.
        """
        most = SHARE * stopped * float(np.hypot(*(q - p)))
        return self.met(p, q, both_sides=True, enough=most)[1] > most


def _of_blocks(hits: Floats, origins: Floats, blocks: slice) -> tuple[Floats, Floats]:
    """Rays of a range of blocks."""
    from indoor_bim.plan.passing_ray_loops import BLOCK

    rows = slice(blocks.start * BLOCK, blocks.stop * BLOCK)
    return hits[rows], origins[rows]
