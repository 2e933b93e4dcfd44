"""Rules beyond the schema that concern scanned buildings; codes name the rule of buildingSMART's validation service that a rule follows.

Source of the codes: github.com/buildingSMART/ifc-gherkin-rules. Each rule takes an open IFC file and yields the entities that break it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

Breach = tuple[Any, str]
_UNREFERENCED = ("IfcStyledItem",)
_PRECISION = 1e-5


def contexts_have_subcontexts(file: Any) -> Iterator[Breach]:
    """GEM052: geometry lies in subcontexts, so every context has one."""
    for context in file.by_type("IfcGeometricRepresentationContext", include_subtypes=False):
        if not context.HasSubContexts:
            yield context, "a context without subcontext"


def spaces_have_one_body(file: Any) -> Iterator[Breach]:
    """GEM002: a space has exactly one body."""
    for space in file.by_type("IfcSpace"):
        shapes = space.Representation.Representations if space.Representation else ()
        count = sum(shape.RepresentationIdentifier == "Body" for shape in shapes)
        if count != 1:
            yield space, f"expected one Body representation, found {count}"


def spatial_structure_has_no_shape(file: Any) -> Iterator[Breach]:
    """Buildings and storeys have no representation of their own."""
    for kind in ("IfcBuilding", "IfcBuildingStorey"):
        for element in file.by_type(kind):
            if element.Representation:
                yield element, "a spatial element with a representation"


def elements_stand_in_the_spatial_structure(file: Any) -> Iterator[Breach]:
    """An element belongs to a spatial element, to a whole, or to the element that it cuts."""
    for element in file.by_type("IfcElement"):
        placed = element.ContainedInStructure or element.Decomposes or getattr(element, "VoidsElements", ())
        if not placed and not element.is_a("IfcVirtualElement"):
            yield element, "belongs to no storey and no other element"


def openings_cut_something(file: Any) -> Iterator[Breach]:
    """An opening without a host cuts nothing."""
    for opening in file.by_type("IfcOpeningElement"):
        if not opening.VoidsElements:
            yield opening, "an opening that cuts no element"


def typed_occurrences_leave_the_predefined_type(file: Any) -> Iterator[Breach]:
    """OJT001: where the type says what kind it is, the occurrence does not say it again."""
    for relation in file.by_type("IfcRelDefinesByType"):
        if getattr(relation.RelatingType, "PredefinedType", None) in (None, "NOTDEFINED"):
            continue
        for element in relation.RelatedObjects:
            if getattr(element, "PredefinedType", None) is not None:
                yield element, "PredefinedType is given by the element and by its type"


def standard_sets_are_standard(file: Any) -> Iterator[Breach]:
    """PSE001, PSE002: names that begin with Pset or Qto belong to the standard, and so do their properties."""
    from ifcopenshell.util.pset import get_template

    templates = get_template(file.schema_identifier)
    for entity, prefix, members in (("IfcPropertySet", "pset", "HasProperties"), ("IfcElementQuantity", "qto", "Quantities")):
        for group in file.by_type(entity):
            if not (group.Name or "").lower().startswith(prefix):
                continue
            template = templates.get_by_name(group.Name)
            if template is None:
                yield group, f"{group.Name} is not a set of {file.schema}; own sets need another prefix"
                continue
            known = {item.Name for item in template.HasPropertyTemplates}
            unknown = sorted(member.Name for member in getattr(group, members) if member.Name not in known)
            if unknown:
                yield group, f"{group.Name} of {file.schema} has no {', '.join(unknown)}"


def base_quantities_name_their_method(file: Any) -> Iterator[Breach]:
    """Standard quantity sets are measured as BaseQuantities."""
    for group in file.by_type("IfcElementQuantity"):
        if (group.Name or "").startswith("Qto_") and group.MethodOfMeasurement != "BaseQuantities":
            yield group, "MethodOfMeasurement is not BaseQuantities"


def contexts_share_the_map(file: Any) -> Iterator[Breach]:
    """GRF001: where one context has a map conversion, all have one."""
    contexts = file.by_type("IfcGeometricRepresentationContext", include_subtypes=False)
    if any(context.HasCoordinateOperation for context in contexts):
        for context in contexts:
            if not context.HasCoordinateOperation:
                yield context, "a context without the map conversion that others have"


def spaces_are_not_deprecated(file: Any) -> Iterator[Breach]:
    """IFC102: the types INTERNAL and EXTERNAL of a space are gone in IFC4X3."""
    if file.schema == "IFC4X3":
        for space in file.by_type("IfcSpace"):
            if space.PredefinedType in ("INTERNAL", "EXTERNAL"):
                yield space, f"the space type {space.PredefinedType} is deprecated, use SPACE"


def geometry_is_used(file: Any) -> Iterator[Breach]:
    """IFC105: every geometric item is part of something."""
    for item in file.by_type("IfcRepresentationItem"):
        if not any(item.is_a(kind) for kind in _UNREFERENCED) and not file.get_total_inverses(item):
            yield item, "a geometric item that nothing refers to"


def polylines_repeat_no_point(file: Any) -> Iterator[Breach]:
    """GEM111: no point of a polyline lies at another one, but a closed polyline ends with the very point it starts with."""
    for polyline in file.by_type("IfcPolyline"):
        points = list(polyline.Points)
        if len(points) > 2 and points[0] == points[-1]:
            points.pop()
        if len({tuple(round(c / _PRECISION) for c in point.Coordinates) for point in points}) < len(points):
            yield polyline, "a polyline with a repeated point"


def profiles_do_not_cross_themselves(file: Any) -> Iterator[Breach]:
    """GEM010: the outlines of a profile do not intersect themselves, and its holes lie within it."""
    import shapely

    for profile in file.by_type("IfcArbitraryClosedProfileDef"):
        curves = [profile.OuterCurve, *(getattr(profile, "InnerCurves", None) or ())]
        if not all(curve.is_a("IfcPolyline") for curve in curves):
            continue
        rings = [[point.Coordinates for point in curve.Points] for curve in curves]
        if any(len(ring) < 4 for ring in rings) or not shapely.Polygon(rings[0], rings[1:]).is_valid:
            yield profile, "an outline that crosses itself or its holes"


def units_are_given(file: Any) -> Iterator[Breach]:
    """Lengths, areas, volumes and angles have a unit."""
    for project in file.by_type("IfcProject"):
        units = project.UnitsInContext.Units if project.UnitsInContext else ()
        kinds = {getattr(unit, "UnitType", None) for unit in units}
        missing = [kind for kind in ("LENGTHUNIT", "AREAUNIT", "VOLUMEUNIT", "PLANEANGLEUNIT") if kind not in kinds]
        if missing:
            yield project, f"no unit for {', '.join(missing)}"


RULES: tuple[Callable[[Any], Iterator[Breach]], ...] = (
    contexts_have_subcontexts,
    spaces_have_one_body,
    spatial_structure_has_no_shape,
    elements_stand_in_the_spatial_structure,
    openings_cut_something,
    typed_occurrences_leave_the_predefined_type,
    standard_sets_are_standard,
    base_quantities_name_their_method,
    contexts_share_the_map,
    spaces_are_not_deprecated,
    geometry_is_used,
    polylines_repeat_no_point,
    profiles_do_not_cross_themselves,
    units_are_given,
)
