"""Houses as an IFC file: a site with its terrain, and on it one building for each house, with walls, floor and roof."""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np

from indoor_bim.export.files import write_text
from indoor_bim.export.ifc_elements import add_storey_elements
from indoor_bim.export.ifc_file import Entity, IfcFile, Schema
from indoor_bim.export.ifc_georeference import add_georeference
from indoor_bim.export.ifc_openings import FillingTypes
from indoor_bim.export.ifc_properties import add_common, add_evidence, add_properties, add_quantities
from indoor_bim.export.ifc_walls import add_wall_types, relate_wall_types
from indoor_bim.model import Building, Joint, Outline, Point2, Slab, Storey, Wall
from indoor_bim.outdoor.model import House, Village

WALL_THICKNESS = 0.3
SLAB_THICKNESS = 0.2


def write_houses_ifc(village: Village, path: str | os.PathLike[str], *, schema: Schema = "IFC4") -> None:
    """Write a village as IFC; equal villages give equal bytes.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    path : path
        IFC file (STEP) to create or to replace.
    schema : {"IFC4", "IFC4X3"}
        Schema of the file.

    Raises
    ------
    WriteError
        If the file cannot be written; what stood at `path` before stays.
    """
    write_text(path, houses_ifc(village, schema=schema))


def houses_ifc(village: Village, *, schema: Schema = "IFC4") -> str:
    """Return a village as the text of an IFC file.

    Walls stand inside the measured outer faces; their thickness, and that of floor and roof, is assumed and says so.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    schema : {"IFC4", "IFC4X3"}
        Schema of the file.
    """
    ifc = IfcFile(schema, village.source)
    project = ifc.root(
        "IfcProject",
        "",
        Name=village.name,
        RepresentationContexts=[ifc.model_context, ifc.plan_context],
        UnitsInContext=ifc.create("IfcUnitAssignment", ifc.units),
    )
    site = ifc.root("IfcSite", "", Name=village.name, ObjectPlacement=ifc.placement((0.0, 0.0, 0.0)), CompositionType="ELEMENT")
    ifc.aggregate(project, [site], "project")
    add_georeference(
        ifc, Building(village.name, transform_cloud_to_model=village.transform_cloud_to_model, crs=village.crs, source=village.source)
    )
    add_properties(
        ifc,
        site,
        "IndoorBim_Reconstruction",
        {
            "Source": ("IfcText", village.source) if village.source else None,
            "Method": ("IfcLabel", village.method) if village.method else None,
            "Warnings": [("IfcText", warning) for warning in village.warnings] or None,
            "TransformCloudToModel": [("IfcReal", value) for row in village.transform_cloud_to_model for value in row],
        },
    )
    if village.ground.triangles:
        _add_terrain(ifc, village, site)
    storeys = [house_storey(house) for house in village.houses]
    wall_types = add_wall_types(ifc, project, [wall for storey in storeys for wall in storey.walls])
    filling_types = FillingTypes()
    buildings = [_add_building(ifc, house, site) for house in village.houses]
    ifc.aggregate(site, buildings, "site")
    for house, storey, building in zip(village.houses, storeys, buildings, strict=True):
        container = ifc.root(
            "IfcBuildingStorey",
            storey.id,
            Name=storey.name,
            ObjectPlacement=ifc.placement((0.0, 0.0, 0.0), relative_to=building.ObjectPlacement),
            CompositionType="ELEMENT",
            Elevation=0.0,
        )
        ifc.aggregate(building, [container], house.id)
        add_storey_elements(ifc, storey, container, wall_types, filling_types)
        _add_roof(ifc, house, container)
    relate_wall_types(ifc, wall_types)
    filling_types.relate(ifc, project)
    return ifc.text(f"{village.name}.ifc")


def house_storey(house: House) -> Storey:
    """One storey from base to eave that holds the walls and the floor of a house.

    Parameters
    ----------
    house : House
        House, metres.
    """
    inner, thickness = _inner_ring(house)
    walls = tuple(_walls(house, inner, thickness))
    joints = tuple(
        Joint(corner, (before.id, after.id), ("end", "start"))
        for corner, before, after in zip((wall.axis[0] for wall in walls), (walls[-1], *walls[:-1]), walls, strict=True)
    )
    floor = Slab(f"{house.id}-floor", "Floor", "floor", Outline.from_polygon(house.polygon), house.base, SLAB_THICKNESS)
    return Storey(f"{house.id}-storey", "Ground floor", house.base, house.height, walls, joints, slabs=(floor,))


def _walls(house: House, inner: list[Point2], thickness: float) -> Iterator[Wall]:
    count = len(house.footprint)
    for i in range(count):
        j = (i + 1) % count
        a, b, c, d = house.footprint[i], house.footprint[j], inner[j], inner[i]
        axis = (_middle(a, d), _middle(b, c))
        facade = house.facades[i]
        name = f"Wall {house.id}-{i + 1}" if facade.seen else f"Wall {house.id}-{i + 1}, not seen"
        yield Wall(
            f"{house.id}-wall-{i + 1}",
            name,
            axis,
            thickness,
            False,
            house.base,
            house.height,
            (a, b, c, d),
            external=True,
            evidence=facade.evidence,
        )


