"""What stands in a storey: walls with their openings, slabs, columns and spaces."""

from __future__ import annotations

from collections.abc import Mapping

from indoor_bim.export.ifc_boundaries import add_boundaries
from indoor_bim.export.ifc_file import Entity, IfcFile
from indoor_bim.export.ifc_openings import FillingTypes, add_opening
from indoor_bim.export.ifc_properties import add_common, add_evidence, add_properties, add_quantities
from indoor_bim.export.ifc_walls import WallType, add_wall, connect, millimetres
from indoor_bim.export.ifc_zones import add_zones
from indoor_bim.model import Column, Curve, Outline, Room, Slab, Storey


def add_storey_elements(
    ifc: IfcFile, storey: Storey, container: Entity, wall_types: Mapping[int, WallType], filling_types: FillingTypes
) -> None:
    """Add everything that stands in a storey.

    Parameters
    ----------
    ifc : IfcFile
        File to add to.
    storey : Storey
        Storey of the model.
    container : IfcBuildingStorey
        Its entity, placed at the storey's elevation.
    wall_types : mapping
        Thickness in whole millimetres to its wall type.
    filling_types : FillingTypes
        Types of doors and windows; new ones are added.
    """
    contained: list[Entity] = []
    walls: dict[str, Entity] = {}
    for wall in storey.walls:
        walls[wall.id] = add_wall(ifc, wall, container, storey.elevation, wall_types[millimetres(wall.thickness)])
        contained.append(walls[wall.id])
        for opening in wall.openings:
            contained.extend(add_opening(ifc, opening, wall, walls[wall.id], filling_types))
    connect(ifc, storey.joints, walls)
    for curve in storey.curves:
        _say_curve(ifc, curve, [walls[wall] for wall in curve.walls])
    slabs = [_add_slab(ifc, slab, container, storey.elevation) for slab in storey.slabs]
    columns = [_add_column(ifc, column, container, storey.elevation) for column in storey.columns]
    spaces = [_add_space(ifc, room, container, storey.elevation) for room in storey.rooms]
    add_boundaries(ifc, storey, spaces, walls, slabs)
    contained += slabs + columns
    if contained:
        ifc.root("IfcRelContainedInSpatialStructure", storey.id, RelatedElements=contained, RelatingStructure=container)
    ifc.aggregate(container, spaces, f"{storey.id}/spaces")
    add_zones(ifc, storey, spaces)


def _say_curve(ifc: IfcFile, curve: Curve, walls: list[Entity]) -> None:
    for wall in walls:
        add_properties(
            ifc,
            wall,
            "IndoorBim_Curve",
            {
                "Curve": ("IfcIdentifier", curve.id),
                "CentreX": ("IfcLengthMeasure", curve.centre[0]),
                "CentreY": ("IfcLengthMeasure", curve.centre[1]),
                "Radius": ("IfcPositiveLengthMeasure", curve.radius),
                "RadiusSigma": None if curve.radius_sigma is None else ("IfcLengthMeasure", curve.radius_sigma),
                "Deviation": None if curve.deviation is None else ("IfcLengthMeasure", curve.deviation),
                "ChainDeviation": ("IfcLengthMeasure", curve.chain_deviation),
            },
        )


def _add_slab(ifc: IfcFile, slab: Slab, container: Entity, elevation: float) -> Entity:
    foot = slab.level - slab.thickness if slab.kind == "floor" else slab.level
    kind = {"PredefinedType": "FLOOR"} if slab.kind == "floor" else {"PredefinedType": "USERDEFINED", "ObjectType": "CEILING"}
    element = ifc.element(
        "IfcSlab",
        slab,
        Name=slab.name,
        Tag=slab.id,
        ObjectPlacement=ifc.placement((0.0, 0.0, foot - elevation), relative_to=container.ObjectPlacement),
        Representation=ifc.shape([ifc.extrusion(ifc.outline_profile(slab.outline), slab.thickness)], colour=slab.kind),
        **kind,
    )
    add_common(ifc, element, "Pset_SlabCommon")
    area, volume = slab.outline.area, slab.outline.area * slab.thickness
    add_quantities(
        ifc,
        element,
        "Qto_SlabBaseQuantities",
        {"Width": slab.thickness, "Perimeter": slab.outline.polygon.exterior.length, "NetArea": area, "NetVolume": volume},
    )
    add_evidence(ifc, element, slab.evidence, ThicknessMeasured=("IfcBoolean", False))
    return element


def _add_column(ifc: IfcFile, column: Column, container: Entity, elevation: float) -> Entity:
    element = ifc.element(
        "IfcColumn",
        column,
        Name=column.name,
        Tag=column.id,
        PredefinedType="COLUMN",
        ObjectPlacement=ifc.placement((0.0, 0.0, column.base - elevation), relative_to=container.ObjectPlacement),
        Representation=ifc.shape([ifc.extrusion(ifc.ring_profile(column.footprint), column.height)], colour="column"),
    )
    add_common(ifc, element, "Pset_ColumnCommon")
    area = Outline(column.footprint).area
    values = {"Length": column.height, "CrossSectionArea": area, "NetVolume": area * column.height}
    add_quantities(ifc, element, "Qto_ColumnBaseQuantities", values)
    add_evidence(ifc, element, column.evidence)
    return element


def _add_space(ifc: IfcFile, room: Room, container: Entity, elevation: float) -> Entity:
    space = ifc.element(
        "IfcSpace",
        room,
        Name=room.id,
        LongName=room.name,
        CompositionType="ELEMENT",
        PredefinedType="SPACE",
        ObjectPlacement=ifc.placement((0.0, 0.0, room.floor - elevation), relative_to=container.ObjectPlacement),
        Representation=ifc.shape([ifc.extrusion(ifc.outline_profile(room.outline), room.height)], colour="space"),
    )
    add_properties(ifc, space, "Pset_SpaceCommon", {"IsExternal": ("IfcBoolean", False)})
    values = {
        "Height": room.height,
        "NetPerimeter": room.outline.polygon.length,
        "NetFloorArea": room.area,
        "NetVolume": room.area * room.height,
    }
    add_quantities(ifc, space, "Qto_SpaceBaseQuantities", values)
    add_evidence(ifc, space, room.evidence)
    return space
