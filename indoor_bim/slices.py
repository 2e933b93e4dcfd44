"""The published `slices` method from a levelled cloud to wall faces: slices, weighted line fits, chi-square merging, contours.

Source: Yang, Duan, Wu, Hu, *Automatic generation of indoor floor plans by weighted iterative line fitting of layered slice point clouds*; the
sections are those of that paper. The line fit is that of Pfister, Roumeliotis, Burdick, ICRA 2003.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import WALL, LevelledCloud
from indoor_bim.cloud.spacing import point_spacing
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.back_to_back import turn_back_to_back
from indoor_bim.plan.boxes import without_boxes
from indoor_bim.plan.chi_square_merge import merge_lines
from indoor_bim.plan.contour_completion import CLOSED, GAP, STEP, Contour, complete_contour
from indoor_bim.plan.contour_gaps import ContourGap, contour_gaps
from indoor_bim.plan.contour_rooms import contour_rooms
from indoor_bim.plan.curtains import draw_curtains
from indoor_bim.plan.doubles import without_doubles
from indoor_bim.plan.facing import orient_by_free_space
from indoor_bim.plan.full_height import ends_lower, share_at_ceiling, with_heights
from indoor_bim.plan.image import remove_burrs, thicken
from indoor_bim.plan.layer_image import STEP, LayerImage, layer_image
from indoor_bim.plan.local_lines import draw_to_lines, line_like, wall_scatter
from indoor_bim.plan.noise import line_distance, scanner_noise, scatter
from indoor_bim.plan.polar_fit import PolarLines, fit_lines, point_covariance, project_ends
from indoor_bim.plan.range_gate import ranges, within_range
from indoor_bim.plan.raster import Raster, count_raster
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.selection import wall_like
from indoor_bim.plan.slice_heights import Slice, choose_slices, layer_evidence, slice_thickness
from indoor_bim.plan.split_and_merge import chain_points, drop_small, split_and_merge
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.slope import free_space

logger = logging.getLogger(__name__)
Points = NDArray[np.float64]
Ints = NDArray[np.int64]

NO_RANGE_GATE = (
    "The range gate was skipped: it needs the time of every point and the path of the scanner, and the scan came without one of them."
)
SLACK = 0.05  # metres: points this close to floor or ceiling belong to them
COVER_CELL, COVER_MARGIN = 0.20, 0.40  # metres: what has neither floor nor ceiling this close lies outside
USUAL_HEIGHT = 2.5  # metres, where no ceiling was seen
LEAST_HEIGHT = 1.0  # metres
FINEST_PIXEL = 0.015  # metres
POINTS_PER_PIXEL = 3.0  # along a wall: fewer, and the walls fall apart in the image
NEIGHBOURHOOD = 3.0  # scatters of a wall: how far neighbours are looked at where walls are noisy
MAP_SHARE = 0.5  # of the scatter of the points: how far whole stretches of wall are off
SHORT = 0.60  # metres: shorter faces are walls only where they reach the ceiling and are parts of a contour
CLOSED_SHARE = 0.9  # of the length of a contour: where so much of it is closed, what it encloses are the rooms
FOLDED = 1.4  # times the usual scatter of a wall: curtains
TELLING = 0.008  # metres: in scans that scatter more, folds do not tell curtains from walls
ON_LINE = 4.0  # scatters: points farther from their line belong to something else
SURE = 6.0  # reaches: shorter faces cannot be told from noise
BELOW_CEILING = (0.025, 0.20)  # metres: depth of the band that every wall is in and no door, window or wardrobe
HITS_PER_STEP = 2.0  # of a wall in that band, on average
AT_CEILING = 0.35  # share of a face right below the ceiling that makes it a wall; less where all of it is hit less often
LEAST_COVERAGE = 0.12  # of a face from floor to ceiling: emptier are beams and what hangs from the ceiling


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


@dataclass(frozen=True, slots=True, eq=False)
class SlicesStages:
    """Every product of the method for one storey, for whoever wants to look.

    Parameters
    ----------
    slices : tuple of Slice
        Heights of the slices above the floor, metres.
    pieces : SliceLines
        Line-like sets after split-and-merge.
    merged : SliceLines
        The same after merging by chi square.
    segments : Segments
        Segments of the merged lines, free space to the left where known.
    contour : Contour
        Completed contour of those that are walls.
    image : LayerImage
        Layers hit in plan.
    gaps : tuple of ContourGap
        Gaps of the contour at the heights of the slices: doors and windows, or what hides the wall.
    plan : StoreyPlan
        Plan of the storey.
    """

    slices: tuple[Slice, ...]
    pieces: SliceLines
    merged: SliceLines
    segments: Segments
    contour: Contour
    image: LayerImage
    gaps: tuple[ContourGap, ...]
    plan: StoreyPlan


def slices_storey(
    levelled: LevelledCloud,
    number: int = 0,
    scanner: Points | None = None,
    *,
    heights: tuple[float, ...] | None = None,
    count: int = 2,
    thickness: float | None = None,
    min_range: float | None = None,
    max_range: float | None = None,
    split_distance: float | None = None,
    split_gap: float | None = None,
    min_length: float = 0.05,
    min_points: int = 5,
    range_noise: float | None = None,
    bearing_noise: float | None = None,
    sigma: float = 3.0,
    closing_gap: float = 0.5,
) -> SlicesStages:
    """Run the method on one storey and keep the product of every stage; parameters that are None are derived from the points.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    number : int
        Storey, from 0.
    scanner : (n, 3) float64, optional
        Position of the scanner at each point in model coordinates, metres. None: the range gate is skipped, and sides are told by floor and
        ceiling.
    heights : tuple of float, optional
        Middles of the slices above the floor, metres; None: where most wall and least furniture is.
    count : int
        Number of slices, if their heights are not given.
    thickness : float, optional
        Thickness of a slice, metres; None: three times the point spacing, more where the scan is sparse.
    min_range, max_range : float, optional
        Nearest and farthest distance of wall points from the scanner, metres.
    split_distance : float, optional
        Largest distance of a point from the line of its set, metres; None: from the scatter of the points.
    split_gap : float, optional
        Largest distance of neighbours in a set, metres; None: from the density of the slices.
    min_length : float
        Shorter sets are dropped, metres.
    min_points : int
        Sets of fewer points are dropped.
    range_noise, bearing_noise : float, optional
        Standard deviations of the scanner, metres and radians; None: from the points.
    sigma : float
        Gate of the merging in standard deviations.
    closing_gap : float
        Shorter gaps of the contour are closed, metres; wider ones are left for doors and windows.

    Raises
    ------
    NothingToReconstructError
        If the storey has no walls.
    """
    points, scanner, floor, height = storey_points(levelled, number, scanner)
    if scanner is not None:
        near = within_range(ranges(points, scanner), nearest=min_range, farthest=max_range)
        points, scanner = points[near], scanner[near]
    if len(points) < 100:
        raise NothingToReconstructError(
            f"found {len(points)} points between floor and ceiling of {len(levelled.points)}; expected walls: scan them too"
        )
    evidence = layer_evidence(points, height=height)
    if thickness is None:
        thickness = slice_thickness(evidence, spacing=point_spacing(points), height=height)
    if heights is None:
        slices = choose_slices(evidence, thickness=thickness, count=count)
    else:
        slices = tuple(Slice(h - thickness / 2, h + thickness / 2) for h in sorted(heights))
    xy, at = cut(points, scanner, slices)
    if len(xy) < min_points:
        raise NothingToReconstructError(
            f"found {len(xy)} points in slices at {', '.join(f'{s.middle:.2f}' for s in slices)} m; expected walls: choose other heights"
        )
    pixel = max(FINEST_PIXEL, POINTS_PER_PIXEL / max(evidence.density * thickness * len(slices), 1e-9))
    pieces = line_sets(
        xy,
        at,
        pixel=min(pixel, 0.12),
        split_distance=split_distance,
        split_gap=split_gap,
        min_length=min_length,
        min_points=min_points,
        noise=(range_noise, bearing_noise),
    )
    storey = _storey_only(levelled, floor=floor, top=floor + height)
    free = free_space(storey)
    group = merge_lines(
        pieces.xy,
        pieces.group,
        pieces.covariance,
        front=_front(pieces, free),
        sigma=sigma,
        gap=closing_gap,
        map_noise=MAP_SHARE * pieces.noise,
        farthest=pieces.reach,
    )
    merged = replace(pieces, group=group, lines=fit_lines(pieces.xy, group, pieces.covariance))
    image = layer_image(points, height=height)
    reach = max(image.bits.cell / 2, 2 * pieces.noise)
    segments = with_heights(line_segments(merged, free), image, height=height, reach=reach)
    if scanner is None:
        segments = turn_back_to_back(segments, count_raster(storey.points[storey.part != WALL, :2], cell=0.02))
    if levelled.storeys[number].ceiling is not None:
        depth = SLACK + float(np.clip(max(4 * reach - SLACK, HITS_PER_STEP / STEP / max(evidence.density, 1e-9)), *BELOW_CEILING))
        expected = 1 - (1 - segments.coverage) ** max((depth - SLACK) / image.layer, 1.0)
        wall = share_at_ceiling(segments, points, height=height, reach=reach, depth=depth) >= np.minimum(AT_CEILING, expected / 2)
        wall |= (segments.length < SHORT) & ~ends_lower(segments, image, height=height, reach=reach)
        wall &= segments.coverage >= LEAST_COVERAGE
    else:
        wall = wall_like(segments, storey_height=height, least_length=0.0)
    if not wall.any():
        raise NothingToReconstructError(f"found no wall among {len(segments)} lines of the slices; expected walls from floor to ceiling")
    contour = wall_contour(segments.take(wall), shortest=SURE * reach, gap=closing_gap)
    rooms, columns = contour_rooms(contour)
    if contour.closed_share() < CLOSED_SHARE:
        rooms = ()
    level = levelled.storeys[number]
    plan = StoreyPlan(
        faces=with_bridges(contour),
        floor=floor,
        ceiling=level.ceiling,
        seen=free,
        rooms=rooms,
        room_levels=tuple((floor, floor + height) for _ in rooms),
        columns=columns,
    )
    gaps = contour_gaps(plan.faces, image, slices, height=height, reach=reach, narrowest=max(closing_gap, STEP))
    return SlicesStages(slices, pieces, merged, segments, contour, image, gaps, plan)


def slices_stages(levelled: LevelledCloud, *, gps_time: Points | None = None, **parameters: Any) -> tuple[SlicesStages, ...]:
    """Run the method on every storey, from the bottom up.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    gps_time : (n,) float64, optional
        Time of each point, seconds; with the trajectory it tells where the scanner was.
    **parameters : float, int, tuple of float or None
        Those of `slices_storey`.

    Returns
    -------
    tuple of SlicesStages
        Products of the storeys that have walls; their plans name what was skipped.

    Raises
    ------
    NothingToReconstructError
        If no storey has walls.
    """
    scanner, path = None, levelled.trajectory
    if gps_time is not None and path is not None and np.isfinite(path[:, 0]).all():
        scanner = sensor_positions(path, gps_time)
    found, complaints = [], []
    for number in range(len(levelled.storeys)):
        try:
            found.append(slices_storey(levelled, number, scanner, **parameters))
        except NothingToReconstructError as error:
            logger.warning("storey %d: %s", number + 1, error)
            complaints.append(error)
    if not found:
        raise complaints[0]
    if scanner is None:
        found[0] = replace(found[0], plan=replace(found[0].plan, warnings=(NO_RANGE_GATE, *found[0].plan.warnings)))
    return tuple(found)


def storey_points(levelled: LevelledCloud, number: int, scanner: Points | None) -> tuple[Points, Points | None, float, float]:
    """Points of a storey between its floor and its ceiling, below or above what was seen of them.

    Returns
    -------
    points : (n, 3) float64
        Metres, z above the floor.
    scanner : (n, 3) float64 or None
        Positions of the scanner, z above the floor.
    floor, height : float
        Level of the floor, or of the lowest points, and height up to the ceiling, or the usual height, metres.
    """
    storey = levelled.storeys[number]
    above = [s.floor for s in levelled.storeys[number + 1 :] if s.floor is not None]
    z = levelled.points[:, 2]
    lowest = float(np.quantile(z, 0.005))
    ceiling = storey.ceiling if storey.ceiling is not None else lowest + USUAL_HEIGHT
    floor = storey.floor if storey.floor is not None else min(lowest, ceiling - LEAST_HEIGHT)
    highest = above[0] - 0.3 if above else float(np.quantile(z, 0.995))
    top = storey.ceiling if storey.ceiling is not None else max(min(highest, floor + USUAL_HEIGHT), floor + LEAST_HEIGHT)
    spots = levelled.points[(np.abs(z - floor) < SLACK) | (np.abs(z - (floor if storey.ceiling is None else top)) < SLACK), :2]
    rows = np.flatnonzero((z > floor + SLACK) & (z < top - SLACK))
    if len(spots):
        seen = count_raster(spots, cell=COVER_CELL)
        margin = round(COVER_MARGIN / COVER_CELL)
        cover = ~thicken(~np.pad(remove_burrs(seen.image > 0), margin + 2))  # the faces of other houses are a line there, no area
        for _ in range(margin + 1):
            cover = thicken(cover)
        inside = Raster(cover, seen.origin - (margin + 2) * COVER_CELL, COVER_CELL).sample(levelled.points[rows, :2]) > 0
        rows = rows[inside]
    shift = np.array([0.0, 0.0, floor])
    return levelled.points[rows] - shift, None if scanner is None else scanner[rows] - shift, floor, top - floor


def cut(points: Points, scanner: Points | None, slices: tuple[Slice, ...]) -> tuple[Points, Points | None]:
    """Points of the slices projected to the plan, sorted by their coordinates, and positions of the scanner in plan (section 1.1).

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z above the floor.
    scanner : (n, 3) float64, optional
        Positions of the scanner, metres.
    slices : tuple of Slice
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

    Walls that scatter by more than a pixel are thinned first by drawing points to the line through their neighbourhood; lines are fitted to the
    points where they were measured. A set that was seen from both sides holds the two faces of a thin wall and is parted.

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
    least = {"min_length": min_length, "min_points": min_points}
    group = np.full(len(xy), -1, dtype=np.int64)
    group[on_line] = piece[chains.member]
    group = drop_small(group, xy, **least)
    alike = np.broadcast_to(np.eye(2), (len(xy), 2, 2))
    lines = fit_lines(xy, group, alike)
    if scanner is not None:
        left = line_distance(scanner, group, lines) > 0
        group = drop_small(np.where(group >= 0, 2 * group + left, -1), xy, **least)
        lines = fit_lines(xy, group, alike)
    covariance, spread = alike, 0.0
    for share in (1.0, 0.5, 0.25):  # ends of short faces hold points of their neighbours, which let go step by step
        offset = line_distance(xy, group, lines)
        spread = scatter(offset)
        if scanner is None:
            covariance = alike * (noise[0] or spread) ** 2
        else:
            found = scanner_noise(xy, scanner, group, lines)
            covariance = point_covariance(xy, scanner, range_noise=noise[0] or found[0], bearing_noise=noise[1] or found[1])
        group = drop_small(np.where(np.abs(offset) <= max(share * distance, ON_LINE * spread), group, -1), xy, **least)
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
    front = _front(found, free)
    sided = np.isfinite(front[:, 0])
    lines = found.lines.facing(np.where(sided[:, None], front, np.nan))
    p, q = project_ends(found.xy, found.group, lines)
    offset = line_distance(found.xy, found.group, lines)
    on = found.group >= 0
    support = np.bincount(found.group[on], minlength=len(lines))
    squares = np.bincount(found.group[on], weights=offset[on] ** 2, minlength=len(lines))
    rmse = np.sqrt(squares / np.maximum(support, 1))
    return replace(Segments.from_ends(p, q), sided=sided, support=support, rmse=rmse, covariance=lines.covariance)