def _inner_ring(house: House) -> tuple[list[Point2], float]:
    """Inner corners of the walls, mitred, and a thickness that leaves room inside."""
    import shapely

    ring = np.array(house.footprint)
    thickness = WALL_THICKNESS
    while thickness > 0.01:
        inner = _offset(ring, thickness)
        polygon = shapely.Polygon(inner)
        quads = [
            shapely.Polygon([a, b, c, d])
            for a, b, c, d in zip(ring, np.roll(ring, -1, axis=0), np.roll(inner, -1, axis=0), inner, strict=True)
        ]
        if polygon.is_valid and polygon.exterior.is_ccw and all(quad.is_valid and quad.exterior.is_ccw for quad in quads):
            break
        thickness = round(thickness / 2, 3)
    return [(float(x), float(y)) for x, y in inner], thickness


def _offset(ring: np.ndarray, distance: float) -> np.ndarray:
    """Corners moved inwards so that every side moves by `distance`; on straight sides they move square to them."""
    ends = np.roll(ring, -1, axis=0)
    d = (ends - ring) / np.hypot(*(ends - ring).T)[:, None]
    n = np.column_stack([-d[:, 1], d[:, 0]])
    before = np.roll(n, 1, axis=0)
    bisector = before + n
    scale = distance / np.maximum((1 + (before * n).sum(axis=1)), 0.05)
    return np.asarray(ring + bisector * scale[:, None])


def _middle(a: Point2, b: Point2) -> Point2:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2


def _add_building(ifc: IfcFile, house: House, site: Entity) -> Entity:
    building = ifc.root(
        "IfcBuilding",
        house.id,
        Name=house.id,
        ObjectPlacement=ifc.placement((0.0, 0.0, house.base), relative_to=site.ObjectPlacement),
        CompositionType="ELEMENT",
    )
    add_properties(ifc, building, "Pset_BuildingCommon", {"NumberOfStoreys": ("IfcInteger", house.storeys)})
    add_quantities(
        ifc,
        building,
        "Qto_BuildingBaseQuantities",
        {"EavesHeight": house.height, f"Foot{'p' if ifc.schema == 'IFC4' else 'P'}rintArea": house.area},
    )
    more = {name.title().replace(" ", ""): ("IfcText", value) for name, value in house.attributes}
    if house.material is not None:
        more["Material"] = ("IfcText", house.material)
    add_properties(ifc, building, "IndoorBim_Attributes", more)
    return building


def _add_roof(ifc: IfcFile, house: House, container: Entity) -> None:
    roof = Slab(f"{house.id}-roof", "Roof", "ceiling", Outline.from_polygon(house.polygon), house.eave, SLAB_THICKNESS)
    element = ifc.element(
        "IfcSlab",
        roof,
        Name="Roof, flat at the eave",
        Tag=roof.id,
        ObjectPlacement=ifc.placement((0.0, 0.0, house.height), relative_to=container.ObjectPlacement),
        Representation=ifc.shape([ifc.extrusion(ifc.outline_profile(roof.outline), SLAB_THICKNESS)], colour="house"),
        PredefinedType="ROOF",
    )
    add_common(ifc, element, "Pset_SlabCommon", external=True)
    area = house.area
    add_quantities(
        ifc,
        element,
        "Qto_SlabBaseQuantities",
        {"Width": SLAB_THICKNESS, "Perimeter": house.polygon.exterior.length, "NetArea": area, "NetVolume": area * SLAB_THICKNESS},
    )
    add_evidence(ifc, element, house.evidence, ThicknessMeasured=("IfcBoolean", False))
    ifc.root("IfcRelContainedInSpatialStructure", roof.id, RelatedElements=[element], RelatingStructure=container)


def _add_terrain(ifc: IfcFile, village: Village, site: Entity) -> None:
    points = ifc.create("IfcCartesianPointList3D", [[float(c) for c in vertex] for vertex in village.ground.vertices])
    faces = ifc.create("IfcTriangulatedFaceSet", points, None, False, [[i + 1 for i in triangle] for triangle in village.ground.triangles])
    ifc.paint(faces, "ground")
    shape = ifc.create("IfcShapeRepresentation", ifc.body, "Body", "Tessellation", [faces])
    terrain = ifc.root(
        "IfcGeographicElement",
        "terrain",
        Name="Ground",
        ObjectPlacement=ifc.placement((0.0, 0.0, 0.0), relative_to=site.ObjectPlacement),
        Representation=ifc.create("IfcProductDefinitionShape", None, None, [shape]),
        PredefinedType="TERRAIN",
    )
    ifc.root("IfcRelContainedInSpatialStructure", "terrain", RelatedElements=[terrain], RelatingStructure=site)
