"""Floor and ceiling of a one-storey scan at any attitude.

Source: Remote Sensing 2021, 13, 4930, section 2.1 (algorithm 2). Added to what the paper leaves to the operator: far stray points are
left out, the planes are refitted robustly, and thresholds come from their residuals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.horizontal_planes import LARGEST_TILT, horizontal_layers, horizontal_plane, sharpest_normal, vertical_axis
from indoor_bim.cloud.plane import Plane, mean_normal, refit_plane
from indoor_bim.cloud.spacing import point_spacing
from indoor_bim.cloud.thinning import thin_evenly
from indoor_bim.errors import NothingToReconstructError

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]

LARGEST_SLANT = np.deg2rad(3)
"""Angle beyond which floor and ceiling are not parallel."""
SMALLEST_HEIGHT = 1.5
"""Storeys lower than this (metres) are not believed."""
FAINT_SHARE = 0.1
"""Points of a floor or ceiling that was hardly seen, against the other one, which was."""
THIN_CELL = 0.05
"""Side of the boxes that points are thinned to, metres."""
ENOUGH_POINTS = 60_000
"""So many points make a first guess as good as all do; what they guess is refined on all."""


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
    faint, counts = horizontal_layers(height, share=FAINT_SHARE)
    opposite = np.abs(faint - level) >= SMALLEST_HEIGHT
    if opposite.any():
        other = float(faint[opposite][np.argmax(counts[opposite])])
        return min(level, other), max(level, other)
    above, below = (height > level + 0.15).sum(), (height < level - 0.15).sum()
    return (level, None) if above >= below else (None, level)


def _angle(a: Points, b: Points) -> float:
    return float(np.arccos(np.clip(abs(float(a @ b)), 0, 1)))


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
