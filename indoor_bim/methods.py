"""The methods of reconstruction by name; each leads from a cloud to storeys of the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from indoor_bim.errors import NothingToReconstructError
from indoor_bim.model import Storey
from indoor_bim.params import Params
from indoor_bim.stages import Stages

if TYPE_CHECKING:
    from indoor_bim.cloud.cloud import Cloud, LevelledCloud
    from indoor_bim.frame import Frame
    from indoor_bim.plan.storey_plan import StoreyPlan


@dataclass(frozen=True, slots=True, eq=False)
class Reconstruction:
    """What a method returns.

    Parameters
    ----------
    frame : Frame
        Takes scan coordinates to model coordinates.
    storeys : tuple of Storey
        Storeys from the bottom up.
    derived : dict of str to value
        Values of parameters that were derived from the scan, by ``stage.name``.
    warnings : tuple of str
        What is missing or doubtful, in sentences.
    """

    frame: Frame
    storeys: tuple[Storey, ...] = ()
    derived: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


SPARSE = 0.05  # metres between neighbouring points; auto reads walls in strips of a centimetre and needs more

Method = Callable[["Cloud", Params, Stages], Reconstruction]


def slope(cloud: Cloud, params: Params, stages: Stages) -> Reconstruction:
    """Levelling by principal components, thinning, slope lines (Remote Sensing 2021, 13, 4930).

    Parameters
    ----------
    cloud : Cloud
        The scan.
    params : Params
        All parameters.
    stages : Stages
        Keeps every stage's product.
    """
    from indoor_bim.cloud.pca_levelling import level_by_pca
    from indoor_bim.slope import slope_stages
    from indoor_bim.slope_plan import slope_plan
    from indoor_bim.storeys import storey_from_plan

    chosen = params.slope
    with stages("level") as keep:
        levelled = level_by_pca(cloud, grid_count=chosen.grid_count)
        keep(levelled)
    with stages("lines") as keep:
        lines = slope_stages(levelled, **chosen.model_dump(exclude={"grid_count"}))
        keep(lines)
    plan = slope_plan(levelled, lines, afar=chosen.magnification is None, gps_time=cloud.gps_time)
    with stages("walls") as keep:
        made = storey_from_plan(plan, min_thickness=params.walls.min_thickness, max_thickness=params.walls.max_thickness, far_snap=2.0)
        keep(made)
    return Reconstruction(levelled.frame, (made.storey,), warnings=made.warnings)


def auto(cloud: Cloud, params: Params, stages: Stages) -> Reconstruction:
    """Rooms and faces by evidence below the ceiling, a cell complex and a minimum cut; the default.

    Scans whose points are more than 5 cm apart are too sparse for it and go to `slope`, as do those that it finds no wall in;
    the warnings say so.

    Parameters
    ----------
    cloud : Cloud
        The scan.
    params : Params
        All parameters.
    stages : Stages
        Keeps every stage's product; "plan", "walls" and "openings" hold one product for each storey.
    """
    from indoor_bim.auto import storey_plans
    from indoor_bim.cloud.levels import lowered
    from indoor_bim.threads import both, threads_for

    with stages("level") as keep:
        levelled, spacing = both(lambda: _levelled(cloud), lambda: _spacing(cloud), threads=threads_for(len(cloud.points)))
        if spacing <= SPARSE and not isinstance(levelled, NothingToReconstructError):
            keep(levelled)
    if spacing > SPARSE:
        return _by_slope(cloud, params, stages, f"The points are {100 * spacing:.0f} cm apart, too sparse for the method auto")
    if isinstance(levelled, NothingToReconstructError):
        raise levelled
    with stages("plan") as keep:
        plans = storey_plans(levelled, gps_time=cloud.gps_time)
        keep(plans)
    if not any(len(plan.faces) for plan in plans):
        return _by_slope(cloud, params, stages, "The method auto found no wall")
    base = plans[0].floor
    if base:
        levelled, plans = lowered(levelled, base), tuple(plan.lowered(base) for plan in plans)
    storeys, warnings = _storeys(plans, params, stages)
    with stages("openings") as keep:
        storeys = _with_openings(storeys, levelled, cloud, params)
        keep(storeys)
    return Reconstruction(levelled.frame, tuple(storeys), warnings=(*levelled.warnings, *warnings))


def _spacing(cloud: Cloud) -> float:
    """Distance between neighbouring points, metres: from few points where these leave no doubt that it is small."""
    from indoor_bim.cloud.spacing import point_spacing

    roughly = point_spacing(cloud.points, sample_size=20_000)  # to some 20 %
    return point_spacing(cloud.points) if roughly > 0.75 * SPARSE else roughly


def _levelled(cloud: Cloud) -> LevelledCloud | NothingToReconstructError:
    """Cloud that stands upright, or what is in the way of it."""
    from indoor_bim.cloud.levels import level

    try:
        return level(cloud)
    except NothingToReconstructError as error:
        return error


def _by_slope(cloud: Cloud, params: Params, stages: Stages, reason: str) -> Reconstruction:
    """What `slope` finds, with the reason why it was asked."""
    published = slope(cloud, params, stages)
    return replace(published, warnings=(f"{reason}: the method slope was used.", *published.warnings))


def slices(cloud: Cloud, params: Params, stages: Stages) -> Reconstruction:
    """Layered slices, weighted line fits, merging by chi square, contour completion (Yang, Duan, Wu, Hu).

    Parameters
    ----------
    cloud : Cloud
        The scan.
    params : Params
        All parameters.
    stages : Stages
        Keeps every stage's product; "lines", "walls" and "openings" hold one product for each storey.
    """
    from indoor_bim.cloud.levels import level
    from indoor_bim.gap_openings import with_gap_openings
    from indoor_bim.slices import slices_stages

    with stages("level") as keep:
        levelled = level(cloud)
        keep(levelled)
    with stages("lines") as keep:
        found = slices_stages(levelled, gps_time=cloud.gps_time, **params.slices.model_dump())
        keep(found)
    storeys, warnings = _storeys([storey.plan for storey in found], params, stages, far_snap=1.5)
    with stages("openings") as keep:
        storeys = _with_openings(storeys, levelled, cloud, params)
        chosen = params.openings.model_dump(exclude={"frame"})
        gaps = {made.plan.floor or 0.0: made.gaps for made in found}
        storeys = [with_gap_openings(storey, gaps[min(gaps, key=lambda z: abs(z - storey.elevation))], **chosen) for storey in storeys]
        keep(storeys)
    return Reconstruction(levelled.frame, tuple(storeys), warnings=(*levelled.warnings, *warnings))


def _with_openings(storeys: Sequence[Storey], levelled: LevelledCloud, cloud: Cloud, params: Params) -> list[Storey]:
    """Storeys with the doors and windows that the rays at their walls show."""
    from indoor_bim.openings import find_openings

    chosen = params.openings.model_dump()
    measured: dict[str, Any] = {"trajectory": levelled.trajectory, "gps_time": cloud.gps_time, "intensity": cloud.intensity}
    return [find_openings(storey, levelled.points, **measured, **chosen) for storey in storeys]


def _storeys(plans: Sequence[StoreyPlan], params: Params, stages: Stages, *, far_snap: float = 0.0) -> tuple[list[Storey], list[str]]:
    """Storeys with walls and rooms, from their plans, and what had to be assumed."""
    from indoor_bim.storeys import storey_from_plan

    warnings: list[str] = []
    storeys: list[Storey] = []
    with stages("walls") as keep:
        geometry = []
        for plan in plans:
            made = storey_from_plan(
                plan,
                number=len(storeys) + 1,
                min_thickness=params.walls.min_thickness,
                max_thickness=params.walls.max_thickness,
                far_snap=far_snap,
            )
            if not made.storey.walls:
                warnings.append(f"no walls were found on the level at {made.storey.elevation:.2f} m")
                continue
            storeys.append(made.storey)
            geometry.append(made)
            warnings += made.warnings
        keep(geometry)
    return storeys, warnings


METHODS: Mapping[str, Method] = MappingProxyType({"auto": auto, "slices": slices, "slope": slope})
