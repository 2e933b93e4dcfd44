"""Curved walls: circular arcs through the points that straight lines do not explain."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.arc_fit import Arc, circle_through, fit_arc, longest_run
from indoor_bim.plan.evidence import FEW_POINTS, WallPoints
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.strips import BELOW_CEILING, CLEARANCE, height_layers

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

UPPER = 0.8
"""Share of the height above which walls stand alone."""
CELL = 0.03
"""Side of the cells whose points are one spot, metres."""
ON_ARC = 0.03
"""Spots this close to a circle lie on it, metres."""
WIDEST_GAP = 1.3
"""Longest gap in a curved wall, metres: a door."""
SMALLEST_RADIUS, LARGEST_RADIUS = 0.5, 30.0
"""Radii of walls, metres: what is smaller is a column, and what is larger a straight wall in a map that bends."""


SPARSE = 16
"""Cells for each point, above which only those that are filled are numbered."""
STEPS = 1e6
"""Steps of a micrometre in a metre; sums of whole steps do not depend on their order."""


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """Cells of the plan that points high on walls fill: their mean (n, 2) in metres and the direction (n, 2) of the wall there."""

    xy: Floats
    tangent: Floats

    def __len__(self) -> int:
        return len(self.xy)

    def take(self, rows: NDArray) -> Spots:
        """Spots of the given rows (indices or mask)."""
        return replace(self, xy=self.xy[rows], tangent=self.tangent[rows])


def find_arcs(points: WallPoints, lines: FaceLines, spots: Spots, *, most: int = 40) -> list[Arc]:
    """Arcs that explain what straight lines do not, the longest first.

    Two spots whose tangents make equal angles with their chord lie on a circle. The circles that most spots lie on are fitted to the points
    and taken when points keep to them as closely as their noise allows.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    lines : FaceLines
        Straight lines that were found.
    spots : Spots
        Spots of the points high on walls, as by `wall_spots`.
    most : int
        Largest number of arcs.
    """
    left = spots.take(~explained_by_straight_lines(spots, lines))
    high = points.take(points.rise > UPPER) if len(left) else points
    arcs: list[Arc] = []
    while len(left) and len(arcs) < most:
        found = [arc for arc in _arcs_by_votes(left, high) if not any(_same(arc, other) for other in arcs)]
        if not found:
            break
        for arc in found:
            left = left.take(~arc.holds(left.xy, across=2 * ON_ARC, beyond=2 * ON_ARC))
        arcs += found
    return sorted(arcs, key=lambda arc: (-round(arc.length, 6), round(arc.radius, 6), *np.round(arc.centre, 6)))


def wall_spots(points: WallPoints, *, reach: float = 0.10, fewest: int = 5) -> Spots:
    """Spots of points high on walls.

    Parameters
    ----------
    points : WallPoints
        Candidates; those high on walls count.
    reach : float
        Spots this close to one another tell the direction of the wall, metres: the faces of a wall are farther apart.
    fewest : int
        So many of them are needed.
    """
    from scipy.spatial import cKDTree

    points = points.take(points.rise > UPPER)
    if not len(points):
        return Spots(np.zeros((0, 2)), np.zeros((0, 2)))
    count, hit, sums = _sums_in_cells(points)
    xy = (sums / count[:, None] / STEPS)[np.bitwise_count(hit) >= 2]
    if not len(xy):
        return Spots(xy, xy)
    first, second = cKDTree(xy).query_pairs(reach, output_type="ndarray").T
    from_, to = np.concatenate([first, second, np.arange(len(xy))]), np.concatenate([second, first, np.arange(len(xy))])
    near = np.bincount(from_)
    mean = np.column_stack([np.bincount(from_, weights=xy[to, k]) / near for k in range(2)])
    x, y = (xy[to] - mean[from_]).T
    xx, yy, both = (np.bincount(from_, weights=w) / near for w in (x * x, y * y, x * y))
    half = np.hypot((xx - yy) / 2, both)
    minor, major = (xx + yy) / 2 - half, (xx + yy) / 2 + half
    angle = 0.5 * np.arctan2(2 * both, xx - yy)
    told = (near >= fewest) & (minor < 0.25 * major) & (major > (0.4 * reach) ** 2)
    return Spots(xy[told], np.column_stack([np.cos(angle), np.sin(angle)])[told])


def _sums_in_cells(points: WallPoints) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Number of points, bits of the height layers that they hit, and sums of their whole steps, of every cell that holds points."""
    corners = np.floor(points.corners / CELL).astype(np.int64)
    columns, rows = (int(side) for side in corners[1] - corners[0] + 1)
    if len(points) > FEW_POINTS and columns * rows < SPARSE * len(points):
        from indoor_bim.plan.spot_loops import sum_in_cells

        count, hit, sums = np.zeros(columns * rows, dtype=np.int64), np.zeros(columns * rows, dtype=np.int64), np.zeros((columns * rows, 2))
        strips = BELOW_CEILING
        layering = (strips.even, strips.layers, strips.fine_height, CLEARANCE)
        xy, rise, depth = (np.ascontiguousarray(values) for values in (points.xy, points.rise, points.depth))
        sum_in_cells(xy, rise, depth, CELL, STEPS, *corners[0], rows, *layering, count, hit, sums)
        filled = np.flatnonzero(count)
        return count[filled], hit[filled], sums[filled]
    cell = np.floor(points.xy / CELL).astype(np.int64) - corners[0]
    _, group, count = np.unique(cell[:, 0] * rows + cell[:, 1], return_inverse=True, return_counts=True)
    hit = np.zeros(len(count), dtype=np.int64)
    np.bitwise_or.at(hit, group, np.int64(1) << height_layers(points))
    return count, hit, np.column_stack([np.bincount(group, weights=np.rint(values * STEPS)) for values in points.xy.T])


