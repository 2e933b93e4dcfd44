"""Free space of a storey: how far it reaches, where floor and ceiling were hit, and what that says about each cell of the plan."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim.plan.cells import Cells, cell_image
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.hit_images import covered, level_raster, local_density, overhead_hits
from indoor_bim.plan.raster import Raster
from indoor_bim.threads import in_threads

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Images = NDArray[np.floating]

FAINT = 0.004
"""Share of pixels hit by two hits within half a metre."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeSpace:
    """Hits of floor and ceiling, pixel by pixel; pixels over walls count for neither.

    Parameters
    ----------
    ceiling, floor : (rows, columns) bool
        Pixels that were hit.
    ceiling_density, floor_density : (rows, columns) float32
        Share of the pixels that would be hit around each pixel if the surface were there.
    low : (2,) float64
        Corner of the images, metres.
    cell : float
        Side of a pixel, metres.
    """

    ceiling: Bools
    floor: Bools
    ceiling_density: Images
    floor_density: Images
    low: Floats
    cell: float

    def raster(self, image: NDArray) -> Raster:
        """Raster of an image of the same shape."""
        return Raster(image, self.low, self.cell)

    @property
    def hit(self) -> Raster:
        """Whether floor or ceiling was hit."""
        return self.raster(self.ceiling | self.floor)

    @property
    def glimpsed(self) -> Raster:
        """Whether floor or ceiling was hit within half a metre, more than once."""
        return self.raster((self.ceiling_density > FAINT) | (self.floor_density > FAINT))

    @property
    def overhead_density(self) -> Raster:
        """Points per square metre of the ceiling."""
        return self.raster(self.ceiling_density / self.cell**2)

    def denser_than(self, points: float) -> FreeSpace:
        """Hits where floor or ceiling hold more points per square metre."""
        near_by = (self.ceiling_density > points * self.cell**2) | (self.floor_density > points * self.cell**2)
        return replace(self, ceiling=self.ceiling & near_by, floor=self.floor & near_by)


def free_space(
    points: Floats,
    everything: Floats,
    wall: WallPoints,
    overhead: Raster,
    *,
    floor: float,
    cover: float,
    low: Floats,
    high: Floats,
    cell: float,
    open_top: bool = False,
) -> FreeSpace:
    """Hits of the floor and of the surface overhead.

    Parameters
    ----------
    points : (n, 3) float64
        Points of the storey, metres.
    everything : (m, 3) float64
        All points of the scan, metres.
    wall : WallPoints
        Wall candidates among the points of the storey.
    overhead : Raster
        Filled overhead height, metres.
    floor : float
        Floor height, metres.
    cover : float
        Points from this height on are something overhead: floor without is outdoors, metres.
    low, high : (2,) float64
        Corners of the images, metres.
    cell : float
        Side of a pixel, metres.
    open_top : bool
        No ceiling was seen.
    """
    seen, column = overhead_hits(points, wall, overhead, low=low, high=high, cell=cell)
    known = ~column & covered(everything, above=cover, low=low, high=high, cell=cell, open_top=open_top)
    ground = known & level_raster(points, base=floor, least=-0.06, most=0.06, low=low, high=high, cell=cell).image
    surfaces = [(seen.image, ~column), (ground, known)]
    density, floor_density = in_threads(lambda pair: local_density(*pair, cell=cell), surfaces, threads=2)
    ceiling = seen.image
    if open_top:
        ceiling, density = np.zeros_like(ceiling), np.zeros_like(density)
    return FreeSpace(ceiling, ground, density, floor_density, low, cell)


def extent(overhead: Raster | None, sample: Floats, *, floor: float, top: float, margin: float = 1.2) -> tuple[Floats, Floats]:
    """Corners of the rectangle that a storey fills, with a margin.

    Parameters
    ----------
    overhead : Raster or None
        Overhead height, NaN where nothing was seen; None where no such surface was.
    sample : (n, 3) float64
        Thinned points, metres.
    floor, top : float
        Heights between which points belong to the storey, metres.
    margin : float
        Margin around the ceiling, metres.

    Returns
    -------
    low, high : (2,) float64
        Corners, metres.
    """
    from scipy import ndimage

    if overhead is None:
        spots = sample[(sample[:, 2] > floor + 0.5) & (sample[:, 2] < top), :2]
        return np.quantile(spots, 0.005, axis=0) - 0.1, np.quantile(spots, 0.995, axis=0) + 0.1
    spots = overhead.centre(np.argwhere(~np.isnan(overhead.image)))
    level = float(np.nanmedian(overhead.image))
    hits = np.floor(sample[np.abs(sample[:, 2] - level) < 0.06, :2]).astype(np.int64)
    first = hits.min(axis=0)
    hit = np.zeros(hits.max(axis=0) - first + 1, dtype=np.float32)
    hit[tuple((hits - first).T)] = 1
    wide = (hit > 0) & (9 * ndimage.uniform_filter(hit, 3, mode="constant") > 4.5)
    spots = np.vstack([spots, np.argwhere(wide) + first, np.argwhere(wide) + first + 1.0])
    return spots.min(axis=0) - margin, spots.max(axis=0) + margin


