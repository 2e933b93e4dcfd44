"""Lines of wall faces: crests of the wall evidence, placed on the points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.strips import Sweep, layer_bits

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class FaceLines:
    """Straight faces, free space to the left of the direction; one row each.

    Parameters
    ----------
    angle : (m,) float64
        Direction of the line, radians.
    offset : (m,) float64
        Signed distance of the line from the origin along its left normal, metres.
    start, end : (m,) float64
        Extent along the direction, metres.
    spread : (m,) float64
        Standard deviation of the points across the line, metres.
    family : (m,) int64
        Number of the sweep that shows the line.
    """

    angle: Floats
    offset: Floats
    start: Floats
    end: Floats
    spread: Floats
    family: Ints

    def __len__(self) -> int:
        return len(self.angle)

    @classmethod
    def none(cls) -> FaceLines:
        """No line at all."""
        nothing = np.zeros(0)
        return cls(nothing, nothing, nothing, nothing, nothing, np.zeros(0, dtype=np.int64))

    @property
    def direction(self) -> Floats:
        """(m, 2) float64 unit vectors along the lines."""
        return np.column_stack([np.cos(self.angle), np.sin(self.angle)])

    @property
    def normal(self) -> Floats:
        """(m, 2) float64 unit normals to the left: into free space."""
        return np.column_stack([-np.sin(self.angle), np.cos(self.angle)])

    def ends(self, reach: float = 0.0) -> tuple[Floats, Floats]:
        """End points (m, 2) of the lines, prolonged by `reach` metres."""
        foot = self.offset[:, None] * self.normal
        return foot + (self.start - reach)[:, None] * self.direction, foot + (self.end + reach)[:, None] * self.direction

    def take(self, rows: NDArray) -> FaceLines:
        """Lines of the given rows (indices or mask)."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})


def ridges(swept: Sweep, *, shortest: int = 4) -> list[tuple[int, Ints, Ints]]:
    """Crests of the wall evidence: side and strip indices (u, v) of each that runs over at least `shortest` strips, ordered along u."""
    found = []
    for part in connected(swept.crest, swept.masks.shape):
        side, u, v = part.T
        for piece in straight_pieces(u, v):
            if u[piece].max() - u[piece].min() + 1 >= shortest:
                found.append((int(side[0]), u[piece], v[piece]))
    return found


