"""Where a scan lies in a model: by what the model says, or by laying the plan of the scan over that of the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.errors import NothingToReconstructError
from indoor_bim.quality.nearest_face import FaceIndex, index_faces
from indoor_bim.quality.unique_rows import unique_rows
from indoor_bim.quality.wall_bodies import Faces, face_cells

Floats = NDArray[np.float64]

_PIXEL = 0.10
_BAND = (0.30, 2.20)  # metres above the floor: what plans are compared by
_BIN = 0.20
_FULL = 0.6  # share of the band that a wall fills
_SAMPLE = 15_000
_NEAR = 0.05
_FINE, _REACH = 0.02, 0.20  # metres: pixels and reach of the search that follows the coarse one
_ITERATIONS, _SPREAD, _STILL = 30, 0.02, 5e-5  # of the refinement; metres
_CANDIDATES = 3
_ALIKE = 0.9  # a second place that fits this well by comparison makes the first one doubtful


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """Where a scan lies in a model.

    Parameters
    ----------
    matrix : (4, 4) float64
        Takes the points to model coordinates.
    fit : float
        Share of the upright surface of the scan within 5 cm of a wall face.
    message : str
        How it was found, in a sentence.
    """

    matrix: Floats
    fit: float
    message: str


@dataclass(frozen=True, slots=True, eq=False)
class UprightScan:
    """Scan turned upright with the levels of its storeys.

    Parameters
    ----------
    points : (n, 3) float64
        Points, z up, metres.
    floors : tuple of float
        Floor levels from the bottom up, metres.
    yaw : float
        Main direction of its walls, radians.
    """

    points: Floats
    floors: tuple[float, ...]
    yaw: float = 0.0


def given_placement(points: Floats, matrix: Floats, faces: Faces) -> Placement:
    """Place points (n, 3) by a matrix (4, 4) that is known, and tell how well that fits the faces."""
    moved = points @ matrix[:3, :3].T + matrix[:3, 3]
    return Placement(matrix, _fit(moved, index_faces(faces)), "placed by the matrix of the model")


def find_placement(scan: UprightScan, faces: Faces, floors: tuple[float, ...]) -> Placement:
    """Turn and shift a scan so that its walls lie on those of a model.

    Parameters
    ----------
    scan : UprightScan
        The scan.
    faces : Faces
        Faces of the model's walls.
    floors : tuple of float
        Floor levels of the model, metres.

    Returns
    -------
    Placement
        The matrix takes the points of the scan to the model.

    Raises
    ------
    NothingToReconstructError
        If the scan lies nowhere in the model.
    """
    cells, _, _ = face_cells(faces, cell=_PIXEL)
    direction = main_direction(faces)
    floor = scan.floors[0]
    picture = _wall_points(scan.points, floor)
    found = []
    for level in floors or (0.0,):
        above = cells[:, 2] - level
        target = cells[(above > _BAND[0]) & (above < _BAND[1]), :2]
        if not len(target) or not len(picture):
            continue
        for quarter in range(4):
            turn = direction - scan.yaw + quarter * np.pi / 2
            rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            shift, score = _best_shift(picture @ rotation.T, target)
            matrix = np.eye(4)
            matrix[:2, :2], matrix[:2, 3], matrix[2, 3] = rotation, shift, level - floor
            found.append((score, level, matrix))
    if not found:
        raise NothingToReconstructError("the scan has no walls to lay over those of the model.")
    found.sort(key=lambda item: -item[0])
    sample, index = _sample(scan, floor, picture), index_faces(faces)
    placements = []
    for _, level, matrix in found[:_CANDIDATES]:
        refined = _refine(sample, index, _nudge(sample, cells, matrix))
        placements.append((_fit(sample @ refined[:3, :3].T + refined[:3, 3], index), level, refined))
    placements.sort(key=lambda item: -item[0])
    fit, level, best = placements[0]
    message = f"laid over the model by plan, its floor at {level:.2f} m: "
    message += f"{fit:.0%} of its upright surface lies within {_NEAR * 100:.0f} cm of a wall face"
    if len(placements) > 1 and placements[1][0] > _ALIKE * fit:
        message += "; another way of laying it fits nearly as well, so look at the plan"
    return Placement(best, fit, message)


def main_direction(faces: Faces) -> float:
    """Direction that most wall faces share, modulo a quarter turn, radians."""
    cross = np.cross(faces.corners[:, 1] - faces.corners[:, 0], faces.corners[:, 2] - faces.corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    return float(np.angle((size * (faces.normal[:, 0] + 1j * faces.normal[:, 1]) ** 4).sum()) / 4)


def _wall_points(points: Floats, floor: float) -> Floats:
    """Centres (k, 2) of the plan cells whose points fill the band above the floor."""
    above = points[:, 2] - floor
    band = points[(above > _BAND[0]) & (above < _BAND[1])]
    if not len(band):
        return np.zeros((0, 2))
    cell = np.floor(band[:, :2] / _PIXEL).astype(np.int64)
    level = np.floor((band[:, 2] - floor - _BAND[0]) / _BIN).astype(np.int64)
    filled = unique_rows(np.column_stack([cell, level])).rows
    cells, _, _, count = unique_rows(filled[:, :2])
    return np.asarray((cells[count >= _FULL * (_BAND[1] - _BAND[0]) / _BIN] + 0.5) * _PIXEL)


def _best_shift(source: Floats, target: Floats) -> tuple[Floats, float]:
    """Shift (2,) that lays most of the source's cells on the target's, and the share of both that meet."""
    from scipy.ndimage import maximum_filter
    from scipy.signal import fftconvolve

    low_source, low_target = source.min(axis=0), target.min(axis=0)
    images = []
    for points, low in ((source, low_source), (target, low_target)):
        index = np.floor((points - low) / _PIXEL).astype(np.int64)
        image = np.zeros(index.max(axis=0) + 3)
        image[index[:, 0] + 1, index[:, 1] + 1] = 1.0
        images.append(image)
    wide = maximum_filter(images[1], size=3)
    meeting = fftconvolve(wide, images[0][::-1, ::-1], mode="full")
    place = np.array(np.unravel_index(int(np.argmax(meeting)), meeting.shape))
    shift = (place - (np.array(images[0].shape) - 1)) * _PIXEL + low_target - low_source
    return shift, float(2 * meeting.max() / (images[0].sum() + images[1].sum()))


def _sample(scan: UprightScan, floor: float, picture: Floats) -> Floats:
    """Points of the plan cells that fill the band above the floor, evenly thinned, as many as refinement needs."""
    above = scan.points[:, 2] - floor
    band = scan.points[(above > _BAND[0]) & (above < _BAND[1])]
    cells = np.floor(np.concatenate([picture, band[:, :2]]) / _PIXEL).astype(np.int64)
    key = (cells[:, 0] - cells[:, 0].min()) * (np.ptp(cells[:, 1]) + 1) + cells[:, 1] - cells[:, 1].min()
    band = band[np.isin(key[len(picture) :], key[: len(picture)])]
    thinned = band[unique_rows(np.floor(band / 0.05).astype(np.int64)).first]
    return np.asarray(thinned[:: max(1, len(thinned) // _SAMPLE)])


def _nudge(points: Floats, cells: Floats, matrix: Floats) -> Floats:
    """Shift in plan, by a few centimetres, to where most points lie on the cells (k, 3) of the faces."""
    from scipy.ndimage import gaussian_filter

    moved = points @ matrix[:3, :3].T + matrix[:3, 3]
    low = np.minimum(moved.min(axis=0), cells.min(axis=0))[:2] - 2 * _REACH
    high = np.maximum(moved.max(axis=0), cells.max(axis=0))[:2] + 2 * _REACH
    image = np.zeros(np.ceil((high - low) / _FINE).astype(int) + 1)
    level = (cells[:, 2] > moved[:, 2].min()) & (cells[:, 2] < moved[:, 2].max())
    index = np.floor((cells[level, :2] - low) / _FINE).astype(np.int64)
    image[index[:, 0], index[:, 1]] = 1.0
    image = gaussian_filter(image, 2.0)
    steps = np.arange(-_REACH, _REACH + _FINE / 2, _FINE)
    scores = np.zeros((len(steps), len(steps)))
    for i, x in enumerate(steps):
        for j, y in enumerate(steps):
            place = np.floor((moved[:, :2] + (x, y) - low) / _FINE).astype(np.int64)
            scores[i, j] = image[place[:, 0], place[:, 1]].sum()
    best = np.unravel_index(int(np.argmax(scores)), scores.shape)
    out = matrix.copy()
    out[:2, 3] += steps[best[0]], steps[best[1]]
    return out


def _refine(points: Floats, index: FaceIndex, matrix: Floats) -> Floats:
    """Turn and shift in plan until the points lie on the faces: point-to-plane steps with weights that fall with the distance."""
    for _ in range(_ITERATIONS):
        moved = points @ matrix[:3, :3].T + matrix[:3, 3]
        near = index.nearest(moved, edge=0.05)
        use = near.square & (np.abs(near.distance) < 5 * _SPREAD)
        if use.sum() < 50:
            return matrix
        middle = moved[use, :2].mean(axis=0)
        normal, arm = index.faces.normal[near.triangle[use]], moved[use, :2] - middle
        jacobian = np.column_stack([normal, normal[:, 1] * arm[:, 0] - normal[:, 0] * arm[:, 1]])
        weight = 1 / np.sqrt(1 + (near.distance[use] / _SPREAD) ** 2)
        step = np.linalg.lstsq(jacobian * weight[:, None], -near.distance[use] * weight, rcond=None)[0]
        cos, sin = np.cos(step[2]), np.sin(step[2])
        change = np.eye(4)
        change[:2, :2] = [[cos, -sin], [sin, cos]]
        change[:2, 3] = middle + step[:2] - change[:2, :2] @ middle
        matrix = change @ matrix
        if np.abs(step[:2]).max() < _STILL and np.abs(step[2] * arm).max() < _STILL:
            break
    return matrix


def _fit(points: Floats, index: FaceIndex) -> float:
    near = index.nearest(points)
    return float(np.mean(near.square & (np.abs(near.distance) < _NEAR))) if len(points) else 0.0
