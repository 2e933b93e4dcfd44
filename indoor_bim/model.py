"""The building model: the one thing that reconstruction, exporters and checks meet at.

Pure, frozen data in metres. Model coordinates are right-handed with z up, the x axis along a main
direction of the building and z = 0 on the floor of the lowest storey. `Building.transform_cloud_to_model`
leads from the scan's own coordinates to them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Final, Literal

from pydantic import ConfigDict, Field

if TYPE_CHECKING:
    import shapely

FORMAT: Final = "indoor-bim-building"
VERSION: Final = 1
UNITS: Final = "m"

Number = Annotated[float, Field(allow_inf_nan=False)]
Point2 = tuple[Number, Number]
Ring = tuple[Point2, ...]
Row4 = tuple[Number, Number, Number, Number]
Matrix4 = tuple[Row4, Row4, Row4, Row4]
IDENTITY: Matrix4 = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))

Id = Annotated[str, Field(min_length=1, description="Identifier, unique in the building.")]
Length = Annotated[float, Field(gt=0, allow_inf_nan=False, description="Metres.")]
Level = Annotated[float, Field(allow_inf_nan=False, description="Height in model coordinates, metres.")]
Share = Annotated[float, Field(ge=0, le=1, description="Share between 0 and 1.")]

Guid = Annotated[
    str | None,
    Field(
        pattern=r"^[0-3][0-9A-Za-z_$]{21}$", description="GlobalId of the element in IFC; null: made of the scan's name and the identifier."
    ),
]

ONLY_KNOWN_FIELDS = ConfigDict(extra="forbid")


@dataclass(frozen=True, slots=True)
class Evidence:
    """What an element rests on."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    support: Annotated[int, Field(ge=0, description="Number of scan points on the element.")] = 0
    coverage: Annotated[float, Field(ge=0, le=1, description="Share of the element's visible surface hit by the scan.")] = 0.0
    rmse: Annotated[float | None, Field(ge=0, description="Root mean square distance of the supporting points, metres.")] = None
    sides: Annotated[int, Field(ge=0, le=2, description="Number of faces of the element that were seen.")] = 0
    deviation: Annotated[
        float | None,
        Field(
            ge=0, description="Distance from a seen face that local medians of its points keep to along 95 % of it, metres; the larger one."
        ),
    ] = None
    position_sigma: Annotated[
        float | None,
        Field(ge=0, description="Standard deviation of the position of a seen face across, metres; of the less certain one."),
    ] = None
    direction_sigma: Annotated[
        float | None, Field(ge=0, description="Standard deviation of the direction of a seen face, degrees; of the less certain one.")
    ] = None


@dataclass(frozen=True, slots=True)
class Outline:
    """Polygon in plan: a counter-clockwise exterior ring and clockwise holes, first corner not repeated."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    exterior: Annotated[Ring, Field(min_length=3)]
    holes: tuple[Ring, ...] = ()

    @property
    def polygon(self) -> shapely.Polygon:
        """The outline as a shapely polygon."""
        import shapely

        return shapely.Polygon(self.exterior, self.holes)

    @property
    def area(self) -> float:
        """Area in square metres, holes left out."""
        return abs(_ring_area(self.exterior)) - sum(abs(_ring_area(hole)) for hole in self.holes)

    @classmethod
    def from_polygon(cls, polygon: shapely.Polygon) -> Outline:
        """Outline of a shapely polygon, rings oriented and started at their smallest corner.

        Parameters
        ----------
        polygon : shapely.Polygon
            Plan polygon, metres.
        """
        return cls(_ring(polygon.exterior.coords, sign=1.0), tuple(sorted(_ring(hole.coords, sign=-1.0) for hole in polygon.interiors)))


@dataclass(frozen=True, slots=True)
class Opening:
    """Door, window or passage in a wall."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    name: str
    kind: Literal["door", "window", "opening"]
    start: Annotated[float, Field(ge=0, description="Distance of the nearer jamb from the first end of the wall axis, metres.")]
    width: Length
    sill: Annotated[float, Field(ge=0, description="Height of the lower edge above the foot of the wall, metres.")]
    height: Length
    hinge: Annotated[Literal["start", "end"] | None, Field(description="Jamb that carries the leaf, if the leaf was seen.")] = None
    swing: Annotated[Literal["left", "right"] | None, Field(description="Side of the wall axis that the leaf opens to, if seen.")] = None
    leaves: Annotated[int, Field(ge=0, le=2, description="Number of door leaves.")] = 1
    confidence: Share = 0.0
    evidence: Evidence = field(default_factory=Evidence)
    guid: Guid = None


