"""The default method: closed rooms and wall faces of every storey, with no parameter to set."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import LevelledCloud
from indoor_bim.cloud.levels import thin
from indoor_bim.cloud.no_walls import no_walls
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan import evidence as ev
from indoor_bim.plan.arc_chains import chain_ends, with_curved_walls
from indoor_bim.plan.arcs import wall_spots
from indoor_bim.plan.beams import without_beams
from indoor_bim.plan.built_in import WIDEST, without_bare_niches, without_built_ins
from indoor_bim.plan.cells import Cells, close_corners, cut_into_cells, hidden_wall, label_cells
from indoor_bim.plan.curve import Curve
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.face_support import measure
from indoor_bim.plan.free_borders import free_borders
from indoor_bim.plan.free_space import FreeSpace, cell_space, extent, free_space, in_front, roofed, usual_density
from indoor_bim.plan.hit_images import hit_raster
from indoor_bim.plan.line_ends import end_cuts, gap_cuts, prolong
from indoor_bim.plan.line_search import AFAR, edge_evidence, find_lines, folded_lines, look_into_free_space
from indoor_bim.plan.loose_faces import loose_faces
from indoor_bim.plan.overhead import fill_nearest, overhead_surface
from indoor_bim.plan.passing_rays import Rays
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.roof import ridge_height, roof_surface, under_the_eaves
from indoor_bim.plan.room_levels import room_levels
from indoor_bim.plan.room_outlines import OutlineRing, RoomOutline, room_outlines
from indoor_bim.plan.scanner_path import known_positions
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.threads import both, threads_for

logger = logging.getLogger(__name__)
Floats = NDArray[np.float64]

PIXEL = 0.025
"""Side of a pixel of the plan, metres."""
SPOT = 0.10
"""Side of the spots of the plan at which the scanner was or was not, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class AutoStages:
    """What the method found on one storey, stage by stage."""

    lines: FaceLines
    cells: Cells
    room: NDArray[np.bool_]
    wall: Floats
    inside: Floats
    seen: Raster
    outlines: tuple[RoomOutline, ...]
    plan: StoreyPlan


