"""Faces of walls around places that were only looked into, where no room closes."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.plan.evidence import clamp_sample
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.line_search import line_evidence
from indoor_bim.plan.passing_rays import Rays
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.strips import BELOW_CEILING, LEAST_EVIDENCE, Sweep

Floats = NDArray[np.float64]

STEP = BELOW_CEILING.along
"""Distance between the values of the evidence along a line, metres."""


def loose_faces(
    lines: FaceLines,
    sweeps: list[Sweep],
    rooms: shapely.Geometry,
    roofed: Raster,
    hits: Floats,
    origins: Floats | None,
    *,
    low: float,
    high: float,
    shortest: float = 1.6,
    away: float = 0.5,
    bridge: float = 1.6,
) -> tuple[Floats, Floats]:
    """Pieces of wall lines in places that were only looked into.

    They were seen well, have a ceiling in front, lie away from closed rooms, stopped the rays that came to them and lead to a room.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    sweeps : list of Sweep
        Sweeps of all lines.
    rooms : shapely geometry
        Closed rooms.
    roofed : Raster
        Where there is a ceiling.
    hits : (n, 3) float64
        Points of the storey, metres.
    origins : (n, 3) float64, optional
        Scanner position at each of them, metres.
    low, high : float
        Floor and ceiling, metres.
    shortest : float
        Shortest piece, metres.
    away : float
        Distance from closed rooms, metres.
    bridge : float
        Longest gap within a piece, metres.

    Returns
    -------
    p, q : (m, 2) float64
        Ends, free space to the left of p -> q, metres.
    """
    from scipy import ndimage

    around = shapely.buffer(rooms, away)
    reach = round(bridge / STEP / 2)
    pieces = []
    for k in range(len(lines)):
        start, end = float(lines.start[k]), float(lines.end[k])
        profile = line_evidence(lines, k, sweeps, start, end)
        t = start + (np.arange(len(profile)) + 0.5) * (end - start) / len(profile)
        spots = t[:, None] * lines.direction[k] + lines.offset[k] * lines.normal[k]
        good = (profile > LEAST_EVIDENCE) & ~shapely.contains_xy(around, *spots.T)
        good &= roofed.sample(spots + 1.0 * lines.normal[k]) > 0
        good = ndimage.binary_closing(np.pad(good, reach), np.ones(2 * reach + 1))[reach:-reach]
        edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(np.int8), [0]])))
        pieces += [(spots[a], spots[b - 1]) for a, b in edges.reshape(-1, 2) if (b - a) * STEP >= shortest]
    p, q = (np.array([piece[end] for piece in pieces]).reshape(-1, 2) for end in (0, 1))
    keep = without_doubles(p, q)
    rays = None
    if origins is not None and keep.any():
        outside = points_outside(around, hits[:, :2])
        rays = Rays(hits[outside], origins[outside], low + 0.1, high - 0.1)
        keep &= opaque(p, q, rays)
    p, q = p[keep], q[keep]
    if rays is not None:
        p, q = joined_pieces(p, q, rooms, rays)
    p, q = reach_out(p, q, rooms, rays)
    keep = attached(p, q, rooms)
    return p[keep], q[keep]


def points_outside(area: shapely.Geometry, xy: Floats, *, tile: float = 0.25) -> NDArray[np.int64]:
    """Rows of points (n, 2) outside of an area; those in tiles that lie well within it need no test of their own.

    Examples
    --------
    >>> points_outside(shapely.box(0, 0, 4, 3), np.array([[1.0, 1.0], [4.01, 1.0], [3.99, 1.0]])).tolist()
    [1]
    """
    core = shapely.buffer(area, -tile)
    if core.is_empty:
        return np.flatnonzero(~shapely.contains_xy(area, *xy.T))
    x0, y0, x1, y1 = core.bounds
    tiles = Raster(np.zeros((int((y1 - y0) / tile) + 3, int((x1 - x0) / tile) + 3)), np.array([x0 - tile, y0 - tile]), tile)
    rows, columns = np.indices(tiles.image.shape)
    centres = tiles.centre(np.column_stack([rows.ravel(), columns.ravel()]))
    shapely.prepare(core)
    tiles.image[...] = shapely.contains_xy(core, *centres.T).reshape(tiles.image.shape)
    unsure = np.flatnonzero(clamp_sample(tiles, xy) == 0)
    outside: NDArray[np.int64] = unsure[~shapely.contains_xy(area, *xy[unsure].T)]
    return outside


def without_doubles(p: Floats, q: Floats, *, apart: float = 0.30, share: float = 0.5) -> NDArray[np.bool_]:
    """Pieces that no longer piece looking the same way runs along: window panes and shutters in their wall.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends, free space to the left of p -> q, metres.
    apart : float
        Farthest such piece, metres.
    share : float
        Share of a piece that the longer one runs along at least.

    Returns
    -------
    (n,) bool
        Pieces to keep.
    """
    length = np.hypot(*(q - p).T)
    keep = np.ones(len(p), dtype=bool)
    order = np.lexsort((p[:, 1], p[:, 0], -np.round(length, 6)))
    for place, k in enumerate(order):
        for j in order[:place]:
            d = (q[j] - p[j]) / length[j]
            if not keep[j] or d @ (q[k] - p[k]) < 0.99 * length[k]:
                continue
            normal = np.array([-d[1], d[0]])
            across = np.array([p[k] - p[j], q[k] - p[j]]) @ normal
            along = np.clip(np.array([p[k] - p[j], q[k] - p[j]]) @ d, 0, length[j])
            if np.abs(across).max() < apart and along[1] - along[0] > share * length[k]:
                keep[k] = False
                break
    return keep


def joined_pieces(
    p: Floats, q: Floats, rooms: shapely.Geometry, rays: Rays, *, gap: float = 8.0, step: float = 0.07, turn: float = 3.0
) -> tuple[Floats, Floats]:
    """Pieces of one face joined where nothing was seen through the gap between them.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends, free space to the left of p -> q, metres.
    rooms : shapely geometry
        Closed rooms: no face runs through them.
    rays : Rays
        Rays to points outside the rooms.
    gap : float
        Longest gap, metres.
    step : float
        Largest step from the line of a piece to the next, metres: a map drifts.
    turn : float
        Largest angle between the two, degrees.

    Returns
    -------
    p, q : (m, 2) float64
        Ends, metres.
    """
    pieces = [(np.asarray(a), np.asarray(b)) for a, b in zip(p, q, strict=True)]
    k = 0
    while k < len(pieces):
        a, b = pieces[k]
        length = float(np.hypot(*(b - a)))
        d = (b - a) / length
        normal = np.array([-d[1], d[0]])
        onward = []
        for j, (c, e) in enumerate(pieces):
            ahead, aside = float((c - b) @ d), float((c - b) @ normal)
            straight = float((e - c) @ d) > np.cos(np.radians(turn)) * float(np.hypot(*(e - c)))
            if j != k and straight and 0.0 < ahead < gap and abs(aside) < step:
                onward.append((ahead, j))
        for _, j in sorted(onward)[:1]:
            c, e = pieces[j]
            stopped = rays.met(a, b)[0] / length
            if not rays.seen_through(b, c, stopped=stopped) and not shapely.LineString([b, c]).intersects(rooms):
                pieces[k] = _one_line((a, b), (c, e))
                del pieces[j]
                k = -1
                break
        k += 1
    ends = np.array(pieces).reshape(-1, 2, 2)
    return ends[:, 0], ends[:, 1]


def _one_line(first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Line along two pieces, placed between them by their lengths, from the start of the first to the end of the second."""
    share = np.linspace(0.05, 0.95, 10)[:, None]
    weight = np.repeat([float(np.hypot(*(b - a))) for a, b in (first, second)], len(share))
    spots = np.vstack([a + share * (b - a) for a, b in (first, second)])
    middle = np.average(spots, axis=0, weights=weight)
    spread = ((spots - middle) * weight[:, None]).T @ (spots - middle)
    d = np.linalg.eigh(spread)[1][:, 1]
    a, b = first[0], second[1]
    return middle + float((a - middle) @ d) * d, middle + float((b - middle) @ d) * d


