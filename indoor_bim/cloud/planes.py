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
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.directions import main_direction

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]

MICROMETRE = 1e-6
LARGEST_TILT = np.deg2rad(35)
"""Tilt beyond which the axis that the principal components offer as vertical is not believed."""
LARGEST_SLANT = np.deg2rad(3)
"""Angle beyond which floor and ceiling are not parallel."""
SMALLEST_HEIGHT = 1.5
"""Storeys lower than this (metres) are not believed."""


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
        return self.normal[0] * x + self.normal[1] * y + self.normal[2] * z - self.offset

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
    return np.bincount(cell, minlength=1)[cell] == 1


def refit_plane(points: Points, plane: Plane, *, reach: float = 0.25) -> tuple[Plane, float]:
    """Robust refit of a plane to the points close to it.

    The paper fits once; scans with furniture and drift need the fit repeated on what lies within three standard deviations,
    estimated by the median absolute deviation.

    Parameters
    ----------
    points : (n, 3) float64
        Points, evenly thinned, metres.
    plane : Plane
        First guess.
    reach : float
        Distance of points from the first guess that take part in the first step, metres.

    Returns
    -------
    plane : Plane
        Refitted plane.
    spread : float
        Standard deviation of its points, metres; NaN if fewer than ten points are near.
    """
    spread = np.nan
    for step in range(12):
        height = plane.height(points)
        near = np.abs(height) < reach
        if near.sum() < 10:
            return plane, np.nan
        middle = float(np.median(height[near]))
        spread = float(1.4826 * np.median(np.abs(height[near] - middle)))
        reach = max(3 * spread, 0.005) if step else max(3 * spread, 0.05)
        close = np.abs(height - middle) < reach
        if close.sum() < 10:
            return plane, np.nan
        plane = fit_plane(points[close]).facing(plane.normal)
    return plane, spread


def thin_evenly(points: Points, *, cell: float) -> Points:
    """Mean of the points in every occupied cube, sorted by cube; the same for every order of the points.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.
    cell : float
        Side of the cubes, metres.

    Returns
    -------
    (m, 3) float64
        One point per occupied cube, exact to a micrometre.

    Examples
    --------
    >>> thin_evenly(np.array([[0.1, 0.1, 0.1], [0.3, 0.3, 0.1], [2.5, 0.5, 0.5]]), cell=1.0).tolist()
    [[0.2, 0.2, 0.1], [2.5, 0.5, 0.5]]
    """
    whole = np.rint(points / MICROMETRE)
    index = np.floor(whole / round(cell / MICROMETRE)).astype(np.int64)
    index -= index.min(axis=0)
    size = index.max(axis=0) + 1
    key = (index[:, 0] * size[1] + index[:, 1]) * size[2] + index[:, 2]
    _, member, count = np.unique(key, return_inverse=True, return_counts=True)
    # sums of whole numbers below 2**53 are exact, whatever their order
    sums = np.column_stack([np.bincount(member, weights=axis) for axis in whole.T])
    return np.rint(sums / count[:, None]) * MICROMETRE


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
    return label.ravel()[flat] == int(in_group.argmax())


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
        warning = f"the cloud's third principal axis is {np.degrees(tilt[2]):.0f}° off the vertical; took the principal axis that is {np.degrees(tilt[nearest]):.0f}° off"
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
    flat = flat[_not_outlying(flat)]
    return fit_plane(flat).facing(normal) if len(flat) >= 30 else None


def _not_outlying(points: Points, *, neighbours: int = 20, ratio: float = 2.0) -> Mask:
    from scipy.spatial import cKDTree

    k = min(neighbours + 1, len(points))
    distance = cKDTree(points).query(points, k=k)[0][:, 1:].mean(axis=1)
    return distance <= distance.mean() + ratio * distance.std()


