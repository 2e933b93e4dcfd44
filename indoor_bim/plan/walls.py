"""Faces to walls: two faces that look away from each other are one wall with a measured thickness."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.face_chains import FaceChains, chain_faces
from indoor_bim.plan.intervals import Interval, merge_intervals
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ANTIPARALLEL_COS = np.cos(np.radians(4.0))  # two faces of one wall differ less than this in direction
INNER_THICKNESS = 0.20  # metres, where a building shows not a single wall from both sides
OUTER_THICKNESS = 0.30  # metres, as the far face of an outer wall is hardly ever seen from inside
TOUCHING = 0.05  # metres between stretches that are one
SHORTEST_OVERLAP = 0.10  # metres that two faces share at least to be one wall
LEAST_SHARED = 0.025  # of the longer of two lines: what is shorter says nothing about all of it


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """Straight walls in plan, one row each, metres.

    Parameters
    ----------
    p, q : (m, 2) float64
        Ends of the centre line.
    thickness : (m,) float64
        Distance between the two faces.
    measured : (m,) bool
        True where both faces were seen; otherwise the thickness is assumed.
    seen_left : (m,) bool
        Where one face was seen: True when it is the one to the left of p -> q.
    support : (m,) int64
        Points on the faces.
    coverage : (m,) float64
        Share of the visible faces that was hit.
    rmse : (m,) float64
        Root mean square distance of these points from their face.
    top : (m,) float64
        Height of the upper edge above the floor; NaN where not known.
    """

    p: Floats
    q: Floats
    thickness: Floats
    measured: NDArray[np.bool_]
    seen_left: NDArray[np.bool_]
    support: NDArray[np.int64]
    coverage: Floats
    rmse: Floats
    top: Floats

    def __len__(self) -> int:
        return len(self.p)

    @property
    def length(self) -> Floats:
        """(m,) float64 lengths of the centre lines, metres."""
        metres: Floats = np.hypot(*(self.q - self.p).T)
        return metres

    @property
    def direction(self) -> Floats:
        """(m, 2) float64 unit vectors from p to q."""
        unit: Floats = (self.q - self.p) / np.maximum(self.length, 1e-12)[:, None]
        return unit

    @property
    def normal(self) -> Floats:
        """(m, 2) float64 unit normals, to the left of p -> q."""
        d = self.direction
        return np.column_stack([-d[:, 1], d[:, 0]])

    def take(self, rows: NDArray | Sequence[int]) -> Self:
        """Walls of the given rows (indices or mask)."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})


@dataclass(frozen=True, slots=True)
class _Piece:
    """A stretch of one wall between two chains of faces, or behind one."""

    chain: int
    partner: int | None
    interval: Interval  # along the chain's line


