"""From the plan of a storey to a storey of the model: walls, corners, rooms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from indoor_bim.assemble import build_storey
from indoor_bim.model import Evidence, Storey
from indoor_bim.plan.alignment import align_faces
from indoor_bim.plan.collinear import merge_collinear
from indoor_bim.plan.curved_walls import with_common_curves
from indoor_bim.plan.face_accuracy import face_accuracy
from indoor_bim.plan.graph import join_walls, wall_graph, without_stubs
from indoor_bim.plan.hull import building_hull, looks_outside, stand_before_others
from indoor_bim.plan.joints import footprints, join_without_overlaps
from indoor_bim.plan.rooms import known_rooms, observed_share, reading_order, room_polygons, shared_areas
from indoor_bim.plan.shared_thickness import share_thickness
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.plan.walls import Walls, walls_from_faces

if TYPE_CHECKING:
    import networkx as nx
    import shapely

LOOKED_INTO = 0.3  # share of a room's floor or ceiling that was seen: less, and it was only looked into
ENTERED = 0.5  # the same, for what walls enclose without the method knowing it as a room
SHORTEST_STEP = 0.05  # metres; shorter sides of steps in a closed outline are left to the joints
USUAL_HEIGHT = 2.5  # metres, where neither ceiling nor wall tops were seen


@dataclass(frozen=True, slots=True, eq=False)
class StoreyGeometry:
    """A storey and the geometry that it was made from.

    Parameters
    ----------
    storey : Storey
        The storey of the model.
    walls : Walls
        Its joined walls as a table.
    graph : networkx.Graph
        Its corners and the stretches of wall between them (`wall_graph`).
    warnings : tuple of str
        What had to be assumed.
    """

    storey: Storey
    walls: Walls
    graph: nx.Graph
    warnings: tuple[str, ...]


def storey_from_plan(
    plan: StoreyPlan,
    *,
    number: int = 1,
    min_thickness: float = 0.05,
    max_thickness: float = 0.60,
    snap: float = 0.30,
    far_snap: float = 0.0,
) -> StoreyGeometry:
    """Make walls of faces, join them, find the rooms between them and put all of it into the model.

    Parameters
    ----------
    plan : StoreyPlan
        Faces, levels and free space, metres.
    number : int
        Number of the storey from the bottom, from 1.
    min_thickness, max_thickness : float
        Bounds of a wall's thickness, metres.
    snap : float
        Slack of corners that were not seen, metres.
    far_snap : float
        Slack of ends that meet nothing within `snap`, metres.

    Returns
    -------
    StoreyGeometry
        The storey of the model, and the table of walls and the graph of corners that it was made from.
    """
    faces = align_faces(plan.faces)
    pair = partial(walls_from_faces, faces, min_thickness=min_thickness, max_thickness=max_thickness)
    if plan.rooms:
        hull = building_hull(plan.rooms)
        outer = looks_outside(faces, hull) & ~stand_before_others(faces, hull)
        walls = pair(outer=outer, shortest_single=SHORTEST_STEP)
    else:
        enclosed = room_polygons(footprints(*join_walls(_tidy(pair()), snap=snap, far_snap=far_snap)))
        walls = pair(outer=looks_outside(faces, building_hull(enclosed)))
    walls = with_common_curves(walls, plan.curves)
    walls = share_thickness(merge_collinear(walls) if plan.rooms else _tidy(walls))
    walls, meetings, outlines = join_without_overlaps(walls, snap=snap, far_snap=far_snap, curves=plan.curves)
    rooms = known_rooms(plan.rooms, outlines)
    known = len(rooms)
    enclosed = room_polygons(outlines)
    taken = [max(shared.values(), default=0.0) for shared in shared_areas(enclosed, rooms)]
    rooms += [room for room, area in zip(enclosed, taken, strict=True) if area <= 0.1 * room.area]
    seen = [1.0 if plan.seen is None else observed_share(room, plan.seen) for room in rooms]
    least = [LOOKED_INTO if k < known or not known else ENTERED for k in range(len(rooms))]
    kept = [k for k in reading_order(rooms) if seen[k] >= least[k]]
    warnings = list(plan.warnings)
    floor, ceiling = _levels(plan, walls, warnings)
    storey = build_storey(
        walls,
        meetings,
        outlines,
        [rooms[k] for k in kept],
        floor=floor,
        ceiling=ceiling,
        number=number,
        room_evidence=[Evidence(coverage=round(seen[k], 3), sides=1) for k in kept],
        room_levels=_room_levels([rooms[k] for k in kept], plan, storey=(floor, ceiling)),
        ceiling_plate=not plan.pitched,
        columns=plan.columns,
        accuracy=face_accuracy(walls, plan.faces),
        curves=plan.curves,
    )
    return StoreyGeometry(storey, walls, wall_graph(walls, meetings), tuple(warnings))


def _tidy(walls: Walls) -> Walls:
    """Walls without furniture, where no rooms say what is a wall."""
    return without_stubs(merge_collinear(walls))


def _room_levels(rooms: list[shapely.Polygon], plan: StoreyPlan, *, storey: tuple[float, float]) -> list[tuple[float, float]]:
    """Floor and ceiling of each room: those of the known room that it shares most with, else the storey's."""
    if not plan.room_levels or plan.floor is None or plan.ceiling is None:
        return [storey] * len(rooms)
    return [plan.room_levels[max(shared, key=shared.__getitem__)] if shared else storey for shared in shared_areas(rooms, plan.rooms)]


def _levels(plan: StoreyPlan, walls: Walls, warnings: list[str]) -> tuple[float, float]:
    """Floor and ceiling; from the walls where they were not seen, and said so."""
    tops = walls.top[walls.top > 0]
    tallest = float(tops.max()) if len(tops) else USUAL_HEIGHT
    floor, ceiling = plan.floor, plan.ceiling
    if floor is None:
        floor = 0.0 if ceiling is None else min(0.0, ceiling - 1.0)
        warnings.append("The floor was not seen; walls stand on the lowest wall points.")
    if ceiling is None:
        ceiling = floor + tallest
        warnings.append("The ceiling was not seen; walls end at the highest wall points.")
    return floor, ceiling