def auto_storey(levelled: LevelledCloud, number: int, gps_time: Floats | None = None, sample: Floats | None = None) -> AutoStages:
    """Faces and rooms of one storey.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    number : int
        Storey, from 0.
    gps_time : (n,) float64, optional
        Time of each point, seconds; with the trajectory it tells the sides that walls were seen from.
    sample : (m, 3) float64, optional
        Thinned points of the scan; default: they are thinned here.

    Raises
    ------
    NothingToReconstructError
        If the storey has no points between floor and ceiling.
    """
    storey = levelled.storeys[number]
    seen = {"floor": storey.floor is not None, "ceiling": storey.ceiling is not None}
    above = [s.floor for s in levelled.storeys[number + 1 :] if s.floor is not None]
    floor = storey.floor if storey.floor is not None else (storey.ceiling or 0.0) - 2.5
    top = storey.ceiling + 0.15 if storey.ceiling is not None else (above[0] - 0.1 if above else floor + 6.0)
    sample = thin(levelled.points) if sample is None else sample
    pitched = storey.ceiling is None
    overhead = roof_surface(sample, floor=floor, top=top) if pitched else overhead_surface(sample, floor=floor, top=top)
    ceiling = ridge_height(overhead) if pitched and overhead is not None else storey.ceiling
    if overhead is None and not ((sample[:, 2] > floor + 0.5) & (sample[:, 2] < top)).any():
        raise NothingToReconstructError(no_walls(len(levelled.points), **seen))
    low, high = extent(overhead, sample, floor=floor, top=top)
    points, sensor = _within(levelled, gps_time, np.array([*low, floor - 0.1]), np.array([*high, top]))
    filled = fill_nearest(overhead) if overhead is not None else Raster(np.full((1, 1), floor + 2.2), low, 1.0)
    wall_points = ev.wall_points(points, sensor, filled, floor=floor, step=0.0 if pitched else 0.30)
    if not len(wall_points):
        raise NothingToReconstructError(no_walls(len(levelled.points), **seen))
    cover = (storey.ceiling if storey.ceiling is not None else floor + 2.0) - 0.06
    image: dict[str, Any] = {"low": low, "high": high, "cell": PIXEL}
    space, spots = both(
        lambda: free_space(points, levelled.points, wall_points, filled, floor=floor, cover=cover, open_top=overhead is None, **image),
        lambda: None if overhead is None else wall_spots(wall_points),
        threads=threads_for(len(points)),
    )
    lines, sweeps = find_lines(wall_points, space.overhead_density if overhead is not None else None)
    curves: tuple[Curve, ...] = ()
    straight = len(sweeps)
    if spots is not None:
        lines, sweeps, curves = with_curved_walls(lines, sweeps, wall_points, spots)
    if sensor is None:
        lines = lines.take(look_into_free_space(lines, space.hit))
    dense = space.denser_than(AFAR)
    firm = free_borders(dense.hit, lines)
    weak = free_borders(dense.raster(dense.ceiling), lines) if overhead is not None else firm
    cut_p, cut_q = end_cuts(lines)
    joined, join_p, join_q = gap_cuts(lines)
    start, end, across_p, across_q = chain_ends(lines, lines.family >= straight, *prolong(lines))
    edge_p, edge_q = np.vstack([firm[0], weak[0], cut_p, join_p, across_p]), np.vstack([firm[1], weak[1], cut_q, join_q, across_q])
    start, end = np.minimum(start, joined.start), np.maximum(end, joined.end)
    p, q = replace(lines, start=start, end=end).ends()
    frame = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    cells = cut_into_cells(np.vstack([p, edge_p, frame]), np.vstack([q, edge_q, np.roll(frame, -1, axis=0)]))
    of_cells = cell_space(cells, space)
    seen_wall, seen_nearby = edge_evidence(cells, lines, sweeps)
    wall = close_corners(cells, seen_wall)
    faces = wall.copy()
    border = cells.edge_line - len(lines)
    wall[(border >= 0) & (border < len(firm[0]) + len(weak[0]))] = 0.4
    wall[(border >= 0) & (border < len(firm[0]))] = 0.7
    unseen = (of_cells.hit < 0.1) & (of_cells.inside < 0)
    rays = None if sensor is None else Rays(points, sensor, floor + 0.1, (ceiling or top) - 0.1)
    hidden = hidden_wall(cells, faces, lines.direction, empty=unseen, sided=sensor is not None, rays=rays)
    wall[hidden] = np.maximum(wall[hidden], 0.6)
    room = label_cells(cells, inside=of_cells.inside + in_front(cells, seen_nearby), wall=wall)
    closed = room_outlines(cells, room, faces, spanned=of_cells.spanned, min_closed=0.4 if overhead is not None else 0.25)
    entered = closed if overhead is None else _entered(closed, space, sensor)
    outlines = _behind_built_ins(entered, folded_lines(lines))
    floor_seen, roof = space.raster(space.floor), overhead if pitched else None

    def faces_and_rooms() -> StoreyPlan:
        loose = None
        if overhead is not None:
            rooms = shapely.union_all([outline.polygon for outline in outlines])
            loose = loose_faces(lines, sweeps, rooms, roofed(space), points, sensor, low=floor, high=ceiling or top)
        return _plan(
            outlines, loose, curves, wall_points, floor=floor, ceiling=ceiling, seen=space.glimpsed, floor_seen=floor_seen, roof=roof
        )

    def levels_of_rooms() -> tuple[tuple[float, float], ...]:
        if ceiling is None:
            return ()
        below = levelled.storeys[number - 1].ceiling if number else None
        between = {"low": below if below is not None else -np.inf, "high": above[0] if above else np.inf}
        return room_levels(sample, [outline.polygon for outline in outlines], floor=floor, ceiling=ceiling, roof=roof, **between)

    plan, levels = both(faces_and_rooms, levels_of_rooms, threads=threads_for(len(points)))
    if ceiling is not None:
        plan = replace(plan, room_levels=levels, pitched=pitched)
    return AutoStages(lines, cells, room, wall, of_cells.inside, space.raster(space.ceiling), outlines, plan)


def _within(levelled: LevelledCloud, gps_time: Floats | None, low: Floats, high: Floats) -> tuple[Floats, Floats | None]:
    """Points within a box, and the scanner's position at each of them, where it is known."""
    near = ev.rows_within(levelled.points, low, high)
    sensor = known_positions(levelled.trajectory, gps_time, near)
    return ev.points_at(levelled.points, near) if len(near) < len(levelled.points) else levelled.points, sensor


