"""Stretches of faces that hang from the ceiling: beams, and the lintels of openings wider than doors."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.raster import Raster

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

COLUMN = 0.10
"""Width of the columns that a face is looked at in, metres."""
END = 0.15
"""A beam that comes this close to the end of the face at its back runs up to that end, metres."""
MIDDLE = (0.1, 0.8)
"""Share of the height between which walls are hit and openings are not."""


def without_beams(
    p: Floats,
    q: Floats,
    points: WallPoints,
    floor: Raster,
    rooms: shapely.Geometry,
    *,
    narrowest: float = 2.2,
    thickest: float = 0.6,
    near: float = 0.05,
    empty: float = 0.9,
) -> tuple[Floats, Floats]:
    """Pieces of faces that stand on the floor.

    Between two rooms, what was hit only near the ceiling while the floor was seen on from one room to the other is a beam. Up to
    the width of a double door it is the lintel of an opening in a wall, and the wall goes on.

    Parameters
    ----------
    p, q : (n, 2) float64
        Ends of faces, free space to the left of p -> q, metres.
    points : WallPoints
        Candidates.
    floor : Raster
        Not zero where the floor was hit.
    rooms : shapely geometry
        All rooms.
    narrowest : float
        Shortest beam, metres.
    thickest : float
        Thickest beam, metres.
    near : float
        Points this close to a face lie on it, metres.
    empty : float
        Least share of the middle of an opening that was not hit, and of its columns in which the floor was seen.

    Returns
    -------
    p, q : (m, 2) float64
        Ends of what is left, metres.
    """
    length = np.hypot(*(q - p).T)
    shapely.prepare(rooms)
    beams: list[list[tuple[float, float]]] = [[] for _ in p]
    for k, (a, b, whole) in enumerate(zip(p, q, length, strict=True)):
        if whole >= narrowest:
            d = (b - a) / whole
            left = np.array([-d[1], d[0]])
            count = int(whole / COLUMN)
            step = whole / count
            spots = a + ((np.arange(count) + 0.5) * step)[:, None] * d
            depths = np.arange(0.1, thickest + 0.15, 0.1)[:, None]
            behind = shapely.contains_xy(rooms, spots[:, 0] - depths * left[0], spots[:, 1] - depths * left[1]).any(axis=0)
            if behind.sum() * step < empty * narrowest:
                continue
            open_below = behind.copy()
            open_below[behind] = _floor_goes_on(spots[behind], left, floor)
            if open_below.sum() * step >= empty * narrowest:
                along, across, rise = _middle_points(a, d, whole, points, depth=0.25)
                standing = _hit_columns(along, rise, np.abs(across) < near, count, step)
                runs = _long_runs(open_below & ~standing, standing, narrowest / step, share=empty)
                reveals = along[(across < -near) & (across > -0.25)]
                for i, j in runs:
                    beams[k].append((0.0 if i == 0 else _jamb(reveals, i * step), whole if j == count else _jamb(reveals, j * step)))
    both = _on_either_side(p, q, beams, thickest=thickest)
    pieces = [piece for a, b, runs in zip(p, q, both, strict=True) for piece in _outside(a, b, runs)]
    return np.array([a for a, _ in pieces]).reshape(-1, 2), np.array([b for _, b in pieces]).reshape(-1, 2)


def _floor_goes_on(spots: Floats, left: Floats, floor: Raster) -> Bools:
    """Whether the floor was hit within a column in front of a face, under it, and behind it."""
    from indoor_bim.plan.face_loops import hit_beside

    image = np.ascontiguousarray(floor.image, dtype=bool)
    place = (float(floor.origin[0]), float(floor.origin[1]), floor.cell)
    shifts = np.linspace(-COLUMN, COLUMN, 9)
    goes_on = np.ones(len(spots), dtype=bool)
    for depths in (np.arange(-0.25, -0.05, 0.02), np.arange(0.06, 0.20, 0.02)):
        hit_beside(image, *place, np.ascontiguousarray(spots), left, shifts, depths, goes_on)
    return goes_on


def _middle_points(a: Floats, d: Floats, length: float, points: WallPoints, *, depth: float) -> tuple[Floats, Floats, Floats]:
    """Places along and across a face, and shares of the height, of points around it and in the middle of the height."""
    from indoor_bim.plan.face_loops import middle_points

    ranges = points.along(a, a + length * d, depth)
    table = np.zeros((int((ranges[:, 1] - ranges[:, 0]).sum()), 3))
    xy, rise = np.ascontiguousarray(points.xy), np.ascontiguousarray(points.rise)
    count = middle_points(xy, rise, ranges, a.copy(), d.copy(), length, depth, *MIDDLE, table)
    along, across, rise = table[:count].T
    return along, across, rise


def _hit_columns(along: Floats, rise: Floats, on: Bools, count: int, step: float, *, layers: int = 7) -> Bools:
    """Columns of a face that were hit at more than one height in its middle."""
    column = np.minimum((along[on] / step).astype(np.int64), count - 1)
    layer = np.minimum(((rise[on] - MIDDLE[0]) / (MIDDLE[1] - MIDDLE[0]) * layers).astype(np.int64), layers - 1)
    hit = np.zeros((count, layers), dtype=bool)
    hit[column, layer] = True
    return np.asarray(hit.sum(axis=1) >= 2, dtype=bool)


def _long_runs(hanging: Bools, standing: Bools, least: float, *, share: float, rest: int = 3) -> list[tuple[int, int]]:
    """Runs of at least so many columns that hang, nearly all of them; up to the end of the face where nothing stands in a short rest."""
    from scipy import ndimage

    bridged = ndimage.binary_closing(np.pad(hanging, 3), np.ones(5))[3:-3]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], bridged.astype(np.int8), [0]]))).reshape(-1, 2)
    runs = []
    for first, last in edges.tolist():
        if last - first < least or hanging[first:last].mean() < share:
            continue
        to_start = first <= rest and not standing[:first].any()
        to_end = len(hanging) - last <= rest and not standing[last:].any()
        runs.append((0 if to_start else first, len(hanging) if to_end else last))
    return runs


def _jamb(reveals: Floats, edge: float, *, reach: float = 0.20, least: int = 10, bin_width: float = 0.02) -> float:
    """Place of the reveal next to the edge of an opening, where points crowd; the edge itself where the reveal was not seen."""
    near = np.sort(reveals[np.abs(reveals - edge) < reach])
    if len(near) < least:
        return edge
    crowd = np.searchsorted(near, near + bin_width, side="right") - np.arange(len(near))
    first = int(np.argmax(crowd))
    return float(np.median(near[first : first + crowd[first]]))


def _on_either_side(p: Floats, q: Floats, beams: list[list[tuple[float, float]]], *, thickest: float) -> list[list[tuple[float, float]]]:
    """Beams of each face with those that were found on the face at their back."""
    length = np.hypot(*(q - p).T)
    direction = (q - p) / np.maximum(length, 1e-9)[:, None]
    both = [list(runs) for runs in beams]
    for k, runs in enumerate(beams):
        for first, last in runs:
            ends = p[k] + np.array([[last], [first]]) * direction[k]
            for j in np.flatnonzero(direction @ direction[k] < -0.99):
                (start, end), across = (ends - p[j]) @ direction[j], (p[j] - ends[0]) @ [direction[k, 1], -direction[k, 0]]
                if 0 < across < thickest and min(end, length[j]) - max(start, 0.0) > 0.5 * (end - start):
                    both[j].append((0.0 if start < END else float(start), length[j] if end > length[j] - END else float(end)))
    return [_merged(runs) for runs in both]


def _merged(runs: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Runs in order, overlapping ones joined."""
    out: list[tuple[float, float]] = []
    for first, last in sorted(runs):
        if out and first <= out[-1][1]:
            out[-1] = (out[-1][0], max(last, out[-1][1]))
        else:
            out.append((first, last))
    return out


def _outside(a: Floats, b: Floats, runs: list[tuple[float, float]]) -> list[tuple[Floats, Floats]]:
    """Pieces of a -> b outside of runs, metres from a."""
    length = float(np.hypot(*(b - a)))
    cuts = [0.0, *(end for run in runs for end in run), length]
    ends = [a if t == 0.0 else b if t == length else a + (b - a) * t / length for t in cuts]
    return [(ends[k], ends[k + 1]) for k in range(0, len(cuts), 2) if cuts[k + 1] > cuts[k]]
