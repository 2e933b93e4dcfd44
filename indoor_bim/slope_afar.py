"""Walls of places that the scanner only looked into, by the stages of the published method on an image of their own.

Through a door, a wall is hit a few times per square metre. In an image that is fine enough for the rooms that were walked through, such
a wall is a row of dots, and the removal of outliers takes it for noise. So what was not seen from close by gets a coarser image.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, LevelledCloud
from indoor_bim.cloud.filters import radius_inliers
from indoor_bim.cloud.thinning import thin_evenly
from indoor_bim.plan.facing import orient_by_free_space
from indoor_bim.plan.image import wall_image
from indoor_bim.plan.line_placement import place_on_points
from indoor_bim.plan.loose_faces import attached, opaque, reach_out, without_doubles
from indoor_bim.plan.passing_rays import Rays
from indoor_bim.plan.raster import Raster, count_raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.slope_lines import find_slope_lines, to_segments
from indoor_bim.plan.support import measure_support
from indoor_bim.plan.wall_stretches import columns_of, wall_stretches
from indoor_bim.slope import COLUMN_SHARE, PIXELS, SlopeStages, lowest_storey, wall_images

Points = NDArray[np.float64]

PIXEL = PIXELS[-1]
"""Side of a pixel, metres."""
LAYER = 0.10
"""Height of the boxes that points are thinned to, metres."""
AROUND = 1.0
"""Distance within which floor and ceiling tell how well a place was seen, metres."""
WELL_SEEN = 0.1
"""Share of the surroundings of a point in which floor or ceiling was seen, where the scanner came by."""
SHORTEST = 1.0
"""Metres; shorter lines are furniture."""
COLUMN = 0.40
"""Width of the columns in which a wall shows, metres."""
NEAR = 0.3
"""Distance within which two hits of floor or ceiling tell that it was seen there, metres."""
BESIDE = 0.25
"""Points this close to a line that was found belong to it, metres."""
BEFORE, LEAST_CONTRAST = 2.0, 0.02
"""Distance before a face in which floor or ceiling shows, metres, and the least difference between the shares of both sides."""
REACH = 0.05
"""Distance within which points belong to a face, metres."""


def walls_afar(levelled: LevelledCloud, found: SlopeStages, walls: Segments, sensor: Points | None = None) -> Segments:
    """Faces of walls where floor and ceiling were hardly seen.

    Parameters
    ----------
    levelled : LevelledCloud
        The levelled scan.
    found : SlopeStages
        What the method found where the scanner came by.
    walls : Segments
        Which of it are walls, metres.
    sensor : (n, 3) float64, optional
        Scanner position at each point of the scan, metres; tells walls from what glass mirrors.

    Returns
    -------
    Segments
        Faces that were hit from low down up to near the ceiling, have a ceiling in front, stopped the rays that came to them, and lead
        to the walls; none where the scan shows none.
    """
    import shapely

    none = found.segments.take(np.zeros(len(found.segments), dtype=bool))
    if found.image.cell >= PIXEL:
        return none
    low, height = lowest_storey(levelled)
    lines = shapely.union_all(shapely.linestrings(np.stack([found.segments.p, found.segments.q], axis=1))).buffer(BESIDE)
    shapely.prepare(lines)
    away = _surroundings(found.free).sample(levelled.points[:, :2]) < WELL_SEEN
    away[away] = ~shapely.contains_xy(lines, *levelled.points[away, :2].T)
    everything = levelled.points[away] - [0, 0, low]
    points = everything[(levelled.part[away] == WALL) & (everything[:, 2] > 0) & (everything[:, 2] < height)]
    faces = _faces(points, height) if len(points) else none
    if not len(faces):
        return none
    if sensor is None:
        hits = count_raster(levelled.points[levelled.part != WALL, :2], cell=LAYER)
        faces = orient_by_free_space(faces, hits, near=LAYER, far=BEFORE, step=LAYER, contrast=LEAST_CONTRAST)
    else:
        faces = seen_faces(faces, everything, sensor[away])
    overhead = levelled.points[levelled.part == CEILING, :2]
    floor = levelled.points[levelled.part == FLOOR, :2]
    columns = columns_of(faces, points, floor, reach=REACH, height=height, column=COLUMN, layer=2 * LAYER)
    nothing = np.zeros(len(faces), dtype=bool)
    faces = wall_stretches(faces, columns, known=nothing, doubtful=~nothing)
    keep = without_doubles(faces.p, faces.q) & _below_ceiling(faces, overhead)
    if sensor is not None:
        keep &= opaque(faces.p, faces.q, Rays(everything, sensor[away] - [0, 0, low], low=LAYER, high=height - LAYER))
    faces = measure_support(faces.take(keep), points, reach=REACH, height=height)
    standing = shapely.union_all(shapely.linestrings(np.stack([walls.p, walls.q], axis=1))).buffer(REACH)
    p, q = reach_out(faces.p, faces.q, standing, mirrors=False)
    return replace(faces, p=p, q=q, top=np.full(len(faces), height)).take(attached(p, q, standing))


def seen_faces(faces: Segments, points: Points, sensor: Points) -> Segments:
    """The faces that were seen on either side of lines, each on the median of its points, free space to its left.

    Parameters
    ----------
    faces : Segments
        Lines through the points of one face, or midway between two, metres.
    points : (n, 3) float64
        Points, metres.
    sensor : (n, 3) float64
        Scanner position at each of them, metres.

    Returns
    -------
    Segments
        One or two for each line; fewer points than a quarter on one side are none.
    """
    p, q = [], []
    for a, b, d, n, length in zip(faces.p, faces.q, faces.direction, faces.normal, faces.length, strict=True):
        along, across = (points[:, :2] - a) @ d, (points[:, :2] - a) @ n
        near = (np.abs(across) < 2 * REACH) & (along > 0) & (along < length)
        to_left = (sensor[near, :2] - a) @ n > 0
        for side, start, end in ((to_left, a, b), (~to_left, b, a)):
            if side.sum() >= max(0.25 * len(side), 1):
                shift = float(np.median(across[near][side])) * n
                p.append(start + shift)
                q.append(end + shift)
    return replace(Segments.from_ends(np.array(p), np.array(q)), sided=np.ones(len(p), dtype=bool))


def _below_ceiling(faces: Segments, ceiling: Points) -> NDArray[np.bool_]:
    """Whether a ceiling was hit here and there before most of a face, where its free side is known."""
    from scipy import ndimage

    hits = count_raster(ceiling, cell=AROUND / 2)
    around = ndimage.convolve(np.pad(hits.image, 1), np.ones((3, 3), dtype=np.int64), mode="constant")
    roofed = Raster(around > 1, hits.origin - hits.cell, hits.cell)
    spots = np.linspace(faces.p, faces.q, 12)[1:-1] + AROUND * faces.normal
    before = roofed.sample(spots.reshape(-1, 2)).reshape(spots.shape[:2])
    kept: NDArray[np.bool_] = ~faces.sided | (before.mean(axis=0) > 0.5)
    return kept


def _faces(points: Points, height: float) -> Segments:
    """Faces in an image of `PIXEL` of wall points, by stages 4 to 11 of the method."""
    radius = 1.5 * PIXEL
    neighbours = max(3, round(COLUMN_SHARE * height / LAYER * 2 * radius / PIXEL))
    dense = thin_evenly(points, cell=PIXEL, layer=LAYER)
    dense = dense[radius_inliers(np.ascontiguousarray(dense[:, :2]), nb_points=neighbours, radius=radius)]
    if not len(dense):
        return Segments.from_ends(np.zeros((0, 2)), np.zeros((0, 2)))
    image, _, slopes = wall_images(dense, pixel=PIXEL)
    lines = find_slope_lines(slopes.image, min_pixels=round(0.3 / PIXEL), merge_gap=0.6 / PIXEL, merge_offset=1.5)
    faces = to_segments(place_on_points(lines, image, points[:, :2], reach=2 * REACH), image, corner_gap=0.15 / PIXEL)
    return faces.take(faces.length >= SHORTEST)


def seen_space(levelled: LevelledCloud, free: Raster) -> Raster:
    """Where floor or ceiling was seen, and, where they were hardly seen, was hit more than once within `NEAR`.

    Parameters
    ----------
    levelled : LevelledCloud
        The levelled scan.
    free : Raster
        Where floor or ceiling was seen, pixel by pixel.
    """
    from scipy import ndimage

    reach = round(NEAR / free.cell)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    hits = wall_image(levelled.points[levelled.part != WALL, :2], magnification=1 / free.cell)
    around = ndimage.convolve(hits.image.astype(np.int16), (x**2 + y**2 <= reach**2).astype(np.int16), mode="constant")
    glimpsed = (around > 1) & (_surroundings(free).image < WELL_SEEN)
    return replace(free, image=free.image | glimpsed)


def _surroundings(free: Raster) -> Raster:
    """Share of the square of `AROUND` on each side of a pixel in which floor or ceiling was seen."""
    from scipy import ndimage

    side = 2 * round(AROUND / free.cell) + 1
    return replace(free, image=ndimage.uniform_filter(free.image.astype(np.float32), side, mode="constant"))
