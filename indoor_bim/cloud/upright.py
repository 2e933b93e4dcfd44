"""The vertical of a scan, from its floors and ceilings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.heights import height_peaks, nearest_peak
from indoor_bim.cloud.motion import moved
from indoor_bim.cloud.plane_pieces import Patches, patches
from indoor_bim.errors import NothingToReconstructError

Floats = NDArray[np.float64]

_UP = np.array([0.0, 0.0, 1.0])
_CELL = 0.60
"""Side of the plane pieces, metres: long enough for the normals of noisy scans."""
_SMALL_CELL = 0.30
_FEW = 30
_DENIED = 3.0
"""So many standard deviations of the floors' heights tell the tilt of the floors from that of the ground outside."""
_ROOM_HEIGHT = 1.8
_GRIDS = 3
"""Boxes are laid along the vertical found so far; so often at most."""
_ALONG_GRID = 3e-3
"""Radians between boxes and vertical that do no harm: 9 cm over 30 m, so that borders of boxes still pass between the floors."""
_BORDER = 7
"""Steps on either side of a border of boxes in which few points are wanted."""
_CONVERGED = 1e-5  # radians: 0.2 mm over 20 m


def upright(points: Floats) -> Floats:
    """Rotation that makes floors and ceilings level.

    The direction that most plane pieces share within 45 degrees of the z axis gives the vertical to a few tenths of a
    degree; planes of one common normal through all floors and ceilings, fitted robustly, give it to a few hundredths. The pieces are
    then those of boxes along the vertical, and turn with it while it moves on by little. Ground seen
    outside counts as long as floors and ceilings do not deny that it is level.

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
    steep = _level_normals(points, steepest=45)
    if len(steep.normal) < 4:
        raise NothingToReconstructError(
            f"found {len(steep.normal)} level surface pieces of {_SMALL_CELL} m in {len(points)} thinned points, expected a floor or a "
            "ceiling: check the up axis and the unit of the scan"
        )
    vertical = _common_direction(steep.normal)
    for _ in range(_GRIDS):
        turn = _rotation_between(vertical, _UP)
        gentle = _level_normals(_between_boxes(moved(points, turn)), steepest=60)
        there = _converged(gentle, _UP, indoors=False)
        vertical = turn.T @ there
        if np.linalg.norm(there - _UP) < _ALONG_GRID:
            break
    within = _converged(gentle, there, indoors=True)
    found: Floats = turn.T @ within if _floors_deny(gentle, there, within) else vertical
    return _rotation_between(found, _UP)


def _between_boxes(points: Floats, *, step: float = 0.02) -> Floats:
    """Points lifted so that the borders of the plane pieces pass where the fewest of them are, away from floors and ceilings."""
    bins = round(_CELL / step)
    count = np.bincount(np.floor(points[::8, 2] / step).astype(np.int64) % bins, minlength=bins)
    around = np.sum([np.roll(count, k) for k in range(-_BORDER, _BORDER + 1)], axis=0)
    lifted: Floats = points - np.array([0.0, 0.0, (np.argmin(around) + 0.5) * step])
    return lifted


def _converged(gentle: Patches, vertical: Floats, *, indoors: bool) -> Floats:
    """Vertical of all level surfaces, or of those indoors, from a guess."""
    for _ in range(6):
        before, vertical = vertical, _fit_levels(gentle, vertical, indoors=indoors)
        if np.linalg.norm(vertical - before) < _CONVERGED:
            break
    return vertical


def _floors_deny(gentle: Patches, vertical: Floats, within: Floats) -> bool:
    """Whether floors and ceilings lie so flat across the vertical that they have indoors that they cannot belong to the other."""
    level = _levels(gentle, _rotation_between(within, _UP), indoors=True)
    peaks = np.array(height_peaks(level[:, 2], share=0.05))
    residual = level[:, 2] - peaks[nearest_peak(level[:, 2], peaks)]
    residual = residual[np.abs(residual) < 0.05]
    reach = float(np.hypot(*np.std(level[:, :2], axis=0)))
    return float(np.linalg.norm(vertical - within)) * reach > _DENIED * float(np.std(residual))


def _level_normals(points: Floats, *, steepest: float) -> Patches:
    """Plane pieces at most `steepest` degrees from level, normals up; small ones where a small scan has few."""
    for cell in (_CELL, _SMALL_CELL):
        flat = patches(points, cell=cell)
        normal = flat.normal * np.where(flat.normal[:, 2:] < 0, -1.0, 1.0)
        level = normal[:, 2] > np.cos(np.radians(steepest))
        if level.sum() >= _FEW:
            break
    return Patches(flat.centre[level], normal[level], flat.spread[level])


def _over_or_under(level: Floats, others: Floats) -> NDArray[np.bool_]:
    """Whether each piece (n, 3) has another at least a room's height above or below it: floors and ceilings, not the ground outside."""
    cells = np.floor(np.vstack([level, others])[:, :2] / _CELL).astype(np.int64)
    cells -= cells.min(axis=0)
    column = cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]
    _, column = np.unique(column, return_inverse=True)
    lowest, highest = np.full(column.max() + 1, np.inf), np.full(column.max() + 1, -np.inf)
    np.minimum.at(lowest, column[len(level) :], others[:, 2])
    np.maximum.at(highest, column[len(level) :], others[:, 2])
    mine, height = column[: len(level)], level[:, 2]
    paired: NDArray[np.bool_] = np.maximum(highest[mine] - height, height - lowest[mine]) >= _ROOM_HEIGHT
    return paired


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


