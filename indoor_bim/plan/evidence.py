"""Points of one storey that may lie on walls, and values of rasters under points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster
from indoor_bim.plan.tiles import TILE, Tiles, tiles_of
from indoor_bim.threads import even_slices, in_parts, in_threads, threads_for

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEW_POINTS = 20_000
"""So many points are taken by numpy and scipy, sooner than the compiled loops are loaded."""


@dataclass(frozen=True, slots=True, eq=False)
class WallPoints:
    """Points between floor and overhead surface that may lie on walls.

    Parameters
    ----------
    xy : (n, 2) float64
        Plan coordinates, metres.
    rise : (n,) float64
        Height as a share of the clear height at the spot the point was seen from, 0 at the floor and 1 overhead.
    depth : (n,) float64
        Distance below the overhead surface at that spot, metres.
    sensor : (n, 2) float64 or None
        Plan position of the scanner when it took the point, metres.
    tiles : Tiles, optional
        Where the points of each tile are, if they are ordered by tile.
    """

    xy: Floats
    rise: Floats
    depth: Floats
    sensor: Floats | None
    tiles: Tiles | None = None

    def __len__(self) -> int:
        return len(self.xy)

    def take(self, rows: NDArray) -> WallPoints:
        """Points of the given rows (indices or mask)."""
        places = np.flatnonzero(rows) if rows.dtype == bool else rows
        sensor = None if self.sensor is None else self.sensor.take(places, axis=0)
        return WallPoints(self.xy.take(places, axis=0), self.rise.take(places), self.depth.take(places), sensor)

    @property
    def corners(self) -> Floats:
        """Corners (2, 2) of a rectangle around the points, metres."""
        if self.tiles is not None:
            return self.tiles.corners
        return np.array([[values.min() for values in self.xy.T], [values.max() for values in self.xy.T]])

    def along(self, p: Floats, q: Floats, reach: float) -> NDArray[np.int64]:
        """Ranges (k, 2) of rows with all points within reach of the line from p to q, and some others."""
        return np.array([[0, len(self)]]) if self.tiles is None else self.tiles.along(p, q, reach)


def clamp_sample(raster: Raster, xy: Floats) -> NDArray:
    """Values (n,) of a raster under points (n, 2); points outside take the value at the border."""
    if len(xy) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import look_up

        values, image = np.zeros(len(xy)), np.ascontiguousarray(raster.image, dtype=np.float64)
        place = (float(raster.origin[0]), float(raster.origin[1]), raster.cell)
        in_parts(lambda part: look_up(xy[part], image, *place, values[part]), len(xy))
        return values
    rc = np.clip(raster.pixel(xy), 0, np.array(raster.image.shape) - 1)
    return raster.image[rc[:, 0], rc[:, 1]]


def towards_scanner(xy: Floats, sensor: Floats, step: float) -> Floats:
    """Spots (n, 2) a step from points (n, 2) towards the scanner (n, 2 or 3), metres."""
    if len(xy) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import step_towards

        spots = np.zeros((len(xy), 2))
        step_towards(xy, sensor, step, spots)
        return spots
    towards = sensor[:, :2] - xy
    nearer: Floats = xy + step * towards / np.maximum(np.hypot(*towards.T), 1e-9)[:, None]
    return nearer


def wall_points(
    points: Floats, sensor: Floats | None, overhead: Raster, *, floor: float, tolerance: float = 0.06, step: float = 0.30
) -> WallPoints:
    """Points between floor and overhead surface, their height measured against the room that they were seen from.

    Parameters
    ----------
    points : (n, 3) float64
        Model coordinates, metres.
    sensor : (n, 3) float64, optional
        Scanner position at each point, metres.
    overhead : Raster
        Filled overhead height, metres.
    floor : float
        Floor height, metres.
    tolerance : float
        Points this close to floor or overhead surface belong to it, metres.
    step : float
        The overhead height is looked up this far towards the scanner, metres.

    Returns
    -------
    WallPoints
        Ordered by tile; those of a tile in the order of the scan.
    """
    if len(points) > FEW_POINTS:
        return _wall_points_of_many(points, sensor, overhead, floor=floor, tolerance=tolerance, step=step)
    xy = points[:, :2]
    spot = xy if sensor is None else towards_scanner(xy, sensor, step)
    height = clamp_sample(overhead, spot)
    slack = tolerance + clamp_sample(rise_within_cell(overhead), spot)
    keep = (points[:, 2] < height - slack) & (points[:, 2] > floor + tolerance) & (height > floor + 0.5)
    rise = (points[keep, 2] - floor) / (height[keep] - floor)
    tiles, order = tiles_of(xy[keep])
    wall = WallPoints(xy[keep], rise, height[keep] - points[keep, 2], None if sensor is None else sensor[keep, :2])
    return replace(wall.take(order), tiles=tiles)


def _wall_points_of_many(
    points: Floats, sensor: Floats | None, overhead: Raster, *, floor: float, tolerance: float, step: float
) -> WallPoints:
    """As `wall_points`; every thread takes a share of the points, and puts those of a tile behind those of the threads before."""
    from indoor_bim.plan.wall_point_loops import find_candidates, put_into_tiles

    points = np.ascontiguousarray(points)
    seen_from = np.zeros((0, 3)) if sensor is None else np.ascontiguousarray(sensor)
    corners = np.floor(np.array([[points[:, k].min(), points[:, k].max()] for k in (0, 1)]).T / TILE).astype(np.int64)
    columns, rows = (int(side) for side in corners[1] - corners[0] + 1)
    images = (np.ascontiguousarray(image, dtype=np.float64) for image in (overhead.image, rise_within_cell(overhead).image))
    place = (*images, float(overhead.origin[0]), float(overhead.origin[1]), overhead.cell)
    grid = (TILE, int(corners[0, 0]), int(corners[0, 1]), columns)
    parts = even_slices(len(points), threads_for(len(points)))
    height, tile = np.zeros(len(points)), np.zeros(len(points), dtype=np.int32)
    count = np.zeros((len(parts), rows * columns), dtype=np.int64)
    in_threads(
        lambda k: find_candidates(
            points[parts[k]], seen_from[parts[k]], step, *place, floor, tolerance, *grid, height[parts[k]], tile[parts[k]], count[k]
        ),
        range(len(parts)),
        threads=len(parts),
    )
    first = np.concatenate([[0], np.cumsum(count.sum(axis=0))]).astype(np.int64)
    start = first[:-1] + np.cumsum(count, axis=0) - count
    total = int(first[-1])
    xy, rise, depth, spots = np.zeros((total, 2)), np.zeros(total), np.zeros(total), np.zeros((0 if sensor is None else total, 2))
    in_threads(
        lambda k: put_into_tiles(
            points[parts[k]], seen_from[parts[k]], floor, height[parts[k]], tile[parts[k]], start[k], xy, rise, depth, spots
        ),
        range(len(parts)),
        threads=len(parts),
    )
    return WallPoints(xy, rise, depth, None if sensor is None else spots, Tiles(corners[0], columns, first))


def rise_within_cell(overhead: Raster) -> Raster:
    """How far a sloped surface rises within half a cell and a bit, metres; steps between levels do not count."""
    if min(overhead.image.shape) < 2:
        return Raster(np.zeros(overhead.image.shape), overhead.origin, overhead.cell)
    rows, columns = np.gradient(overhead.image)
    rise = np.hypot(rows, columns)
    return Raster(np.where(rise < 2 * overhead.cell, 0.75 * rise, 0.0), overhead.origin, overhead.cell)


def rows_within(points: Floats, low: Floats, high: Floats) -> NDArray[np.int64]:
    """Rows of the points (n, 3) within a box with the given corners (3,), metres."""
    if len(points) > FEW_POINTS:
        from indoor_bim.plan.raster_loops import in_box

        points, inside = np.ascontiguousarray(points), np.zeros(len(points), dtype=bool)
        in_parts(lambda part: in_box(points[part], low, high, inside[part]), len(points))
        return np.flatnonzero(inside)
    return np.flatnonzero(((points > low) & (points < high)).all(axis=1))


def points_at(points: Floats, rows: NDArray[np.int64]) -> Floats:
    """Points (k, 3) of some rows, copied."""
    if len(rows) <= FEW_POINTS:
        return points.take(rows, axis=0)
    from indoor_bim.plan.raster_loops import copy_points

    points, some = np.ascontiguousarray(points), np.zeros((len(rows), 3))
    in_parts(lambda part: copy_points(points, rows[part], some[part]), len(rows))
    return some
