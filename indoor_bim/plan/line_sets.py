"""Points of slices in plan to line-like sets, their lines and segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.facing import orient_by_free_space
from indoor_bim.plan.local_lines import draw_to_lines, line_like, wall_scatter
from indoor_bim.plan.noise import line_distance, scanner_noise, scatter
from indoor_bim.plan.polar_fit import PolarLines, fit_lines, point_covariance, project_ends
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.slice_heights import Slice
from indoor_bim.plan.split_and_merge import chain_points, drop_small, split_and_merge

Points = NDArray[np.float64]
Ints = NDArray[np.int64]

NEIGHBOURHOOD = 3.0  # scatters of a wall: how far neighbours are looked at where walls are noisy
ON_LINE = 4.0  # scatters: points farther from their line belong to something else
LETTING_GO = (1.0, 0.5, 0.25)  # of the largest distance: ends of short faces hold points of their neighbours, which let go step by step


@dataclass(frozen=True, slots=True, eq=False)
class SliceLines:
    """Sets of points of the slices and the lines fitted to them.

    Parameters
    ----------
    xy : (n, 2) float64
        Points of the slices in plan, metres, in the order of their coordinates.
    scanner : (n, 2) float64 or None
        Position of the scanner at each, metres.
    group : (n,) int64
        Line that each point belongs to; -1: none.
    covariance : (n, 2, 2) float64
        Covariance of each point, square metres.
    lines : PolarLines
        Lines with their covariance.
    noise : float
        Robust standard deviation of the points across their lines, metres.
    reach : float
        Largest distance of a place from the line of its set, metres.
    """

    xy: Points
    scanner: Points | None
    group: Ints
    covariance: Points
    lines: PolarLines
    noise: float
    reach: float


def cut(points: Points, scanner: Points | None, slices: Sequence[Slice]) -> tuple[Points, Points | None]:
    """Points of the slices projected to the plan, sorted by their coordinates, and positions of the scanner in plan (section 1.1).

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z above the floor.
    scanner : (n, 3) float64, optional
        Positions of the scanner, metres.
    slices : sequence of Slice
        Slices.
    """
    inside = np.zeros(len(points), dtype=bool)
    for part in slices:
        inside |= (points[:, 2] >= part.low) & (points[:, 2] < part.high)
    rows = np.flatnonzero(inside)
    rows = rows[np.lexsort(points[rows].T)]
    return points[rows, :2], None if scanner is None else scanner[rows, :2]


def line_sets(
    xy: Points,
    scanner: Points | None = None,
    *,
    pixel: float,
    split_distance: float | None = None,
    split_gap: float | None = None,
    min_length: float = 0.05,
    min_points: int = 5,
    noise: tuple[float | None, float | None] = (None, None),
) -> SliceLines:
    """Line-like sets of points by split-and-merge, and the lines fitted to them (sections 1.2 and 1.3).

    Walls that scatter by more than a pixel are thinned first by drawing points to the line through their neighbourhood; lines are
    fitted to the points where they were measured. A set that was seen from both sides holds the two faces of a thin wall and is
    parted.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    scanner : (n, 2) float64, optional
        Positions of the scanner, metres; None: the noise is the same in all directions.
    pixel : float
        Side of the pixels in which points hang together, metres.
    split_distance, split_gap : float, optional
        Both stopping rules, metres; None: from the scatter of the points and from the pixel.
    min_length, min_points : float, int
        Smaller sets are dropped.
    noise : tuple of two floats or None
        Range noise in metres and bearing noise in radians; None: from the points.
    """
    wide = wall_scatter(xy)
    thin = xy
    if wide > 0.4 * pixel:
        for _ in range(2):
            thin = draw_to_lines(thin, radius=NEIGHBOURHOOD * wide)
    on_line = line_like(xy, radius=max(NEIGHBOURHOOD * wide, 2 * pixel))
    chains = chain_points(thin[on_line], pixel=pixel)
    distance = max(1.25 * pixel, 1.5 * wide) if split_distance is None else split_distance
    piece = split_and_merge(chains, distance=distance, gap=4 * pixel if split_gap is None else split_gap)
    group = np.full(len(xy), -1, dtype=np.int64)
    group[on_line] = piece[chains.member]
    group = drop_small(group, xy, min_length=min_length, min_points=min_points)
    alike = np.broadcast_to(np.eye(2), (len(xy), 2, 2))
    lines = fit_lines(xy, group, alike)
    if scanner is not None:
        left = line_distance(scanner, group, lines) > 0
        group = drop_small(np.where(group >= 0, 2 * group + left, -1), xy, min_length=min_length, min_points=min_points)
        lines = fit_lines(xy, group, alike)
    covariance, spread = alike, 0.0
    for share in LETTING_GO:
        offset = line_distance(xy, group, lines)
        spread = scatter(offset)
        if scanner is None:
            covariance = alike * (noise[0] or spread) ** 2
        else:
            found = scanner_noise(xy, scanner, group, lines)
            covariance = point_covariance(xy, scanner, range_noise=noise[0] or found[0], bearing_noise=noise[1] or found[1])
        group = drop_small(
            np.where(np.abs(offset) <= max(share * distance, ON_LINE * spread), group, -1), xy, min_length=min_length, min_points=min_points
        )
        lines = fit_lines(xy, group, covariance)
    return SliceLines(xy, scanner, group, covariance, lines, spread, distance)


def line_segments(found: SliceLines, free: Raster) -> Segments:
    """Segments of fitted lines: ends projected, free space to the left where it is known (section 1.3).

    Parameters
    ----------
    found : SliceLines
        Lines and their points.
    free : Raster
        Where floor or ceiling was seen; tells sides where the path of the scanner is not known.
    """
    front = front_of(found, free)
    sided = np.isfinite(front[:, 0])
    lines = found.lines.facing(np.where(sided[:, None], front, np.nan))
    p, q = project_ends(found.xy, found.group, lines)
    offset = line_distance(found.xy, found.group, lines)
    on = found.group >= 0
    support = np.bincount(found.group[on], minlength=len(lines))
    squares = np.bincount(found.group[on], weights=offset[on] ** 2, minlength=len(lines))
    rmse = np.sqrt(squares / np.maximum(support, 1))
    return replace(Segments.from_ends(p, q), sided=sided, support=support, rmse=rmse, covariance=lines.covariance)


def front_of(found: SliceLines, free: Raster) -> Points:
    """A place (m, 2) before each line: where the scanner was on the whole, else to the side of floor and ceiling; NaN where not known.

    Parameters
    ----------
    found : SliceLines
        Lines and their points.
    free : Raster
        Where floor or ceiling was seen.
    """
    on = found.group >= 0
    if found.scanner is not None:
        count = np.maximum(np.bincount(found.group[on], minlength=len(found.lines)), 1)
        sums = [np.bincount(found.group[on], weights=found.scanner[on, k], minlength=len(found.lines)) for k in (0, 1)]
        return np.column_stack(sums) / count[:, None]
    p, q = project_ends(found.xy, found.group, found.lines)
    turned = orient_by_free_space(Segments.from_ends(p, q), free)
    return np.where(turned.sided[:, None], (turned.p + turned.q) / 2 + turned.normal, np.nan)