def wall_contour(walls: Segments, *, shortest: float, gap: float) -> Contour:
    """Completed contour of faces that are walls, without doubles, curtains and loose ends (section 1.4.2).

    Parameters
    ----------
    walls : Segments
        Faces that go up to the ceiling, metres.
    shortest : float
        Shorter faces cannot be told from noise, metres.
    gap : float
        Shorter gaps are closed, metres.
    """
    faces = without_boxes(without_doubles(walls, shortest=shortest))
    usual = float(np.average(faces.rmse, weights=faces.length))
    faces = draw_curtains(faces, soft=(faces.rmse > FOLDED * usual) | (usual > TELLING))
    while True:
        contour = complete_contour(faces, gap=gap)
        goes_on = (contour.follows >= 0).all(axis=1) | (contour.kind == CLOSED).any(axis=1)
        stub = (contour.segments.length < SHORT) & ~goes_on
        if not stub.any() or stub.all():
            return contour
        faces = faces.take(~stub)


def with_bridges(contour: Contour) -> Segments:
    """Segments of a contour, and faces without support across its gaps and steps: the wall goes on over a door and below a window."""
    pairs = np.concatenate([contour.pairs(GAP), contour.pairs(STEP)])
    ends = contour.place(pairs.ravel()).reshape(-1, 2, 2)
    from_end = (pairs[:, 0] % 2 == 1)[:, None]
    p, q = np.where(from_end, ends[:, 0], ends[:, 1]), np.where(from_end, ends[:, 1], ends[:, 0])
    bridges = replace(Segments.from_ends(p, q), sided=contour.segments.sided[pairs // 2].all(axis=1))
    return Segments(**{name: np.concatenate([getattr(part, name) for part in (contour.segments, bridges)]) for name in Segments.__slots__})


def _front(found: SliceLines, free: Raster) -> Points:
    """A place (m, 2) before each line: where the scanner was on the whole, else to the side of floor and ceiling; NaN where not known."""
    on = found.group >= 0
    if found.scanner is not None:
        count = np.maximum(np.bincount(found.group[on], minlength=len(found.lines)), 1)
        sums = [np.bincount(found.group[on], weights=found.scanner[on, k], minlength=len(found.lines)) for k in (0, 1)]
        return np.column_stack(sums) / count[:, None]
    p, q = project_ends(found.xy, found.group, found.lines)
    turned = orient_by_free_space(Segments.from_ends(p, q), free)
    return np.where(turned.sided[:, None], (turned.p + turned.q) / 2 + turned.normal, np.nan)


def _storey_only(levelled: LevelledCloud, *, floor: float, top: float) -> LevelledCloud:
    """The cloud without the other storeys."""
    if len(levelled.storeys) == 1:
        return levelled
    rows = (levelled.points[:, 2] > floor - 2 * SLACK) & (levelled.points[:, 2] < top + 2 * SLACK)
    return replace(levelled, points=levelled.points[rows], part=levelled.part[rows])
