"""Lines of wall faces in all directions and at all densities of the scan, and the evidence along them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.cells import Cells
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import FaceLines, face_lines, join_lines
from indoor_bim.plan.folds import without_curtains
from indoor_bim.plan.hangings import hangings
from indoor_bim.plan.line_fit import fit_to_points
from indoor_bim.plan.line_merging import APART, merge_lines
from indoor_bim.plan.local_density import thinly_scanned
from indoor_bim.plan.map_drift import largest_double
from indoor_bim.plan.oblique import other_directions, unexplained
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.strips import BELOW_CEILING, FAR, THIN, WHOLE_COLUMN, Strips, Sweep, evidence_along, sweep
from indoor_bim.threads import in_threads, most_threads

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

REACH = 1.5
"""How far past the ends of a line its edges may lie, metres."""
MAIN = (0.0, float(np.pi / 2))
"""Main directions of a levelled scan, radians."""
FINELY = 600.0
"""Points per square metre from which fine strips show all there is."""
AFAR = 100.0
"""Points per square metre below which the scanner only looked in from afar."""


def find_lines(points: WallPoints, overhead: Raster | None) -> tuple[FaceLines, list[Sweep]]:
    """Lines of faces, and the sweeps that show them: densely scanned walls first, then those that were seen from far away.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    overhead : Raster, optional
        Points per square metre of the surface overhead; without it, walls are sought in the whole column.

    Returns
    -------
    lines : FaceLines
        Lines, pieces that continue one another merged, placed on the points.
    sweeps : list of Sweep
        Every sweep; ``lines.family`` numbers them.
    """
    if overhead is None:
        sweeps = [sweep(points, angle, strips=WHOLE_COLUMN) for angle in MAIN]
        return merge_lines(join_lines([face_lines(swept, family=k) for k, swept in enumerate(sweeps)])), sweeps
    sweeps = []
    lines = FaceLines.none()
    for strips, sparse in ((BELOW_CEILING, np.inf), (THIN, FINELY), (FAR, AFAR)):
        candidates = points if np.isinf(sparse) else points.take(thinly_scanned(points, overhead, sparse=sparse, whole=strips is FAR))
        if not len(candidates):
            continue
        shown, found = _swept(candidates, MAIN, strips, first=len(sweeps))
        sweeps += shown
        if strips is BELOW_CEILING:
            rest = unexplained(candidates, join_lines([lines, *found]))
            shown, others = _swept(rest, other_directions(rest), strips, first=len(sweeps))
            sweeps, found = sweeps + shown, found + others
        more = join_lines(found)
        lines = merge_lines(join_lines([lines, more.take(~beside(more, lines))]))
    lines = without_curtains(lines, points)
    drift = largest_double(lines, points)
    if drift > APART:
        lines = merge_lines(lines, apart=drift)
    lines = fit_to_points(lines, points)
    hung = hangings(lines, lambda row, start, end: line_evidence(lines, row, sweeps, start, end))
    return lines.take(~hung), sweeps


def _swept(points: WallPoints, angles: Sequence[float], strips: Strips, *, first: int) -> tuple[list[Sweep], list[FaceLines]]:
    """Bare sweeps along some directions and the lines that they show; `first`: number of the first of these sweeps."""

    def one(k: int) -> tuple[Sweep, FaceLines]:
        swept = sweep(points, angles[k], strips=strips)
        return swept.bare(), face_lines(swept, family=first + k)

    both = in_threads(one, range(len(angles)), threads=min(most_threads(), 2))
    return [swept for swept, _ in both], [lines for _, lines in both]


def beside(lines: FaceLines, others: FaceLines, *, near: float = 0.05, far: float = 0.35, share: float = 0.5) -> Bools:
    """Lines that run along others close by, looking the same way: window panes and curtains along the wall that they are in.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    others : FaceLines
        Lines that are certain.
    near, far : float
        Distances between which a line is beside another, metres; nearer, it is the same.
    share : float
        Share of a line that the other runs along at least.

    Returns
    -------
    (m,) bool
        One value for each line.
    """
    p, q = lines.ends()
    found = np.zeros(len(lines), dtype=bool)
    for k in range(len(others)):
        d, normal = others.direction[k], others.normal[k]
        along, across = np.array([p @ d, q @ d]), np.array([p @ normal, q @ normal]) - others.offset[k]
        common = np.minimum(along.max(axis=0), others.end[k]) - np.maximum(along.min(axis=0), others.start[k])
        apart = np.abs(across.mean(axis=0))
        found |= (lines.direction @ d > 0.99) & (apart > near) & (apart < far) & (common > share * (lines.end - lines.start))
    return found


def look_into_free_space(lines: FaceLines, horizontal: Raster) -> NDArray[np.bool_]:
    """Lines with at least as much floor and ceiling close to their left as to their right.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    horizontal : Raster
        Image that is not zero where floor or ceiling was hit.
    """
    keep = np.ones(len(lines), dtype=bool)
    away = np.arange(0.05, 0.13, horizontal.cell)
    for k in range(len(lines)):
        t = np.arange(float(lines.start[k]), float(lines.end[k]), horizontal.cell)
        foot = t[:, None] * lines.direction[k] + lines.offset[k] * lines.normal[k]
        left, right = (sum(int((horizontal.sample(foot + side * d * lines.normal[k]) > 0).sum()) for d in away) for side in (1, -1))
        keep[k] = left >= right
    return keep


def folded_lines(lines: FaceLines, *, times: float = 1.4) -> NDArray[np.bool_]:
    """Lines whose points scatter across by more than those of the usual wall: curtains."""
    length = lines.end - lines.start
    order = np.argsort(lines.spread, kind="stable")
    half = np.searchsorted(np.cumsum(length[order]), length.sum() / 2)
    usual = lines.spread[order[min(half, len(order) - 1)]] if len(order) else 0.0
    folded: NDArray[np.bool_] = lines.spread > times * max(usual, 0.5 * BELOW_CEILING.across)
    return folded


def line_evidence(lines: FaceLines, row: int, sweeps: list[Sweep], start: float, end: float) -> Floats:
    """Best wall evidence along a line in the sweeps of about its direction, one value every 10 cm.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    row : int
        Line.
    sweeps : list of Sweep
        Sweeps of all lines.
    start, end : float
        Extent along the line, metres.
    """
    best: Floats = np.maximum.reduce([shown for _, shown in _shown_along(lines, row, sweeps, start, end)])
    return best


def _shown_along(lines: FaceLines, row: int, sweeps: list[Sweep], start: float, end: float) -> list[tuple[Sweep, Floats]]:
    """Wall evidence along a line in each sweep of its direction."""
    angle, offset = float(lines.angle[row]), float(lines.offset[row])
    own = sweeps[lines.family[row]].angle
    return [(s, evidence_along(s, angle, offset, start, end)) for s in sweeps if s.angle == own]


def edge_evidence(cells: Cells, lines: FaceLines, sweeps: list[Sweep]) -> tuple[Floats, Floats]:
    """Share of each edge where the face of its line was seen, and where it was seen from nearby.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    lines : FaceLines
        Lines that it was made from, in their order.
    sweeps : list of Sweep
        Sweeps of all lines.

    Returns
    -------
    seen, from_nearby : (e,) float64
        Shares; 0 on edges of other lines.
    """
    shares = np.zeros((2, len(cells.edge_line)))
    for line in range(len(lines)):
        rows = np.flatnonzero(cells.edge_line == line)
        if not len(rows):
            continue
        start, end = float(lines.start[line]) - REACH, float(lines.end[line]) + REACH
        shown = _shown_along(lines, line, sweeps, start, end)
        best = np.maximum.reduce([values for _, values in shown]), np.maximum.reduce([v for s, v in shown if s.strips is not FAR])
        u0, u1 = cells.edge_start[rows] @ lines.direction[line], cells.edge_end[rows] @ lines.direction[line]
        at, length = np.linspace(start, end, len(best[0]) + 1), np.maximum(u1 - u0, 1e-6)
        for share, values in zip(shares, best, strict=True):
            profile = np.clip((values - 0.15) / 0.5, 0, 1)
            total = np.concatenate([[0.0], np.cumsum(profile)]) * (end - start) / len(profile)
            share[rows] = (np.interp(u1, at, total) - np.interp(u0, at, total)) / length
    seen, from_nearby = np.clip(shares, 0, 1)
    return seen, from_nearby
