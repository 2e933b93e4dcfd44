"""First-level space boundaries: the surfaces of a room that walls, floor and ceiling bound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import hypot

from indoor_bim.export.ifc_file import PRECISION, Entity, IfcFile, Point3
from indoor_bim.model import Point2, Room, Slab, Wall

_FACE_TOLERANCE = 0.02
_MIN_CONTACT_AREA = 1e-4
_COVERED = 0.999
Rings = Sequence[Sequence[Point2]]


def add_boundaries(
    ifc: IfcFile, room: Room, space: Entity, walls: Sequence[tuple[Wall, Entity]], slabs: Sequence[tuple[Slab, Entity]]
) -> None:
    """Relate a room to the walls that the model names and to the slabs above and below it.

    Parameters
    ----------
    ifc : IfcFile
        File to add to.
    room : Room
        Room of the model.
    space : IfcSpace
        Its entity, placed at its floor.
    walls, slabs : sequence of (element, entity)
        Walls and slabs of the storey.
    """
    for wall, entity in walls:
        if wall.id not in room.walls:
            continue
        side = {True: "EXTERNAL", False: "INTERNAL", None: "NOTDEFINED"}[wall.external]
        surfaces: list[Entity | None] = [_wall_surface(ifc, a, b, room.height) for a, b in _edges_along(room, wall)]
        for i, surface in enumerate(surfaces or [None]):
            _add_boundary(ifc, f"{room.id}/{wall.id}/{i}", space, entity, side, surface)
    polygon = room.outline.polygon
    for slab, entity in slabs:
        contact = float(slab.outline.polygon.intersection(polygon).area)
        if contact < _MIN_CONTACT_AREA:
            continue
        surface = _slab_surface(ifc, room, slab) if contact > _COVERED * polygon.area else None
        _add_boundary(ifc, f"{room.id}/{slab.id}", space, entity, "NOTDEFINED", surface)


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
