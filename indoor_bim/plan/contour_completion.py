"""Contour completion: ends of segments extended to corners, closed over small gaps, or left open as a door or window."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HALF_RIGHT_COS = np.cos(np.radians(45.0))  # less parallel: the ends make a corner; more: a gap
BACK_COS = np.cos(np.radians(10.0))  # less parallel: not the same face, nor the other face of a wall
IN_LINE = 0.05  # metres across: ends that are farther apart make a step, not a bend
CORNER, CLOSED, STEP, GAP = 1, 2, 3, 4
THINNEST_WALL, THICKEST_WALL = 0.05, 0.5  # metres between a face and the one at its back
BACKED = 0.9  # of the way to a corner that was not seen: the face at the back goes along


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """Segments and how their ends hang together.

    Parameters
    ----------
    segments : Segments
        The segments, ends moved.
    follows : (m, 2) int64
        For the start and the end of each segment the end that it is linked to, as twice its row plus 0 for a start and 1 for
        an end; -1: none.
    kind : (m, 2) int8
        How: `CORNER`, `CLOSED`, `STEP`, `GAP`; 0: not linked.
    """

    segments: Segments
    follows: Ints
    kind: NDArray[np.int8]

    def pairs(self, kind: int) -> Ints:
        """Pairs (k, 2) of ends that are linked in a way, the smaller first: those with a `GAP` between them, or a `STEP`."""
        ends = np.flatnonzero(self.kind.ravel() == kind)
        partner = self.follows.ravel()[ends]
        return np.column_stack([ends, partner])[ends < partner]

    def place(self, ends: Ints) -> Floats:
        """Place (k, 2) of ends given as twice the row plus 0 or 1, metres."""
        spots: Floats = np.stack([self.segments.p, self.segments.q], axis=1).reshape(-1, 2)[ends]
        return spots

    def closed_share(self) -> float:
        """Share of the length of all segments that belongs to closed contours."""
        rows = [row for ring in self.rings() for row in ring]
        length = self.segments.length
        return float(length[rows].sum() / max(length.sum(), 1e-9))

    def rings(self) -> list[list[int]]:
        """Rows of the segments of each closed contour, in the order in which they follow one another."""
        follows = self.follows.ravel()
        rings, seen = [], np.zeros(len(self.segments), dtype=bool)
        for start in range(len(self.segments)):
            ring, end = [], 2 * start + 1
            while not seen[end // 2] and follows[end] >= 0:
                seen[end // 2] = True
                ring.append(end // 2)
                end = int(follows[end]) ^ 1
            if ring and end == 2 * start + 1:
                rings.append(ring)
        return rings


def complete_contour(segments: Segments, *, gap: float = 0.5, reach: float = 0.5, far_reach: float = 2.0, widest: float = 3.0) -> Contour:
    """Complete the contour that segments are parts of (section 1.4.2).

    Ends of two segments are linked, the nearest first, each to one other end; ends of faces whose side is known only so that free
    space stays on the same side. At an angle of 45 to 90 degrees both become the intersection of the lines. At a smaller angle and
    end to end, both become their mean where they are less than `gap` apart along x and along y; otherwise the gap is left for a
    door or window. Segments that lie side by side are left alone.

    The paper takes the mean of both coordinates, which bends walls that jump. Here ends that are more than `IN_LINE` apart across the
    segments meet half way along, and a step remains between them.

    Parameters
    ----------
    segments : Segments
        Segments, metres, x along a main direction.
    gap : float
        Gaps shorter than this along x and along y are closed, metres.
    reach : float
        Ends are moved to a corner by no more than this, metres.
    far_reach : float
        Ends that are left are moved on to a corner by no more than this, and no segment becomes more than twice as long, metres.
    widest : float
        Gaps wider than this are not linked, metres. Ends are moved on to a corner by up to this where the other face of the wall,
        seen from its other side, goes along all the way.

    Returns
    -------
    Contour
        Segments with moved ends, and the links.

    Examples
    --------
    >>> corner = complete_contour(Segments.from_ends([[0, 0], [3.1, 0.2]], [[2.9, 0], [3.1, 2]]))
    >>> corner.segments.q[0].tolist(), corner.segments.p[1].tolist()
    ([3.1, 0.0], [3.1, 0.0])
    >>> door = complete_contour(Segments.from_ends([[0, 0], [3, 0]], [[2, 0], [5, 0]]))
    >>> door.pairs(GAP).tolist()
    [[1, 2]]
    """
    m = len(segments)
    follows, kind = np.full(2 * m, -1, dtype=np.int64), np.zeros(2 * m, dtype=np.int8)
    if m < 2:
        return Contour(segments, follows.reshape(-1, 2), kind.reshape(-1, 2))
    a, b, how, cost, to_a, to_b, outwards = _links(segments, gap=gap, reach=max(reach, far_reach, widest), widest=widest)
    ends = np.stack([segments.p, segments.q], axis=1).reshape(-1, 2)
    place = np.round(ends, 6)
    moves = np.hypot(*(to_a - ends[a]).T), np.hypot(*(to_b - ends[b]).T)
    far = (how == CORNER) & (np.maximum(*moves) > reach)
    shown = [
        (move <= np.minimum(segments.length[end // 2], far_reach)) | (far & (other <= reach) & _backed(segments, end // 2, ends[end], to))
        for move, other, end, to in zip(moves, moves[::-1], (a, b), (to_a, to_b), strict=True)
    ]
    allowed = ~far | (outwards & shown[0] & shown[1])
    turn = np.where(far, 2, how == GAP)  # first what is near, then gaps, then corners that were not seen
    order = np.lexsort((place[b, 1], place[b, 0], place[a, 1], place[a, 0], np.round(cost, 6), turn))
    moved = ends.copy()
    for k in order[allowed[order]]:
        if follows[a[k]] >= 0 or follows[b[k]] >= 0 or follows[a[k] ^ 1] == b[k]:
            continue
        follows[a[k]], follows[b[k]] = b[k], a[k]
        kind[a[k]] = kind[b[k]] = how[k]
        if how[k] != GAP:
            moved[a[k]], moved[b[k]] = to_a[k], to_b[k]
    p, q = moved[0::2], moved[1::2]
    turned = ((q - p) * segments.direction).sum(axis=1) <= 0
    p, q = np.where(turned[:, None], segments.p, p), np.where(turned[:, None], segments.q, q)
    lost = np.repeat(turned, 2)
    lost |= lost[follows] & (follows >= 0)
    follows[lost], kind[lost] = -1, 0
    return Contour(replace(segments, p=p, q=q), follows.reshape(-1, 2), kind.reshape(-1, 2))


def _backed(segments: Segments, row: Ints, start: Floats, end: Floats) -> NDArray[np.bool_]:
    """Ways (k,) on from faces that a face at the back of the same wall goes along."""
    d, n = segments.direction[row], segments.normal[row]
    way = np.sort(np.stack([np.zeros(len(row)), ((end - start) * d).sum(axis=1)]), axis=0)
    out = np.zeros(len(row), dtype=bool)
    for p, q, sided, direction in zip(segments.p, segments.q, segments.sided, segments.direction, strict=True):
        behind = ((start - (p + q) / 2) * n).sum(axis=1)
        at = np.sort(np.stack([((p - start) * d).sum(axis=1), ((q - start) * d).sum(axis=1)]), axis=0)
        shared = np.minimum(at[1], way[1]) - np.maximum(at[0], way[0])
        back = sided & segments.sided[row] & (d @ direction < -BACK_COS) & (behind >= THINNEST_WALL) & (behind <= THICKEST_WALL)
        out |= back & (shared >= BACKED * (way[1] - way[0]))
    return out


def interrupted(contour: Contour, *, gap: float = 0.5, widest: float = 3.0, in_line: float = 0.02) -> Ints:
    """Pairs (k, 2) of ends between which a face goes on though only one was left: the other is a corner with what stands in between.

    That is the jamb of a door of which the other jamb was not seen, up to `widest` away, or something thin that ends at the face.

    Parameters
    ----------
    contour : Contour
        Completed contour.
    gap : float
        Largest gap at something that ends at the face from in front, metres.
    widest : float
        Largest gap at a jamb, metres.
    in_line : float
        Each end is no farther than this from the line of the other, metres.
    """
    segments, follows = contour.segments, contour.follows.ravel()
    ends = np.stack([segments.p, segments.q], axis=1).reshape(-1, 2)
    corners = np.flatnonzero((contour.kind.ravel() == CORNER) & np.repeat(segments.sided, 2))
    partner = follows[corners] // 2
    middle = (segments.p[partner] + segments.q[partner]) / 2
    jamb = ((middle - ends[corners]) * segments.normal[corners // 2]).sum(axis=1) < 0
    pairs = []
    for a in np.flatnonzero((follows < 0) & np.repeat(segments.sided, 2)):
        d, n = segments.direction[a // 2] * (1 if a % 2 else -1), segments.normal[a // 2]
        along, across = (ends[corners] - ends[a]) @ d, (ends[corners] - ends[a]) @ n
        fits = (
            (corners % 2 != a % 2) & (corners // 2 != a // 2) & (segments.direction[corners // 2] @ segments.direction[a // 2] > BACK_COS)
        )
        back = np.abs(((ends[corners] - ends[a]) * segments.normal[corners // 2]).sum(axis=1))
        fits &= (np.maximum(np.abs(across), back) <= in_line) & (along > 0) & (along <= np.where(jamb, widest, gap))
        if fits.any():
            pairs.append((int(a), int(corners[fits][np.argmin(along[fits])])))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _links(
    segments: Segments, *, gap: float, reach: float, widest: float
) -> tuple[Ints, Ints, NDArray[np.int8], Floats, Floats, Floats, NDArray[np.bool_]]:
    """Pairs of ends that may be linked: both ends, how, how far they move, where each goes, and whether both are prolonged."""
    from scipy.spatial import cKDTree

    ends = np.stack([segments.p, segments.q], axis=1).reshape(-1, 2)
    outward = np.stack([-segments.direction, segments.direction], axis=1).reshape(-1, 2)
    row = np.arange(len(ends)) // 2
    a, b = cKDTree(ends).query_pairs(np.hypot(reach, max(reach, widest)) + reach, output_type="ndarray").astype(np.int64).reshape(-1, 2).T
    near = row[a] != row[b]
    sided = segments.sided[row]
    near &= ~(sided[a] & sided[b]) | (a % 2 != b % 2)
    a, b = a[near], b[near]
    between = ends[b] - ends[a]
    u, v = outward[a], outward[b]
    steep = np.abs((u * v).sum(axis=1)) <= HALF_RIGHT_COS + 1e-12
    sine = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        move_a = (between[:, 0] * v[:, 1] - between[:, 1] * v[:, 0]) / sine
        move_b = (between[:, 0] * u[:, 1] - between[:, 1] * u[:, 0]) / sine
    length = segments.length[row]
    corner = steep & (np.abs(move_a) <= reach) & (np.abs(move_b) <= reach)
    corner &= (move_a > -length[a] / 2) & (move_b > -length[b] / 2)
    along, across = np.abs((between * u).sum(axis=1)), np.abs(between[:, 0] * u[:, 1] - between[:, 1] * u[:, 0])
    facing = ~steep & ((u * v).sum(axis=1) < 0) & ((between * u).sum(axis=1) > -IN_LINE)
    near = facing & (np.abs(between) < gap).all(axis=1)
    step = near & (across > IN_LINE)
    closed = near & ~step
    wide = facing & ~near & (across <= IN_LINE) & (along <= widest)
    keep = corner | near | wide
    how = np.where(corner, CORNER, np.where(closed, CLOSED, np.where(step, STEP, GAP))).astype(np.int8)[keep]
    cost = np.where(corner, np.abs(move_a) + np.abs(move_b), np.hypot(*between.T))[keep]
    meeting = ends[a] + np.where(corner, move_a, 0.0)[:, None] * u
    half = ((between * u).sum(axis=1) / 2)[:, None] * u
    to_a = np.where(corner[:, None], meeting, np.where(step[:, None], ends[a] + half, (ends[a] + ends[b]) / 2))
    to_b = np.where(step[:, None], ends[b] - half, to_a)
    return a[keep], b[keep], how, cost, to_a[keep], to_b[keep], ((move_a > 0) & (move_b > 0))[keep]