def explained_by_straight_lines(spots: Spots, lines: FaceLines, *, near: float = 0.04, shortest: float = 1.0, bow: float = 0.015) -> Bools:
    """Spots on lines along which no bow shows.

    Parameters
    ----------
    spots : Spots
        Spots high on walls.
    lines : FaceLines
        Straight lines.
    near : float
        Spots this close to a line lie on it, metres.
    shortest : float
        Shorter lines may be parts of arcs, metres.
    bow : float
        Least bow of spots along a line that is not straight, metres.
    """
    explained = np.zeros(len(spots), dtype=bool)
    for direction, normal, offset, start, end in zip(lines.direction, lines.normal, lines.offset, lines.start, lines.end, strict=True):
        if end - start < shortest:
            continue
        along, across = spots.xy @ direction, spots.xy @ normal - offset
        on = (np.abs(across) < 1.5 * near) & (along > start - near) & (along < end + near)
        if on.sum() < 10:
            continue
        x = (along[on] - (start + end) / 2) / ((end - start) / 2)
        curvature = np.polynomial.polynomial.polyfit(x, across[on], 2)[2]
        if abs(curvature) < bow:
            explained |= on & (np.abs(across) < near)
    return explained


def _arcs_by_votes(spots: Spots, points: WallPoints, *, shortest: float = 0.8, filled: float = 0.6) -> list[Arc]:
    """Arcs of the circles that most spots lie on; each spot takes part once."""
    centres, radii = _circles_of_pairs(spots)
    on = _on_circles(spots, centres, radii)
    votes, free = on.sum(axis=1), np.ones(len(spots), dtype=bool)
    arcs: list[Arc] = []
    for k in np.lexsort((*np.round(centres.T, 6), -votes)):
        if (on[k] & free).sum() < max(shortest / CELL, 0.5 * votes[k]):
            continue
        run = _refined_run(spots, centres[k], float(radii[k]))
        free &= ~on[k]
        if run is None or run.length < shortest:
            continue
        mine = _on_circle(spots, run.centre, run.radius, across=2 * ON_ARC) & run.holds(spots.xy, across=2 * ON_ARC)
        free &= ~mine
        if mine.sum() * CELL < filled * run.length:
            continue
        arc = fit_arc(points, run.centre, run.radius, run.start, run.end)
        if arc is not None and any(_same(arc, other) for other in arcs):
            continue
        if arc is not None and SMALLEST_RADIUS <= arc.radius <= LARGEST_RADIUS:
            arcs.append(arc)
    return arcs


