"""Where the points of one storey hit floor, walls and what is overhead, pixel by pixel, and how densely."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.block_image import bits_of_points
from indoor_bim.plan.evidence import FEW_POINTS, WallPoints, clamp_sample, rise_within_cell
from indoor_bim.plan.raster import Raster
from indoor_bim.threads import in_parts

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEW_PIXELS = 100_000
"""So many pixels are taken by scipy, sooner than the compiled loops are loaded."""


def hit_raster(xy: Floats, *, low: Floats, high: Floats, cell: float) -> Raster:
    """True in every cell that holds a point (n, 2)."""
    raster = _no_hits(low, high, cell)
    if len(xy) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import mark

        mark(xy, float(low[0]), float(low[1]), cell, raster.image)
        return raster
    rc = raster.pixel(xy)
    rc = rc[((rc >= 0) & (rc < raster.image.shape)).all(axis=1)]
    raster.image[rc[:, 0], rc[:, 1]] = True
    return raster


def level_raster(points: Floats, *, base: float, least: float, most: float, low: Floats, high: Floats, cell: float) -> Raster:
    """True in every cell that holds a point (n, 3) between the heights `least` and `most` above `base`, metres."""
    if len(points) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import mark_level

        points, raster = np.ascontiguousarray(points), _no_hits(low, high, cell)
        place = (float(low[0]), float(low[1]), cell)
        in_parts(lambda part: mark_level(points[part], base, least, most, *place, raster.image), len(points))
        return raster
    above = points[:, 2] - base
    return hit_raster(points[(above > least) & (above < most), :2], low=low, high=high, cell=cell)


def surface_raster(points: Floats, surface: Raster, slack: Raster, *, low: Floats, high: Floats, cell: float) -> Raster:
    """True in every cell that holds a point (n, 3) within the slack of a surface; both rasters have the same cells."""
    if len(points) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import mark_surface

        points, raster = np.ascontiguousarray(points), _no_hits(low, high, cell)
        images = [np.ascontiguousarray(image, dtype=np.float64) for image in (surface.image, slack.image)]
        place = (float(surface.origin[0]), float(surface.origin[1]), surface.cell, float(low[0]), float(low[1]), cell)
        in_parts(lambda part: mark_surface(points[part], *images, *place, raster.image), len(points))
        return raster
    hit = np.abs(points[:, 2] - clamp_sample(surface, points[:, :2])) < clamp_sample(slack, points[:, :2])
    return hit_raster(points[hit, :2], low=low, high=high, cell=cell)


def _no_hits(low: Floats, high: Floats, cell: float) -> Raster:
    return Raster(np.zeros(np.ceil((high - low) / cell).astype(np.int64)[::-1], dtype=bool), low, cell)


def overhead_hits(
    points: Floats, wall: WallPoints, overhead: Raster, *, low: Floats, high: Floats, cell: float, tolerance: float = 0.06
) -> tuple[Raster, Bools]:
    """Where the overhead surface was hit; the upper ends of walls are no ceiling.

    Parameters
    ----------
    points : (n, 3) float64
        Points of the storey, metres.
    wall : WallPoints
        Wall candidates among them.
    overhead : Raster
        Filled overhead height, metres.
    low, high : (2,) float64
        Corners of the raster, metres.
    cell : float
        Side of a pixel, metres.
    tolerance : float
        Points this close to the overhead surface belong to it, metres.

    Returns
    -------
    seen : Raster
        True where hit; False over walls.
    column : (rows, columns) bool
        Pixels over walls, and those around them.
    """
    slack = Raster(tolerance + rise_within_cell(overhead).image, overhead.origin, overhead.cell)
    raster = surface_raster(points, overhead, slack, low=low, high=high, cell=cell)
    rows, columns = raster.image.shape
    column = np.zeros((rows, columns), dtype=bool)
    i, j = wall_columns(wall, raster)
    for down, across in itertools.product((-1, 0, 1), (-1, 0, 1)):
        column[np.clip(i + down, 0, rows - 1), np.clip(j + across, 0, columns - 1)] = True
    return Raster(raster.image & ~column, low, cell), column


def wall_columns(wall: WallPoints, raster: Raster, *, above: float = 0.75, layers: int = 24) -> tuple[NDArray[np.int64], ...]:
    """Rows (k,) and columns (k,) of the pixels of a raster in which points high on the walls hit more than one height layer."""
    rows, columns = raster.image.shape
    if len(wall) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import set_layers

        place = (float(raster.origin[0]), float(raster.origin[1]), raster.cell)
        layered = bits_of_points(
            lambda *image: set_layers(wall.xy, wall.rise, above, layers, *place, columns, *image), (rows, columns), points=len(wall)
        )
        return replace(layered, values=np.bitwise_count(layered.values) >= 2).nonzero()
    upper = wall.rise > above
    rc = raster.pixel(wall.xy[upper])
    layer = np.clip((wall.rise[upper] * layers).astype(np.int64), 0, layers - 1)
    ok = ((rc >= 0) & (rc < raster.image.shape)).all(axis=1)
    masks = np.zeros((rows, columns), dtype=np.uint32)
    np.bitwise_or.at(masks, (rc[ok, 0], rc[ok, 1]), np.uint32(1) << layer[ok].astype(np.uint32))
    return np.nonzero(np.bitwise_count(masks) >= 2)


def covered(
    points: Floats,
    *,
    above: float,
    low: Floats,
    high: Floats,
    cell: float,
    open_top: bool = False,
    coarse: float = 0.20,
    reach: float = 0.6,
) -> Bools:
    """Pixels that have something overhead, at whatever height: indoors, even where the ceiling is missing.

    Parameters
    ----------
    points : (n, 3) float64
        All points, metres.
    above : float
        Height from which points count, metres.
    low, high : (2,) float64
        Corners of the raster, metres.
    cell : float
        Side of a pixel, metres.
    open_top : bool
        No ceiling was seen: what tall walls surround counts as well.
    coarse : float
        Side of the cells that are looked at, metres.
    reach : float
        Cells within this distance are averaged, metres.
    """
    from scipy import ndimage

    hits = level_raster(points, base=above, least=0.0, most=np.inf, low=low, high=high, cell=coarse)
    share = ndimage.uniform_filter(hits.image.astype(np.float32), 2 * round(reach / coarse) + 1)
    shape = np.ceil((high - low) / cell).astype(np.int64)[::-1]
    rows = np.minimum((np.arange(shape[0]) * cell / coarse).astype(np.int64), share.shape[0] - 1)
    columns = np.minimum((np.arange(shape[1]) * cell / coarse).astype(np.int64), share.shape[1] - 1)
    under = share > 0.25
    if open_top:
        under |= ndimage.binary_fill_holes(ndimage.binary_closing(np.pad(hits.image, 3), np.ones((3, 3)), iterations=2))[3:-3, 3:-3]
    indoors: Bools = under.take(rows, axis=0).take(columns, axis=1)
    return indoors


def local_density(seen: Bools, known: Bools, *, cell: float, reach: float = 0.25) -> NDArray[np.floating]:
    """Best mean within a distance of each pixel, 0 where nothing can be known.

    Parameters
    ----------
    seen : (rows, columns) bool
        Pixels that were hit.
    known : (rows, columns) bool
        Pixels that count.
    cell : float
        Side of a pixel, metres.
    reach : float
        Distance, metres.

    Returns
    -------
    (rows, columns) float32
    """
    steps = round(reach / cell)
    density: NDArray[np.floating]
    if seen.size > FEW_PIXELS:
        from indoor_bim.plan.window_loops import best_share_around

        density = np.zeros(seen.shape, dtype=np.float32)
        best_share_around(np.ascontiguousarray(seen), np.ascontiguousarray(known), steps, 0.05, density)
        return density
    from scipy import ndimage

    window, weight = 2 * steps + 1, known.astype(np.float32)
    mean = ndimage.uniform_filter(seen.astype(np.float32), window) / np.maximum(ndimage.uniform_filter(weight, window), 0.05)
    density = ndimage.maximum_filter(mean, window) * weight
    return density