def connected(crest: Ints, shape: tuple[int, ...], *, across: int = 3) -> list[Ints]:
    """Groups of strips on crests: those side by side along that are not too far apart across belong together.

    Parameters
    ----------
    crest : (n, 3) int64
        Side, u and v of the strips, ascending.
    shape : (int, int, int)
        Numbers of sides and strips.
    across : int
        Largest difference in v.

    Returns
    -------
    list of (m, 3) int64
        Groups in the order of their first strips.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not len(crest):
        return []
    width = shape[2] + across
    key = (crest[:, 0] * (shape[1] + 1) + crest[:, 1]) * width + crest[:, 2]
    beside = np.flatnonzero(np.diff(key) <= across)
    first = np.searchsorted(key, key + width - across)
    count = np.searchsorted(key, key + width + across, side="right") - first
    behind = np.repeat(np.arange(len(key)), count)
    ahead = np.arange(len(behind)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
    tail, head = np.concatenate([beside, behind]), np.concatenate([beside + 1, ahead])
    number, label = connected_components(
        coo_matrix((np.ones(len(tail), dtype=bool), (tail, head)), shape=(len(key), len(key))), directed=False
    )
    order = np.argsort(label, kind="stable")
    groups: list[Ints] = np.split(crest[order], np.searchsorted(label[order], np.arange(1, number)))
    return groups


def straight_pieces(u: Ints, v: Ints, *, rough: float = 1.0, better: float = 0.5, step: float = 4.0, shortest: int = 4) -> list[slice]:
    """Whole crest, or both parts of one that steps: a door leaf beside the wall that it is hung in.

    Parameters
    ----------
    u, v : (n,) int64
        Strips of the crest, ordered along u.
    rough : float
        Root mean square distance of the crest from one line, in strips, from which two lines are tried.
    better : float
        Two lines are taken when they leave at most this share of the distance.
    step : float
        Least step from one to the other, in strips: maps that drift bend walls, but do not break them.
    shortest : int
        Strips of the shorter part at least.
    """
    whole = [slice(0, len(u))]
    cuts = np.flatnonzero(np.diff(u, prepend=u[:1]))
    if len(cuts) < 2 * shortest:
        return whole
    sums = np.cumsum(np.column_stack([np.ones(len(u)), u, v, u * u, u * v, v * v]).astype(np.float64), axis=0)
    left = sums[cuts - 1]
    apart = [_squares(part) for part in (left, sums[-1] - left)]
    allowed = (u[cuts - 1] - u[0] + 1 >= shortest) & (u[-1] - u[cuts] + 1 >= shortest)
    one, two = float(_squares(sums[-1:])[0]), np.where(allowed, apart[0] + apart[1], np.inf)
    best = int(np.argmin(two))
    if one < rough**2 * len(u) or two[best] > better**2 * one:
        return whole
    pieces = [slice(0, int(cuts[best])), slice(int(cuts[best]), len(u))]
    at_cut = [float(np.polyval(np.polyfit(u[piece], v[piece], 1), u[cuts[best]] - 0.5)) for piece in pieces]
    return pieces if abs(at_cut[1] - at_cut[0]) > step else whole


def _squares(sums: Floats) -> Floats:
    """Sum of squared distances from the best line, from (n, 6) sums of 1, u, v, uu, uv, vv."""
    n, su, sv, uu, uv, vv = sums.T
    within = np.maximum(uu - su * su / n, 1e-9)
    squares: Floats = np.maximum(vv - sv * sv / n - (uv - su * sv / n) ** 2 / within, 0.0)
    return squares


def face_lines(swept: Sweep, *, family: int, steepest: float = 12.0) -> FaceLines:
    """Lines of all faces along one direction.

    Parameters
    ----------
    swept : Sweep
        Wall points in strips along the direction.
    family : int
        Number of the sweep.
    steepest : float
        Largest angle between a face and the direction, degrees.
    """
    rows: list[tuple[float, ...]] = []
    for side, u, v in ridges(swept):
        line = _fit(swept, side, u, v)
        if line is None or abs(line[0]) > np.tan(np.radians(steepest)):
            continue
        rows.append(_row(swept, side, *line, int(u.min()), int(u.max())))
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return FaceLines(table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4], np.full(len(table), family, dtype=np.int64))


def _fit(swept: Sweep, side: int, u: Ints, v: Ints) -> tuple[float, float, float, float] | None:
    """Robust line v = level + slope (u - middle) through the strips around a crest, in metres."""
    from indoor_bim.plan.crest_loops import fit_crest

    columns, first = np.unique(u, return_index=True)
    path = np.interp(np.arange(columns[0], columns[-1] + 1), columns, v[first])
    strips, masks = swept.strips, swept.masks
    image = (masks.slot[side], masks.values, masks.shape[2])
    found, *line = fit_crest(*image, int(columns[0]), path, layer_bits(strips.band), strips.along, strips.across)
    slope, middle, level, spread = line
    return (slope, middle + swept.low[0], level + swept.low[1], spread) if found else None


def _row(swept: Sweep, side: int, slope: float, middle: float, level: float, spread: float, first: int, last: int) -> tuple[float, ...]:
    """Line in model coordinates: angle, offset, start, end, spread."""
    turn = float(np.arctan(slope))
    cos, sin = np.cos(turn), np.sin(turn)
    offset = -sin * middle + cos * level
    along = cos * middle + sin * level
    start = along + (swept.low[0] + first * swept.strips.along - middle) / cos
    end = along + (swept.low[0] + (last + 1) * swept.strips.along - middle) / cos
    if side == 1:
        return swept.angle + turn + np.pi, -offset, -end, -start, spread
    return swept.angle + turn, offset, start, end, spread


def join_lines(parts: Sequence[FaceLines]) -> FaceLines:
    """All lines in one table."""
    return FaceLines(*(np.concatenate([getattr(part, name) for part in parts]) for name in FaceLines.__slots__))