def walls_from_faces(
    faces: Segments,
    *,
    min_thickness: float = 0.05,
    max_thickness: float = 0.60,
    bridged_gap: float = 2.5,
    offset_tolerance: float = 0.03,
    shortest_single: float = 0.60,
    usual_thickness: float | None = None,
    outer_thickness: float | None = None,
    outer: NDArray[np.bool_] | None = None,
) -> Walls:
    """Pair faces to walls.

    Faces on one line are chained over gaps (doors, walls that butt against them). Two chains that look away from each
    other, overlap, and are no thicker apart than `max_thickness` are one wall. What is seen from one side only continues
    the wall it is part of, or gets the usual thickness of its kind in this building (the median of the inner walls measured).

    Parameters
    ----------
    faces : Segments
        Faces in metres; free space to the left where `sided`. A face that is not sided is taken for the middle of a thin wall
        unless it pairs with another one.
    min_thickness, max_thickness : float
        Bounds of a wall's thickness, metres.
    bridged_gap : float
        Widest gap in a line of faces that a wall runs through, metres.
    offset_tolerance : float
        Faces on one line lie closer than this to it, metres.
    shortest_single : float
        Shorter stretches that are seen from one side are the sides of jambs and piers, no walls, metres.
    usual_thickness : float, optional
        Thickness of inner walls seen from one side, metres; default: from the walls that were measured.
    outer_thickness : float, optional
        The same for outer walls; default: 0.30, or that of the inner walls if they are thicker.
    outer : (m,) bool, optional
        Faces that have the outside behind them; default: none.

    Returns
    -------
    Walls
        Sorted by position.

    Examples
    --------
    >>> faces = Segments.from_ends([[0, 0], [4, 0.2]], [[4, 0], [0, 0.2]])
    >>> faces = replace(faces, sided=np.array([True, True]))
    >>> walls_from_faces(faces).thickness.tolist()  # free space lies between them: two walls
    [0.2, 0.2]
    >>> away = Segments.from_ends(faces.q, faces.p)
    >>> walls_from_faces(replace(away, sided=faces.sided)).measured.tolist()
    [True]
    """
    if not len(faces):
        return _stack([])
    order = np.lexsort(np.round(np.column_stack([faces.q, faces.p]).T, 6))
    faces = faces.take(order)
    chains = chain_faces(_oriented(faces, max_thickness=max_thickness), bridged_gap=bridged_gap, offset_tolerance=offset_tolerance)
    pieces = _pieces(chains, min_thickness=min_thickness, max_thickness=max_thickness)
    pairs = sorted({(min(x.chain, x.partner), max(x.chain, x.partner)) for x in pieces if x.partner is not None})
    two_sided = [wall for pair in pairs for wall in _two_sided(chains, pair, pieces)]
    usual = _usual(two_sided) if usual_thickness is None else usual_thickness
    outside = max(OUTER_THICKNESS, usual) if outer_thickness is None else outer_thickness
    is_outer = np.zeros(len(faces), dtype=bool) if outer is None else outer[order]
    one_sided = [
        _one_sided(chains, piece, thickness=outside if chains.mostly(is_outer, piece.chain) else usual)
        for piece in pieces
        if piece.partner is None and piece.interval[1] - piece.interval[0] > shortest_single
    ]
    one_sided = [wall for wall in one_sided if not _is_side_of_another(wall, two_sided + one_sided)]
    return _stack(two_sided + one_sided)


def _oriented(faces: Segments, *, max_thickness: float) -> Segments:
    """Give a side to faces without one, where the nearest face across says which.

    A face not sided that has an opposite face with known sides within a wall's thickness must look the other way.
    """
    p, q, sided = faces.p.copy(), faces.q.copy(), faces.sided.copy()
    d, n, m = faces.direction, faces.normal, (faces.p + faces.q) / 2
    for i in np.flatnonzero(~faces.sided):
        offset = (m - m[i]) @ n[i]
        along = np.abs((m - m[i]) @ d[i])
        near = (
            faces.sided
            & (np.abs(d @ d[i]) > ANTIPARALLEL_COS)
            & (np.abs(offset) < max_thickness)
            & (np.abs(offset) > 0.03)
            & (along < (faces.length + faces.length[i]) / 2)
        )
        near &= n @ n[i] * offset > 0  # that face looks away from this one
        if near.any():
            j = np.flatnonzero(near)[np.argmin(np.abs(offset[near]))]
            if offset[j] > 0:  # material lies to the left: turn round
                p[i], q[i] = faces.q[i], faces.p[i]
            sided[i] = True
    return replace(faces, p=p, q=q, sided=sided)


def _pieces(chains: FaceChains, *, min_thickness: float, max_thickness: float) -> list[_Piece]:
    """Cut every chain where its nearest opposite chain changes; fill what has none from its neighbours."""
    out: list[_Piece] = []
    limits = {"min_thickness": min_thickness, "max_thickness": max_thickness}
    options = [_opposite(chains, i, near, **limits) for i, near in enumerate(_across_a_wall(chains, **limits))]
    for i in range(len(chains)):
        for lo, hi in chains.extents[i]:
            cuts = sorted({lo, hi, *(x for _, _, (a, b) in options[i] for x in (a, b) if lo < x < hi)})
            labels: list[int | None] = []
            for a, b in itertools.pairwise(cuts):
                middle = (a + b) / 2
                here = [(t, j) for t, j, (u, v) in options[i] if u <= middle <= v]
                labels.append(min(here)[1] if here else None)
            spans = _filled([(a, b) for a, b in itertools.pairwise(cuts)], labels)
            out += [_Piece(i, partner, span) for span, partner in spans]
    return out


