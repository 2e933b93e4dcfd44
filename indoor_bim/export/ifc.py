"""The building model as an IFC file: Project > Site > Building > Storeys > elements and spaces, in metres."""

from __future__ import annotations

import os

from indoor_bim.export.files import write_text
from indoor_bim.export.ifc_elements import add_storey_elements
from indoor_bim.export.ifc_file import Entity, IfcFile, Schema
from indoor_bim.export.ifc_georeference import add_georeference
from indoor_bim.export.ifc_openings import FillingTypes
from indoor_bim.export.ifc_properties import add_properties
from indoor_bim.export.ifc_walls import add_wall_types, relate_wall_types
from indoor_bim.model import Building


def write_ifc(building: Building, path: str | os.PathLike[str], *, schema: Schema = "IFC4") -> None:
    """Write a building as IFC; equal buildings give equal bytes.

    GUIDs are those of the model, or made of the name of the scan and the identifiers in the model. A building without storeys
    gives a valid file whose building says why. Map coordinates are written only when the scan's coordinate reference system is known.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        IFC file (STEP) to create or to replace.
    schema : {"IFC4", "IFC4X3"}
        Schema of the file.

    Raises
    ------
    WriteError
        If the file cannot be written; what stood at `path` before stays.
    """
    write_text(path, to_ifc(building, schema=schema))


def to_ifc(building: Building, *, schema: Schema = "IFC4") -> str:
    """Return a building as the text of an IFC file.

    Parameters
    ----------
    building : Building
        Model, metres.
    schema : {"IFC4", "IFC4X3"}
        Schema of the file.

    Returns
    -------
    str
        STEP physical file.

    Examples
    --------
    >>> text = to_ifc(Building("Empty", warnings=("No walls were found.",)))
    >>> "FILE_SCHEMA(('IFC4'))" in text, "No walls were found." in text
    (True, True)
    """
    ifc = IfcFile(schema, building.source)
    project = ifc.root(
        "IfcProject",
        "",
        Name=building.name,
        RepresentationContexts=[ifc.model_context, ifc.plan_context],
        UnitsInContext=ifc.create("IfcUnitAssignment", ifc.units),
    )
    placement = ifc.placement((0.0, 0.0, 0.0))
    site = ifc.root("IfcSite", "", Name="Site", ObjectPlacement=placement, CompositionType="ELEMENT")
    house = ifc.root(
        "IfcBuilding",
        "",
        Name=building.name,
        Description=" ".join(building.warnings) or None,
        ObjectPlacement=ifc.placement((0.0, 0.0, 0.0), relative_to=placement),
        CompositionType="ELEMENT",
    )
    ifc.aggregate(project, [site], "project")
    ifc.aggregate(site, [house], "site")
    add_georeference(ifc, building)
    _add_reconstruction(ifc, house, building)
    wall_types = add_wall_types(ifc, project, [wall for storey in building.storeys for wall in storey.walls])
    filling_types = FillingTypes()
    containers = [
        ifc.root(
            "IfcBuildingStorey",
            storey.id,
            Name=storey.name,
            ObjectPlacement=ifc.placement((0.0, 0.0, storey.elevation), relative_to=house.ObjectPlacement),
            CompositionType="ELEMENT",
            Elevation=storey.elevation,
        )
        for storey in building.storeys
    ]
    ifc.aggregate(house, containers, "building")
    for storey, container in zip(building.storeys, containers, strict=True):
        add_storey_elements(ifc, storey, container, wall_types, filling_types)
    relate_wall_types(ifc, wall_types)
    filling_types.relate(ifc, project)
    return ifc.text(f"{building.name}.ifc")


def _add_reconstruction(ifc: IfcFile, house: Entity, building: Building) -> None:
    """Attach where the model comes from and what is doubtful about it."""
    add_properties(
        ifc,
        house,
        "IndoorBim_Reconstruction",
        {
            "Source": ("IfcText", building.source) if building.source else None,
            "Method": ("IfcLabel", building.method) if building.method else None,
            "Warnings": [("IfcText", warning) for warning in building.warnings] or None,
            "TransformCloudToModel": [("IfcReal", value) for row in building.transform_cloud_to_model for value in row],
        },
    )
