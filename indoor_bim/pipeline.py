"""The whole way from a scan to a building model, every stage in order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from indoor_bim.errors import ConfigError, NothingToReconstructError
from indoor_bim.identity import with_guids
from indoor_bim.methods import METHODS, Reconstruction
from indoor_bim.model import Building
from indoor_bim.params import Params
from indoor_bim.stages import Progress, Stages
from indoor_bim.title import building_name

if TYPE_CHECKING:
    from indoor_bim.cloud.cloud import Cloud

DEFAULT_METHOD = "auto"
FORMATS = ("ifc", "obj", "svg", "json")


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """A building model and how it came about.

    Parameters
    ----------
    building : Building
        The model.
    params : Params
        Parameters that were asked for.
    derived : dict of str to value
        Values of parameters that were derived from the scan, by ``stage.name``.
    stages : dict of str to object
        Product of every stage, by the name of the stage.
    timings : dict of str to float
        Seconds that each stage took.
    warnings : tuple of str
        What is missing or doubtful, in sentences.
    """

    building: Building
    params: Params
    derived: dict[str, Any]
    stages: dict[str, Any]
    timings: dict[str, float]
    warnings: tuple[str, ...]


def reconstruct(
    scan: Any,
    out: str | Path | None = None,
    *,
    method: str = DEFAULT_METHOD,
    params: Params | None = None,
    trajectory: Any = None,
    formats: Sequence[str] = FORMATS,
    debug: str | Path | None = None,
    progress: Progress | None = None,
) -> Result:
    """Make a building model from a laser scan.

    Parameters
    ----------
    scan : path, Cloud, open3d point cloud (legacy or tensor), or (n, 3) array_like
        The scan, z (or y) roughly up, in metres or another unit that is recognised.
    out : path, optional
        Folder for model.ifc, model.obj, plan.svg, model.json and params.toml; made if missing. Default: nothing is written.
    method : str
        One of `METHODS`.
    params : Params, optional
        Parameters; by default everything is derived from the scan.
    trajectory : path, (m, 4) array_like or False, optional
        Scanner path as t, x, y, z in scan coordinates; default: ``trajectory.csv`` beside the scan, if there is one.
    formats : sequence of str
        What to write of "ifc", "obj", "svg", "json", "ply", "gltf", "geojson", "dxf", "pdf", "png"; the last three need an extra.
    debug : path, optional
        Folder for a picture of every wall with its hits, holes and openings; made if missing. Default: no pictures.
    progress : callable, optional
        Called with the name of the stage and the share of it that is done.

    Returns
    -------
    Result
        The model, every stage's product, times and warnings.

    Raises
    ------
    ReadError
        If the scan cannot be read.
    NothingToReconstructError
        If there are no walls in it. Files that say why are written to `out` all the same.
    WriteError
        If `out` cannot be written.
    ConfigError
        If there is no such method.
    """
    if method not in METHODS:
        raise ConfigError(f'method: there is no "{method}"; expected one of {", ".join(sorted(METHODS))}')
    from indoor_bim.outputs import failed_checks, prepare_folder, write_outputs

    params = params or Params()
    folder = prepare_folder(out, formats=formats) if out is not None else None
    pictures = prepare_folder(debug, formats=()) if debug is not None else None
    stages = Stages(progress)

    from indoor_bim.cloud.density_limit import limit_for
    from indoor_bim.cloud.no_walls import check_depth
    from indoor_bim.cloud.read import as_cloud

    with stages("read") as keep:
        chosen = params.read
        bounded = method == DEFAULT_METHOD or chosen.max_memory is not None or chosen.per_cube is not None
        limit = limit_for(per_cube=chosen.per_cube, max_memory=chosen.max_memory) if bounded else None
        cloud = as_cloud(scan, unit=chosen.unit, up=chosen.up, crs=chosen.crs, trajectory=trajectory, limit=limit)
        keep(cloud)
    failure: NothingToReconstructError | None = None
    found = Reconstruction(frame=cloud.frame)
    try:
        check_depth(cloud.points)
        found = METHODS[method](cloud, params, stages)
    except NothingToReconstructError as error:
        failure = NothingToReconstructError(f"{cloud.source}: {str(error).removeprefix(f'{cloud.source}: ')}")
    name = params.read.title or building_name(scan, source=cloud.source)
    building = _building(cloud, found, name=name, method=method, failure=failure)
    if failure is None and not any(storey.walls for storey in building.storeys):
        failure = NothingToReconstructError(f"{cloud.source}: found no wall; expected the scan of a building from inside.")
        building = _building(cloud, found, name=name, method=method, failure=failure)
    derived = {**cloud.derived, **found.derived}
    doubts: tuple[str, ...] = ()
    if folder is not None:
        with stages("write"):
            file = Path(scan) if isinstance(scan, str | Path) else None
            underlays = {}
            if params.drawing.underlay:
                from indoor_bim.quality.density import scan_underlays

                underlays = scan_underlays(building, cloud)
            write_outputs(building, folder, formats=formats, params=params, derived=derived, scan=file, underlays=underlays)
        with stages("check"):
            doubts = failed_checks(folder)
    if pictures is not None and failure is None:
        with stages("pictures"):
            _write_wall_pictures(building, cloud, pictures)
    if failure is not None:
        raise failure
    return Result(building, params, derived, stages.products, stages.timings, (*building.warnings, *doubts))


def _write_wall_pictures(building: Building, cloud: Cloud, folder: Path) -> None:
    """Write every wall as the scan saw it."""
    from indoor_bim.frame import Frame
    from indoor_bim.wall_views import write_wall_pictures

    to_model = Frame.from_matrix(building.transform_cloud_to_model)
    turn = to_model.rotation @ cloud.frame.rotation.T
    shift = to_model.to_local(cloud.frame.to_scan([[0.0, 0.0, 0.0]]))[0]
    points = cloud.points @ turn.T + shift
    path = None if cloud.trajectory is None else np.column_stack([cloud.trajectory[:, 0], cloud.trajectory[:, 1:] @ turn.T + shift])
    for storey in building.storeys:
        write_wall_pictures(storey, points, folder, trajectory=path, gps_time=cloud.gps_time)


def _building(cloud: Cloud, found: Reconstruction, *, name: str, method: str, failure: NothingToReconstructError | None) -> Building:
    """Building model of what a method found."""
    warnings = [*cloud.warnings, *found.warnings, *([str(failure)] if failure else [])]
    storeys = () if failure else found.storeys
    if storeys and not any(storey.rooms for storey in storeys):
        warnings.append("No walls close a room: the scan shows too little of every room, or a building from outside.")
    building = Building(
        name=name,
        storeys=storeys,
        transform_cloud_to_model=found.frame.rows(),
        crs=cloud.crs,
        source=Path(cloud.source).name,
        method=method,
        warnings=tuple(dict.fromkeys(warnings)),
    )
    return with_guids(building)
