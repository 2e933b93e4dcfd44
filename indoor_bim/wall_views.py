"""What a scan shows of each wall of a storey."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from indoor_bim.export.files import replace_file
from indoor_bim.model import Storey, Wall
from indoor_bim.plan.brightness import with_brightness
from indoor_bim.plan.recess import rays_at_recess, recess_depth
from indoor_bim.plan.relief import Relief, level_faces
from indoor_bim.plan.scanner_path import path_periods, sensor_positions
from indoor_bim.plan.wall_image import png_bytes, wall_image
from indoor_bim.plan.wall_picture import WallPicture, cell_size, draw_picture, picture_shape
from indoor_bim.plan.wall_points import PointsAround, points_around, rays_from_points
from indoor_bim.plan.wall_rays import WallBox, WallRays, rays_at_walls
from indoor_bim.threads import in_threads, threads_for

Floats = NDArray[np.float64]
Outcome = TypeVar("Outcome")

COARSEST_CELL, COARSEST_BLIND_CELL = 0.06, 0.10  # metres
LONGEST_STAND = 3600.0  # seconds that a scanner measures from its last standpoint
LEAF_REACH = 1.3  # metres before a face: where the leaves of doors stand
FINEST_TOLERANCE, COARSEST_TOLERANCE = 0.03, 0.08  # metres


@dataclass(frozen=True, slots=True, eq=False)
class WallView:
    """Everything that the scan shows of one wall.

    Parameters
    ----------
    wall : Wall
        Wall of the model.
    box : WallBox
        Where it stands.
    rays : WallRays
        Rays at it, with corrected depths.
    picture : WallPicture
        Their picture.
    relief : tuple of Relief
        Relief of its faces.
    around : PointsAround
        Points around it.
    walked : tuple of float
        Places along it where the scanner was carried through, metres.
    scatter : float
        Standard deviation of the hits on its faces, metres.
    tolerance : float
        Hits closer than this to a face are on it, metres.
    through_depth : float
        Rays that ended this far behind the nearer face went through, metres.
    """

    wall: Wall
    box: WallBox
    rays: WallRays
    picture: WallPicture
    relief: tuple[Relief, ...]
    around: PointsAround
    walked: tuple[float, ...]
    scatter: float
    tolerance: float
    through_depth: float
    blind: bool


def each_wall(
    work: Callable[[WallView], Outcome],
    storey: Storey,
    points: Floats,
    *,
    trajectory: Floats | None = None,
    gps_time: Floats | None = None,
    intensity: NDArray | None = None,
    max_thickness: float = 0.60,
    ahead: bool = False,
) -> list[Outcome]:
    """Do work on what the scan shows of each wall, several walls at once.

    Parameters
    ----------
    work : callable
        Takes the view of one wall.
    storey : Storey
        Storey with walls.
    points : (n, 3) float64
        All points of the scan in model coordinates, metres.
    trajectory : (m, 4) float64, optional
        Path of the scanner: time in seconds, and x, y, z in model coordinates, metres.
    gps_time : (n,) float64, optional
        Time of each point, seconds.
    intensity : (n,) array, optional
        Strength of each return, in the unit of the scanner.
    max_thickness : float
        Thickest wall, metres: rays that end farther behind a wall seen from one side went through it.
    ahead : bool
        Whether the pictures show what stands before the walls as well.

    Returns
    -------
    list
        Outcomes of the work, in the order of the walls.
    """
    boxes = [WallBox(wall.axis[0], wall.axis[1], wall.thickness, wall.base, wall.height) for wall in storey.walls]
    around = points_around(boxes, points, reach=LEAF_REACH)
    blind = trajectory is None or gps_time is None or not _is_timed(trajectory, gps_time)
    if trajectory is None or gps_time is None or blind:
        all_rays: list[WallRays | None] = [None] * len(boxes)
    else:
        sensors, periods = sensor_positions(trajectory, gps_time), path_periods(trajectory, gps_time)
        all_rays = [*with_brightness(rays_at_walls(boxes, points, sensors, periods, intensity))]

    def outcome(k: int) -> Outcome:
        walked = _walked_through(boxes[k], trajectory)
        return work(_view(storey.walls[k], all_rays[k], around[k], walked=walked, thickest=max_thickness, ahead=ahead))

    order = sorted(range(len(boxes)), key=lambda k: -len(all_rays[k] or ()))  # what takes longest comes first: all threads end together
    done = dict(zip(order, in_threads(outcome, order, threads=threads_for(len(points))), strict=True))
    return [done[k] for k in range(len(boxes))]


def wall_views(
    storey: Storey,
    points: Floats,
    *,
    trajectory: Floats | None = None,
    gps_time: Floats | None = None,
    intensity: NDArray | None = None,
) -> list[WallView]:
    """What the scan shows of each wall.

    Parameters
    ----------
    storey : Storey
        Storey with walls.
    points : (n, 3) float64
        All points of the scan in model coordinates, metres.
    trajectory : (m, 4) float64, optional
        Path of the scanner: time in seconds, and x, y, z in model coordinates, metres.
    gps_time : (n,) float64, optional
        Time of each point, seconds.
    intensity : (n,) array, optional
        Strength of each return, in the unit of the scanner.
    """
    return each_wall(lambda view: view, storey, points, trajectory=trajectory, gps_time=gps_time, intensity=intensity, ahead=True)


def _view(
    wall: Wall, traced: WallRays | None, around: PointsAround, *, walked: tuple[float, ...], thickest: float, ahead: bool
) -> WallView:
    """What rays, or points where there are none, show of a wall."""
    blind, box = traced is None, around.wall
    rays = traced
    if rays is None:
        rays = rays_from_points(*around.within(), thickness=wall.thickness, both_faces=wall.thickness_measured)
    cell = cell_size(box, len(rays), largest=COARSEST_BLIND_CELL if blind else COARSEST_CELL)
    corrected, scatter, relief = level_faces(rays, cell=cell, shape=picture_shape(box, cell=cell))
    tolerance = float(np.clip(2.5 * scatter, FINEST_TOLERANCE, COARSEST_TOLERANCE))
    if not wall.thickness_measured:
        corrected = corrected.take(np.flatnonzero(corrected.side == _seen_side(corrected, tolerance=tolerance)))
    through_depth = wall.thickness + tolerance if wall.thickness_measured else thickest
    before = around.within() if ahead else None
    picture = draw_picture(box, corrected, tolerance=tolerance, through_depth=through_depth, cell=cell, around=before)
    return WallView(wall, box, corrected, picture, relief, around, walked, scatter, tolerance, through_depth, blind)


def recessed(view: WallView) -> Iterator[WallView]:
    """What the scan shows of the recesses of a wall, from either side.

    Parameters
    ----------
    view : WallView
        What it shows of the wall.

    Yields
    ------
    WallView
        The same wall with the bottom of a recess for its face.
    """
    for side in (1, -1):
        depth = recess_depth(view.rays, side=side, tolerance=view.tolerance)
        if depth is None or depth > view.through_depth - view.tolerance:
            continue
        box = replace(view.box, thickness=max(view.box.thickness - depth, view.tolerance))
        rays = view.rays.take(np.flatnonzero(view.rays.side == side))
        inside = rays_at_recess(rays, depth=depth, thickness=view.box.thickness)
        through_depth = view.through_depth - depth
        picture = draw_picture(box, inside, tolerance=view.tolerance, through_depth=through_depth, cell=view.picture.cell)
        yield replace(view, box=box, rays=inside, picture=picture, relief=(), through_depth=through_depth)


def _is_timed(trajectory: Floats, gps_time: Floats) -> bool:
    """True where the path and the points have times on one clock."""
    if len(trajectory) < 1 or not (np.isfinite(trajectory[:, 0]).all() and np.isfinite(gps_time).all()):
        return False
    begin, end = float(trajectory[0, 0]), float(trajectory[-1, 0])
    slack = max(LONGEST_STAND, (end - begin) / max(len(trajectory) - 1, 1))
    return bool(len(gps_time)) and float(gps_time.min()) > begin - slack and float(gps_time.max()) < end + slack


def _seen_side(rays: WallRays, *, tolerance: float) -> int:
    """Side from which more hits lie on the face."""
    face = np.abs(rays.depth) <= tolerance
    return 1 if int((face & (rays.side == 1)).sum()) >= int((face & (rays.side == -1)).sum()) else -1


def _walked_through(box: WallBox, trajectory: Floats | None) -> tuple[float, ...]:
    """Places along a wall where the path crosses its centre line."""
    if trajectory is None or len(trajectory) < 2:
        return ()
    dx, dy = box.direction
    x, y = trajectory[:, 1] - box.start[0], trajectory[:, 2] - box.start[1]
    along, across = x * dx + y * dy, y * dx - x * dy
    level = trajectory[:, 3] - box.base
    rows = np.flatnonzero(((across[:-1] < 0) != (across[1:] < 0)) & (level[:-1] > 0) & (level[:-1] < box.height))
    share = across[rows] / (across[rows] - across[rows + 1])
    place = along[rows] + share * (along[rows + 1] - along[rows])
    step = np.hypot(np.diff(x)[rows], np.diff(y)[rows])
    return tuple(float(p) for p in place[(place > 0) & (place < box.length) & (step < 1.0)])


def picture_png(view: WallView, wall: Wall | None = None) -> bytes:
    """Picture of a wall as a PNG file.

    Parameters
    ----------
    view : WallView
        What the scan shows of it.
    wall : Wall, optional
        Wall whose openings are outlined; default: that of the view.
    """
    openings = (wall or view.wall).openings
    return png_bytes(wall_image(view.picture, [(o.start, o.start + o.width, o.sill, o.sill + o.height) for o in openings]))


def write_wall_pictures(
    storey: Storey,
    points: Floats,
    folder: str | os.PathLike[str],
    *,
    trajectory: Floats | None = None,
    gps_time: Floats | None = None,
) -> list[Path]:
    """Write the picture of every wall of a storey as ``<wall>.png``, its openings outlined.

    Parameters
    ----------
    storey : Storey
        Storey with walls and openings.
    points : (n, 3) float64
        All points of the scan in model coordinates, metres.
    folder : path
        Folder to write to; it must exist.
    trajectory : (m, 4) float64, optional
        Path of the scanner: time in seconds, and x, y, z in model coordinates, metres.
    gps_time : (n,) float64, optional
        Time of each point, seconds.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    WriteError
        If a file cannot be written.
    """

    def written(view: WallView) -> Path:
        path = Path(folder, f"{view.wall.id}.png")
        with replace_file(path) as draft:
            draft.write_bytes(picture_png(view))
        return path

    return each_wall(written, storey, points, trajectory=trajectory, gps_time=gps_time, ahead=True)
