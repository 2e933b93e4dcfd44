"""First-level space boundaries: the surfaces of a room that walls, floor and ceiling bound."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import hypot

from indoor_bim.export.ifc_file import PRECISION, Entity, IfcFile, Point3
from indoor_bim.model import Point2, Room, Slab, Storey, Wall

_FACE_TOLERANCE = 0.02
_MIN_CONTACT_AREA = 1e-4
_COVERED = 0.999
Rings = Sequence[Sequence[Point2]]


def add_boundaries(ifc: IfcFile, storey: Storey, spaces: Sequence[Entity], walls: Mapping[str, Entity], slabs: Sequence[Entity]) -> None:
    """Relate every room to the walls that the model names for it and to the slabs above and below it.

    Parameters
    ----------
    ifc : IfcFile
        File to add to.
    storey : Storey
        Storey of the model.
    spaces : sequence of IfcSpace
        Entities of its rooms, placed at their floors.
    walls : mapping of str to IfcWall
        Entities of its walls.
    slabs : sequence of IfcSlab
        Entities of its slabs.
    """
    import shapely

    models = {wall.id: wall for wall in storey.walls}
    plates = [slab.outline.polygon for slab in storey.slabs]
    tree = shapely.STRtree(plates)
    for room, space in zip(storey.rooms, spaces, strict=True):
        for wall in (models[id] for id in dict.fromkeys(room.walls) if id in models):
            side = {True: "EXTERNAL", False: "INTERNAL", None: "NOTDEFINED"}[wall.external]
            surfaces: list[Entity | None] = [_wall_surface(ifc, a, b, room.height) for a, b in _edges_along(room, wall)]
            for i, surface in enumerate(surfaces or [None]):
                _add_boundary(ifc, f"{space.GlobalId}/{walls[wall.id].GlobalId}/{i}", space, walls[wall.id], side, surface)
        polygon = room.outline.polygon
        for i in sorted(tree.query(polygon).tolist()):
            slab, contact = storey.slabs[i], float(plates[i].intersection(polygon).area)
            if contact >= _MIN_CONTACT_AREA:
                covered = contact > _COVERED * polygon.area
                plate = _slab_surface(ifc, room, slab) if covered else None
                _add_boundary(ifc, f"{space.GlobalId}/{slabs[i].GlobalId}", space, slabs[i], "NOTDEFINED", plate)


def _add_boundary(ifc: IfcFile, key: str, space: Entity, element: Entity, side: str, surface: Entity | None) -> None:
    ifc.root(
        "IfcRelSpaceBoundary",
        key,
        Name="1stLevel",
        RelatingSpace=space,
        RelatedBuildingElement=element,
        ConnectionGeometry=surface,
        PhysicalOrVirtualBoundary="PHYSICAL",
        InternalOrExternalBoundary=side,
    )


def _edges_along(room: Room, wall: Wall) -> Iterator[tuple[Point2, Point2]]:
    """Edges of the room that lie on a face of the wall."""
    (x0, y0), (x1, y1) = wall.axis
    ux, uy = (x1 - x0) / wall.length, (y1 - y0) / wall.length
    reach = wall.thickness / 2 + _FACE_TOLERANCE
    for ring in (room.outline.exterior, *room.outline.holes):
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True):
            along = sorted((x - x0) * ux + (y - y0) * uy for x, y in (a, b))
            across = [(y - y0) * ux - (x - x0) * uy for x, y in (a, b)]
            length = hypot(b[0] - a[0], b[1] - a[1])
            overlap = min(along[1], wall.length + reach) - max(along[0], -reach)
            on_face = abs(across[1] - across[0]) <= _FACE_TOLERANCE and max(map(abs, across)) <= reach
            if length > PRECISION and on_face and overlap > length / 2:
                yield a, b


def _wall_surface(ifc: IfcFile, a: Point2, b: Point2, height: float) -> Entity:
    """Rectangle over a room edge; rooms lie to the left of their edges, so its normal points to the right, into the wall."""
    length = hypot(b[0] - a[0], b[1] - a[1])
    ux, uy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    return _surface(ifc, (*a, 0.0), (uy, -ux, 0.0), (ux, uy, 0.0), [[(0.0, 0.0), (length, 0.0), (length, height), (0.0, height)]])


def _slab_surface(ifc: IfcFile, room: Room, slab: Slab) -> Entity:
    """Outline of the room on its floor, seen from below, or on its ceiling, seen from above: the normal points into the slab."""
    sign, z = (-1.0, 0.0) if slab.kind == "floor" else (1.0, room.height)
    rings = [[(x, sign * y) for x, y in ring] for ring in (room.outline.exterior, *room.outline.holes)]
    return _surface(ifc, (0.0, 0.0, z), (0.0, 0.0, sign), (1.0, 0.0, 0.0), rings)


def _surface(ifc: IfcFile, origin: Point3, normal: Point3, x: Point3, rings: Rings) -> Entity:
    plane = ifc.create("IfcPlane", ifc.axes(origin, z=normal, x=x))
    outer, *inner = [ifc.polyline(ring, closed=True) for ring in rings]
    return ifc.create("IfcConnectionSurfaceGeometry", ifc.create("IfcCurveBoundedPlane", plane, outer, inner))