def _entered(
    outlines: Sequence[RoomOutline], space: FreeSpace, sensor: Floats | None, *, share: float = 0.2, inside: float = 0.3
) -> list[RoomOutline]:
    """Outlines without those that were only looked into: where floor and ceiling hold few points, and few for this scan.

    Where the scanner itself went, so far inside that it stood beyond the door, is entered.
    """
    density = np.array([usual_density(outline.polygon, space) for outline in outlines])
    area = np.array([outline.polygon.area for outline in outlines])
    order = np.argsort(density, kind="stable")
    middle = order[np.searchsorted(np.cumsum(area[order]), area.sum() / 2)] if len(order) else 0
    least = min(AFAR, share * density[middle]) if len(order) else AFAR
    enough = density > least
    if sensor is not None and not enough.all():
        corners = shapely.total_bounds([outline.polygon for outline in outlines]).reshape(2, 2)
        went = hit_raster(sensor[:, :2], low=np.floor(corners[0] / SPOT) * SPOT, high=corners[1], cell=SPOT)
        stood = went.centre(np.argwhere(went.image))
        for k in np.flatnonzero(~enough).tolist():
            enough[k] = shapely.contains_xy(outlines[k].polygon.buffer(-inside), *stood.T).any()
    return [outline for outline, kept in zip(outlines, enough, strict=True) if kept]


def _behind_built_ins(outlines: Sequence[RoomOutline], folded: NDArray[np.bool_]) -> tuple[RoomOutline, ...]:
    """Outlines that run along the walls: behind built-in furniture and curtains, and across doorways."""
    polygons = [outline.polygon for outline in outlines]
    tree = shapely.STRtree(polygons)
    rooms = []
    for k, outline in enumerate(outlines):
        around = shapely.box(*polygons[k].bounds).buffer(WIDEST, join_style="mitre")
        others = shapely.union_all([polygons[j] for j in np.sort(tree.query(around)).tolist() if j != k])
        soft = [line < len(folded) and bool(folded[line]) for line in outline.exterior.lines]
        corners = without_built_ins(outline.exterior.corners, folded=soft, others=others)
        if corners == outline.exterior.corners:
            corners = without_bare_niches(corners, bare=[line >= len(folded) for line in outline.exterior.lines])
        if len(corners) != len(outline.exterior.corners):
            outline = RoomOutline(OutlineRing(corners, (-1,) * len(corners)), outline.holes)
        rooms.append(outline)
    return tuple(rooms)


def _plan(
    outlines: tuple[RoomOutline, ...],
    loose: tuple[Floats, Floats] | None,
    curves: tuple[Curve, ...],
    points: ev.WallPoints,
    *,
    floor: float,
    ceiling: float | None,
    seen: Raster,
    floor_seen: Raster,
    roof: Raster | None = None,
) -> StoreyPlan:
    """Plan of a storey: the sides of all rooms are its faces."""
    p, q = ([], []) if loose is None else (list(loose[0]), list(loose[1]))
    columns = []
    for outline in outlines:
        standing = [hole for hole in outline.holes if is_column(hole)]
        columns += [shapely.Polygon(hole.corners) for hole in standing]
        for ring in (outline.exterior, *(hole for hole in outline.holes if hole not in standing)):
            p += list(ring.corners)
            q += list(ring.corners[1:] + ring.corners[:1])
    rooms = tuple(outline.polygon for outline in outlines)
    tails, heads = (np.array(ends).reshape(-1, 2) for ends in (p, q))
    faces = measure(Segments.from_ends(*without_beams(tails, heads, points, floor_seen, shapely.union_all(rooms))), points)
    if ceiling is None:
        faces = faces.take(faces.coverage > 0.3)
    if roof is not None:
        faces = faces.take(~under_the_eaves(faces.p, faces.q, roof, floor=floor))
    return StoreyPlan(faces, floor, ceiling, seen=seen, rooms=rooms, columns=tuple(columns), curves=curves)


def is_column(ring: OutlineRing, *, widest: float = 1.2) -> bool:
    """Whether a ring that stands in a room is small enough for a column, metres; larger ones are walls around something."""
    low, high = np.min(ring.corners, axis=0), np.max(ring.corners, axis=0)
    return bool(np.hypot(*(high - low)) <= np.sqrt(2) * widest)


def storey_plans(levelled: LevelledCloud, *, gps_time: Floats | None = None) -> tuple[StoreyPlan, ...]:
    """Faces and rooms of every storey, from the bottom up.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    gps_time : (n,) float64, optional
        Time of each point, seconds; with the trajectory it tells the sides that walls were seen from.

    Returns
    -------
    tuple of StoreyPlan
        Plans of the storeys that have points between floor and ceiling; of those with rooms, if there are any: the ground
        under the eaves of a house is no storey.

    Raises
    ------
    NothingToReconstructError
        If no storey has.
    """
    sample = thin(levelled.points)
    plans, complaints = [], []
    for number in range(len(levelled.storeys)):
        try:
            plans.append(auto_storey(levelled, number, gps_time, sample).plan)
        except NothingToReconstructError as error:
            logger.warning("storey %d: %s", number + 1, error)
            complaints.append(error)
    if not plans:
        raise complaints[0]
    return tuple(plan for plan in plans if plan.rooms) or tuple(plans)
