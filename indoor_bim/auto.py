"""The default method: closed rooms and wall faces of every storey, with no parameter to set."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import LevelledCloud, StoreyLevels
from indoor_bim.cloud.levels import thin
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan import evidence as ev
from indoor_bim.plan.built_in import without_built_ins
from indoor_bim.plan.cells import Cells, cell_image, close_corners, cut_into_cells, hidden_wall, label_cells
from indoor_bim.plan.face_lines import FaceLines, face_lines, join_lines
from indoor_bim.plan.face_support import measure
from indoor_bim.plan.line_ends import end_cuts, prolong
from indoor_bim.plan.line_merging import merge_lines
from indoor_bim.plan.local_density import thinly_scanned
from indoor_bim.plan.loose_faces import attached, opaque, reach_out, without_doubles
from indoor_bim.plan.oblique import other_directions, unexplained
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.room_outlines import OutlineRing, RoomOutline, room_outlines
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.plan.strips import BELOW_CEILING, FAR, THIN, WHOLE_COLUMN, Sweep, evidence_along, sweep

logger = logging.getLogger(__name__)
Floats = NDArray[np.float64]
Images = NDArray[np.floating]

MAIN = (0.0, float(np.pi / 2))
PIXEL = 0.025
REACH = 1.5
FAINT = 0.004  # share of pixels hit: two hits within half a metre
SPARSE = 100.0  # points per square metre: where fewer were taken, the scanner only looked in from afar


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


def auto_storey(levelled: LevelledCloud, number: int, sensor: Floats | None = None) -> AutoStages:
    """Faces and rooms of one storey.

    Parameters
    ----------
    levelled : LevelledCloud
        Levelled scan.
    number : int
        Storey, from 0.
    sensor : (n, 3) float64, optional
        Scanner position at each point in model coordinates, metres.

    Raises
    ------
    NothingToReconstructError
        If the storey has no points between floor and ceiling.
    """
    storey = levelled.storeys[number]
    above = [s.floor for s in levelled.storeys[number + 1 :] if s.floor is not None]
    floor = storey.floor if storey.floor is not None else (storey.ceiling or 0.0) - 2.5
    top = storey.ceiling + 0.15 if storey.ceiling is not None else (above[0] - 0.1 if above else floor + 6.0)
    points = levelled.points
    sample = thin(points)
    overhead = ev.overhead_surface(sample, floor=floor, top=top) if storey.ceiling is not None else None
    if overhead is None and not ((sample[:, 2] > floor + 0.5) & (sample[:, 2] < top)).any():
        raise NothingToReconstructError(_no_walls(len(levelled.points)))
    low, high = _extent(overhead, sample, floor, top)
    near = ((points[:, :2] > low) & (points[:, :2] < high)).all(axis=1) & (points[:, 2] > floor - 0.1) & (points[:, 2] < top)
    points = points[near]
    sensor = None if sensor is None else sensor[near]
    filled = ev.fill_nearest(overhead) if overhead is not None else Raster(np.full((1, 1), floor + 2.2), low, 1.0)
    wall_points = ev.wall_points(points, sensor, filled, floor=floor)
    if not len(wall_points):
        raise NothingToReconstructError(_no_walls(len(levelled.points)))
    seen, density, column = ev.overhead_hits(points, wall_points, filled, low=low, high=high, cell=PIXEL)
    spacious = Raster(density / PIXEL**2, low, PIXEL)
    lines, sweeps = _find_lines(wall_points, spacious if overhead is not None else None)
    if overhead is None:
        seen, density = Raster(np.zeros_like(seen.image), low, PIXEL), np.zeros_like(density)
    floor_hits = np.abs(points[:, 2] - floor) < 0.06
    floor_seen = ev.hit_raster(points[floor_hits, :2], low=low, high=high, cell=PIXEL)
    floor_image = floor_seen.image.astype(np.float32)
    floor_image[column] = 0
    covered = ev.covered(levelled.points, above=_cover(storey, floor), low=low, high=high, cell=PIXEL, open_top=overhead is None)
    floor_image[~covered] = 0
    floor_density = ev.local_density(floor_image, ~column & covered, cell=PIXEL)
    if sensor is None:
        horizontal = Raster((seen.image > 0) | (floor_image > 0), low, PIXEL)
        lines = lines.take(_looks_into_free_space(lines, horizontal))
    near_by = np.maximum(density, floor_density) > SPARSE * PIXEL**2
    firm = ev.free_borders(Raster(np.maximum(seen.image, floor_image) * near_by, low, PIXEL), lines)
    weak = ev.free_borders(Raster(seen.image * near_by, low, PIXEL), lines) if overhead is not None else firm
    cut_p, cut_q = end_cuts(lines)
    edge_p, edge_q = np.vstack([firm[0], weak[0], cut_p]), np.vstack([firm[1], weak[1], cut_q])
    start, end = prolong(lines)
    p, q = replace(lines, start=start, end=end).ends()
    frame = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    cells = cut_into_cells(np.vstack([p, edge_p, frame]), np.vstack([q, edge_q, np.roll(frame, -1, axis=0)]))
    inside, spanned, hit = _inside(cells, seen.image, density, floor_image, floor_density, seen)
    wall = close_corners(cells, _edge_evidence(cells, lines, sweeps))
    faces = wall.copy()
    border = cells.edge_line - len(lines)
    wall[(border >= 0) & (border < len(firm[0]) + len(weak[0]))] = 0.4
    wall[(border >= 0) & (border < len(firm[0]))] = 0.7
    hidden = hidden_wall(cells, faces, lines.direction, empty=hit < 0.1)
    wall[hidden] = np.maximum(wall[hidden], 0.6)
    room = label_cells(cells, inside=inside, wall=wall)
    outlines = tuple(room_outlines(cells, room, faces, spanned=spanned, min_closed=0.4 if overhead is not None else 0.25))
    outlines = _behind_built_ins(outlines, folded_lines(lines))
    free = Raster((density > FAINT) | (floor_density > FAINT), low, PIXEL)
    loose = None
    if overhead is not None:
        loose = _loose_faces(lines, sweeps, outlines, _roofed(seen), points, sensor, height=(floor, storey.ceiling or top))
    plan = _plan(outlines, loose, wall_points, floor=floor, ceiling=storey.ceiling, seen=free)
    return AutoStages(lines, cells, room, wall, inside, seen, outlines, plan)


def _find_lines(points: ev.WallPoints, overhead: Raster | None) -> tuple[FaceLines, list[Sweep]]:
    """Lines of faces, and the sweeps that show them: densely scanned walls first, then those that were seen from far away."""
    if overhead is None:
        sweeps = [sweep(points, angle, strips=WHOLE_COLUMN) for angle in MAIN]
        return merge_lines(join_lines([face_lines(swept, family=k) for k, swept in enumerate(sweeps)])), sweeps
    sweeps, parts = [], []
    for strips, sparse in ((BELOW_CEILING, np.inf), (THIN, 600.0), (FAR, SPARSE)):
        candidates = points if np.isinf(sparse) else points.take(thinly_scanned(points, overhead, sparse=sparse))
        if not len(candidates):
            continue
        for angle in MAIN:
            sweeps.append(sweep(candidates, angle, strips=strips))
            parts.append(face_lines(sweeps[-1], family=len(sweeps) - 1))
        rest = unexplained(candidates, join_lines(parts))
        for angle in other_directions(rest) if strips is BELOW_CEILING else ():
            sweeps.append(sweep(rest, angle, strips=strips))
            parts.append(face_lines(sweeps[-1], family=len(sweeps) - 1))
    return merge_lines(join_lines(parts)), sweeps


def _looks_into_free_space(lines: FaceLines, horizontal: Raster) -> NDArray[np.bool_]:
    """Lines with at least as much floor and ceiling close to their left as to their right."""
    keep = np.ones(len(lines), dtype=bool)
    away = np.arange(0.05, 0.13, PIXEL)
    for k in range(len(lines)):
        t = np.arange(float(lines.start[k]), float(lines.end[k]), PIXEL)
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


def _behind_built_ins(outlines: tuple[RoomOutline, ...], folded: NDArray[np.bool_]) -> tuple[RoomOutline, ...]:
    """Outlines that run along the walls behind built-in furniture and curtains."""
    polygons = [outline.polygon for outline in outlines]
    rooms = []
    for k, outline in enumerate(outlines):
        others = shapely.union_all([polygon for j, polygon in enumerate(polygons) if j != k])
        soft = [line < len(folded) and bool(folded[line]) for line in outline.exterior.lines]
        corners = without_built_ins(outline.exterior.corners, folded=soft, others=others)
        if len(corners) != len(outline.exterior.corners):
            outline = RoomOutline(OutlineRing(corners, (-1,) * len(corners)), outline.holes)
        rooms.append(outline)
    return tuple(rooms)


def _no_walls(points: int) -> str:
    return f"found {points} points and none between floor and ceiling; expected walls: scan them too, at their full height"


def _cover(storey: StoreyLevels, floor: float) -> float:
    """Height from which a point counts as something overhead."""
    return (storey.ceiling if storey.ceiling is not None else floor + 2.0) - 0.06


def _extent(overhead: Raster | None, sample: Floats, floor: float, top: float, *, margin: float = 1.2) -> tuple[Floats, Floats]:
    from scipy import ndimage

    if overhead is None:
        inside = sample[(sample[:, 2] > floor + 0.5) & (sample[:, 2] < top)]
        spots = inside[:, :2]
        return np.quantile(spots, 0.005, axis=0) - 0.1, np.quantile(spots, 0.995, axis=0) + 0.1
    spots = overhead.centre(np.argwhere(~np.isnan(overhead.image)))
    level = float(np.nanmedian(overhead.image))
    hits = np.floor(sample[np.abs(sample[:, 2] - level) < 0.06, :2]).astype(np.int64)
    first = hits.min(axis=0)
    hit = np.zeros(hits.max(axis=0) - first + 1, dtype=np.float32)
    hit[tuple((hits - first).T)] = 1
    faint = np.argwhere((hit > 0) & (9 * ndimage.uniform_filter(hit, 3, mode="constant") > 5.5)) + first
    spots = np.vstack([spots, faint + 0.5])
    return spots.min(axis=0) - margin, spots.max(axis=0) + margin


def _inside(
    cells: Cells, seen: Images, density: Images, floor_seen: Images, floor_density: Images, template: Raster
) -> tuple[Floats, NDArray[np.bool_], Floats]:
    """Evidence in square metres that each cell is free space: overhead surface, and floor where there is nothing overhead."""
    image = cell_image(cells.polygons, template)
    within = image >= 0
    label = image[within]
    count = len(cells.polygons)

    def total(values: Images) -> Floats:
        return np.bincount(label, weights=values[within], minlength=count).astype(np.float64)

    sure = density / (density + 0.02)
    share = np.clip(total(seen) / np.maximum(total(density), 1e-9), 0, 1)
    open_above = 1 - sure
    usual = float(np.median(floor_density[(sure > 0.5) & (floor_density > 0)])) if ((sure > 0.5) & (floor_density > 0)).any() else 0.0
    expected = np.maximum(floor_density, 0.5 * usual * (floor_density > 0))
    floor_sure = open_above * floor_density / (floor_density + 0.02)
    floor_share = np.clip(total(floor_seen * open_above) / np.maximum(total(expected * open_above), 1e-9), 0, 1)
    area = np.array([polygon.area for polygon in cells.polygons])
    for_room = np.clip(share / 0.3 - 1, -1, 1)
    firm = np.where(for_room < 0, total(sure * (1 - floor_density / (floor_density + 0.02))), total(sure))
    evidence = firm * for_room + total(floor_sure) * np.clip(floor_share / 0.4 - 1, -0.3, 1)
    hit = total(((seen > 0) | (floor_seen > 0)).astype(np.float32)) / np.maximum(np.bincount(label, minlength=count), 1)
    return evidence * PIXEL**2 - 0.1 * area, (share > 0.3) & (total(sure) * PIXEL**2 > 0.3 * area), hit


def _edge_evidence(cells: Cells, lines: FaceLines, sweeps: list[Sweep]) -> Floats:
    """Share of each edge where the face of its line was seen."""
    wall = np.zeros(len(cells.edge_line))
    for line in range(len(lines)):
        rows = np.flatnonzero(cells.edge_line == line)
        if not len(rows):
            continue
        start, end = float(lines.start[line]) - REACH, float(lines.end[line]) + REACH
        profile = np.clip((line_evidence(lines, line, sweeps, start, end) - 0.15) / 0.5, 0, 1)
        at = np.linspace(start, end, len(profile) + 1)
        total = np.concatenate([[0.0], np.cumsum(profile)]) * (end - start) / len(profile)
        u0, u1 = cells.edge_start[rows] @ lines.direction[line], cells.edge_end[rows] @ lines.direction[line]
        wall[rows] = (np.interp(u1, at, total) - np.interp(u0, at, total)) / np.maximum(u1 - u0, 1e-6)
    return np.clip(wall, 0, 1)


def line_evidence(lines: FaceLines, row: int, sweeps: list[Sweep], start: float, end: float) -> Floats:
    """Best wall evidence along a line in the sweeps of about its direction, one value for each fine strip."""
    angle, offset = float(lines.angle[row]), float(lines.offset[row])
    own = sweeps[lines.family[row]].angle
    best: Floats = np.maximum.reduce([evidence_along(s, angle, offset, start, end) for s in sweeps if s.angle == own])
    return best


def _roofed(seen: Raster, *, coarse: int = 20, share: float = 0.2) -> Raster:
    """Where the surface overhead was hit here and there."""
    from scipy import ndimage

    rows, columns = (np.array(seen.image.shape) // coarse) * coarse
    hit = seen.image[:rows, :columns].reshape(rows // coarse, coarse, columns // coarse, coarse).max(axis=(1, 3)) > 0
    cell = seen.cell * coarse
    return Raster(ndimage.uniform_filter(hit.astype(np.float32), 3) > share, seen.origin, cell)


def _loose_faces(
    lines: FaceLines,
    sweeps: list[Sweep],
    outlines: tuple[RoomOutline, ...],
    roofed: Raster,
    points: Floats,
    sensor: Floats | None,
    *,
    height: tuple[float, float],
    shortest: float = 1.6,
    away: float = 0.5,
    bridge: int = 8,
) -> tuple[Floats, Floats]:
    """Pieces of wall lines in rooms that were only looked into: seen well, a ceiling in front, away from closed rooms."""
    from scipy import ndimage

    rooms = shapely.union_all([outline.polygon.buffer(away) for outline in outlines]) if outlines else shapely.Polygon()
    pieces = []
    for k in range(len(lines)):
        start, end = float(lines.start[k]), float(lines.end[k])
        profile = line_evidence(lines, k, sweeps, start, end)
        t = start + (np.arange(len(profile)) + 0.5) * (end - start) / len(profile)
        spots = t[:, None] * lines.direction[k] + lines.offset[k] * lines.normal[k]
        good = (profile > 0.35) & ~shapely.contains_xy(rooms, *spots.T)
        good &= roofed.sample(spots + 1.0 * lines.normal[k]) > 0
        good = ndimage.binary_closing(np.pad(good, bridge), np.ones(2 * bridge + 1))[bridge:-bridge]
        edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(np.int8), [0]])))
        for first, last in edges.reshape(-1, 2):
            if (last - first) * BELOW_CEILING.along >= shortest:
                pieces.append((spots[first], spots[last - 1]))
    p, q = (np.array([piece[end] for piece in pieces]).reshape(-1, 2) for end in (0, 1))
    keep = without_doubles(p, q)
    if sensor is not None:
        outside = ~shapely.contains_xy(rooms, *points[:, :2].T)
        keep &= opaque(p, q, points[outside], sensor[outside], low=height[0] + 0.1, high=height[1] - 0.1)
    closed = shapely.union_all([outline.polygon for outline in outlines])
    p, q = reach_out(p[keep], q[keep], closed)
    keep = attached(p, q, closed)
    return p[keep], q[keep]


def _plan(
    outlines: tuple[RoomOutline, ...],
    loose: tuple[Floats, Floats] | None,
    points: ev.WallPoints,
    *,
    floor: float,
    ceiling: float | None,
    seen: Raster,
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
    faces = measure(Segments.from_ends(np.array(p).reshape(-1, 2), np.array(q).reshape(-1, 2)), points)
    if ceiling is None:
        faces = faces.take(faces.coverage > 0.3)
    rooms = tuple(outline.polygon for outline in outlines)
    top = ceiling if ceiling is not None else floor + 2.5
    levels = tuple((floor, top) for _ in rooms)
    return StoreyPlan(faces, floor, ceiling, seen=seen, rooms=rooms, room_levels=levels, columns=tuple(columns))


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
        Plans of the storeys that have points between floor and ceiling.

    Raises
    ------
    NothingToReconstructError
        If no storey has.
    """
    sensor = None
    if gps_time is not None and levelled.trajectory is not None and np.isfinite(levelled.trajectory[:, 0]).all():
        sensor = sensor_positions(levelled.trajectory, gps_time)
    plans, complaints = [], []
    for number in range(len(levelled.storeys)):
        try:
            plans.append(auto_storey(levelled, number, sensor).plan)
        except NothingToReconstructError as error:
            logger.warning("storey %d: %s", number + 1, error)
            complaints.append(error)
    if not plans:
        raise complaints[0]
    return tuple(plans)
