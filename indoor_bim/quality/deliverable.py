"""What every delivered IFC file holds, as an Information Delivery Specification (buildingSMART IDS 1.0)."""

from __future__ import annotations

from typing import Any

TITLE = "Indoor BIM deliverable"
_VERSIONS = ["IFC4", "IFC4X3_ADD2"]


def deliverable() -> Any:
    """Return the specification; `schemas/deliverable.ids` is its XML.

    Returns
    -------
    ifctester.ids.Ids
        Specifications for walls, doors, windows, slabs and spaces.
    """
    from ifctester import ids

    document = ids.Ids(title=TITLE, description="Elements are placed, measured and say what they rest on.")

    def specify(name: str, entity: str, *requirements: Any) -> None:
        specification = ids.Specification(name=name, ifcVersion=_VERSIONS, minOccurs=0)
        specification.applicability.append(ids.Entity(name=entity))
        specification.requirements.extend(requirements)
        document.specifications.append(specification)

    def quantity(group: str, name: str, kind: str) -> Any:
        return ids.Property(propertySet=f"Qto_{group}BaseQuantities", baseName=name, dataType=kind)

    def contained() -> Any:
        return ids.PartOf(name="IFCBUILDINGSTOREY", relation="IFCRELCONTAINEDINSPATIALSTRUCTURE")

    def evidence() -> Any:
        return ids.Property(propertySet="IndoorBim_Evidence", baseName="Support", dataType="IFCINTEGER")

    def external(group: str) -> Any:
        return ids.Property(propertySet=f"Pset_{group}Common", baseName="IsExternal", dataType="IFCBOOLEAN", cardinality="optional")

    specify(
        "Walls are named, layered, measured and stand in a storey",
        "IFCWALL",
        ids.Attribute(name="Name"),
        ids.Material(),
        contained(),
        external("Wall"),
        quantity("Wall", "Length", "IFCLENGTHMEASURE"),
        quantity("Wall", "Width", "IFCLENGTHMEASURE"),
        quantity("Wall", "Height", "IFCLENGTHMEASURE"),
        quantity("Wall", "NetVolume", "IFCVOLUMEMEASURE"),
        evidence(),
        ids.Property(propertySet="IndoorBim_Evidence", baseName="ThicknessMeasured", dataType="IFCBOOLEAN"),
    )
    for entity, group in (("IFCDOOR", "Door"), ("IFCWINDOW", "Window")):
        specify(
            f"{group}s have a size and stand in a storey",
            entity,
            ids.Attribute(name="OverallWidth"),
            ids.Attribute(name="OverallHeight"),
            contained(),
            external(group),
            quantity(group, "Area", "IFCAREAMEASURE"),
            evidence(),
        )
    specify(
        "Slabs are measured and stand in a storey",
        "IFCSLAB",
        contained(),
        quantity("Slab", "Width", "IFCLENGTHMEASURE"),
        quantity("Slab", "NetArea", "IFCAREAMEASURE"),
        evidence(),
    )
    specify(
        "Spaces are named, measured and belong to a storey",
        "IFCSPACE",
        ids.Attribute(name="Name"),
        ids.Attribute(name="LongName"),
        ids.PartOf(name="IFCBUILDINGSTOREY", relation="IFCRELAGGREGATES"),
        quantity("Space", "Height", "IFCLENGTHMEASURE"),
        quantity("Space", "NetFloorArea", "IFCAREAMEASURE"),
        quantity("Space", "NetVolume", "IFCVOLUMEMEASURE"),
        evidence(),
    )
    return document


def deliverable_xml() -> str:
    """Return the specification as XML text."""
    import xml.etree.ElementTree as ElementTree

    root = ElementTree.fromstring(deliverable().to_string())
    ElementTree.indent(root)
    ElementTree.register_namespace("", "http://standards.buildingsmart.org/IDS")
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=False) + "\n"
