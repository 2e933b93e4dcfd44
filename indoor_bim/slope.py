"""The published `slope` method from a levelled cloud to wall faces (Remote Sensing 2021, 13, 4930)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import WALL, LevelledCloud
from indoor_bim.cloud.filters import radius_inliers
from indoor_bim.cloud.spacing import point_spacing
from indoor_bim.cloud.thinning import thin_evenly
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.facing import orient_by_free_space
from indoor_bim.plan.heights import line_heights
from indoor_bim.plan.image import remove_burrs, thicken, wall_image
from indoor_bim.plan.line_placement import place_on_points
from indoor_bim.plan.pixel_size import connected_pixel
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.skeleton import pixel_slopes, remove_faults, thin_to_skeleton
from indoor_bim.plan.slope_lines import find_slope_lines, to_segments
from indoor_bim.plan.support import measure_support

Points = NDArray[np.float64]

FINEST_PIXEL = 0.015
"""Side of the smallest pixel, metres."""
PIXELS = (FINEST_PIXEL, 0.02, 0.03, 0.04, 0.06, 0.08, 0.10, 0.12)
"""Sides of pixels to choose from, metres."""
LAYER = 0.05
"""Height of the boxes that wall points are thinned to, metres."""
COLUMN_SHARE = 0.06
"""Share of a full column of boxes that a wall has to show."""
LARGEST_LOSS = 0.05
"""Share of the wall pixels that the removal of burrs may take before the image counts as too thin."""


@dataclass(frozen=True, slots=True, eq=False)
class SlopeStages:
    """Every product of the method, for whoever wants to look.

    Parameters
    ----------
    walls : (n, 3) float64
        Wall points that were left by the filters, metres.
    image : Raster
        Binary image of the walls without burrs.
    skeleton : Raster
        Skeleton of the image.
    slopes : Raster
        Slope of each pixel of the skeleton, faults removed.
    free : Raster
        Where floor or ceiling was seen.
    segments : Segments
        Faces.
    """

    walls: Points
    image: Raster
    skeleton: Raster
    slopes: Raster
    free: Raster
    segments: Segments


def slope_stages(
    levelled: LevelledCloud,
    *,
    gror_radius: float | None = None,
    gror_neighbours: int | None = None,
    magnification: float | None = None,
    min_pixels: int | None = None,
    merge_gap: float | None = None,
    merge_offset: float | None = None,
    corner_gap: float | None = None,
    refit: bool = True,
) -> SlopeStages:
    """Run the method and keep the product of every stage; parameters that are None are derived from the points.

    Parameters
    ----------
    levelled : LevelledCloud
        Cloud with x along a main direction, as `indoor_bim.cloud.pca_levelling.level_by_pca` gives it. The lowest storey is taken.
    gror_radius : float, optional
        Radius of the outlier removal in plan, metres (r_GROR); None: 1.5 pixels.
    gror_neighbours : int, optional
        Neighbours that a point needs within it (n_GROR), counted on all points as published. None: the points are thinned to
        boxes of a pixel by `LAYER` first, so that near and far walls count alike, and a point needs `COLUMN_SHARE` of the
        neighbours that it would have in a wall seen from floor to ceiling.
    magnification : float, optional
        Pixels per metre of the wall image (n_moc); None: the finest of `PIXELS` at which walls are unbroken lines.
    min_pixels : int, optional
        Lines of fewer pixels are dropped before lines are merged; None: 10 cm, at least 3 pixels.
    merge_gap : float, optional
        Distance of end points below which lines of equal slope are merged, pixels (d_p); None: 30 cm.
    merge_offset : float, optional
        Largest distance across such lines, pixels; None: 3 cm, at least 1.5 pixels.
    corner_gap : float, optional
        Distance of end points below which they become a corner, pixels (d_v); None: 15 cm.
    refit : bool
        Move each line to the median of its points; False: leave it at the mean of its pixels, as published.

    Returns
    -------
    SlopeStages
        All products.

    Raises
    ------
    NothingToReconstructError
        If there are no walls.
    """
    between, low, height = points_between(levelled)
    spacing = point_spacing(between)
    magnification = 1 / connected_pixel(between, sizes=PIXELS) if magnification is None else magnification
    pixel = 1 / magnification
    gror_radius = 1.5 * pixel if gror_radius is None else gror_radius
    walls = between
    if gror_neighbours is None:
        layer = max(LAYER, spacing)
        walls = thin_evenly(between, cell=pixel, layer=layer)
        gror_neighbours = max(3, round(COLUMN_SHARE * height / layer * 2 * gror_radius / pixel))
    walls = walls[radius_inliers(np.ascontiguousarray(walls[:, :2]), nb_points=gror_neighbours, radius=gror_radius)]
    if not len(walls):
        raise NothingToReconstructError(
            f"found no walls: none of {len(between)} points between floor and ceiling has {gror_neighbours} others within "
            f"{gror_radius:.3f} m in plan; scan the walls from floor to ceiling, or lower slope.gror_neighbours"
        )
    image, skeleton, slopes = wall_images(walls, pixel=pixel)
    lines = find_slope_lines(
        slopes.image,
        min_pixels=max(3, round(0.10 * magnification)) if min_pixels is None else min_pixels,
        merge_gap=0.30 * magnification if merge_gap is None else merge_gap,
        merge_offset=max(1.5, 0.03 * magnification) if merge_offset is None else merge_offset,
    )
    if not len(lines):
        raise NothingToReconstructError(f"found no wall lines in an image of {int(image.image.sum())} wall pixels; expected straight walls")
    walls = thin_evenly(walls, cell=min(pixel, FINEST_PIXEL), layer=LAYER)
    if refit:
        lines = place_on_points(lines, image, walls[:, :2], reach=max(3 * pixel, 0.03))
    segments = to_segments(lines, image, corner_gap=0.15 * magnification if corner_gap is None else corner_gap)
    free = free_space(levelled)
    reach = max(2 * pixel, 0.03)
    segments = measure_support(orient_by_free_space(segments, free), walls - [0, 0, low], reach=reach, height=height)
    middle = (segments.p + segments.q) / 2
    top = line_heights(middle, walls[:, :2], walls[:, 2] - low, radius=2 * pixel, storey_height=height)
    return SlopeStages(walls, image, skeleton, slopes, free, replace(segments, top=top))


def points_between(levelled: LevelledCloud) -> tuple[Points, float, float]:
    """Wall points between floor and ceiling of the lowest storey, height of its floor, and its height, metres.

    Raises
    ------
    NothingToReconstructError
        If there are hardly any.
    """
    z = levelled.points[:, 2]
    low, height = lowest_storey(levelled)
    between = levelled.points[(levelled.part == WALL) & (z > low) & (z < low + height)]
    if len(between) < 100:
        raise NothingToReconstructError(
            f"found {len(between)} points between floor and ceiling of {len(z)} points; expected walls: scan them too"
        )
    return between, low, height


def lowest_storey(levelled: LevelledCloud) -> tuple[float, float]:
    """Height of the floor of the lowest storey and its clear height, metres; up to the outermost points where one was not seen."""
    z = levelled.points[:, 2]
    floor, ceiling = levelled.storeys[0].floor, levelled.storeys[0].ceiling
    low = floor if floor is not None else float(np.quantile(z, 0.005))
    high = ceiling if ceiling is not None else float(np.quantile(z, 0.995))
    return low, high - low


def wall_images(walls: Points, *, pixel: float) -> tuple[Raster, Raster, Raster]:
    """Image of the walls without burrs, its skeleton, and the slopes of the skeleton without faults (sections 2.2 and 2.3).

    Parameters
    ----------
    walls : (n, 3) float64
        Wall points, metres.
    pixel : float
        Side of a pixel, metres.
    """
    image = _clean_image(wall_image(walls[:, :2], magnification=1 / pixel))
    skeleton = replace(image, image=thin_to_skeleton(image.image))
    return image, skeleton, replace(image, image=remove_faults(pixel_slopes(skeleton.image)))


def _clean_image(image: Raster) -> Raster:
    """Image without burrs, thickened before where its lines are too thin to survive that."""
    clean = remove_burrs(image.image)
    if (image.image & ~clean).sum() > LARGEST_LOSS * image.image.sum():
        clean = remove_burrs(thicken(image.image))
    return replace(image, image=clean)


def slope_segments(levelled: LevelledCloud, **parameters: float | None) -> Segments:
    """Wall faces by the published method; see `slope_stages`.

    Parameters
    ----------
    levelled : LevelledCloud
        Cloud with x along a main direction.
    **parameters : float, int, bool or None
        Those of `slope_stages`.

    Returns
    -------
    Segments
        Faces, sorted by the coordinates of their ends.
    """
    return slope_stages(levelled, **parameters).segments  # type: ignore[arg-type]


def free_space(levelled: LevelledCloud, *, cell: float | None = None) -> Raster:
    """Image of where floor or ceiling was seen.

    Parameters
    ----------
    levelled : LevelledCloud
        Cloud split into floor, ceiling and walls.
    cell : float, optional
        Side of a pixel, metres; None: slightly more than the point spacing, at least 3 cm.

    Returns
    -------
    Raster
        True where a floor or ceiling point lies, or in five of the eight neighbours.
    """
    seen = levelled.points[levelled.part != WALL, :2]
    if not len(seen):
        return Raster(np.zeros((1, 1), dtype=bool), np.zeros(2), 0.03)
    if cell is None:
        spacing = point_spacing(levelled.points[levelled.part != WALL])
        cell = max(0.03, 1.1 * spacing) if np.isfinite(spacing) else 0.03
    raster = wall_image(seen, magnification=1 / cell)
    return replace(raster, image=raster.image | remove_burrs(raster.image))
