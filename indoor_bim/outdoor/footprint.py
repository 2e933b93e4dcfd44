"""Footprints of all houses of a scan, the default way: wall lines, closed outlines, sides placed on all their points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.outdoor.edges import FittedEdge, fit_edges
from indoor_bim.outdoor.ground_seen import GroundSeen, see_ground
from indoor_bim.outdoor.heights import base_height
from indoor_bim.outdoor.outlines import OutlineEdge, find_outlines
from indoor_bim.outdoor.party_walls import split_at_party_walls
from indoor_bim.outdoor.terrain import Terrain
from indoor_bim.outdoor.wall_cells import WallCells, clusters, find_wall_cells
from indoor_bim.outdoor.wall_lines import WallLine, find_wall_lines

Floats = NDArray[np.float64]

WALL_FOOT = 0.3
OVERHEAD = 1.8
AROUND = 1.5
HOUSE_DEPTH = 12.0


@dataclass(frozen=True, slots=True, eq=False)
class WallPoints:
    """Points that may be of walls, sorted by x, so that the points about a house are found quickly.

    Parameters
    ----------
    points : (n, 3) float64
        Points above the foot of walls, metres.
    """

    points: Floats

    @classmethod
    def above(cls, points: Floats, above_ground: Floats) -> WallPoints:
        """Keep what lies higher than the foot of a wall."""
        kept = points[above_ground > WALL_FOOT]
        return cls(kept[np.lexsort((kept[:, 2], kept[:, 1], kept[:, 0]))])

    def about(self, corners: Floats) -> Floats:
        """Points (k, 3) in the bounding box of an outline (m, 2) and a little around it."""
        low, high = corners.min(axis=0) - AROUND, corners.max(axis=0) + AROUND
        first, last = np.searchsorted(self.points[:, 0], [low[0], high[0]])
        strip = self.points[first:last]
        near: Floats = strip[(strip[:, 1] >= low[1]) & (strip[:, 1] <= high[1])]
        return near


def wall_lines(cells: WallCells, *, gap: float = 1.0) -> list[WallLine]:
    """Straight faces of all groups of wall cells.

    Parameters
    ----------
    cells : WallCells
        Cells of the whole scan.
    gap : float
        Cells farther apart than this are of different groups, metres.
    """
    lines: list[WallLine] = []
    for rows in _groups(clusters(cells.xy, gap=gap)):
        lines += find_wall_lines(cells.take(rows))
    return lines


def house_outlines(
    lines: list[WallLine], seen: GroundSeen, *, least_area: float = 8.0, least_coverage: float = 0.3
) -> list[list[OutlineEdge]]:
    """Closed outlines of all houses, neighbourhood by neighbourhood.

    Parameters
    ----------
    lines : list of WallLine
        Faces of the whole scan.
    seen : GroundSeen
        Where the ground was seen.
    least_area : float
        Smallest house, square metres.
    least_coverage : float
        Least share of an outline where a wall was seen.
    """
    outlines: list[list[OutlineEdge]] = []
    for group in _neighbourhoods(lines, reach=HOUSE_DEPTH):
        outlines += find_outlines([lines[i] for i in group], seen, least_area=least_area, least_coverage=least_coverage)
    return outlines


def find_footprints(
    walls: WallPoints,
    lines: list[WallLine],
    seen: GroundSeen,
    terrain: Terrain,
    *,
    least_area: float,
    least_coverage: float,
    right_angles: bool,
) -> list[list[FittedEdge]]:
    """Sides of every house, placed on the wall points.

    Parameters
    ----------
    walls : WallPoints
        Points that may be of walls.
    lines : list of WallLine
        Faces of the whole scan.
    seen : GroundSeen
        Where the ground was seen.
    terrain : Terrain
        Ground heights.
    least_area : float
        Smallest house, square metres.
    least_coverage : float
        Least share of an outline where a wall was seen.
    right_angles : bool
        Square up sides whose directions agree with a right angle within their uncertainty.

    Returns
    -------
    list of list of FittedEdge
        Houses, each counter-clockwise.
    """
    houses = []
    for outline in house_outlines(lines, seen, least_area=least_area, least_coverage=least_coverage):
        corners = np.array([edge.start for edge in outline])
        points = walls.about(corners)
        edges = fit_edges(corners, points[:, :2], right_angles=right_angles)
        fitted = np.array([edge.start for edge in edges])
        parts = split_at_party_walls(edges, points, foot=base_height(terrain, fitted), least_area=least_area)
        if len(parts) == 1:
            houses.append(edges)
        else:
            houses += [fit_edges(part, points[:, :2], right_angles=right_angles) for part in parts]
    return houses


def evidence_of(points: Floats, above_ground: Floats, ground: Floats) -> tuple[WallCells, GroundSeen]:
    """What the points say of walls and of where the ground was seen.

    Parameters
    ----------
    points : (n, 3) float64
        Points that may be of buildings, metres.
    above_ground : (n,) float64
        Height of each above the ground, metres.
    ground : (g, 3) float64
        Ground points, metres.
    """
    cells = find_wall_cells(points, above_ground)
    return cells, see_ground(ground[:, :2], points[above_ground > OVERHEAD, :2])


def _groups(numbers: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    order = np.argsort(numbers, kind="stable")
    breaks = np.flatnonzero(np.diff(numbers[order])) + 1
    return np.split(order, breaks) if len(order) else []


def _neighbourhoods(lines: list[WallLine], *, reach: float) -> list[list[int]]:
    """Faces that are linked by distances of at most `reach`."""
    import shapely
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not lines:
        return []
    strokes = shapely.linestrings([[line.start, line.end] for line in lines])
    pairs = shapely.STRtree(strokes).query(strokes, predicate="dwithin", distance=reach)
    links = coo_array((np.ones(pairs.shape[1]), (pairs[0], pairs[1])), shape=(len(lines), len(lines)))
    numbers = connected_components(links, directed=False)[1].astype(np.int64)
    return [rows.tolist() for rows in _groups(numbers)]
