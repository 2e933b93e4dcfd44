"""The way of the scanner through a building: a walk through all rooms that can be reached, or stations in them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Building, Point2, Room, Storey

if TYPE_CHECKING:
    import networkx as nx
    import shapely

Points = NDArray[np.float64]

_SHOULDER, _APPROACH, _STEP, _SMOOTHING = 0.2, 0.45, 0.05, 0.25


@dataclass(frozen=True, slots=True)
class Stair:
    """Straight flight between two storeys: where it starts below and arrives above, metres."""

    foot: Point2
    head: Point2
    width: float
    bottom: float
    top: float


def stairs(building: Building) -> list[Stair]:
    """Flights under the holes of the upper floors, rising along the longer side towards its smaller coordinate."""
    flights = []
    for below, above in itertools.pairwise(building.storeys):
        for hole in (hole for slab in above.slabs if slab.kind == "floor" for hole in slab.outline.holes):
            low, high = np.min(hole, axis=0), np.max(hole, axis=0)
            centre, long = (low + high) / 2, int(np.argmax(high - low))
            foot, head = centre.copy(), centre.copy()
            foot[long], head[long] = high[long], low[long]
            width = float(high[1 - long] - low[1 - long])
            flights.append(Stair(tuple(foot.tolist()), tuple(head.tolist()), width, below.elevation, above.elevation))
    return flights


def walk_path(building: Building) -> Points:
    """Path (m, 3) of feet through every room that can be reached through open doors and up the stairs, points 5 cm apart.

    Rooms are visited depth first; each is walked round once. The path keeps clear of walls by a shoulder's width.

    Parameters
    ----------
    building : Building
        Doors with a hinge stand open, doors without one are closed.

    Raises
    ------
    ValueError
        If the building has no room to start in.
    """
    from scipy.ndimage import gaussian_filter1d

    if not building.storeys or not building.storeys[0].rooms:
        raise ValueError(f"building {building.name!r} has no room to walk in")
    flights = stairs(building)
    corners: list[Points] = []
    start: Point2 | None = None
    for k, storey in enumerate(building.storeys):
        way = _storey_walk(storey, start, [f for f in flights if storey.elevation in (f.bottom, f.top)])
        up = next((f for f in flights if f.bottom == storey.elevation), None) if k + 1 < len(building.storeys) else None
        corners.append(np.column_stack([way, np.full(len(way), storey.elevation)]))
        if up is None:
            break
        corners.append(np.array([[*up.foot, up.bottom], [*up.head, up.top]]))
        start = _beyond(up.head, up.foot)
    route = np.concatenate(corners)
    route = route[np.r_[True, np.linalg.norm(np.diff(route, axis=0), axis=1) > 1e-9]]
    travelled = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))]
    even = np.linspace(0.0, travelled[-1], max(2, int(np.ceil(travelled[-1] / _STEP)) + 1))
    path = np.column_stack([np.interp(even, travelled, route[:, axis]) for axis in range(3)])
    return np.asarray(gaussian_filter1d(path, _SMOOTHING / _STEP, axis=0, mode="nearest"))


def stations(building: Building, *, spacing: float = 6.0) -> Points:
    """Tripod positions (m, 3) on the floor: every room has one, long rooms and those that lead round others one every `spacing` metres."""
    import shapely

    positions = []
    for storey in building.storeys:
        for room in storey.rooms:
            polygon = room.outline.polygon
            if _leads_round(polygon):
                way = shapely.LinearRing(_round(polygon))
                count = int(np.ceil(way.length / spacing))
                clear = shapely.get_coordinates(shapely.line_interpolate_point(way, (np.arange(count) + 0.5) / count, normalized=True))
                positions.append(np.column_stack([clear, np.full(len(clear), storey.elevation)]))
                continue
            a, b, c = np.asarray(shapely.minimum_rotated_rectangle(polygon).exterior.coords)[:3]
            if np.linalg.norm(b - a) < np.linalg.norm(c - b):
                a, b, c = b, c, a + c - b
            count = max(1, int(np.ceil(np.linalg.norm(b - a) / spacing)))
            middle = (a + c) / 2 + (b - a) * ((np.arange(count) - (count - 1) / 2) / count)[:, None]
            clear = middle[shapely.contains_xy(polygon.buffer(-0.3), middle)]
            if len(clear) == 0:
                clear = np.asarray(shapely.maximum_inscribed_circle(polygon).coords)[:1]
            positions.append(np.column_stack([clear, np.full(len(clear), storey.elevation)]))
    return np.concatenate(positions)


def _storey_walk(storey: Storey, start: Point2 | None, flights: list[Stair]) -> Points:
    """Corners (m, 2) of the walk over one storey, from `start` (or the first room) round all rooms and to the stair up."""
    import networkx as nx
    import shapely

    holes = [shapely.LineString([f.foot, f.head]).buffer(f.width / 2, cap_style="flat") for f in flights]
    floors = {room.id: room.outline.polygon.difference(shapely.union_all(holes)) for room in storey.rooms}
    rounds = {room.id: _round(floors[room.id]) for room in storey.rooms}
    graph = nx.Graph()
    landings = {_beyond(*((f.foot, f.head) if f.bottom == storey.elevation else (f.head, f.foot))) for f in flights}
    doors = _doorways(storey, floors)
    for room in storey.rooms:
        clear = floors[room.id].buffer(-_SHOULDER)
        bends = [xy for part in shapely.get_parts(clear.buffer(-0.1)) for xy in part.exterior.coords[:-1]]
        nodes = {*rounds[room.id], *bends, *(p for p in landings if clear.covers(shapely.Point(p)))}
        nodes |= {approach for *_, approaches in doors for owner, approach in approaches if owner == room.id}
        _connect(graph, sorted(nodes), clear.buffer(1e-6))
    for _, centre, approaches in doors:
        for _, approach in approaches:
            graph.add_edge(centre, approach, weight=float(np.hypot(*np.subtract(centre, approach))))
    room = next((r for r in storey.rooms if start and floors[r.id].covers(shapely.Point(start))), storey.rooms[0])
    stops = [start] if start else []
    _visit(room, storey, rounds, doors, graph, stops, set())
    up = [p for f in flights if f.bottom == storey.elevation for p in [_beyond(f.foot, f.head)]]
    stops += up
    way = [stops[0]]
    for a, b in itertools.pairwise(stops):
        if graph.has_node(b) and nx.has_path(graph, a, b):
            way += nx.shortest_path(graph, a, b, weight="weight")[1:]
    return np.asarray(way)


def _visit(
    room: Room,
    storey: Storey,
    rounds: dict[str, list[Point2]],
    doors: list[tuple[str, Point2, list[tuple[str, Point2]]]],
    graph: nx.Graph,
    stops: list[Point2],
    seen: set[str],
) -> None:
    """Append the stops of a walk round this room and, depth first, all rooms behind its doors."""
    seen.add(room.id)
    loop = rounds[room.id]
    if stops:
        first = min(range(len(loop)), key=lambda k: (np.hypot(*np.subtract(loop[k], stops[-1])), loop[k]))
        loop = loop[first:] + loop[:first]
    stops += [*loop, loop[0]]
    for _, centre, approaches in doors:
        owners = [owner for owner, _ in approaches]
        beyond = next((r for r in storey.rooms if r.id in owners and r.id not in seen), None)
        if room.id in owners and beyond is not None:
            stops.append(centre)
            _visit(beyond, storey, rounds, doors, graph, stops, seen)
            stops.append(centre)


def _doorways(storey: Storey, floors: dict[str, shapely.Polygon]) -> list[tuple[str, Point2, list[tuple[str, Point2]]]]:
    """Open doors and passages between two rooms: identifier, centre, and each room with the point in front of the door."""
    import shapely

    doorways = []
    for wall in storey.walls:
        a, b = np.asarray(wall.axis[0]), np.asarray(wall.axis[1])
        along = (b - a) / wall.length
        normal = np.array([-along[1], along[0]])
        for opening in wall.openings:
            if opening.kind == "window" or (opening.kind == "door" and opening.hinge is None):
                continue
            centre = a + along * (opening.start + opening.width / 2)
            fronts = [tuple((centre + side * normal * (wall.thickness / 2 + _APPROACH)).tolist()) for side in (1, -1)]
            approaches = [(room, front) for front in fronts for room, floor in floors.items() if floor.covers(shapely.Point(front))]
            if len(approaches) == 2:
                doorways.append((opening.id, tuple(centre.tolist()), approaches))
    return doorways


def _round(floor: shapely.Polygon) -> list[Point2]:
    """Corners of the widest comfortable round through a room."""
    import shapely

    for inset in (1.1, 0.8, 0.45, 0.3):
        parts = [part for part in shapely.get_parts(floor.buffer(-inset, join_style="mitre").simplify(0.05)) if part.area > 0.01]
        if parts and not (_leads_round(floor) and len(parts) > 1):
            return list(max(parts, key=lambda part: part.area).exterior.coords[:-1])
    return [shapely.maximum_inscribed_circle(floor).coords[0]]


def _leads_round(floor: shapely.Geometry) -> bool:
    """Whether a floor has a hole that a room may stand in."""
    import shapely

    return any(shapely.Polygon(ring).area > 2.0 for part in shapely.get_parts(floor) for ring in part.interiors)


def _connect(graph: nx.Graph, nodes: list[Point2], clear: shapely.Geometry) -> None:
    """Join all pairs of nodes that see each other over clear floor."""
    import shapely

    graph.add_nodes_from(nodes)
    pairs = list(itertools.combinations(nodes, 2))
    if pairs:
        lines = shapely.linestrings(np.asarray(pairs))
        for (a, b), free, length in zip(pairs, shapely.covers(clear, lines), shapely.length(lines), strict=True):
            if free:
                graph.add_edge(a, b, weight=float(length))


def _beyond(end: Point2, other: Point2) -> Point2:
    """Point half a metre outside the given end of a flight."""
    a, b = np.asarray(end), np.asarray(other)
    x, y = a + (a - b) / np.linalg.norm(a - b) * 0.5
    return float(x), float(y)