def mean_normal(first: Plane, second: Plane) -> Points:
    """Unit normal (3,) of two planes that ought to be parallel: the mean of their normals (section 2.1, equation 6)."""
    total = first.normal + second.facing(first.normal).normal
    return total / np.linalg.norm(total)


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
    cell = 0.05
    thin = thin_evenly(points, cell=cell)
    thin = thin[main_body(thin)]
    mean, up, warning = vertical_axis(thin)
    warnings = [] if warning is None else [warning]
    if grid_count is None:
        source = thin
        grid_count = int(np.clip(np.ptp(thin, axis=0).max() / cell, 10, 5000))
    else:
        low, high = thin.min(axis=0) - cell, thin.max(axis=0) + cell
        source = points[((points >= low) & (points <= high)).all(axis=1)]
        source = source[np.lexsort(source.T)]
    above = (source - mean) @ up >= 0
    found: dict[str, tuple[Plane, float]] = {}
    thin_above = (thin - mean) @ up >= 0
    for name, half, thin_half in (("floor", source[~above], thin[~thin_above]), ("ceiling", source[above], thin[thin_above])):
        plane = horizontal_plane(half, normal=up, grid_count=grid_count) if len(half) else None
        if plane is None:
            continue
        plane, spread = refit_plane(thin_half, plane)
        if np.isfinite(spread) and _stands_out(thin, plane, spread):
            found[name] = plane, spread
    if len(found) == 2 and not _are_parallel(found["floor"][0], found["ceiling"][0]):
        weaker = min(found, key=lambda name: _count_near(thin, *found[name]))
        slant = np.degrees(_angle(found["floor"][0].normal, found["ceiling"][0].normal))
        warnings.append(f"floor and ceiling are not parallel ({slant:.1f}° apart); the {weaker} is not used")
        del found[weaker]
    if not found:
        size = " x ".join(f"{x:.1f}" for x in np.ptp(thin, axis=0))
        raise NothingToReconstructError(
            f"found no floor and no ceiling in {len(points)} points of {size} m: no horizontal surface stands out from the rest; "
            "expected an indoor scan with z roughly up that shows at least one of them"
        )
    normal = mean_normal(found["floor"][0], found["ceiling"][0]) if len(found) == 2 else next(iter(found.values()))[0].normal
    offsets: dict[str, float | None] = {"floor": None, "ceiling": None}
    limits = {"floor": floor_threshold, "ceiling": ceiling_threshold}
    heights = Plane(normal, 0.0).height(thin)
    for name, (plane, spread) in found.items():
        near = np.abs(plane.height(thin)) < max(3 * spread, 0.005)
        offsets[name] = float(np.median(heights[near]))
        if limits[name] is None:
            limits[name] = float(np.clip(5 * spread, 0.03, 0.15))
    for name in ("floor", "ceiling"):
        if offsets[name] is None:
            warnings.append(f"the {name} was not seen")
    return FloorAndCeiling(
        normal=normal,
        floor=offsets["floor"],
        ceiling=offsets["ceiling"],
        floor_threshold=limits["floor"] or 0.0,
        ceiling_threshold=limits["ceiling"] or 0.0,
        warnings=tuple(warnings),
    )


def _angle(a: Points, b: Points) -> float:
    return float(np.arccos(np.clip(abs(float(a @ b)), 0, 1)))


def _are_parallel(floor: Plane, ceiling: Plane) -> bool:
    return _angle(floor.normal, ceiling.normal) <= LARGEST_SLANT


def _count_near(points: Points, plane: Plane, spread: float) -> int:
    return int((np.abs(plane.height(points)) < max(3 * spread, 0.02)).sum())


def _stands_out(points: Points, plane: Plane, spread: float, *, factor: float = 2.5) -> bool:
    """Whether a plane holds clearly more points than parallel layers of the same thickness usually do."""
    if np.arccos(np.clip(plane.normal[2], -1, 1)) > LARGEST_TILT:
        return False
    layer = 2 * max(3 * spread, 0.02)
    height = plane.height(points)
    low, high = np.quantile(height, [0.01, 0.99])
    counts = np.bincount(np.floor((height[(height >= low) & (height <= high)] - low) / layer).astype(np.int64))
    usual = float(np.median(counts)) if len(counts) else 0.0
    return float((np.abs(height) < layer / 2).sum()) >= factor * max(usual, 1.0)


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
            f"{cloud.source}: found only {int(between.sum())} points between floor and ceiling of {len(cloud)}; expected walls: scan them too"
        )
    upright = cloud.points[between] @ turn.T
    walls = thin_evenly(upright, cell=0.05)
    angle = main_direction(walls[main_body(walls), :2])
    c, s = np.cos(angle), np.sin(angle)
    yaw = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rotation, shift = yaw @ turn, np.array([0.0, 0.0, -low])
    trajectory = None
    if cloud.trajectory is not None:
        trajectory = cloud.trajectory.copy()
        trajectory[:, 1:] = cloud.trajectory[:, 1:] @ rotation.T + shift
    return LevelledCloud(
        points=cloud.points @ rotation.T + shift,
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
    >>> (rotation_to_z(np.array([0.6, 0.0, 0.8])) @ [0.6, 0.0, 0.8]).round(12).tolist()
    [0.0, 0.0, 1.0]
    """
    x, y, z = normal
    if z < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1 + z)
