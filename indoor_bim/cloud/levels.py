"""Turn a scan upright and into the building's main direction, and find its storeys.

Everything rests on area, not on point counts: the cloud is thinned to one mean per small voxel first, and
surfaces are cells of a coarse grid whose points lie in a plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud, LevelledCloud, StoreyLevels
from indoor_bim.errors import NothingToReconstructError

Floats = NDArray[np.float64]

_VOXEL = 0.05
_CELL = 0.30
_MIN_CELL_POINTS = 8
_MIN_CLEAR_HEIGHT = 1.8
_LEVEL_TOLERANCE = 0.06
_MIN_STOREY_AREA = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Small plane pieces of a scan, one per cubic cell whose points lie in a plane.

    Parameters
    ----------
    centre : (m, 3) float64
        Mean point, metres.
    normal : (m, 3) float64
        Unit normal, sign arbitrary.
    spread : (m,) float64
        Standard deviation of the points across the plane, metres.
    """

    centre: Floats
    normal: Floats
    spread: Floats


def thin(points: Floats, *, voxel: float = _VOXEL) -> Floats:
    """Mean point of every occupied voxel, so that each bit of surface counts alike.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.
    voxel : float
        Side of a voxel, metres.

    Returns
    -------
    (m, 3) float64
        Means, ordered by voxel.

    Examples
    --------
    >>> thin(np.array([[0.01, 0, 0], [0.03, 0, 0], [1.0, 1, 1]]), voxel=0.05).round(2).tolist()
    [[0.02, 0.0, 0.0], [1.0, 1.0, 1.0]]
    """
    _, group, count = _group(points, voxel)
    return np.column_stack([np.bincount(group, weights=points[:, k]) / count for k in range(3)])