def reach_out(
    p: Floats,
    q: Floats,
    rooms: shapely.Geometry,
    rays: Rays | None = None,
    *,
    near: float = 3.5,
    far: float = 8.0,
    farthest: float = 12.0,
    past: float = 1.0,
    mirrors: bool = True,
    away: float = 0.6,
) -> tuple[Floats, Floats]:
    """Pieces whose ends run on to the next room or to where they meet another piece that does the same.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends, metres.
    rooms : shapely geometry
        Closed rooms.
    rays : Rays, optional
        Rays to points outside the rooms.
    near : float
        Longest prolongation without a look at the rays, metres.
    far, farthest : float
        Longest prolongation where nothing was seen through it, and of pieces that are at least half as long, metres.
    past : float
        Longest end past what a piece meets that is cut off, metres.
    mirrors : bool
        Whether what would continue the side of a room is taken for its image in a pane, and left.
    away : float
        Nearer to the room it is that side itself, metres.

    Returns
    -------
    p, q : (n, 2) float64
        New ends, metres.
    """
    length = np.hypot(*(q - p).T)
    direction = (q - p) / length[:, None]
    new = [p.copy(), q.copy()]
    for k in range(len(p)):
        for end, (spot, d) in enumerate(((p[k], -direction[k]), (q[k], direction[k]))):
            ahead = _next_met(p, q, rooms, spot, d, reach=near, past=past)
            if ahead is None and rays is not None:
                ahead = _next_met(p, q, rooms, spot, d, reach=min(farthest, max(far, 2 * float(length[k]))), past=past)
                if ahead is not None and rays.seen_through(spot, spot + ahead * d, stopped=rays.met(p[k], q[k])[0] / float(length[k])):
                    ahead = None
            beyond_a_pane = mirrors and shapely.Point(spot).distance(rooms) > away
            if ahead is not None and beyond_a_pane and _continues_a_side(rooms, spot + ahead * d, d):
                ahead = None
            if ahead is not None:
                new[end][k] = spot + ahead * d
    return new[0], new[1]