def _across_a_wall(chains: FaceChains, *, min_thickness: float, max_thickness: float, slack: float = 1e-6) -> list[Ints]:
    """Chains that may be across a wall from each chain: what `_opposite` asks of their stretches, asked of whole chains."""
    reach = np.array([[min(a for a, _ in spans), max(b for _, b in spans)] if spans else [np.nan] * 2 for spans in chains.extents])
    ends = chains.point[:, None] + reach.reshape(-1, 2, 1) * chains.direction[:, None]
    found = []
    for i in range(len(chains)):
        away = ends - chains.point[i]
        along, depth = away @ chains.direction[i], -(away @ chains.normal[i])
        near = (depth.max(axis=1) > min_thickness - slack) & (depth.min(axis=1) < max_thickness + slack)
        near &= (along.max(axis=1) > reach[i, 0] - slack) & (along.min(axis=1) < reach[i, 1] + slack)
        opposed = chains.sided[i] & chains.sided & (chains.direction @ chains.direction[i] < -ANTIPARALLEL_COS)
        found.append(np.flatnonzero(near & opposed))
    return found


def _opposite(
    chains: FaceChains, i: int, candidates: Ints, *, min_thickness: float, max_thickness: float
) -> list[tuple[float, int, Interval]]:
    """Those of some chains that are across a wall from chain i: (thickness, chain, interval along i) of every shared stretch."""
    out: list[tuple[float, int, Interval]] = []
    for j in candidates:
        for a, b in chains.extents[j]:
            ends = chains.point[j] + np.outer([b, a], chains.direction[j]) - chains.point[i]
            lo, hi = ends @ chains.direction[i]
            for u, v in chains.extents[i]:
                lo_, hi_ = max(lo, u), min(hi, v)
                if hi_ - lo_ < max(SHORTEST_OVERLAP, LEAST_SHARED * max(hi - lo, v - u)):
                    continue
                depth = -(ends @ chains.normal[i])
                share = ((lo_ + hi_) / 2 - lo) / max(hi - lo, 1e-9)
                t = float(depth[0] + share * (depth[1] - depth[0]))
                if min_thickness <= t <= max_thickness:
                    out.append((t, int(j), (float(lo_), float(hi_))))
    return out


def _filled(spans: list[Interval], labels: list[int | None]) -> list[tuple[Interval, int | None]]:
    """Give stretches without partner the partner of the nearer labelled neighbour; join equal neighbours."""
    known = [k for k, label in enumerate(labels) if label is not None]
    filled = list(labels)
    for k, label in enumerate(labels):
        if label is None and known:
            nearest = min(known, key=lambda m: (max(spans[m][0] - spans[k][1], spans[k][0] - spans[m][1]), m))
            filled[k] = labels[nearest]
    out: list[tuple[Interval, int | None]] = []
    for span, label in zip(spans, filled, strict=True):
        if out and out[-1][1] == label:
            out[-1] = ((out[-1][0][0], span[1]), label)
        else:
            out.append((span, label))
    return out


