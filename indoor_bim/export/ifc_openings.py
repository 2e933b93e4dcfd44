"""Openings in walls, and the doors and windows that fill them."""

from __future__ import annotations

from types import MappingProxyType

from indoor_bim.export.ifc_file import Entity, IfcFile
from indoor_bim.export.ifc_properties import add_common, add_evidence, add_quantities
from indoor_bim.model import Opening, Wall

OVERSHOOT = 0.05
_FRAME = 0.05
_PANEL = 0.04
_SIZE_STEP = 50  # millimetres
_HANDS = MappingProxyType({"SINGLE_SWING_LEFT": " left", "SINGLE_SWING_RIGHT": " right", "DOUBLE_DOOR_SINGLE_SWING": " double"})


class FillingTypes:
    """Door and window types, told apart by nominal size and operation, with the doors and windows that have them."""

    def __init__(self) -> None:
        self._types: dict[tuple[str, int, int, str], tuple[Entity, list[Entity]]] = {}

    def assign(self, ifc: IfcFile, filling: Entity, opening: Opening) -> None:
        """Give a door or window its type: the size in steps of 5 cm and the way it opens."""
        kind = opening.kind.title()
        width, height = (max(_SIZE_STEP, _SIZE_STEP * round(1000 * length / _SIZE_STEP)) for length in (opening.width, opening.height))
        operation = door_operation(opening) if opening.kind == "door" else ""
        key = (kind, width, height, operation)
        if key not in self._types:
            hand = _HANDS.get(operation, "")
            entity = ifc.root(
                f"Ifc{kind}Type",
                "/".join(map(str, key)),
                Name=f"{kind} {width} x {height}{hand}",
                Description="Nominal size in millimetres, in steps of 50.",
                PredefinedType=kind.upper(),
            )
            if opening.kind == "door":
                entity.OperationType = operation
            else:
                entity.PartitioningType = "NOTDEFINED"
            self._types[key] = (entity, [])
        self._types[key][1].append(filling)

    def relate(self, ifc: IfcFile, project: Entity) -> None:
        """Declare the types and relate them to their doors and windows, once all are there."""
        for key, (entity, fillings) in sorted(self._types.items()):
            ifc.root("IfcRelDefinesByType", "/".join(map(str, key)), RelatedObjects=fillings, RelatingType=entity)
        if self._types:
            entities = [entity for _, (entity, _) in sorted(self._types.items())]
            ifc.root("IfcRelDeclares", "filling types", RelatingContext=project, RelatedDefinitions=entities)


def add_opening(ifc: IfcFile, opening: Opening, wall: Wall, host: Entity, types: FillingTypes) -> list[Entity]:
    """Cut an opening through both faces of a wall and fill it.

    Parameters
    ----------
    ifc : IfcFile
        File to add to.
    opening : Opening
        Door, window or passage.
    wall : Wall
        Wall that it is in.
    host : IfcWall
        Its entity.
    types : FillingTypes
        Types of doors and windows.

    Returns
    -------
    list of entity
        The door or window; nothing for a passage.
    """
    place = f"{host.GlobalId}/{opening.guid or opening.id}"
    void = ifc.root(
        "IfcOpeningElement",
        place,
        Name=opening.name,
        Tag=opening.id,
        PredefinedType="OPENING",
        ObjectPlacement=ifc.placement((opening.start, 0.0, opening.sill), relative_to=host.ObjectPlacement),
        Representation=ifc.shape([_block(ifc, opening.width, opening.height, wall.thickness + 2 * OVERSHOOT)]),
    )
    if opening.kind == "opening":
        void.GlobalId = ifc.element_guid(opening)
    ifc.root("IfcRelVoidsElement", place, RelatingBuildingElement=host, RelatedOpeningElement=void)
    area = opening.width * opening.height
    add_quantities(
        ifc,
        void,
        "Qto_OpeningElementBaseQuantities",
        {"Width": opening.width, "Height": opening.height, "Depth": wall.thickness, "Area": area, "Volume": area * wall.thickness},
    )
    confidence = ("IfcNormalisedRatioMeasure", float(opening.confidence))
    if opening.kind == "opening":
        add_evidence(ifc, void, opening.evidence, Confidence=confidence)
        return []
    kind = opening.kind.title()
    turned = opening.swing == "right"
    filling = ifc.element(
        f"Ifc{kind}",
        opening,
        Name=opening.name,
        Tag=opening.id,
        OverallHeight=opening.height,
        OverallWidth=opening.width,
        ObjectPlacement=ifc.placement(
            (opening.width if turned else 0.0, 0.0, 0.0), x=(-1.0 if turned else 1.0, 0.0, 0.0), relative_to=void.ObjectPlacement
        ),
        Representation=ifc.shape(_frame_and_panels(ifc, opening, wall.thickness)),
    )
    types.assign(ifc, filling, opening)
    ifc.root("IfcRelFillsElement", place, RelatingOpeningElement=void, RelatedBuildingElement=filling)
    add_common(ifc, filling, f"Pset_{kind}Common", external=wall.external)
    add_quantities(
        ifc,
        filling,
        f"Qto_{kind}BaseQuantities",
        {"Width": opening.width, "Height": opening.height, "Perimeter": 2 * (opening.width + opening.height), "Area": area},
    )
    add_evidence(ifc, filling, opening.evidence, Confidence=confidence)
    return [filling]


def door_operation(opening: Opening) -> str:
    """Operation type of a door whose y axis points to the side that it opens to.

    Examples
    --------
    >>> door_operation(Opening("D1", "Door", "door", 1.0, 0.9, 0.0, 2.1, hinge="start", swing="left"))
    'SINGLE_SWING_LEFT'
    """
    if opening.leaves == 2 and opening.swing:
        return "DOUBLE_DOOR_SINGLE_SWING"
    if opening.leaves != 1 or not opening.hinge or not opening.swing:
        return "NOTDEFINED"
    return "SINGLE_SWING_LEFT" if (opening.hinge == "start") == (opening.swing == "left") else "SINGLE_SWING_RIGHT"


def _block(ifc: IfcFile, width: float, height: float, depth: float, *, x: float = 0.0, z: float = 0.0) -> Entity:
    """Box from (x, z), `depth` thick about the axis, swept across the wall."""
    position = ifc.axes((x, depth / 2, z), z=(0.0, -1.0, 0.0))
    return ifc.extrusion(ifc.rectangle_profile(width, height, centre=(width / 2, height / 2)), depth, position=position)


def _frame_and_panels(ifc: IfcFile, opening: Opening, thickness: float) -> list[Entity]:
    width, height = opening.width, opening.height
    frame = min(_FRAME, width / 4, height / 4)
    depth = min(thickness, 2 * _FRAME)
    foot = frame if opening.kind == "window" else 0.0
    parts = [
        _block(ifc, frame, height, depth),
        _block(ifc, frame, height, depth, x=width - frame),
        _block(ifc, width - 2 * frame, frame, depth, x=frame, z=height - frame),
    ]
    if foot:
        parts.append(_block(ifc, width - 2 * frame, frame, depth, x=frame))
    for part in parts:
        ifc.paint(part, "frame")
    count = 1 if opening.kind == "window" else opening.leaves
    panel = (width - 2 * frame) / max(count, 1)
    for i in range(count):
        leaf = _block(ifc, panel, height - frame - foot, min(_PANEL, depth), x=frame + i * panel, z=foot)
        parts.append(ifc.paint(leaf, "window" if opening.kind == "window" else "door"))
    return parts
