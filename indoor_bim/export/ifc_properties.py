"""Property sets and base quantities of IFC elements."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from indoor_bim.export.ifc_file import Entity, IfcFile
from indoor_bim.model import Evidence

Value = tuple[str, Any]
_QUANTITY_KINDS = {"Area": "IfcQuantityArea", "Volume": "IfcQuantityVolume"}


def add_properties(ifc: IfcFile, element: Entity, name: str, values: Mapping[str, Value | list[Value] | None]) -> None:
    """Attach a property set; values that are None are left out, and so is a set without values.

    Parameters
    ----------
    ifc : IfcFile
        File that holds `element`.
    element : entity
        Element that the properties belong to.
    name : str
        Name of the set.
    values : mapping
        Property name to (IFC type, value), or to a list of them.
    """
    properties = [_property(ifc, key, value) for key, value in values.items() if value is not None]
    if properties:
        _attach(ifc, element, name, ifc.root("IfcPropertySet", f"{element.GlobalId}/{name}", Name=name, HasProperties=properties))


def add_common(ifc: IfcFile, element: Entity, name: str, *, external: bool | None = None) -> None:
    """Attach a ``Pset_*Common`` set: the element stands (a scan shows nothing else); external or not only where known."""
    status = ifc.create("IfcPropertyEnumeratedValue", "Status", None, [ifc.create("IfcLabel", "EXISTING")], _element_status(ifc))
    properties = [status]
    if external is not None:
        properties.append(_property(ifc, "IsExternal", ("IfcBoolean", external)))
    _attach(ifc, element, name, ifc.root("IfcPropertySet", f"{element.GlobalId}/{name}", Name=name, HasProperties=properties))


def add_evidence(ifc: IfcFile, element: Entity, evidence: Evidence, **more: Value | None) -> None:
    """Attach what the element rests on, and its uncertainty where the schema has a set for it.

    Parameters
    ----------
    ifc : IfcFile
        File that holds `element`.
    element : entity
        Element of the building.
    evidence : Evidence
        Its evidence.
    **more
        Further properties of the evidence set, as (IFC type, value).
    """
    add_properties(
        ifc,
        element,
        "IndoorBim_Evidence",
        {
            "Support": ("IfcInteger", evidence.support),
            "Coverage": ("IfcNormalisedRatioMeasure", float(evidence.coverage)),
            "Rmse": _length(evidence.rmse),
            "SidesSeen": ("IfcInteger", evidence.sides),
            "Deviation": _length(evidence.deviation),
            "PositionSigma": _length(evidence.position_sigma),
            "DirectionSigma": None
            if evidence.direction_sigma is None
            else ("IfcPlaneAngleMeasure", math.radians(evidence.direction_sigma)),
            **more,
        },
    )
    if ifc.schema == "IFC4X3" and evidence.rmse:
        name = "Pset_Uncertainty"
        basis = ifc.create("IfcPropertyEnumeratedValue", "UncertaintyBasis", None, [ifc.create("IfcLabel", "MEASUREMENT")])
        rmse = _property(ifc, "LinearUncertainty", ("IfcPositiveLengthMeasure", float(evidence.rmse)))
        _attach(ifc, element, name, ifc.root("IfcPropertySet", f"{element.GlobalId}/{name}", Name=name, HasProperties=[basis, rmse]))


def _length(metres: float | None) -> Value | None:
    return None if metres is None else ("IfcLengthMeasure", float(metres))


def add_quantities(ifc: IfcFile, element: Entity, name: str, values: Mapping[str, float]) -> None:
    """Attach base quantities; the last word of a quantity's name tells its kind (…Area, …Volume, else a length).

    Parameters
    ----------
    ifc : IfcFile
        File that holds `element`.
    element : entity
        Element of the building.
    name : str
        ``Qto_*BaseQuantities``.
    values : mapping of str to float
        Metres, square metres, cubic metres.
    """
    quantities = []
    for key, value in values.items():
        kind = next((entity for ending, entity in _QUANTITY_KINDS.items() if key.endswith(ending)), "IfcQuantityLength")
        quantities.append(ifc.create(kind, key, None, None, float(value)))
    quantity_set = ifc.root(
        "IfcElementQuantity", f"{element.GlobalId}/{name}", Name=name, MethodOfMeasurement="BaseQuantities", Quantities=quantities
    )
    _attach(ifc, element, name, quantity_set)


def _attach(ifc: IfcFile, element: Entity, name: str, definition: Entity) -> None:
    key = f"{element.GlobalId}/{name}"
    ifc.root("IfcRelDefinesByProperties", key, RelatedObjects=[element], RelatingPropertyDefinition=definition)


def _property(ifc: IfcFile, name: str, value: Value | list[Value]) -> Entity:
    if isinstance(value, tuple):
        return ifc.create("IfcPropertySingleValue", name, None, ifc.create(*value))
    return ifc.create("IfcPropertyListValue", name, None, [ifc.create(kind, content) for kind, content in value])


def _element_status(ifc: IfcFile) -> Entity:
    existing = ifc.file.by_type("IfcPropertyEnumeration")
    if existing:
        return existing[0]
    names = ("NEW", "EXISTING", "DEMOLISH", "TEMPORARY", "OTHER", "NOTKNOWN", "UNSET")
    return ifc.create("IfcPropertyEnumeration", "PEnum_ElementStatus", [ifc.create("IfcLabel", name) for name in names])