def _levels(gentle: Patches, turn: Floats, *, indoors: bool) -> Floats:
    """Centres (n, 3) of the level ones of plane pieces once they are turned; those indoors where there are enough."""
    centre = moved(gentle.centre, turn)
    level: Floats = centre[np.abs(gentle.normal @ turn[2]) > np.cos(np.radians(6))]
    if indoors:
        paired = _over_or_under(level, centre)
        if paired.sum() >= max(_FEW, 0.1 * len(level)):
            level = level[paired]
    return level


def _fit_levels(gentle: Patches, vertical: Floats, *, indoors: bool) -> Floats:
    """One Gauss-Newton step of planes with a common normal through all level surfaces, Tukey weights."""
    turn = _rotation_between(vertical, _UP)
    level = _levels(gentle, turn, indoors=indoors)
    if len(level) < 4:
        return vertical
    slope: Floats = np.zeros(2)
    for width in (0.25, 0.15, 0.10, 0.06, 0.05, 0.05):
        height = level[:, 2] - level[:, :2] @ slope
        peaks = np.array(height_peaks(height, share=0.05))
        nearest = nearest_peak(height, peaks)
        residual = height - peaks[nearest]
        near = np.abs(residual) < width
        weight = np.where(near, (1 - (residual / width) ** 2) ** 2, 0.0)
        total = np.maximum(np.bincount(nearest, weights=weight, minlength=len(peaks)), 1e-12)
        mean = np.column_stack([np.bincount(nearest, weights=weight * level[:, k], minlength=len(peaks)) / total for k in range(3)])
        centred = level - mean[nearest]
        a = (weight[:, None] * centred[:, :2]).T @ centred[:, :2]
        if np.linalg.eigvalsh(a)[0] < 1e-6:
            return vertical
        slope = np.asarray(np.linalg.solve(a, (weight[:, None] * centred[:, :2]).T @ centred[:, 2]), dtype=np.float64)
    up = np.array([-slope[0], -slope[1], 1.0])
    back: Floats = turn.T @ (up / np.linalg.norm(up))
    return back


def _rotation_between(a: Floats, b: Floats) -> Floats:
    """Smallest rotation that takes unit vector `a` to unit vector `b`."""
    axis = np.cross(a, b)
    cosine = float(a @ b)
    k = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    rotation: Floats = np.eye(3) + k + k @ k / (1.0 + cosine)
    return rotation