def patches(points: Floats, *, cell: float = _CELL, flatness: float = 0.2) -> Patches:
    """Plane pieces of a thinned cloud.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned points, metres.
    cell : float
        Side of a cell, metres.
    flatness : float
        Largest ratio between the standard deviations across the plane and along its shorter axis.
    """
    _, group, count = _group(points, cell)
    total = np.column_stack([np.bincount(group, weights=points[:, k]) for k in range(3)])
    centre = total / count[:, None]
    offset = points - centre[group]
    moments = np.zeros((len(count), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            moments[:, i, j] = moments[:, j, i] = np.bincount(group, weights=offset[:, i] * offset[:, j]) / count
    values, vectors = np.linalg.eigh(moments)
    deviation = np.sqrt(np.maximum(values, 0))
    keep = (count >= _MIN_CELL_POINTS) & (deviation[:, 0] <= flatness * deviation[:, 1])
    return Patches(centre[keep], vectors[keep, :, 0], deviation[keep, 0])


def upright(points: Floats) -> Floats:
    """Rotation that makes floors and ceilings level.

    The direction that most plane pieces share within 45 degrees of the z axis gives the vertical to a few tenths of a
    degree; planes of one common normal through all floors and ceilings, fitted robustly, give it to a few hundredths.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned points, metres, z roughly up.

    Returns
    -------
    (3, 3) float64
        Proper rotation; the smallest one.

    Raises
    ------
    NothingToReconstructError
        If no level surface is found.
    """
    flat = patches(points)
    up = flat.normal * np.where(flat.normal[:, 2:] < 0, -1.0, 1.0)
    steep = up[:, 2] > np.cos(np.radians(45))
    if steep.sum() < 4:
        raise NothingToReconstructError(
            f"found {int(steep.sum())} level surface pieces of {_CELL} m in {len(points)} thinned points, expected a floor or a ceiling: "
            "check the up axis and the unit of the scan"
        )
    vertical = _common_direction(up[steep])
    for _ in range(6):
        vertical = _fit_levels(points, vertical)
    return _rotation_between(vertical, np.array([0.0, 0.0, 1.0]))


def main_direction(points: Floats) -> float:
    """Angle of the building's main direction in plan, radians in (-pi/4, pi/4].

    Parameters
    ----------
    points : (n, 3) float64
        Thinned upright points, metres.

    Returns
    -------
    float
        Angle from the x axis to the nearer of the two main directions.
    """
    column = np.floor(points[:, :2] / _VOXEL).astype(np.int64)
    column -= column.min(axis=0)
    _, group, filled = np.unique(column[:, 0] * (column[:, 1].max() + 1) + column[:, 1], return_inverse=True, return_counts=True)
    xy = np.column_stack([np.bincount(group, weights=points[:, k]) / filled for k in range(2)])
    weight = np.minimum(filled, 40).astype(np.float64) ** 2
    wall = weight >= np.quantile(weight, 0.7)
    xy, weight = xy[wall], weight[wall]
    best = 0.0
    for reach, step, width in ((45.0, 1.0, 0.10), (1.5, 0.25, 0.05), (0.3, 0.05, 0.03), (0.06, 0.01, 0.03)):
        angles = best + np.radians(np.arange(-reach, reach + step / 2, step))
        best = float(angles[int(np.argmax([_sharpness(xy, weight, a, width) for a in angles]))])
    for width in (0.06, 0.05, 0.04, 0.04):
        best += _common_turn(xy, weight, best, width)
    return float(np.pi / 4 - np.mod(np.pi / 4 - best, np.pi / 2))


def storey_levels(points: Floats) -> tuple[StoreyLevels, ...]:
    """Floors and ceilings of the storeys, from the bottom up.

    In every column of the plan the level surfaces that stand at least a room's height apart, with nothing level
    between them, are the bottom and top of a space. The bottoms that cover most area are floors; spaces that overlap in
    height for the most part belong to one storey. A ceiling is the top that most of the storey's area shares; where tops
    share no height (a pitched roof) there is none.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned upright points, metres.

    Returns
    -------
    tuple of StoreyLevels
        Empty where no level surface was found.
    """
    flat = patches(points)
    overhead = flat.centre[np.abs(flat.normal[:, 2]) > np.cos(np.radians(60))]
    level = _level_pieces(points)
    if not len(level):
        return ()
    bottoms, tops = _clear_spaces(overhead, level)
    if not len(bottoms):
        return _open_level(points, level[:, 2])
    storeys: list[StoreyLevels] = []
    groups: list[list[float]] = []
    for floor in _height_peaks(bottoms, share=0.08):
        mine = np.abs(bottoms - floor) < _LEVEL_TOLERANCE
        is_ceiling = (np.abs(tops - floor) < _LEVEL_TOLERANCE).sum() > mine.sum()
        if is_ceiling or mine.sum() * _CELL**2 < _MIN_STOREY_AREA:
            continue
        top = float(np.median(tops[mine]))
        for group in groups:
            overlap = min(top, group[1]) - max(floor, group[0])
            if overlap > 0.5 * min(top - floor, group[1] - group[0]):
                break
        else:
            groups.append([floor, top])
    for floor, _ in sorted(groups):
        mine = np.abs(bottoms - floor) < _LEVEL_TOLERANCE
        ceilings = [z for z in _height_peaks(tops[mine], share=1.0) if (np.abs(tops[mine] - z) < _LEVEL_TOLERANCE).mean() > 0.3]
        storeys.append(StoreyLevels(_level_at(points[:, 2], floor), _level_at(points[:, 2], ceilings[0]) if ceilings else None))
    return tuple(storeys) if storeys else _open_level(points, level[:, 2])


def level(cloud: Cloud) -> LevelledCloud:
    """Turn a cloud upright and into its main direction, and find its storeys.

    Parameters
    ----------
    cloud : Cloud
        Scan with z roughly up.

    Returns
    -------
    LevelledCloud
        Lowest floor at z = 0.

    Raises
    ------
    NothingToReconstructError
        If the scan has no level surface.
    """
    sample = thin(cloud.points)
    turn = upright(sample)
    sample = sample @ turn.T
    yaw = main_direction(sample)
    cos, sin = np.cos(-yaw), np.sin(-yaw)
    about_z = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    storeys = storey_levels(sample)
    warnings = list(cloud.warnings)
    if not storeys:
        raise NothingToReconstructError("found neither floor nor ceiling: no level surface covers enough of the plan")
    known = [z for s in storeys for z in (s.floor, s.ceiling) if z is not None]
    base = next((s.floor for s in storeys if s.floor is not None), min(known))
    rotation = about_z @ turn
    shift = np.array([0.0, 0.0, -base])
    points = cloud.points @ rotation.T + shift
    storeys = tuple(StoreyLevels(_minus(s.floor, base), _minus(s.ceiling, base)) for s in storeys)
    for number, s in enumerate(storeys, 1):
        if s.floor is None:
            warnings.append(f"storey {number}: the floor was not seen")
        if s.ceiling is None:
            warnings.append(f"storey {number}: no level ceiling was seen")
    trajectory = cloud.trajectory
    if trajectory is not None:
        trajectory = np.column_stack([trajectory[:, 0], trajectory[:, 1:4] @ rotation.T + shift])
    return LevelledCloud(
        points=points,
        frame=cloud.frame.then(rotation, shift),
        part=_parts(points[:, 2], storeys),
        storeys=storeys,
        trajectory=trajectory,
        warnings=tuple(warnings),
    )


def _minus(height: float | None, base: float) -> float | None:
    return None if height is None else height - base


def _group(points: Floats, side: float) -> tuple[Floats, NDArray[np.int64], Floats]:
    cells = np.floor(points / side).astype(np.int64)
    cells -= cells.min(axis=0)
    spans = cells.max(axis=0) + 1
    keys = (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
    unique, group, count = np.unique(keys, return_inverse=True, return_counts=True)
    return unique, group, count.astype(np.float64)


def _level_pieces(points: Floats, *, thickness: float = 0.10) -> Floats:
    """Centres (m, 3) of flat cells that are filled along both axes of the plan: level surfaces, not walls."""
    _, group, count = _group(points / np.array([_CELL, _CELL, thickness]), 1.0)
    centre = np.column_stack([np.bincount(group, weights=points[:, k]) / count for k in range(3)])
    x, y, z = (points - centre[group]).T
    xx, yy, xy, zz = (np.bincount(group, weights=w) / count for w in (x * x, y * y, x * y, z * z))
    minor = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)
    evenly_filled = _CELL**2 / 12
    return centre[(count >= _MIN_CELL_POINTS) & (minor > 0.25 * evenly_filled) & (zz < 0.25 * minor)]


def _sharpness(xy: Floats, weight: Floats, angle: float, width: float) -> float:
    """How well points line up along a direction and across it."""
    total = 0.0
    for direction in ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))):
        offset = (xy @ np.array(direction)) / width
        base = np.floor(offset).astype(np.int64)
        fraction = offset - base
        base -= base.min()
        histogram = np.bincount(base, weights=weight * (1 - fraction), minlength=int(base.max()) + 2)
        histogram += np.bincount(base + 1, weights=weight * fraction, minlength=int(base.max()) + 2)
        total += float((histogram**2).sum())
    return total


