"""Segments that are one line within their uncertainty become one, tested by chi square."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.polar_fit import PolarLines, fit_lines, project_ends

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CROSSING_COS = np.cos(np.radians(30.0))  # what is less parallel than this to a line can end in a gap of it
CROSSING_REACH = 0.10  # metres around a gap
TOUCHING = 0.03  # metres: a shorter gap cannot hold the end of another wall


def chi_square_limit(sigma: float) -> float:
    """Largest chi square of two degrees of freedom that is as probable as a deviation of `sigma` standard deviations.

    Examples
    --------
    >>> round(chi_square_limit(3.0), 2)
    11.83
    """
    return -2 * math.log(math.erfc(sigma / math.sqrt(2)))


def chi_square(first: PolarLines, second: PolarLines, *, sided: NDArray[np.bool_] | bool = True) -> Floats:
    """Chi square of the difference of lines, row by row (section 1.4.1; Pfister et al., section V).

    With dL = (difference of alpha, difference of R) it is dLᵀ (P1 + P2)⁻¹ dL. Compare lines with respect to an origin near both
    (`PolarLines.moved`): what one says about a far place is worth little.

    Parameters
    ----------
    first, second : PolarLines
        Lines.
    sided : bool or (m,) bool
        True where the normals tell sides apart; elsewhere a line equals the same line with the opposite normal.

    Returns
    -------
    (m,) float64

    Examples
    --------
    >>> matrix = np.diag([1e-4, 1e-4])[None]
    >>> a, b = (PolarLines(np.zeros(1), np.array([r]), matrix) for r in (2.0, 2.02))
    >>> chi_square(a, b).round(6).tolist()
    [2.0]
    """
    turned = (second.alpha - first.alpha + np.pi) % (2 * np.pi) - np.pi
    other = ~np.broadcast_to(sided, turned.shape) & (np.abs(turned) > np.pi / 2)
    d_alpha = np.where(other, (turned + np.pi / 2) % np.pi - np.pi / 2, turned)
    sign = np.where(other, -1.0, 1.0)
    d_radius = sign * second.radius - first.radius
    total = first.covariance + second.covariance
    cross = first.covariance[:, 0, 1] + sign * second.covariance[:, 0, 1]
    aa, rr = total[:, 0, 0], total[:, 1, 1]
    out: Floats = (d_alpha**2 * rr - 2 * d_alpha * d_radius * cross + d_radius**2 * aa) / (aa * rr - cross**2)
    return out


def with_map_noise(lines: PolarLines, p: Floats, q: Floats, *, noise: float) -> PolarLines:
    """Lines whose covariance also holds the error of the map: points measured at about the same time are off by the same.

    Parameters
    ----------
    lines : PolarLines
        Lines.
    p, q : (m, 2) float64
        Their ends, metres.
    noise : float
        Standard deviation with which a stretch of wall is off as a whole, metres.
    """
    middle = (p + q) / 2
    here = lines.moved(middle)
    length = np.maximum(np.hypot(*(q - p).T), 1e-6)
    covariance = here.covariance.copy()
    covariance[:, 0, 0] += 12 * (noise / length) ** 2
    covariance[:, 1, 1] += noise**2
    wider = PolarLines(here.alpha, here.radius, covariance)
    return wider.moved(-middle)


def merge_lines(
    points: Floats,
    group: Ints,
    covariance: Floats,
    *,
    front: Floats | None = None,
    sigma: float = 3.0,
    gap: float = 0.5,
    map_noise: float = 0.0,
    farthest: float = np.inf,
) -> Ints:
    """Merge sets of points whose lines do not differ by more than their uncertainty, and that lie close to one another.

    In every round each set is compared with all within `gap`; sets that are each other's best match are merged, and all lines are fitted
    again. So the order of the sets and of the points does not matter. Sets are kept apart where another wall ends in the gap between them.

    Parameters
    ----------
    points : (n, 2) float64
        Points, metres.
    group : (n,) int64
        Set of each point; negative: none.
    covariance : (n, 2, 2) float64
        Covariance of each point, square metres.
    front : (m, 2) float64, optional
        For each set a place in front of it, metres, NaN where not known: faces that look to opposite sides are not merged.
    sigma : float
        Gate in standard deviations.
    gap : float
        Largest distance between two sets, metres.
    map_noise : float
        Standard deviation of the map, metres, see `with_map_noise`.
    farthest : float
        No end of two merged lines lies farther from the line that is the mean of both, weighted by their covariances, metres.

    Returns
    -------
    (n,) int64
        New sets, numbered from 0 by the coordinates of their ends.
    """
    limit = chi_square_limit(sigma)
    count = int(group.max(initial=-1)) + 1
    front = np.full((count, 2), np.nan) if front is None else front.copy()
    group = group.copy()
    lines = fit_lines(points, group, covariance, count=count)
    p, q = project_ends(points, group, lines)
    while True:
        known = np.isfinite(front[:, 0]) & np.isfinite(lines.alpha)
        lines = lines.facing(np.where(known[:, None], front, np.nan))
        gates = {"gap": gap, "limit": limit, "farthest": farthest}
        pairs = _best_pairs(lines, with_map_noise(lines, p, q, noise=map_noise), p, q, known, **gates)
        if not len(pairs):
            break
        target = np.arange(count)
        target[pairs[:, 1]] = pairs[:, 0]
        front = _mean_front(front, np.bincount(group[group >= 0], minlength=count), target)
        present, number = np.unique(target, return_inverse=True)
        changed = np.isin(present, pairs[:, 0])
        lines, p, q = lines.take(present), p[present], q[present]
        group = np.where(group >= 0, number[target[group]], -1)
        count = len(present)
        rows = np.flatnonzero((group >= 0) & changed[group])
        again = np.full(count, -1, dtype=np.int64)
        again[changed] = np.arange(changed.sum())
        fitted = fit_lines(points[rows], again[group[rows]], covariance[rows], count=int(changed.sum()))
        ends = project_ends(points[rows], again[group[rows]], fitted)
        for name in PolarLines.__slots__:
            getattr(lines, name)[changed] = getattr(fitted, name)
        p[changed], q[changed] = ends
    swap = (q[:, 0] < p[:, 0]) | ((q[:, 0] == p[:, 0]) & (q[:, 1] < p[:, 1]))
    places = np.round(np.where(swap[:, None], np.hstack([q, p]), np.hstack([p, q])), 6)
    rank = np.zeros(count, dtype=np.int64)
    rank[np.lexsort(places.T[::-1])] = np.arange(count)
    out: Ints = np.where(group >= 0, rank[group], -1) if count else group
    return out


def _mean_front(front: Floats, size: Ints, target: Ints) -> Floats:
    """Places in front of the sets that are left when each set goes into its target: means weighted by their points."""
    weight = np.where(np.isfinite(front[:, 0]), size, 0)
    _, number = np.unique(target, return_inverse=True)
    total = np.bincount(number, weights=weight)
    sums = np.column_stack([np.bincount(number, weights=weight * np.nan_to_num(front[:, k])) for k in (0, 1)])
    return np.where(total[:, None] > 0, sums / np.maximum(total, 1)[:, None], np.nan)


def _best_pairs(
    fitted: PolarLines,
    lines: PolarLines,
    p: Floats,
    q: Floats,
    known: NDArray[np.bool_],
    *,
    gap: float,
    limit: float,
    farthest: float,
) -> Ints:
    """Rows (k, 2) of lines that are each other's best match within the gates; `lines` hold the error of the map, `fitted` do not."""
    import shapely

    usable = np.flatnonzero(np.isfinite(p).all(axis=1) & np.isfinite(q).all(axis=1) & np.isfinite(lines.alpha))
    shapes = shapely.linestrings(np.stack([p[usable], q[usable]], axis=1))
    near = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=gap)
    i, j = usable[near[:, near[0] < near[1]]]
    origin = (p[i] + q[i] + p[j] + q[j]) / 4
    value = chi_square(lines.take(i).moved(origin), lines.take(j).moved(origin), sided=known[i] & known[j])
    good = value <= limit
    i, j, value, origin = i[good], j[good], value[good], origin[good]
    good = (
        _farthest_end(fitted.take(i).moved(origin), fitted.take(j).moved(origin), [x - origin for x in (p[i], q[i], p[j], q[j])])
        <= farthest
    )
    i, j, value = i[good], j[good], value[good]
    apart = _wall_ends_between(lines, p, q, i, j, usable)
    i, j, value = i[~apart], j[~apart], value[~apart]
    # each set's best match: smallest chi square, ties by where the other one lies
    a, b, v = np.concatenate([i, j]), np.concatenate([j, i]), np.round(np.tile(value, 2), 9)
    middle = np.round((p + q) / 2, 6)
    order = np.lexsort((middle[b, 1], middle[b, 0], v, a))
    first = order[np.append(True, a[order][1:] != a[order][:-1])] if len(order) else order
    best = np.full(len(lines), -1, dtype=np.int64)
    best[a[first]] = b[first]
    mutual = (best[i] == j) & (best[j] == i)
    return np.column_stack([i[mutual], j[mutual]])


