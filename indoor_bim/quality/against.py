"""Bring a model together with a scan or another model, and measure the deviations."""

from __future__ import annotations

import logging
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.quality.deviation import Deviations, wall_deviations
from indoor_bim.quality.ifc_bodies import walls_of_ifc
from indoor_bim.quality.registration import Placement, UprightScan, find_placement, given_placement, main_direction
from indoor_bim.quality.wall_bodies import Faces, WallModel, bodies_of_building, face_cells, upright_faces

Floats = NDArray[np.float64]

USUAL_HEIGHT = 2.5  # metres, where a scan does not show the ceiling
_LEAST_FIT = 0.25  # of a placement that a model claims; less, and the claim is not believed
_SAMPLE_CELL = 0.05
_log = logging.getLogger(__name__)


def read_wall_model(path: str | os.PathLike[str]) -> WallModel:
    """Read the walls of a model: ``.ifc`` of anybody, ``.json`` of this program.

    Parameters
    ----------
    path : path
        Model file.

    Raises
    ------
    ReadError
        If the file is missing, damaged or holds no walls.
    """
    if Path(path).suffix.lower() == ".ifc":
        return walls_of_ifc(path)
    from indoor_bim.export.json import read_json

    return bodies_of_building(read_json(path))


def against_scan(model: WallModel, cloud: Cloud) -> Deviations:
    """Measure how far the walls of a model are from a scan.

    A model that tells where it lies in its scan is put there; any other is found by its plan, after the scan was turned upright.

    Parameters
    ----------
    model : WallModel
        Walls and other elements, metres.
    cloud : Cloud
        The scan.

    Raises
    ------
    NothingToReconstructError
        If the model has no walls, or if the scan shows no floor, no walls or another building.
    """
    faces = _faces(model)
    if model.scan_to_model is not None:
        placement = given_placement(cloud.points, model.scan_to_model @ np.linalg.inv(cloud.frame.matrix), faces)
        if placement.fit >= _LEAST_FIT / 2:
            bands = _bands_of(model)
            points = _moved(cloud.points, placement.matrix)
            scanner = _scanner(cloud.trajectory, cloud, placement.matrix)
            return wall_deviations(model, points, bands=bands, message=_said(placement), time=cloud.gps_time, scanner=scanner)
        _log.warning("%s does not lie where the model says; it is laid over it by plan.", cloud.source)
    from indoor_bim.cloud.levels import level

    levelled = level(cloud)
    floors = tuple(s.floor if s.floor is not None else (s.ceiling or 0.0) - USUAL_HEIGHT for s in levelled.storeys)
    ceilings = [s.ceiling if s.ceiling is not None else floor + USUAL_HEIGHT for s, floor in zip(levelled.storeys, floors, strict=True)]
    placement = find_placement(UprightScan(levelled.points, floors), faces, tuple(z for _, z in model.storeys))
    _check_fit(placement)
    rise = placement.matrix[2, 3]
    bands = [(floor + rise, ceiling + rise) for floor, ceiling in zip(floors, ceilings, strict=True)]
    points, scanner = _moved(levelled.points, placement.matrix), _scanner(levelled.trajectory, cloud, placement.matrix)
    return wall_deviations(model, points, bands=bands, message=_said(placement), time=cloud.gps_time, scanner=scanner)


def against_model(model: WallModel, other: WallModel) -> Deviations:
    """Measure how far the walls of a model are from those of another one.

    The faces of the other model take the place of a scan. Models of one scan are brought together by their matrices, others as
    they lie where that fits, else by their plans.

    Parameters
    ----------
    model, other : WallModel
        Walls and other elements, metres.

    Raises
    ------
    NothingToReconstructError
        If a model has no walls, or if they are of different buildings.
    """
    model, other = model.detailed(None), other.detailed(None)
    faces, other_faces = _faces(model), _faces(other)
    points, _, _ = face_cells(other_faces, cell=_SAMPLE_CELL)
    placement = _where_claimed(model, other, points, faces)
    if placement is None:
        floors = tuple(z for _, z in other.storeys) or (float(points[:, 2].min()),)
        upright = UprightScan(points, floors, main_direction(other_faces))
        placement = find_placement(upright, faces, tuple(z for _, z in model.storeys))
        _check_fit(placement)
    moved = _moved(points, placement.matrix)
    bands = [(low, high) for low, high in _bands_of(model) if ((moved[:, 2] > low) & (moved[:, 2] < high)).any()]
    return wall_deviations(model, moved, bands=bands, is_scan=False, message=f"The other model is {placement.message}.")


def _where_claimed(model: WallModel, other: WallModel, points: Floats, faces: Faces) -> Placement | None:
    """Place another model by the matrices of a common scan, or leave it where it lies; None where neither fits."""
    claims = []
    if model.scan_to_model is not None and other.scan_to_model is not None and model.source == other.source:
        claims.append((model.scan_to_model @ np.linalg.inv(other.scan_to_model), "placed by the matrices of the scan that both come from"))
    claims.append((np.eye(4), "left where it lies"))
    for matrix, message in claims:
        placement = replace(given_placement(points, matrix, faces), message=message)
        if placement.fit >= _LEAST_FIT:
            return placement
    return None


def _faces(model: WallModel) -> Faces:
    faces = upright_faces(model.walls)
    if not len(faces.wall):
        raise NothingToReconstructError("the model has no walls to measure; expected walls with bodies.")
    return faces


def _bands_of(model: WallModel) -> list[tuple[float, float]]:
    """Heights of the storeys of a model: from each floor to the top of the walls that stand in it."""
    tops = {name: [body.vertices[:, 2].max() for body in model.walls if body.storey == name] for name, _ in model.storeys}
    bands = [(level, float(np.median(tops[name]))) for name, level in model.storeys if tops[name]]
    if not bands:
        heights = np.concatenate([body.vertices[:, 2] for body in model.walls])
        return [(float(heights.min()), float(heights.max()))]
    return bands


def _scanner(trajectory: Floats | None, cloud: Cloud, matrix: Floats) -> Floats | None:
    """Where the scanner was when each point was taken, moved; None where that is not known."""
    if trajectory is None or cloud.gps_time is None or not np.isfinite(trajectory[:, 0]).all():
        return None
    return _moved(sensor_positions(trajectory, cloud.gps_time), matrix)


def _moved(points: Floats, matrix: Floats) -> Floats:
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def _said(placement: Placement) -> str:
    message = f"The scan is {placement.message}."
    _log.info(message)
    return message


def _check_fit(placement: Placement) -> None:
    if placement.fit < _LEAST_FIT / 2:
        raise NothingToReconstructError(
            f"the model does not fit: only {placement.fit:.0%} of the upright surface lies at its walls in the best place found; "
            "expected a scan or model of the same building."
        )
