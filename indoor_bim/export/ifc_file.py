"""An IFC file in the making: its header, contexts, identifiers, placements and solids. All lengths are metres."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import hypot
from typing import Any, Literal

from indoor_bim import __version__
from indoor_bim.export.guids import Identified, element_guid, global_id
from indoor_bim.export.mesh import COLOURS, OPACITY, Material
from indoor_bim.model import Outline, Point2, Ring

Schema = Literal["IFC4", "IFC4X3"]
Entity = Any
VIEW = "DesignTransferView_V1.0"
TIME_STAMP = "1970-01-01T00:00:00"
PRECISION = 1e-5
Point3 = tuple[float, float, float]


class IfcFile:
    """IFC file with the contexts and units that every element shares.

    Parameters
    ----------
    schema : {"IFC4", "IFC4X3"}
        Schema of the file.
    source : str
        Name of the scan; with an element's identifier it makes the element's GUID.
    """

    def __init__(self, schema: Schema, source: str) -> None:
        import ifcopenshell

        self.file: Any = ifcopenshell.file(schema=schema)
        self.schema = schema
        self._source = source
        self._points: dict[tuple[float, ...], Entity] = {}
        self._directions: dict[tuple[float, ...], Entity] = {}
        self._styles: dict[Material, Entity] = {}
        self.model_context = self.create("IfcGeometricRepresentationContext", None, "Model", 3, PRECISION, self.axes((0.0, 0.0, 0.0)))
        origin = self.create("IfcAxis2Placement2D", self.point((0.0, 0.0)), self.direction((1.0, 0.0)))
        self.plan_context = self.create("IfcGeometricRepresentationContext", None, "Plan", 2, PRECISION, origin)
        self.body = self._subcontext("Body", self.model_context, "MODEL_VIEW")
        self.axis = self._subcontext("Axis", self.plan_context, "GRAPH_VIEW")
        self.units = [
            self.create("IfcSIUnit", None, kind, None, name)
            for kind, name in (
                ("LENGTHUNIT", "METRE"),
                ("AREAUNIT", "SQUARE_METRE"),
                ("VOLUMEUNIT", "CUBIC_METRE"),
                ("PLANEANGLEUNIT", "RADIAN"),
            )
        ]

    def create(self, entity: str, *values: Any, **attributes: Any) -> Entity:
        """Add an entity without an identifier."""
        return self.file.create_entity(entity, *values, **attributes)

    def root(self, entity: str, key: str, **attributes: Any) -> Entity:
        """Add an entity with a GUID that depends on the scan, the kind of entity and `key` alone."""
        return self.create(entity, self.guid(f"{entity}/{key}"), **attributes)

    def element(self, entity: str, element: Identified, **attributes: Any) -> Entity:
        """Add an element of the model under its GUID."""
        return self.create(entity, self.element_guid(element), **attributes)

    def element_guid(self, element: Identified) -> str:
        """GUID of an element of the model."""
        return element_guid(self._source, element)

    def guid(self, key: str) -> str:
        """GUID of `key` in the scan this file comes from.

        Examples
        --------
        >>> IfcFile("IFC4", "house.laz").guid("IfcWall/W1") == IfcFile("IFC4X3", "house.laz").guid("IfcWall/W1")
        True
        """
        return global_id(f"{self._source}/{key}")

    def text(self, name: str) -> str:
        """Return the file as STEP text, with `name` and a fixed time in its header."""
        header = self.file.header
        header.file_description.description = (f"ViewDefinition [{VIEW}]",)
        header.file_name.name = name
        header.file_name.time_stamp = TIME_STAMP
        header.file_name.originating_system = f"indoor-bim {__version__}"
        return str(self.file.to_string())

    def point(self, coordinates: Sequence[float]) -> Entity:
        """Return the point at 2 or 3 coordinates."""
        key = tuple(float(c) + 0.0 for c in coordinates)
        if key not in self._points:
            self._points[key] = self.create("IfcCartesianPoint", key)
        return self._points[key]

    def direction(self, ratios: Sequence[float]) -> Entity:
        """Return the direction of 2 or 3 ratios."""
        key = tuple(float(r) + 0.0 for r in ratios)
        if key not in self._directions:
            self._directions[key] = self.create("IfcDirection", key)
        return self._directions[key]

    def axes(self, origin: Point3, *, z: Point3 = (0.0, 0.0, 1.0), x: Point3 = (1.0, 0.0, 0.0)) -> Entity:
        """Coordinate axes at `origin`."""
        return self.create("IfcAxis2Placement3D", self.point(origin), self.direction(z), self.direction(x))

    def placement(self, origin: Point3, *, x: Point3 = (1.0, 0.0, 0.0), relative_to: Entity | None = None) -> Entity:
        """Upright local placement."""
        return self.create("IfcLocalPlacement", relative_to, self.axes(origin, x=x))

    def polyline(self, points: Iterable[Point2], *, closed: bool = False) -> Entity:
        """Polyline through `points`, corners that repeat left out."""
        corners: list[Point2] = []
        for corner in points:
            if not corners or hypot(corner[0] - corners[-1][0], corner[1] - corners[-1][1]) > PRECISION:
                corners.append(corner)
        if closed:
            while len(corners) > 1 and hypot(corners[0][0] - corners[-1][0], corners[0][1] - corners[-1][1]) <= PRECISION:
                corners.pop()
            corners.append(corners[0])
        return self.create("IfcPolyline", [self.point(corner) for corner in corners])

    def ring_profile(self, ring: Ring) -> Entity:
        """Profile with one ring."""
        return self.create("IfcArbitraryClosedProfileDef", "AREA", None, self.polyline(ring, closed=True))

    def outline_profile(self, outline: Outline) -> Entity:
        """Profile with the holes of `outline`."""
        if not outline.holes:
            return self.ring_profile(outline.exterior)
        holes = [self.polyline(hole, closed=True) for hole in outline.holes]
        return self.create("IfcArbitraryProfileDefWithVoids", "AREA", None, self.polyline(outline.exterior, closed=True), holes)

    def rectangle_profile(self, width: float, depth: float, *, centre: Point2) -> Entity:
        """Rectangle profile about `centre`, `width` along x and `depth` along y."""
        position = self.create("IfcAxis2Placement2D", self.point(centre), self.direction((1.0, 0.0)))
        return self.create("IfcRectangleProfileDef", "AREA", None, position, width, depth)

    def extrusion(self, profile: Entity, depth: float, *, position: Entity | None = None) -> Entity:
        """Solid swept from `profile` along the z axis of `position`, by default the element's own."""
        position = position or self.axes((0.0, 0.0, 0.0))
        return self.create("IfcExtrudedAreaSolid", profile, position, self.direction((0.0, 0.0, 1.0)), depth)

    def paint(self, solid: Entity, colour: Material) -> Entity:
        """Give a solid its surface style."""
        if colour not in self._styles:
            red, green, blue = (channel / 255 for channel in COLOURS[colour])
            surface = self.create(
                "IfcSurfaceStyleRendering",
                SurfaceColour=self.create("IfcColourRgb", None, red, green, blue),
                Transparency=1.0 - OPACITY.get(colour, 1.0),
                ReflectanceMethod="NOTDEFINED",
            )
            self._styles[colour] = self.create("IfcSurfaceStyle", colour.title(), "BOTH", [surface])
        self.create("IfcStyledItem", solid, [self._styles[colour]])
        return solid

    def shape(self, solids: Sequence[Entity], *, axis: Entity | None = None, colour: Material | None = None) -> Entity:
        """Product shape of swept solids, with the wall axis where given; all in one colour, or as they were painted."""
        if colour is not None:
            for solid in solids:
                self.paint(solid, colour)
        representations = [self.create("IfcShapeRepresentation", self.body, "Body", "SweptSolid", list(solids))]
        if axis is not None:
            representations.insert(0, self.create("IfcShapeRepresentation", self.axis, "Axis", "Curve2D", [axis]))
        return self.create("IfcProductDefinitionShape", None, None, representations)

    def aggregate(self, whole: Entity, parts: Sequence[Entity], key: str) -> None:
        """Make `parts` the parts of `whole`."""
        if parts:
            self.root("IfcRelAggregates", key, RelatingObject=whole, RelatedObjects=list(parts))

    def _subcontext(self, identifier: str, parent: Entity, view: str) -> Entity:
        return self.create(
            "IfcGeometricRepresentationSubContext",
            ContextIdentifier=identifier,
            ContextType=parent.ContextType,
            ParentContext=parent,
            TargetView=view,
        )
