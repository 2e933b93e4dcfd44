"""Houses from an outdoor scan, every stage in order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.errors import ConfigError, NothingToReconstructError
from indoor_bim.outdoor.model import House, Village
from indoor_bim.params import HousesParams, Params
from indoor_bim.stages import Progress, Stages

if TYPE_CHECKING:
    from indoor_bim.outdoor.accuracy import Accuracy
    from indoor_bim.outdoor.scene import Scene

DEFAULT_METHOD = "lines"

Floats = NDArray[np.float64]
Method = Callable[["Scene", HousesParams, Stages], tuple[House, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class HousesResult:
    """Houses and how they came about.

    Parameters
    ----------
    village : Village
        The houses.
    accuracy : Accuracy
        Distances of the wall points from the houses, and of surveyed corners where there are any.
    params : Params
        Parameters that were asked for.
    stages : dict of str to object
        Product of every stage, by the name of the stage.
    timings : dict of str to float
        Seconds that each stage took.
    warnings : tuple of str
        What is missing or doubtful, in sentences.
    """

    village: Village
    accuracy: Accuracy
    params: Params
    stages: dict[str, Any]
    timings: dict[str, float]
    warnings: tuple[str, ...]


def houses(
    scan: Any,
    out: str | Path | None = None,
    *,
    method: str = DEFAULT_METHOD,
    params: Params | None = None,
    attributes: str | Path | None = None,
    corners: str | Path | None = None,
    formats: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> HousesResult:
    """Find the houses of an outdoor scan: footprints, heights, storeys.

    Parameters
    ----------
    scan : path, Cloud, open3d point cloud (legacy or tensor), or (n, 3) array_like
        The scan, z up; class codes in the file (2 ground, 6 building) are used when there are any.
    out : path, optional
        Folder for the files; made if missing. Default: nothing is written.
    method : str
        One of `METHODS`: ``lines``, the default, or ``topology``, the published way (Sensors 2024, 24, 5723).
    params : Params, optional
        Parameters; `HousesParams` are those of this way.
    attributes : path, optional
        Table (CSV) of materials and other attributes, joined to the houses by ``id`` or by ``x`` and ``y`` in scan coordinates.
    corners : path, optional
        Surveyed corners (CSV with ``x``, ``y`` in scan coordinates, and ``id``) to compare the footprints with.
    formats : sequence of str, optional
        What to write, of `indoor_bim.outdoor.outputs.FILES`; default: everything.
    progress : callable, optional
        Called with the name of the stage and the share of it that is done.

    Returns
    -------
    HousesResult

    Raises
    ------
    ReadError
        If the scan or the table cannot be read.
    NothingToReconstructError
        If there is no ground or no house in it.
    ConfigError
        If there is no such method or format.
    WriteError
        If `out` cannot be written.
    """
    if method not in METHODS:
        raise ConfigError(f'method: there is no "{method}"; expected one of {", ".join(sorted(METHODS))}')
    from indoor_bim.cloud.read import as_cloud
    from indoor_bim.export.files import write_text
    from indoor_bim.outdoor.accuracy import measure, read_corners
    from indoor_bim.outdoor.attributes import join_attributes, read_attributes
    from indoor_bim.outdoor.footprint import WallPoints
    from indoor_bim.outdoor.outputs import FILES, write_outputs
    from indoor_bim.outdoor.scene import see_scene
    from indoor_bim.outdoor.terrain import ground_mesh, spot_heights
    from indoor_bim.outputs import prepare_folder

    params = params or Params()
    chosen = params.houses
    wanted = tuple(FILES) if formats is None else tuple(formats)
    folder = prepare_folder(out, formats=wanted, known=tuple(FILES)) if out is not None else None
    table = read_attributes(attributes) if attributes is not None else ()
    surveyed = read_corners(corners) if corners is not None else ()
    stages = Stages(progress)
    with stages("read") as keep:
        cloud = as_cloud(scan, unit=params.read.unit, up=params.read.up, crs=params.read.crs, trajectory=False)
        keep(cloud)
    with stages("ground") as keep:
        scene = see_scene(cloud.points, cloud.classification, terrain_spacing=chosen.terrain_spacing)
        keep(scene)
    if scene is None:
        raise NothingToReconstructError(f"{cloud.source}: found no ground; expected an outdoor scan of houses with the ground about them.")
    found = METHODS[method](scene, chosen, stages)
    if not found:
        raise NothingToReconstructError(
            f"{cloud.source}: found no house; expected walls about at least {chosen.least_area:g} m2, seen along "
            f"{100 * chosen.least_coverage:g} % of the outline and more than 2 m high."
        )
    with stages("model") as keep:
        found, warnings = join_attributes(found, table, cloud.frame)
        village = Village(
            name=Path(cloud.source).stem or "Village",
            houses=found,
            ground=ground_mesh(scene.terrain),
            spot_heights=tuple(map(tuple, spot_heights(scene.ground, spacing=chosen.spot_spacing, radius=chosen.spot_radius).tolist())),
            storey_height=chosen.storey_height,
            transform_cloud_to_model=cloud.frame.rows(),
            crs=cloud.crs,
            source=Path(cloud.source).name,
            method=method,
            warnings=tuple(dict.fromkeys([*cloud.warnings, *warnings, *_doubts(found, scene)])),
        )
        keep(village)
    with stages("accuracy") as keep:
        accuracy = measure(village, WallPoints.above(scene.building, scene.above_ground), cloud.frame, surveyed)
        keep(accuracy)
    if folder is not None:
        with stages("write"):
            write_outputs(village, folder, formats=wanted, params=params)
            write_text(folder / "accuracy.md", accuracy.table())
    return HousesResult(village, accuracy, params, stages.products, stages.timings, village.warnings)


def lines(scene: Scene, params: HousesParams, stages: Stages) -> tuple[House, ...]:
    """Wall lines, closed outlines, sides placed on all wall points.

    Parameters
    ----------
    scene : Scene
        Ground and building points.
    params : HousesParams
        Parameters.
    stages : Stages
        Keeps every stage's product.
    """
    from indoor_bim.outdoor.build import make_houses
    from indoor_bim.outdoor.footprint import WallPoints, evidence_of, find_footprints, wall_lines

    with stages("walls") as keep:
        cells, seen = evidence_of(scene.building, scene.above_ground, scene.ground)
        faces = wall_lines(cells)
        keep(faces)
    with stages("footprints") as keep:
        walls = WallPoints.above(scene.building, scene.above_ground)
        footprints = find_footprints(
            walls,
            faces,
            seen,
            scene.terrain,
            least_area=params.least_area,
            least_coverage=params.least_coverage,
            right_angles=params.right_angles,
        )
        keep(footprints)
    with stages("heights"):
        return make_houses(footprints, walls, scene.terrain, storey_height=params.storey_height)


def topology(scene: Scene, params: HousesParams, stages: Stages) -> tuple[House, ...]:
    """Slice, grid, chain of nearest neighbours, simplification by angle (Sensors 2024, 24, 5723).

    Parameters
    ----------
    scene : Scene
        Ground and building points.
    params : HousesParams
        Parameters; their defaults are the paper's values.
    stages : Stages
        Keeps every stage's product.
    """
    from indoor_bim.outdoor.build import make_published_houses
    from indoor_bim.outdoor.topology import outlines
    from indoor_bim.outdoor.wall_cells import upright_points

    with stages("walls") as keep:
        walls = upright_points(scene.building, scene.above_ground)
        keep(walls)
    points, above_ground = scene.building[walls], scene.above_ground[walls]
    with stages("footprints") as keep:
        rings = outlines(
            points,
            above_ground,
            low=params.slice_low,
            high=params.slice_high,
            cell=params.grid_size,
            neighbours=params.neighbours,
            angle=params.angle_threshold,
            least_area=params.least_area,
        )
        keep(rings)
    with stages("heights"):
        return make_published_houses(rings, points, storey_height=params.storey_height)


METHODS: Mapping[str, Method] = MappingProxyType({"lines": lines, "topology": topology})


def _doubts(found: tuple[House, ...], scene: Scene) -> list[str]:
    """Sentences about what was assumed."""
    doubts = [] if scene.classes_from_file else ["The scan has no classes of ground and building: they were told by shape."]
    for house in found:
        hidden = sum(facade.length for facade in house.facades if not facade.seen)
        if hidden > 0:
            doubts.append(f"House {house.id}: {hidden:.1f} m of its outline were not seen and are closed by assumption.")
    return doubts
