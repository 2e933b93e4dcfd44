"""The published `slices` method from a levelled cloud to wall faces: slices, weighted line fits, chi-square merging, contours.

Source: Yang, Duan, Wu, Hu, *Automatic generation of indoor floor plans by weighted iterative line fitting of layered slice point clouds*;
the sections are those of that paper. The line fit is that of Pfister, Roumeliotis, Burdick, ICRA 2003.
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
from indoor_bim.plan.chi_square_merge import merge_lines
from indoor_bim.plan.contour_completion import Contour
from indoor_bim.plan.contour_gaps import ContourGap, contour_gaps
from indoor_bim.plan.contour_rooms import contour_rooms
from indoor_bim.plan.full_height import with_heights
from indoor_bim.plan.layer_image import SAMPLING, LayerImage, layer_image
from indoor_bim.plan.line_sets import SliceLines, cut, front_of, line_segments, line_sets
from indoor_bim.plan.polar_fit import fit_lines
from indoor_bim.plan.range_gate import ranges, within_range
from indoor_bim.plan.raster import count_raster
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.selection import wall_like
from indoor_bim.plan.slice_heights import Slice, choose_slices, layer_evidence, slice_thickness
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.plan.wall_contour import up_to_ceiling, wall_contour, with_bridges
from indoor_bim.slope import free_space
from indoor_bim.storey_points import storey_only, storey_points

logger = logging.getLogger(__name__)
Points = NDArray[np.float64]

NO_RANGE_GATE = (
    "The range gate was skipped: it needs the time of every point and the path of the scanner, and the scan came without one of them."
)
FINEST_PIXEL, COARSEST_PIXEL = 0.015, 0.12  # metres
POINTS_PER_PIXEL = 3.0  # along a wall: fewer, and the walls fall apart in the image
MAP_SHARE = 0.5  # of the scatter of the points: how far whole stretches of wall are off
CLOSED_SHARE = 0.9  # of the length of a contour: where so much of it is closed, what it encloses are the rooms
SURE = 6.0  # reaches: shorter faces cannot be told from noise


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
        pixel=min(pixel, COARSEST_PIXEL),
        split_distance=split_distance,
        split_gap=split_gap,
        min_length=min_length,
        min_points=min_points,
        noise=(range_noise, bearing_noise),
    )
    storey = storey_only(levelled, floor=floor, top=floor + height)
    free = free_space(storey)
    group = merge_lines(
        pieces.xy,
        pieces.group,
        pieces.covariance,
        front=front_of(pieces, free),
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
        wall = up_to_ceiling(segments, points, image, height=height, reach=reach, density=evidence.density)
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
        faces=with_bridges(contour, gap=closing_gap),
        floor=floor,
        ceiling=level.ceiling,
        seen=free,
        rooms=rooms,
        room_levels=tuple((floor, floor + height) for _ in rooms),
        columns=columns,
    )
    gaps = contour_gaps(plan.faces, image, slices, height=height, reach=reach, narrowest=max(closing_gap, SAMPLING))
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