def _farthest_end(first: PolarLines, second: PolarLines, ends: Sequence[Floats]) -> Floats:
    """Largest distance (m,) of the ends from the mean of two lines, weighted by the inverse of their covariances (Pfister et al.)."""
    turned = (second.alpha - first.alpha + np.pi) % (2 * np.pi) - np.pi
    other = np.abs(turned) > np.pi / 2
    sign = np.where(other, -1.0, 1.0)
    difference = np.column_stack([(turned + np.pi / 2) % np.pi - np.pi / 2, sign * second.radius - first.radius])
    flip = np.ones((len(first), 2, 2))
    flip[:, 0, 1] = flip[:, 1, 0] = sign
    a, b = np.linalg.inv(first.covariance), np.linalg.inv(second.covariance * flip)
    step = np.linalg.solve(a + b, b @ difference[:, :, None])[:, :, 0]
    alpha, radius = first.alpha + step[:, 0], first.radius + step[:, 1]
    off = [np.abs(x[:, 0] * np.cos(alpha) + x[:, 1] * np.sin(alpha) - radius) for x in ends]
    farthest: Floats = np.max(off, axis=0)
    return farthest


def _wall_ends_between(lines: PolarLines, p: Floats, q: Floats, i: Ints, j: Ints, usable: Ints) -> NDArray[np.bool_]:
    """Pairs between which a crossing line ends: a partition that meets the wall there."""
    along, normal = lines.along, lines.normal
    d = along[i]
    mine = np.sort(np.stack([(p[i] * d).sum(axis=1), (q[i] * d).sum(axis=1)]), axis=0)
    other = np.sort(np.stack([(p[j] * d).sum(axis=1), (q[j] * d).sum(axis=1)]), axis=0)
    ahead = other[0] > mine[0]
    low, high = np.where(ahead, mine[1], other[1]), np.where(ahead, other[0], mine[0])
    out = np.zeros(len(i), dtype=bool)
    for k in np.flatnonzero(high - low >= TOUCHING):
        across = usable[np.abs(along[usable] @ d[k]) < CROSSING_COS]
        ends = np.vstack([p[across], q[across]])
        at, off = ends @ d[k], np.abs(ends @ normal[i[k]] - lines.radius[i[k]])
        out[k] = bool(((at > low[k] - TOUCHING) & (at < high[k] + TOUCHING) & (off < CROSSING_REACH)).any())
    return out