@dataclass(frozen=True, slots=True)
class Wall:
    """Straight wall of constant thickness."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    name: str
    axis: Annotated[tuple[Point2, Point2], Field(description="Centre line, metres.")]
    thickness: Length
    thickness_measured: Annotated[bool, Field(description="True when both faces were seen.")]
    base: Level
    height: Length
    footprint: Annotated[Ring, Field(min_length=3, description="Plan outline with joints resolved: footprints do not overlap.")]
    external: Annotated[bool | None, Field(description="True for a wall to the outside; null when not known.")] = None
    openings: tuple[Opening, ...] = ()
    evidence: Evidence = field(default_factory=Evidence)
    seen: Annotated[Literal["both", "left", "right"] | None, Field(description="Faces that were seen, looking along the axis.")] = None
    guid: Guid = None

    @property
    def length(self) -> float:
        """Length of the axis in metres."""
        (x0, y0), (x1, y1) = self.axis
        return float(((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5)


@dataclass(frozen=True, slots=True)
class Joint:
    """Place where walls meet: two ends (L), an end at a through wall (T, X), or three and more ends (Y)."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    point: Point2
    walls: Annotated[tuple[str, ...], Field(min_length=2, description="Identifiers of the walls that meet.")]
    ends: Annotated[
        tuple[Literal["start", "end", "path"], ...],
        Field(min_length=2, description="Where each wall takes part: at an end of its axis, or along it."),
    ]


@dataclass(frozen=True, slots=True)
class Curve:
    """Circular arc that a chain of straight walls stands for."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    centre: Point2
    radius: Annotated[float, Field(gt=0, allow_inf_nan=False, description="Radius of the axis, metres.")]
    ends: Annotated[tuple[Point2, Point2], Field(description="Ends of the axis on the arc, counter-clockwise; equal for a circle.")]
    walls: Annotated[tuple[str, ...], Field(min_length=2, description="Identifiers of the walls of the chain, counter-clockwise.")]
    chain_deviation: Annotated[float, Field(ge=0, description="Largest distance of the axes of the chain from the arc, metres.")]
    radius_sigma: Annotated[float | None, Field(ge=0, description="Standard deviation of the radius, metres.")] = None
    deviation: Annotated[
        float | None, Field(ge=0, description="Distance from the arc that local medians of the points keep to along 95 % of it, metres.")
    ] = None


@dataclass(frozen=True, slots=True)
class Column:
    """Free-standing column, pillar or shaft."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    name: str
    footprint: Annotated[Ring, Field(min_length=3)]
    base: Level
    height: Length
    evidence: Evidence = field(default_factory=Evidence)
    guid: Guid = None


@dataclass(frozen=True, slots=True)
class Room:
    """Space enclosed by walls."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    name: str
    outline: Outline
    floor: Level
    height: Length
    walls: Annotated[tuple[str, ...], Field(description="Identifiers of the walls that bound the room.")] = ()
    evidence: Evidence = field(default_factory=Evidence)
    guid: Guid = None

    @property
    def area(self) -> float:
        """Net floor area in square metres."""
        return self.outline.area


@dataclass(frozen=True, slots=True)
class Slab:
    """Floor or ceiling plate; its visible surface is known, its thickness is assumed."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    name: str
    kind: Literal["floor", "ceiling"]
    outline: Outline
    level: Annotated[float, Field(allow_inf_nan=False, description="Top of a floor, underside of a ceiling; metres.")]
    thickness: Length
    evidence: Evidence = field(default_factory=Evidence)
    guid: Guid = None


@dataclass(frozen=True, slots=True)
class Storey:
    """One level of the building."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    name: str
    elevation: Level
    height: Annotated[float, Field(gt=0, allow_inf_nan=False, description="Clear height from floor to ceiling, metres.")]
    walls: tuple[Wall, ...] = ()
    joints: tuple[Joint, ...] = ()
    columns: tuple[Column, ...] = ()
    rooms: tuple[Room, ...] = ()
    slabs: tuple[Slab, ...] = ()
    curves: tuple[Curve, ...] = ()


@dataclass(frozen=True, slots=True)
class Building:
    """A reconstructed building with everything that is known about where it comes from."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    name: str
    storeys: tuple[Storey, ...] = ()
    transform_cloud_to_model: Annotated[
        Matrix4, Field(description="Row-major 4 x 4 matrix that takes scan coordinates (in the scan's unit) to model coordinates.")
    ] = IDENTITY
    crs: Annotated[str | None, Field(description="Coordinate reference system of the scan, as EPSG:code, if known.")] = None
    source: Annotated[str, Field(description="Name of the scan file.")] = ""
    method: Annotated[str, Field(description="Method that made the model.")] = ""
    warnings: Annotated[tuple[str, ...], Field(description="What is missing or doubtful, in sentences.")] = ()
    format: Literal["indoor-bim-building"] = FORMAT
    version: Literal[1] = VERSION
    units: Annotated[Literal["m"], Field(description="Unit of every length in the model.")] = UNITS


def _ring_area(ring: Ring) -> float:
    return 0.5 * sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, (*ring[1:], ring[0]), strict=True))


def _ring(coords: object, *, sign: float) -> Ring:
    ring = [(float(x), float(y)) for x, y in list(coords)[:-1]]  # type: ignore[call-overload]
    if _ring_area(tuple(ring)) * sign < 0:
        ring.reverse()
    first = min(range(len(ring)), key=ring.__getitem__)
    return tuple(ring[first:] + ring[:first])
