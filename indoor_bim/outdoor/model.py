"""Houses of a village: the one thing that finding houses and writing them meet at.

Pure, frozen data in metres, as `indoor_bim.model`. Model coordinates are those of the scan about a local origin: z up, not
turned. `Village.transform_cloud_to_model` leads from the scan's own coordinates to them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Final, Literal

from pydantic import Field

from indoor_bim.model import IDENTITY, ONLY_KNOWN_FIELDS, Evidence, Id, Length, Matrix4, Number, Point2, Ring

if TYPE_CHECKING:
    import shapely

FORMAT: Final = "indoor-bim-village"
VERSION: Final = 1

Point3 = tuple[Number, Number, Number]


@dataclass(frozen=True, slots=True)
class Facade:
    """Outer face of one wall; the house lies to the left of start -> end."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    start: Point2
    end: Point2
    seen: Annotated[bool, Field(description="False where the outline was closed without wall points.")]
    top: Annotated[float | None, Field(allow_inf_nan=False, description="Height its points end at, metres; null when not seen.")] = None
    evidence: Evidence = field(default_factory=Evidence)

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(((self.end[0] - self.start[0]) ** 2 + (self.end[1] - self.start[1]) ** 2) ** 0.5)


@dataclass(frozen=True, slots=True)
class House:
    """One house: its outline on the ground, counter-clockwise, and its height."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    id: Id
    footprint: Annotated[Ring, Field(min_length=3, description="Corners of the outer wall faces, first one not repeated.")]
    base: Annotated[float, Field(allow_inf_nan=False, description="Mean height of the ground along its walls, metres.")]
    eave: Annotated[float, Field(allow_inf_nan=False, description="Height that most walls end at, metres.")]
    storeys: Annotated[int, Field(ge=0)]
    facades: tuple[Facade, ...] = ()
    material: Annotated[str | None, Field(description="From the table of attributes; null when not known.")] = None
    attributes: Annotated[tuple[tuple[str, str], ...], Field(description="Further columns of that table.")] = ()
    evidence: Evidence = field(default_factory=Evidence)

    @property
    def polygon(self) -> shapely.Polygon:
        """Footprint as a shapely polygon, metres."""
        import shapely

        return shapely.Polygon(self.footprint)

    @property
    def area(self) -> float:
        """Area of the footprint in square metres."""
        return abs(shoelace(self.footprint)[0])

    @property
    def centroid(self) -> Point2:
        """Centre of the footprint, where labels stand."""
        return shoelace(self.footprint)[1]

    @property
    def height(self) -> float:
        """Height of the eave above the base, metres."""
        return self.eave - self.base


@dataclass(frozen=True, slots=True)
class Ground:
    """Ground as a mesh of triangles."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    vertices: tuple[Point3, ...] = ()
    triangles: Annotated[tuple[tuple[int, int, int], ...], Field(description="Counter-clockwise from above.")] = ()


@dataclass(frozen=True, slots=True)
class Village:
    """All houses of a scan and the ground they stand on."""

    __pydantic_config__ = ONLY_KNOWN_FIELDS
    name: str
    houses: tuple[House, ...] = ()
    ground: Ground = field(default_factory=Ground)
    spot_heights: tuple[Point3, ...] = ()
    storey_height: Length = 3.0
    transform_cloud_to_model: Annotated[
        Matrix4, Field(description="Row-major 4 x 4 matrix that takes scan coordinates (in the scan's unit) to model coordinates.")
    ] = IDENTITY
    crs: Annotated[str | None, Field(description="Coordinate reference system of the scan, as EPSG:code, if known.")] = None
    source: Annotated[str, Field(description="Name of the scan file.")] = ""
    method: Annotated[str, Field(description="Method that found the houses.")] = ""
    warnings: Annotated[tuple[str, ...], Field(description="What is missing or doubtful, in sentences.")] = ()
    format: Literal["indoor-bim-village"] = FORMAT
    version: Literal[1] = VERSION


def shoelace(ring: Ring) -> tuple[float, Point2]:
    """Area and centroid of a polygon.

    Parameters
    ----------
    ring : ring
        Corners, metres, the first not repeated.

    Returns
    -------
    area : float
        Square metres; positive when the corners run counter-clockwise.
    centroid : (float, float)
        Metres.

    Notes
    -----
    Sensors 2024, 24, 5723, equations 4 and 6, taken about the first corner, so that large coordinates lose nothing.

    Examples
    --------
    >>> shoelace(((0, 0), (4, 0), (4, 2), (0, 2)))
    (8.0, (2.0, 1.0))
    """
    x0, y0 = ring[0]
    local = [(x - x0, y - y0) for x, y in ring]
    area = x_moment = y_moment = 0.0
    for (xa, ya), (xb, yb) in zip(local, (*local[1:], local[0]), strict=True):
        cross = xa * yb - xb * ya
        area += cross / 2
        x_moment += (xa + xb) * cross
        y_moment += (ya + yb) * cross
    if not area:
        return 0.0, (x0, y0)
    return area, (x0 + x_moment / (6 * area), y0 + y_moment / (6 * area))


__all__ = ["Facade", "Ground", "House", "Point3", "Village", "shoelace"]