def _common_turn(xy: Floats, weight: Floats, angle: float, width: float) -> float:
    """Least-squares turn of the wall lines along and across a direction, Tukey weights."""
    along = xy @ np.array([np.cos(angle), np.sin(angle)])
    across = xy @ np.array([-np.sin(angle), np.cos(angle)])
    numerator = denominator = 0.0
    for u, v in ((along, across), (-across, along)):
        peaks = np.array(_height_peaks(v, share=0.15))
        nearest = np.argmin(np.abs(v[:, None] - peaks[None]), axis=1)
        residual = v - peaks[nearest]
        w = weight * np.maximum(1 - (residual / width) ** 2, 0) ** 2
        total = np.maximum(np.bincount(nearest, weights=w, minlength=len(peaks)), 1e-12)
        du = u - (np.bincount(nearest, weights=w * u, minlength=len(peaks)) / total)[nearest]
        dv = v - (np.bincount(nearest, weights=w * v, minlength=len(peaks)) / total)[nearest]
        numerator += float((w * du * dv).sum())
        denominator += float((w * du * du).sum())
    return float(np.arctan2(numerator, denominator)) if denominator > 0 else 0.0


def _common_direction(up: Floats) -> Floats:
    """Mode of unit vectors in the upper half space."""
    plane = up[:, :2] / up[:, 2:]
    start, bins = -1.0, 100
    cell = np.clip(((plane - start) / (2 / bins)).astype(np.int64), 0, bins - 1)
    votes = np.bincount(cell[:, 0] * bins + cell[:, 1], minlength=bins * bins).reshape(bins, bins).astype(float)
    padded = np.pad(votes, 2)
    smooth = np.sum([padded[i : i + bins, j : j + bins] for i in range(5) for j in range(5)], axis=0)
    row, column = np.unravel_index(int(np.argmax(smooth)), smooth.shape)
    mode = start + (np.array([row, column]) + 0.5) * 2 / bins
    for width in (0.10, 0.06, 0.04, 0.03):
        distance = np.hypot(*(plane - mode).T)
        weight = np.maximum(1 - (distance / width) ** 2, 0) ** 2
        mode = (weight[:, None] * plane).sum(axis=0) / max(weight.sum(), 1e-12)
    vertical = np.array([mode[0], mode[1], 1.0])
    unit: Floats = vertical / np.linalg.norm(vertical)
    return unit