def _two_sided(chains: FaceChains, pair: tuple[int, int], pieces: list[_Piece]) -> list[Walls]:
    """Walls between two chains that look away from each other."""
    i, j = pair
    di = chains.direction[i]
    # bisecting line of the two faces, weighted by nothing: each face counts as much as the other
    direction = di - chains.direction[j]
    direction /= np.hypot(*direction)
    normal = np.array([-direction[1], direction[0]])
    spans: list[Interval] = []
    for piece in pieces:
        if {piece.chain, piece.partner} == {i, j}:
            ends = chains.point[piece.chain] + np.outer(piece.interval, chains.direction[piece.chain])
            a, b = sorted(float(x) for x in ends @ direction)
            spans.append((a, b))
    out = []
    for a, b in merge_intervals(spans, gap=TOUCHING):
        middle = (a + b) / 2
        offsets = [chains.offset_at(k, direction=direction, along=middle) for k in (i, j)]
        axis = float(np.mean(offsets))
        left = offsets[0] > offsets[1]
        out.append(
            _wall(
                p=direction * a + normal * axis,
                q=direction * b + normal * axis,
                thickness=abs(offsets[0] - offsets[1]),
                measured=True,
                seen_left=left,
                evidence=chains.evidence((i, j), direction=direction, span=(a, b)),
            )
        )
    return out


def _one_sided(chains: FaceChains, piece: _Piece, *, thickness: float) -> Walls:
    """Wall behind a face that was seen from one side; around the line itself where the side is unknown."""
    i = piece.chain
    d, n = chains.direction[i], chains.normal[i]
    depth = thickness / 2 if chains.sided[i] else 0.0
    a, b = piece.interval
    along = float(chains.point[i] @ d)
    return _wall(
        p=chains.point[i] + d * a - n * depth,
        q=chains.point[i] + d * b - n * depth,
        thickness=thickness,
        measured=False,
        seen_left=True,
        evidence=chains.evidence((i,), direction=d, span=(along + a, along + b)),
    )


def _usual(walls: list[Walls]) -> float:
    """Median thickness of the walls that are longer than they are thick."""
    t = [float(w.thickness[0]) for w in walls if w.length[0] > 2 * w.thickness[0]]
    return float(np.median(t)) if t else INNER_THICKNESS


def _is_side_of_another(wall: Walls, others: list[Walls]) -> bool:
    """Tell whether a short wall lies inside longer ones: the side of a pier or of a jamb."""
    if wall.length[0] > 2 * wall.thickness[0]:
        return False
    share = np.linspace(0.1, 0.9, 5)[:, None]
    spots = wall.p + share * (wall.q - wall.p)
    inside = np.zeros(len(spots), dtype=bool)
    for other in others:
        if other.length[0] <= wall.length[0]:
            continue
        d, n = other.direction[0], other.normal[0]
        along, across = (spots - other.p[0]) @ d, (spots - other.p[0]) @ n
        inside |= (along >= 0) & (along <= other.length[0]) & (np.abs(across) <= other.thickness[0] / 2)
    return bool(inside.mean() >= 0.7)


def _wall(*, p: Floats, q: Floats, thickness: float, measured: bool, seen_left: bool, evidence: tuple[int, float, float, float]) -> Walls:
    support, coverage, rmse, top = evidence
    return Walls(
        p=p[None],
        q=q[None],
        thickness=np.array([thickness]),
        measured=np.array([measured]),
        seen_left=np.array([seen_left]),
        support=np.array([support], dtype=np.int64),
        coverage=np.array([coverage]),
        rmse=np.array([rmse]),
        top=np.array([top]),
    )


def _stack(walls: list[Walls]) -> Walls:
    """One table of all walls, sorted by position, each pointing towards +x (or +y)."""
    if not walls:
        none = np.zeros(0)
        return Walls(
            np.zeros((0, 2)), np.zeros((0, 2)), none, none.astype(bool), none.astype(bool), none.astype(np.int64), none, none, none
        )
    table = Walls(**{name: np.concatenate([getattr(w, name) for w in walls]) for name in Walls.__slots__})
    d = np.round(table.q - table.p, 6)
    backwards = (d[:, 0] < 0) | ((d[:, 0] == 0) & (d[:, 1] < 0))
    flip = backwards[:, None]
    table = replace(
        table,
        p=np.where(flip, table.q, table.p),
        q=np.where(flip, table.p, table.q),
        seen_left=table.seen_left ^ backwards,
    )
    return table.take(np.lexsort(np.round(np.column_stack([table.q, table.p]).T, 6)))