def _same(arc: Arc, other: Arc) -> bool:
    angles = np.linspace(arc.start, arc.end, 9)
    places = arc.centre + arc.radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return bool(other.holds(places, across=ON_ARC).mean() > 0.5)


def _refined_run(spots: Spots, centre: Floats, radius: float) -> Arc | None:
    """Longest run of spots on a circle, the circle fitted to them."""
    for across in (2 * ON_ARC, ON_ARC, ON_ARC):
        on = spots.xy[_on_circle(spots, centre, radius, across=across)]
        if len(on) < 10:
            return None
        start, end, _ = longest_run(on, centre, radius, gap=WIDEST_GAP)
        run = Arc(centre, radius, start, end, True, np.eye(3), 0.0, 0.0)
        centre, radius, _ = circle_through(on[run.holds(on, across=across)], centre, radius, finest=CELL / 4)
        if not SMALLEST_RADIUS <= radius <= LARGEST_RADIUS:
            return None
    return replace(run, centre=centre, radius=radius)


def _circles_of_pairs(
    spots: Spots, *, seeds: int = 500, most: int = 1500, nearest: float = 0.4, farthest: float = 4.0, alike: float = 8.0, turn: float = 12.0
) -> tuple[Floats, Floats]:
    """Centres (n, 2) and radii (n,) of circles through pairs of spots whose tangents make the same angle with their chord, metres."""
    order = np.lexsort(spots.xy.T)
    rows = order[np.unique(np.linspace(0, len(order) - 1, min(seeds, len(order))).astype(np.int64))] if len(order) else order
    xy, tangent = spots.xy[rows], spots.tangent[rows]
    i, j = np.triu_indices(len(rows), 1)
    chord = xy[j] - xy[i]
    length = np.hypot(*chord.T)
    close = (length > nearest) & (length < farthest)
    i, j, chord, length = i[close], j[close], chord[close], length[close]
    unit = chord / length[:, None]

    def angle(of: Floats) -> Floats:
        turned = np.arctan2(unit[:, 0] * of[:, 1] - unit[:, 1] * of[:, 0], (unit * of).sum(axis=1))
        return np.asarray(np.mod(turned + np.pi / 2, np.pi) - np.pi / 2)

    first, second = angle(tangent[i]), angle(tangent[j])
    half = (first - second) / 2
    good = (np.abs(first + second) < np.radians(alike)) & (np.abs(half) > np.radians(turn / 2))
    good &= length / (2 * np.sin(np.maximum(np.abs(half), 1e-9))) <= LARGEST_RADIUS
    chosen = np.flatnonzero(good)
    chosen = chosen[np.unique(np.linspace(0, len(chosen) - 1, min(most, len(chosen))).astype(np.int64))] if len(chosen) else chosen
    unit, half, length = unit[chosen], half[chosen], length[chosen]
    radius = length / (2 * np.sin(np.abs(half)))
    left = np.column_stack([-unit[:, 1], unit[:, 0]])
    centre = (xy[i[chosen]] + xy[j[chosen]]) / 2 - left * (np.sign(half) * radius * np.cos(half))[:, None]
    return centre, radius


def _on_circles(spots: Spots, centres: Floats, radii: Floats, *, across: float = ON_ARC, steepest: float = 12.0) -> Bools:
    """Spots on each circle whose wall runs along it (circles, spots)."""
    from indoor_bim.plan.arc_loops import mark_on_circles

    on = np.zeros((len(radii), len(spots)), dtype=bool)
    xy, tangent = np.ascontiguousarray(spots.xy), np.ascontiguousarray(spots.tangent)
    mark_on_circles(xy, tangent, np.column_stack([centres, radii]), across, float(np.sin(np.radians(steepest))), on)
    return on


def _on_circle(spots: Spots, centre: Floats, radius: float, *, across: float = ON_ARC) -> Bools:
    """Spots on one circle."""
    on: Bools = _on_circles(spots, centre[None], np.array([radius]), across=across)[0]
    return on