def _fit_levels(points: Floats, vertical: Floats) -> Floats:
    """One Gauss-Newton step of planes with a common normal through all level surfaces, Tukey weights."""
    turned = points @ _rotation_between(vertical, np.array([0.0, 0.0, 1.0])).T
    flat = patches(turned)
    level = flat.centre[np.abs(flat.normal[:, 2]) > np.cos(np.radians(6))]
    if len(level) < 4:
        return vertical
    slope = np.zeros(2)
    for width in (0.25, 0.15, 0.10, 0.06, 0.05, 0.05):
        height = level[:, 2] - level[:, :2] @ slope
        peaks = np.array(_height_peaks(height, share=0.05))
        nearest = np.argmin(np.abs(height[:, None] - peaks[None]), axis=1)
        residual = height - peaks[nearest]
        near = np.abs(residual) < width
        weight = np.where(near, (1 - (residual / width) ** 2) ** 2, 0.0)
        mean = np.zeros((len(peaks), 3))
        total = np.maximum(np.bincount(nearest, weights=weight, minlength=len(peaks)), 1e-12)
        for k in range(3):
            mean[:, k] = np.bincount(nearest, weights=weight * level[:, k], minlength=len(peaks)) / total
        centred = level - mean[nearest]
        a = (weight[:, None] * centred[:, :2]).T @ centred[:, :2]
        if np.linalg.eigvalsh(a)[0] < 1e-6:
            return vertical
        slope = np.linalg.solve(a, (weight[:, None] * centred[:, :2]).T @ centred[:, 2])
    up = np.array([-slope[0], -slope[1], 1.0])
    back: Floats = _rotation_between(vertical, np.array([0.0, 0.0, 1.0])).T @ (up / np.linalg.norm(up))
    return back


def _height_peaks(height: Floats, *, share: float, step: float = 0.01) -> list[float]:
    """Heights that many surface pieces share, most first; `share` of the largest is the least."""
    if not len(height):
        return []
    low = float(height.min()) - 1.0
    histogram = np.bincount(((height - low) / step).astype(np.int64)).astype(float)
    histogram = np.pad(histogram, (0, 100))
    half = round(_LEVEL_TOLERANCE / step)
    kernel = np.maximum(1 - (np.arange(-half, half + 1) / (half + 1)) ** 2, 0)
    smooth = np.convolve(histogram, kernel, mode="same")
    peaks: list[float] = []
    least = share * smooth.max()
    while smooth.max() >= max(least, 1.0):
        top = int(np.argmax(smooth))
        near = np.abs(height - (low + (top + 0.5) * step)) < _LEVEL_TOLERANCE
        peaks.append(float(np.median(height[near])) if near.any() else low + (top + 0.5) * step)
        smooth[max(top - 2 * half, 0) : top + 2 * half + 1] = 0
    return peaks


def _level_at(height: Floats, guess: float) -> float:
    """Robust mean of the surface heights around a guess."""
    value = guess
    for _ in range(4):
        residual = height - value
        weight = np.maximum(1 - (residual / _LEVEL_TOLERANCE) ** 2, 0) ** 2
        value += float((weight * residual).sum() / max(weight.sum(), 1e-12))
    return value


def _clear_spaces(overhead: Floats, level: Floats) -> tuple[Floats, Floats]:
    """Bottom and top (k,) of the spaces between a level surface and the next surface at least a room's height above."""
    everything = np.vstack([overhead, level])
    is_level = np.arange(len(everything)) >= len(overhead)
    cells = np.floor(everything[:, :2] / _CELL).astype(np.int64)
    cells -= cells.min(axis=0)
    column = cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]
    order = np.lexsort((everything[:, 2], column))
    column, z, is_level = column[order], everything[order, 2], is_level[order]
    # duplicates (a level piece stands in both lists) have no gap between them and drop out by themselves
    gap = (column[1:] == column[:-1]) & (z[1:] - z[:-1] >= _MIN_CLEAR_HEIGHT)
    below = np.flatnonzero(gap)
    lower_is_level = is_level[below] | ((below > 0) & is_level[np.maximum(below - 1, 0)] & (z[below] - z[np.maximum(below - 1, 0)] < 1e-9))
    below = below[lower_is_level]
    return z[below], z[below + 1]


def _open_level(points: Floats, height: Floats) -> tuple[StoreyLevels, ...]:
    """One storey of which only the floor or only the ceiling was seen."""
    peak = _level_at(height, _height_peaks(height, share=0.5)[0])
    above = int((points[:, 2] > peak + 0.3).sum())
    below = int((points[:, 2] < peak - 0.3).sum())
    return (StoreyLevels(peak, None),) if above >= below else (StoreyLevels(None, peak),)


def _parts(z: Floats, storeys: tuple[StoreyLevels, ...]) -> NDArray[np.uint8]:
    part = np.full(len(z), WALL, dtype=np.uint8)
    for storey in storeys:
        if storey.floor is not None:
            part[np.abs(z - storey.floor) < _LEVEL_TOLERANCE] = FLOOR
        if storey.ceiling is not None:
            part[np.abs(z - storey.ceiling) < _LEVEL_TOLERANCE] = CEILING
    return part


def _rotation_between(a: Floats, b: Floats) -> Floats:
    """Smallest rotation that takes unit vector `a` to unit vector `b`."""
    axis = np.cross(a, b)
    cosine = float(a @ b)
    k = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    rotation: Floats = np.eye(3) + k + k @ k / (1.0 + cosine)
    return rotation