@dataclass(frozen=True, slots=True, eq=False)
class CellSpace:
    """What floor and ceiling say about each cell.

    Parameters
    ----------
    inside : (k,) float64
        Evidence in square metres that the cell is free space; negative where it is not.
    spanned : (k,) bool
        Whether a surface overhead spans the cell.
    hit : (k,) float64
        Share of the pixels of the cell that floor or ceiling was hit in.
    """

    inside: Floats
    spanned: Bools
    hit: Floats


def cell_space(cells: Cells, space: FreeSpace) -> CellSpace:
    """Evidence for free space in each cell: the surface overhead, and the floor where there is nothing overhead.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    space : FreeSpace
        Hits of floor and ceiling.
    """
    from indoor_bim.plan.cell_loops import sum_in_cells

    hits = [np.ascontiguousarray(image) for image in (space.ceiling, space.floor)]
    densities = [np.ascontiguousarray(image, dtype=np.float32) for image in (space.ceiling_density, space.floor_density)]
    below = densities[1][(densities[0] > 0.02) & (densities[1] > 0)]
    usual = float(np.median(below)) if len(below) else 0.0
    sums = np.zeros((len(cells.polygons), 9))
    sum_in_cells(cell_image(cells.polygons, space.raster(space.ceiling)), *hits, *densities, 0.5 * usual, sums)
    pixels, hit, ceiling, expected, sure, sure_alone, floor, floor_expected, floor_sure = sums.T
    share = np.clip(ceiling / np.maximum(expected, 1e-9), 0, 1)
    floor_share = np.clip(floor / np.maximum(floor_expected, 1e-9), 0, 1)
    area = np.array([polygon.area for polygon in cells.polygons])
    for_room = np.clip(share / 0.3 - 1, -1, 1)
    evidence = np.where(for_room < 0, sure_alone, sure) * for_room + floor_sure * np.clip(floor_share / 0.4 - 1, -0.3, 1)
    spanned = (share > 0.3) & (sure * space.cell**2 > 0.3 * area)
    return CellSpace(evidence * space.cell**2 - 0.1 * area, spanned, hit / np.maximum(pixels, 1))


def in_front(cells: Cells, faces: Floats, *, depth: float = 0.60, most: float = 0.5) -> Floats:
    """Square metres in each cell that lie right in front of faces: whoever saw a face looked through them.

    Parameters
    ----------
    cells : Cells
        Arrangement.
    faces : (e,) float64
        Share of each edge where a face looking to its left was seen.
    depth : float
        Depth in front of a face that counts, metres.
    most : float
        Share of a cell's area that counts at most.
    """
    length = np.hypot(*(cells.edge_end - cells.edge_start).T)
    front = np.bincount(cells.left[cells.left >= 0], (depth * faces * length)[cells.left >= 0], minlength=len(cells.polygons))
    return np.minimum(front, most * np.array([polygon.area for polygon in cells.polygons]))


def usual_density(polygon: shapely.Polygon, space: FreeSpace) -> float:
    """Median density of floor or ceiling, whichever is denser, where either was hit in a polygon; points per square metre, 0 for none."""
    first, last = space.raster(space.ceiling).pixel(np.array(polygon.bounds).reshape(2, 2))
    rows, columns = np.meshgrid(np.arange(first[0], last[0] + 1, 4), np.arange(first[1], last[1] + 1, 4), indexing="ij")
    centres = space.raster(space.ceiling).centre(np.column_stack([rows.ravel(), columns.ravel()]))
    within = centres[shapely.contains_xy(polygon, *centres.T)]
    density = np.maximum(*(space.raster(image).sample(within) for image in (space.ceiling_density, space.floor_density)))
    return float(np.median(density[density > 0])) / space.cell**2 if (density > 0).any() else 0.0


def roofed(space: FreeSpace, *, coarse: float = 0.5) -> Raster:
    """Where the surface overhead was hit here and there, however thinly, but not all along a line as the top of a wall is.

    Parameters
    ----------
    space : FreeSpace
        Hits of floor and ceiling.
    coarse : float
        Side of the pixels of the result, metres; of each and its eight neighbours two have to be hit, and not just three in a line.
    """
    from scipy import ndimage

    step = round(coarse / space.cell)
    rows, columns = (np.array(space.ceiling.shape) // step) * step
    hit = space.ceiling[:rows, :columns].reshape(rows // step, step, columns // step, step).any(axis=(1, 3))
    around = np.rint(9 * ndimage.uniform_filter(hit.astype(np.float32), 3, mode="constant"))
    line = np.zeros_like(hit)
    for axis in (0, 1):
        full = 3 * ndimage.uniform_filter1d(hit.astype(np.float32), 3, axis=axis, mode="constant") > 2.5
        line |= ndimage.maximum_filter1d(full, 3, axis=1 - axis)
    return Raster((around >= 2) & ~(line & (around == 3)), space.low, space.cell * step)