def _continues_a_side(rooms: shapely.Geometry, end: Floats, d: Floats, *, along: float = 1.0, beside: float = 0.10) -> bool:
    """Whether a side of a room runs on from an end: a pane across shows the side again beyond, mirrored."""
    onward = shapely.LineString([end - beside * d, end + along * d]).buffer(beside, cap_style="flat")
    return bool(shapely.intersection(shapely.boundary(rooms), onward).length > 0.7 * along)


def _next_met(p: Floats, q: Floats, rooms: shapely.Geometry, spot: Floats, d: Floats, *, reach: float, past: float) -> float | None:
    """How far from a spot, along d, the next room or the line of another piece is; None if there is none within reach."""
    length = np.hypot(*(q - p).T)
    direction = (q - p) / length[:, None]
    meets = []
    beyond = shapely.LineString([spot, spot + reach * d]).intersection(rooms)
    if not beyond.is_empty:
        meets.append(float(shapely.Point(spot).distance(beyond)))
    cross = direction[:, 0] * d[1] - direction[:, 1] * d[0]
    for j in np.flatnonzero(np.abs(cross) > 0.5):
        w = p[j] - spot
        along = (w[1] * direction[j, 0] - w[0] * direction[j, 1]) / cross[j]
        on = (w[1] * d[0] - w[0] * d[1]) / cross[j]
        if -past < along < reach and -reach < on < length[j] + reach:
            meets.append(float(along))
    return min(meets) if meets else None


def opaque(p: Floats, q: Floats, rays: Rays, *, walls: float = 3.0) -> NDArray[np.bool_]:
    """Pieces that stopped nearly all rays that came to them: what only a mirror shows lets rays pass.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends, free space to the left of p -> q, metres.
    rays : Rays
        Rays to points around and behind the pieces.
    walls : float
        Rays that a wall with windows stops for each that goes through.

    Returns
    -------
    (n,) bool
        Pieces to keep.

    Examples
    --------
    >>> p, q = np.array([[2.0, 3.0]]), np.array([[0.0, 3.0]])
    >>> hits = np.array([[0.5, 3.0, 1.0], [1.5, 3.01, 1.0], [0.9, 2.99, 1.2], [1.0, 5.0, 1.0]])
    >>> opaque(p, q, Rays(hits, np.tile([1.0, 0.0, 1.0], (4, 1)), low=0.0, high=2.5)).tolist()
    [True]
    >>> opaque(p, q, Rays(hits[[0, 1, 3]], np.tile([1.0, 0.0, 1.0], (3, 1)), low=0.0, high=2.5)).tolist()
    [False]
    """
    met = np.array([rays.met(p[k], q[k]) for k in range(len(p))]).reshape(-1, 2)
    return np.asarray(met[:, 0] >= walls * met[:, 1])


def attached(p: Floats, q: Floats, rooms: shapely.Geometry, *, gap: float = 0.3) -> NDArray[np.bool_]:
    """Pieces that lead to a room, by themselves or by way of other pieces; what stands alone is a reflection or another building.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends, metres.
    rooms : shapely geometry
        Closed rooms.
    gap : float
        Widest gap between two that belong together, metres.

    Returns
    -------
    (n,) bool
        Pieces to keep.

    Examples
    --------
    >>> p, q = np.array([[1.1, 0.0], [3.0, 0.1], [3.0, 5.0]]), np.array([[3.0, 0.0], [3.0, 2.0], [5.0, 5.0]])
    >>> attached(p, q, shapely.box(0, 0, 1, 1)).tolist()
    [True, True, False]
    """
    pieces = shapely.linestrings(np.stack([p, q], axis=1))
    reached = shapely.dwithin(pieces, rooms, gap)
    for _ in range(len(p)):
        grown = shapely.dwithin(pieces, shapely.union_all(pieces[reached]), gap) | reached
        if (grown == reached).all():
            break
        reached = grown
    return np.asarray(reached, dtype=bool)
