"""Levelling by principal components: floor, ceiling and walls of a scan at any attitude.

Source: Remote Sensing 2021, 13, 4930, section 2.1 (algorithms 1 and 2). Each step of the paper is a function here;
`level_by_pca` joins them and adds what the paper leaves to the operator: far stray points are left out, the planes
are refitted robustly, thresholds come from their residuals, and the building is turned into its main direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud, LevelledCloud, StoreyLevels
from indoor_bim.cloud.filters import statistical_inliers
from indoor_bim.cloud.spacing import point_spacing
from indoor_bim.cloud.thinning import MICROMETRE, thin_evenly
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.directions import main_direction

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]

LARGEST_TILT = np.deg2rad(35)
"""Tilt beyond which the axis that the principal components offer as vertical is not believed."""
LARGEST_SLANT = np.deg2rad(3)
"""Angle beyond which floor and ceiling are not parallel."""
SMALLEST_HEIGHT = 1.5
"""Storeys lower than this (metres) are not believed."""
THIN_CELL = 0.05
"""Side of the boxes that points are thinned to, metres."""
ENOUGH_POINTS = 60_000
"""So many points make a first guess as good as all do; what they guess is refined on all."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Plane ``normal · x = offset``.

    Parameters
    ----------
    normal : (3,) float64
        Unit normal.
    offset : float
        Distance of the plane from the origin along the normal, metres.
    """

    normal: Points
    offset: float

    def height(self, points: Points) -> Points:
        """Signed distances (n,) of points (n, 3) from the plane, metres; positive on the side of the normal."""
        x, y, z = np.asarray(points, dtype=np.float64).T
        height: Points = self.normal[0] * x + self.normal[1] * y + self.normal[2] * z - self.offset
        return height

    def facing(self, up: Points) -> Self:
        """Return the same plane with its normal turned to the side of `up` (3,)."""
        return self if float(self.normal @ up) >= 0 else type(self)(-self.normal, -self.offset)


def principal_axes(points: Points) -> tuple[Points, Points, Points]:
    """Mean, principal axes and variances of points (section 2.1, algorithm 1).

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.

    Returns
    -------
    mean : (3,) float64
        Mean of the points.
    axes : (3, 3) float64
        Unit axes v1, v2, v3 in the rows, largest variance first; v3 is the normal of the mid plane.
    variances : (3,) float64
        Variances along the axes, square metres.

    Examples
    --------
    >>> mean, axes, variances = principal_axes(np.array([[0.0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 0]]))
    >>> mean.tolist(), np.abs(axes).round(6).tolist()
    ([2.0, 1.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    """
    mean = points.mean(axis=0)
    deviation = points - mean
    _, variances, axes = np.linalg.svd(deviation.T @ deviation / len(points))
    return mean, axes, variances


def fit_plane(points: Points) -> Plane:
    """Plane through points by principal components (section 2.1, equations 1 and 5).

    Parameters
    ----------
    points : (n, 3) float64
        At least three points, metres.

    Returns
    -------
    Plane
        Plane of least squared distance, its normal towards +z.
    """
    mean, axes, _ = principal_axes(points)
    return Plane(axes[2], float(axes[2] @ mean)).facing(np.array([0.0, 0.0, 1.0]))


def alone_in_cell(xy: Points, *, grid_count: int) -> Mask:
    """Points that have a cell of the grid to themselves (section 2.1, grid threshold method, equations 2 to 4).

    A wall stacks many points in a cell, a floor or ceiling about one. The grid covers the range of the points (the paper
    prints the maximum instead of the range); cell numbers are rounded, then clamped to 1 ... `grid_count`.

    Parameters
    ----------
    xy : (n, 2) float64
        Points projected to the plane, metres.
    grid_count : int
        Cells along each side of the grid (n_fac).

    Returns
    -------
    (n,) bool
        True where a point is the only one of its cell.

    Examples
    --------
    >>> alone_in_cell(np.array([[0.0, 0.0], [0.1, 0.0], [5.0, 9.0], [10.0, 10.0]]), grid_count=10).tolist()
    [False, False, True, True]
    """
    low = xy.min(axis=0)
    step = np.maximum((xy.max(axis=0) - low) / grid_count, MICROMETRE)
    i, j = np.clip(np.rint((xy - low) / step).astype(np.int64), 1, grid_count).T
    cell = (i - 1) * grid_count + (j - 1)
    alone: Mask = np.bincount(cell, minlength=1)[cell] == 1
    return alone


def sharpest_normal(points: Points, normal: Points) -> Points:
    """Return the normal near a first guess along which horizontal surfaces pile up most sharply.

    The paper fits each plane once to all points that are alone in their cell; stairs, furniture and surfaces at several heights
    tilt that fit by degrees. Here tilts about the guess are searched coarse to fine for the largest sum of squared counts
    of the heights.

    Parameters
    ----------
    points : (n, 3) float64
        Points, evenly thinned, metres.
    normal : (3,) float64
        First guess, within some 8 degrees.

    Returns
    -------
    (3,) float64
        Unit normal on the side of the guess.
    """
    sample = points[:: max(1, len(points) // 30_000)]
    sample = sample - np.median(sample, axis=0)
    turn = rotation_to_z(normal)
    for half, step, layer, every in ((8.0, 1.0, 0.15, 4), (1.0, 0.25, 0.08, 1), (0.25, 0.05, 0.04, 1)):
        x, y, z = turn @ sample[::every].T
        slopes = np.tan(np.deg2rad(step)) * np.arange(-round(half / step), round(half / step) + 1)
        tilts = [(a * a + b * b, a, b) for a in slopes for b in slopes]
        _, _, a, b = max((_peakedness((a * x + b * y + z) / np.sqrt(1 + r), layer), -r, a, b) for r, a, b in tilts)
        best = turn.T @ np.array([a, b, 1.0])
        turn = rotation_to_z(best / np.linalg.norm(best))
    upright: Points = turn[2]
    return upright


def _peakedness(height: Points, layer: float) -> float:
    index = np.floor(height / layer).astype(np.int64)
    counts = np.bincount(index - index.min())
    return float((np.convolve(counts, [0.5, 1.0, 0.5]) ** 2).sum())


def horizontal_layers(height: Points, *, layer: float = 0.05, contrast: float = 2.5, share: float = 0.25) -> tuple[Points, Points]:
    """Heights at which horizontal surfaces lie, from the bottom up.

    Parameters
    ----------
    height : (n,) float64
        Heights of evenly thinned points, metres.
    layer : float
        Thickness of the layers that are counted, metres.
    contrast : float
        Least number of points in a layer against the median of the layers within half a metre.
    share : float
        Least number of points in a layer against the fullest layer.

    Returns
    -------
    levels : (m,) float64
        Median height of the points of each layer that stands out, metres.
    counts : (m,) float64
        Number of its points.
    """
    from scipy import ndimage

    low, high = np.quantile(height, [0.002, 0.998])
    step = layer / 2
    first = np.floor(low / step) - 2
    index = np.floor(height / step).astype(np.int64) - int(first)
    inside = (index >= 0) & (index <= (high / step - first) + 2)
    counts = np.bincount(index[inside], minlength=5)
    window = np.convolve(counts, [1, 1], mode="full")[: len(counts)].astype(np.float64)
    usual = ndimage.median_filter(window, size=2 * round(0.5 / step) + 1, mode="constant")
    enough = np.maximum(contrast * usual, share * window.max())
    levels: list[float] = []
    sizes: list[float] = []
    padded = np.pad(window, 2)
    for i in np.flatnonzero(window >= enough):
        if window[i] == padded[i : i + 5].max() and not (levels and (first + i) * step - levels[-1] < 2 * layer):
            near = np.abs(height - (first + i) * step) <= layer
            levels.append(float(np.median(height[near])))
            sizes.append(float(window[i]))
    return np.array(levels), np.array(sizes)


def refit_plane(points: Points, plane: Plane, *, reach: float = 0.06, least_reach: float = 0.02) -> tuple[Plane, float]:
    """Robust refit of a plane to the points close to it.

    Parameters
    ----------
    points : (n, 3) float64
        Points, evenly thinned, metres.
    plane : Plane
        First guess.
    reach : float
        Distance of points from the first guess that take part in the first step, metres.
    least_reach : float
        Distance that is never undercut in the next steps, metres; above the spacing of clouds that were thinned to a grid.

    Returns
    -------
    plane : Plane
        Plane of the points within three standard deviations (from the median absolute deviation), repeatedly fitted.
    spread : float
        Standard deviation of these points, metres.
    """
    spread = reach / 3
    points = points.take(np.flatnonzero(np.abs(plane.height(points)) < 10 * reach), axis=0)
    for _ in range(6):
        height = plane.height(points)
        near = np.abs(height) < reach
        if near.sum() < 30:
            break
        spread = float(1.4826 * np.median(np.abs(height[near] - np.median(height[near]))))
        plane = fit_plane(points[near]).facing(plane.normal)
        reach = float(max(least_reach, min(3 * spread, 0.10)))
    return plane, spread


def main_body(points: Points, *, cell: float = 0.5, share: float = 0.02) -> Mask:
    """Points of the building without those far outside, seen through windows or made by reflections.

    Parameters
    ----------
    points : (n, 3) float64
        Points, evenly thinned, metres.
    cell : float
        Side of the square columns that are judged, metres.
    share : float
        Least number of points in a column as a share of the fullest columns (their 75th percentile by points).

    Returns
    -------
    (n,) bool
        Points of the largest connected group of columns that hold enough points.
    """
    from scipy import ndimage

    index = np.floor(points[:, :2] / cell).astype(np.int64)
    index -= index.min(axis=0) - 1
    shape = index.max(axis=0) + 2
    flat = index[:, 0] * shape[1] + index[:, 1]
    count = np.bincount(flat, minlength=int(shape.prod()))
    full = float(np.quantile(count[flat], 0.75))
    label, _ = ndimage.label((count >= max(share * full, 2)).reshape(shape), structure=np.ones((3, 3)))
    in_group = np.bincount(label.ravel(), weights=count)
    in_group[0] = 0
    largest: Mask = label.ravel()[flat] == int(in_group.argmax())
    return largest


def vertical_axis(points: Points) -> tuple[Points, Points, str | None]:
    """Mid point and normal of the plane that splits the scan into an upper and a lower half (section 2.1).

    The paper takes the third principal axis, whatever its direction. It is not vertical for clouds that are as high as
    wide; then the axis closest to +z is taken, or +z itself, with a word of warning. The normal always points to +z.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z roughly up.

    Returns
    -------
    mean : (3,) float64
        Point on the mid plane.
    normal : (3,) float64
        Its unit normal, towards +z.
    warning : str or None
        What was assumed.
    """
    mean, axes, _ = principal_axes(points)
    tilt = np.arccos(np.clip(np.abs(axes[:, 2]), 0, 1))
    nearest = int(np.argmin(tilt))
    if tilt[2] <= LARGEST_TILT:
        normal, warning = axes[2], None
    elif tilt[nearest] <= LARGEST_TILT:
        normal = axes[nearest]
        warning = (
            f"the cloud's third principal axis is {np.degrees(tilt[2]):.0f}° off the vertical; "
            f"took the principal axis that is {np.degrees(tilt[nearest]):.0f}° off"
        )
    else:
        normal = np.array([0.0, 0.0, 1.0])
        warning = (
            f"no principal axis of the cloud is nearer than {np.degrees(tilt[nearest]):.0f}° to the vertical; took the scan's own z axis"
        )
    return mean, normal * (1.0 if normal[2] >= 0 else -1.0), warning


def horizontal_plane(half: Points, *, normal: Points, grid_count: int) -> Plane | None:
    """Floor or ceiling of one half of the scan (section 2.1, algorithm 2, steps 3 to 11).

    The half is projected to its plane, points alone in their cell are kept, statistical outliers are removed, and the rest is fitted
    by principal components.

    Parameters
    ----------
    half : (n, 3) float64
        Upper or lower half of the scan, metres.
    normal : (3,) float64
        Normal of the mid plane.
    grid_count : int
        Cells along each side of the grid (n_fac).

    Returns
    -------
    Plane or None
        Plane with its normal on the side of `normal`; None if fewer than 30 points are left.
    """
    across = np.linalg.svd(normal[None, :])[2][1:]
    flat = half[alone_in_cell(half @ across.T, grid_count=grid_count)]
    if len(flat) < 30:
        return None
    flat = flat[statistical_inliers(flat, nb_neighbors=20, std_ratio=2.0)]
    return fit_plane(flat).facing(normal) if len(flat) >= 30 else None


def mean_normal(first: Plane, second: Plane) -> Points:
    """Return the unit normal (3,) of two planes that ought to be parallel, the mean of both (section 2.1, equation 6)."""
    total = first.normal + second.facing(first.normal).normal
    unit: Points = total / np.linalg.norm(total)
    return unit


@dataclass(frozen=True, slots=True, eq=False)
class FloorAndCeiling:
    """Floor and ceiling with a common upward normal.

    Parameters
    ----------
    normal : (3,) float64
        Upward unit normal.
    floor, ceiling : float or None
        Offsets of the planes along the normal, metres; None where not seen.
    floor_threshold, ceiling_threshold : float
        Distance from the plane within which points belong to it, metres.
    warnings : tuple of str
        What was not seen or is doubtful.
    """

    normal: Points
    floor: float | None
    ceiling: float | None
    floor_threshold: float
    ceiling_threshold: float
    warnings: tuple[str, ...]


def find_floor_and_ceiling(
    points: Points, *, grid_count: int | None = None, floor_threshold: float | None = None, ceiling_threshold: float | None = None
) -> FloorAndCeiling:
    """Floor and ceiling planes of a one-storey scan at any attitude (section 2.1, algorithm 2).

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres, z roughly up: of the two planes the lower one is the floor.
    grid_count : int, optional
        Cells along each side of the grid (n_fac), on all points as published; None: on evenly thinned points, from their extent.
    floor_threshold, ceiling_threshold : float, optional
        Distance from the plane within which points belong to it, metres; None: from the spread of the plane's points.

    Returns
    -------
    FloorAndCeiling
        Planes and thresholds.

    Raises
    ------
    NothingToReconstructError
        If neither floor nor ceiling can be found.
    """
    thin = thin_evenly(points, cell=THIN_CELL)
    thin = thin.take(np.flatnonzero(main_body(thin)), axis=0)
    cell = THIN_CELL * max(1.0, (len(thin) / ENOUGH_POINTS) ** 0.5)
    coarse = thin if cell == THIN_CELL else thin_evenly(thin, cell=cell)
    mean, up, warning = vertical_axis(coarse)
    warnings = [] if warning is None else [warning]
    if grid_count is None:
        source = coarse
        grid_count = int(np.clip(np.ptp(thin, axis=0).max() / cell, 10, 5000))
    else:
        low, high = thin.min(axis=0) - THIN_CELL, thin.max(axis=0) + THIN_CELL
        source = points[((points >= low) & (points <= high)).all(axis=1)]
        source = source[np.lexsort(source.T)]
    above = (source - mean) @ up >= 0
    guesses = [horizontal_plane(half, normal=up, grid_count=grid_count) for half in (source[~above], source[above]) if len(half) >= 30]
    planes = [plane for plane in guesses if plane is not None and np.arccos(plane.normal[2]) <= LARGEST_TILT]
    guess = mean_normal(planes[0], planes[-1]) if planes else up
    normal = sharpest_normal(thin, guess)
    levels = dict(zip(("floor", "ceiling"), _floor_and_ceiling_levels(Plane(normal, 0.0).height(thin)), strict=True))
    least = 0.02 if len(thin) < 0.8 * len(points) else max(0.02, 1.1 * point_spacing(thin, sample_size=ENOUGH_POINTS))
    reach = max(0.06, least)
    seen = {
        name: refit_plane(thin, Plane(normal, level), reach=reach, least_reach=least) for name, level in levels.items() if level is not None
    }
    if not seen:
        size = " x ".join(f"{x:.1f}" for x in np.ptp(thin, axis=0))
        raise NothingToReconstructError(
            f"found no floor and no ceiling in {len(points)} points of {size} m: no horizontal surface stands out from the rest; "
            "expected an indoor scan with z roughly up that shows at least one of them"
        )
    if len(seen) == 2 and (slant := _angle(seen["floor"][0].normal, seen["ceiling"][0].normal)) > LARGEST_SLANT:
        warnings.append(f"floor and ceiling are not parallel: {np.degrees(slant):.1f}° apart")
    pair = [plane for plane, _ in seen.values()]
    normal = mean_normal(pair[0], pair[-1])
    height = Plane(normal, 0.0).height(thin)
    offsets: dict[str, float | None] = {"floor": None, "ceiling": None}
    limits = {"floor": floor_threshold, "ceiling": ceiling_threshold}
    for name, (plane, spread) in seen.items():
        near = np.abs(plane.height(thin)) < max(least, min(3 * spread, 0.10))
        offsets[name] = float(height[near].mean()) if near.any() else levels[name]
        if limits[name] is None:
            limits[name] = float(max(0.03, 1.2 * least, min(5 * spread, 0.15)))
    warnings += [f"the {name} was not seen" for name in ("floor", "ceiling") if offsets[name] is None]
    return FloorAndCeiling(
        normal=normal,
        floor=offsets["floor"],
        ceiling=offsets["ceiling"],
        floor_threshold=limits["floor"] or 0.0,
        ceiling_threshold=limits["ceiling"] or 0.0,
        warnings=tuple(warnings),
    )


def _floor_and_ceiling_levels(height: Points) -> tuple[float | None, float | None]:
    """Heights of the lowest storey's floor and ceiling among the horizontal layers."""
    levels, counts = horizontal_layers(height)
    if not len(levels):
        return None, None
    for level in levels[counts >= 0.4 * counts.max()]:
        higher = levels >= level + SMALLEST_HEIGHT
        if higher.any():
            return float(level), float(levels[higher & (counts >= 0.7 * counts[higher].max())][0])
    level = float(levels[np.argmax(counts)])
    above, below = (height > level + 0.15).sum(), (height < level - 0.15).sum()
    return (level, None) if above >= below else (None, level)


def _angle(a: Points, b: Points) -> float:
    return float(np.arccos(np.clip(abs(float(a @ b)), 0, 1)))


def level_by_pca(
    cloud: Cloud, *, grid_count: int | None = None, floor_threshold: float | None = None, ceiling_threshold: float | None = None
) -> LevelledCloud:
    """Turn a one-storey scan upright and into its main direction, split into floor, ceiling and walls (section 2.1).

    Parameters
    ----------
    cloud : Cloud
        Scan at any attitude with z roughly up.
    grid_count : int, optional
        Cells along each side of the grid that finds floor and ceiling (n_fac); None: from the extent.
    floor_threshold, ceiling_threshold : float, optional
        Distance from the plane within which points belong to it, metres; None: from the spread of the plane's points.

    Returns
    -------
    LevelledCloud
        Floor at z = 0 (the lowest wall points, if the floor was not seen), x along the main direction; of the four
        equivalent quarter turns the one that turns the scan least.

    Raises
    ------
    NothingToReconstructError
        If neither floor nor ceiling can be found, or nothing but them.
    """
    if len(cloud) < 100:
        raise NothingToReconstructError(f"{cloud.source}: found {len(cloud)} points; expected a scan of a building with at least 100")
    planes = find_floor_and_ceiling(
        cloud.points, grid_count=grid_count, floor_threshold=floor_threshold, ceiling_threshold=ceiling_threshold
    )
    turn = rotation_to_z(planes.normal)
    height = Plane(planes.normal, 0.0).height(cloud.points)
    part = np.full(len(cloud), WALL)
    if planes.floor is not None:
        part[np.abs(height - planes.floor) < planes.floor_threshold] = FLOOR
    if planes.ceiling is not None:
        part[np.abs(height - planes.ceiling) < planes.ceiling_threshold] = CEILING
    low = planes.floor if planes.floor is not None else float(np.quantile(height, 0.005))
    high = planes.ceiling if planes.ceiling is not None else float(np.quantile(height, 0.995))
    between = (part == WALL) & (height > low) & (height < high)
    if between.sum() < 100:
        raise NothingToReconstructError(
            f"{cloud.source}: found only {int(between.sum())} points between floor and ceiling of {len(cloud)}; "
            "expected walls: scan them too"
        )
    upright = cloud.points.take(np.flatnonzero(between), axis=0) @ turn.T
    walls = thin_evenly(upright, cell=THIN_CELL)
    walls = walls.take(np.flatnonzero(main_body(walls)), axis=0)
    angle = main_direction(walls[:, :2])
    c, s = np.cos(angle), np.sin(angle)
    yaw = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rotation, shift = yaw @ turn, np.array([0.0, 0.0, -low])
    trajectory = None
    if cloud.trajectory is not None:
        trajectory = cloud.trajectory.copy()
        trajectory[:, 1:] = cloud.trajectory[:, 1:] @ rotation.T + shift
    points = cloud.points @ rotation.T
    points += shift
    return LevelledCloud(
        points=points,
        frame=cloud.frame.then(rotation, shift),
        part=part,
        storeys=(StoreyLevels(None if planes.floor is None else 0.0, None if planes.ceiling is None else planes.ceiling - low),),
        trajectory=trajectory,
        warnings=(*cloud.warnings, *planes.warnings),
    )


def rotation_to_z(normal: Points) -> Points:
    """Smallest rotation (3, 3) that takes the unit vector `normal` (3,) to +z.

    Examples
    --------
    >>> np.abs(rotation_to_z(np.array([0.6, 0.0, 0.8])) @ [0.6, 0.0, 0.8]).round(12).tolist()
    [0.0, 0.0, 1.0]
    """
    x, y, z = normal
    if z < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    turn: Points = np.eye(3) + cross + cross @ cross / (1 + z)
    return turn
