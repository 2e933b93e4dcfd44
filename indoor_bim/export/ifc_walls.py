"""Walls, their types and their joints.

A wall's body is its footprint swept upwards: footprints meet without overlap, so the bodies do, whatever the kind of joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from indoor_bim.export.ifc_file import Entity, IfcFile, Point3
from indoor_bim.export.ifc_properties import add_common, add_evidence, add_quantities
from indoor_bim.model import Joint, Outline, Ring, Wall

_CONNECTION = {"start": "ATSTART", "end": "ATEND", "path": "ATPATH"}
_RECTANGLE_TOLERANCE = 1e-8


@dataclass(frozen=True, slots=True)
class WallType:
    """Wall type, its layer set and the walls that have it."""

    entity: Entity
    layers: Entity
    walls: list[Entity] = field(default_factory=list)


def add_wall_types(ifc: IfcFile, project: Entity, walls: Sequence[Wall]) -> dict[int, WallType]:
    """Add one wall type with its layer set per thickness, told apart by whole millimetres; names are rounded to 5 mm."""
    if not walls:
        return {}
    material = ifc.create("IfcMaterial", "Unknown")
    types = {}
    for thickness in sorted({millimetres(wall.thickness) for wall in walls}):
        name = f"Wall {5 * round(thickness / 5)}"
        layers = ifc.create("IfcMaterialLayerSet", [ifc.create("IfcMaterialLayer", material, thickness / 1000)], name)
        entity = ifc.root("IfcWallType", f"{thickness}", Name=name, Description=f"{thickness} mm", PredefinedType="SOLIDWALL")
        ifc.root("IfcRelAssociatesMaterial", f"type/{thickness}", RelatedObjects=[entity], RelatingMaterial=layers)
        types[thickness] = WallType(entity, layers)
    ifc.root("IfcRelDeclares", "types", RelatingContext=project, RelatedDefinitions=[t.entity for t in types.values()])
    return types


def relate_wall_types(ifc: IfcFile, types: Mapping[int, WallType]) -> None:
    """Give every wall its type, once all walls are there."""
    for thickness, wall_type in types.items():
        ifc.root("IfcRelDefinesByType", f"{thickness}", RelatedObjects=wall_type.walls, RelatingType=wall_type.entity)


def millimetres(length: float) -> int:
    """Length in whole millimetres, at least one."""
    return max(1, round(length * 1000))


def add_wall(ifc: IfcFile, wall: Wall, container: Entity, elevation: float, wall_type: WallType) -> Entity:
    """Add a wall with axis, body, layers, properties and quantities to the storey `container`, whose floor is at `elevation` metres."""
    (x, y), _ = wall.axis
    local = _along_axis(wall)
    if _is_rectangle(local, wall):
        profile = ifc.rectangle_profile(wall.length, wall.thickness, centre=(wall.length / 2, 0.0))
    else:
        profile = ifc.ring_profile(local)
    element = ifc.element(
        "IfcWall",
        wall,
        Name=wall.name,
        Tag=wall.id,
        ObjectPlacement=ifc.placement((x, y, wall.base - elevation), x=_direction(wall), relative_to=container.ObjectPlacement),
        Representation=ifc.shape([ifc.extrusion(profile, wall.height)], axis=ifc.polyline([(0.0, 0.0), (wall.length, 0.0)]), colour="wall"),
    )
    add_common(ifc, element, "Pset_WallCommon", external=wall.external)
    footprint = Outline(local)
    cut_area, cut_volume = _cut_by_openings(footprint, wall)
    spelling = "Footprint" if ifc.schema == "IFC4" else "FootPrint"
    add_quantities(
        ifc,
        element,
        "Qto_WallBaseQuantities",
        {
            "Length": wall.length,
            "Width": wall.thickness,
            "Height": wall.height,
            f"Gross{spelling}Area": footprint.area,
            "GrossSideArea": wall.length * wall.height,
            "NetSideArea": wall.length * wall.height - cut_area,
            "GrossVolume": footprint.area * wall.height,
            "NetVolume": footprint.area * wall.height - cut_volume,
        },
    )
    usage = ifc.create("IfcMaterialLayerSetUsage", wall_type.layers, "AXIS2", "POSITIVE", -millimetres(wall.thickness) / 2000)
    ifc.root("IfcRelAssociatesMaterial", element.GlobalId, RelatedObjects=[element], RelatingMaterial=usage)
    wall_type.walls.append(element)
    add_evidence(ifc, element, wall.evidence, ThicknessMeasured=("IfcBoolean", wall.thickness_measured))
    return element


def connect(ifc: IfcFile, joints: Sequence[Joint], walls: Mapping[str, Entity]) -> None:
    """Relate the walls that meet, in pairs; where one runs through, the others meet it and not each other.

    Parameters
    ----------
    ifc : IfcFile
        File to add to.
    joints : sequence of Joint
        Joints of a storey; walls that are not there are passed over.
    walls : mapping of str to IfcWall
        Entities of the storey's walls.
    """
    pairs: dict[tuple[tuple[str, str], tuple[str, str]], None] = {}
    for joint in joints:
        members = sorted(zip(joint.walls, joint.ends, strict=True), key=lambda member: member[1] == "path")
        for related, relating in combinations([member for member in members if member[0] in walls], 2):
            if "path" not in joint.ends or "path" in (related[1], relating[1]):
                pairs[relating, related] = None
    for (relating_id, relating_end), (related_id, related_end) in pairs:
        ifc.root(
            "IfcRelConnectsPathElements",
            "/".join((walls[relating_id].GlobalId, relating_end, walls[related_id].GlobalId, related_end)),
            RelatingElement=walls[relating_id],
            RelatedElement=walls[related_id],
            RelatingPriorities=[],
            RelatedPriorities=[],
            RelatingConnectionType=_CONNECTION[relating_end],
            RelatedConnectionType=_CONNECTION[related_end],
        )


def _direction(wall: Wall) -> Point3:
    (x0, y0), (x1, y1) = wall.axis
    return ((x1 - x0) / wall.length, (y1 - y0) / wall.length, 0.0)


def _along_axis(wall: Wall) -> Ring:
    """Footprint in the wall's own coordinates: origin at the first end of the axis, x along it."""
    (x0, y0), _ = wall.axis
    ux, uy, _ = _direction(wall)
    return tuple(((x - x0) * ux + (y - y0) * uy, (y - y0) * ux - (x - x0) * uy) for x, y in wall.footprint)


def _is_rectangle(local: Ring, wall: Wall) -> bool:
    half = wall.thickness / 2
    corners = [(0.0, -half), (0.0, half), (wall.length, -half), (wall.length, half)]
    near = [[max(abs(x - cx), abs(y - cy)) <= _RECTANGLE_TOLERANCE for x, y in local] for cx, cy in corners]
    return len(local) == 4 and all(any(hits) for hits in near)


def _cut_by_openings(footprint: Outline, wall: Wall) -> tuple[float, float]:
    """Side area and volume that the openings take from a wall."""
    import shapely

    cuts = [
        shapely.box(opening.start, opening.sill, opening.start + opening.width, min(opening.sill + opening.height, wall.height))
        for opening in wall.openings
        if opening.sill < wall.height
    ]
    side = shapely.union_all(cuts).intersection(shapely.box(0.0, 0.0, wall.length, wall.height)).area
    reach = wall.thickness
    volume = 0.0
    for cut in cuts:
        x0, z0, x1, z1 = cut.bounds
        strip = shapely.box(x0, -reach, x1, reach)
        volume += float(strip.intersection(footprint.polygon).area) * (z1 - z0)
    return float(side), volume
