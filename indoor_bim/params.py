"""Every parameter of every stage, declared once: default, unit, bounds and one sentence.

TOML files, the JSON Schema, command line help and the parameter table of the documentation come from here.
``None`` means: derived from the scan.
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from indoor_bim.errors import ConfigError


class Stage(BaseModel):
    """Parameters of one stage: frozen, no unknown names, no infinite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class ReadParams(Stage):
    """Reading the scan."""

    unit: Literal["auto", "m", "dm", "cm", "mm", "ft", "us-ft", "in"] = Field(
        "auto", description="Unit of the scan's coordinates; auto recognises millimetres."
    )
    up: Literal["auto", "z", "y", "x"] = Field("auto", description="Axis of the scan that points up; auto recognises y-up clouds.")
    crs: str | None = Field(
        None, pattern=r"^EPSG:\d+$", description="Coordinate reference system of the scan, as EPSG:code; none: from the file, if it says."
    )
    title: str | None = Field(
        None,
        min_length=1,
        max_length=120,
        description="Name of the building in drawings and IFC; none: that of the file, or of its folder.",
    )
    per_cube: int | None = Field(
        None,
        ge=1,
        le=30_000,
        description="Most points kept of each cube of 10 cm; none: 64 above 4 million points with the method auto, else all.",
    )
    max_memory: float | None = Field(
        None, ge=0.6, le=10_000, description="Most memory in gigabytes; points are thinned out until the rest fits; none: no limit."
    )


class SlopeParams(Stage):
    """The published slope method (Remote Sensing 2021, 13, 4930)."""

    grid_count: int | None = Field(
        None, ge=10, le=5000, description="Cells along each side of the grid that finds floor and ceiling (n_fac); none: from the size."
    )
    gror_radius: float | None = Field(
        None, gt=0, le=1, description="Radius of the outlier removal in metres (r_GROR); none: from the point spacing."
    )
    gror_neighbours: int | None = Field(
        None,
        ge=1,
        le=100000,
        description="Neighbours that a point needs within the radius (n_GROR), of all points; none: from the height, on thinned points.",
    )
    magnification: float | None = Field(
        None, gt=0, le=1000, description="Pixels per metre of the wall image (n_moc); none: from the point spacing."
    )
    merge_gap: float | None = Field(
        None, gt=0, le=1000, description="Largest gap in pixels between merged lines of equal slope (d_p); none: from the magnification."
    )
    merge_offset: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="Largest distance in pixels across merged lines; none: 3 cm. As large as merge_gap: no limit, as published.",
    )
    min_pixels: int | None = Field(
        None, ge=1, le=1000, description="Lines of fewer pixels are dropped before lines are merged; none: 10 cm."
    )
    corner_gap: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="Largest distance in pixels between end points that become a corner (d_v); none: from the magnification.",
    )
    refit: bool = Field(
        True, description="Move each line to the median of its points; false: leave it at the mean of its pixels, as published."
    )


class SlicesParams(Stage):
    """The published slices method (weighted line fits of layered slices)."""

    heights: tuple[float, ...] | None = Field(
        None, min_length=1, max_length=10, description="Heights of the slices above the floor in metres; none: where most wall is."
    )
    count: int = Field(2, ge=1, le=10, description="Number of slices, where their heights are not given.")
    thickness: float | None = Field(
        None, gt=0, le=2, description="Thickness of a slice in metres; none: three times the point spacing, more in sparse scans."
    )
    min_range: float | None = Field(
        None,
        ge=0,
        le=10,
        description="Points nearer to the scanner are left out, metres; none: 0.4. Needs times and the path of the scanner.",
    )
    max_range: float | None = Field(
        None, gt=0, le=1000, description="Points farther from the scanner are left out, metres; none: from the ranges of all points."
    )
    split_distance: float | None = Field(
        None,
        gt=0,
        le=1,
        description="Largest distance of a point from the line of its set in metres; none: from the scatter of the points.",
    )
    split_gap: float | None = Field(
        None, gt=0, le=2, description="Largest distance of neighbours in a set in metres; none: from the density of the slices."
    )
    min_length: float = Field(0.05, ge=0, le=5, description="Shorter sets are dropped, metres.")
    min_points: int = Field(5, ge=2, le=100000, description="Sets of fewer points are dropped.")
    range_noise: float | None = Field(
        None, gt=0, le=0.5, description="Standard deviation of a measured distance in metres; none: from the points."
    )
    bearing_noise: float | None = Field(
        None, gt=0, le=0.1, description="Standard deviation of a measured bearing in radians; none: from the points."
    )
    sigma: float = Field(3.0, gt=0, le=10, description="Gate of the merging of lines in standard deviations.")
    closing_gap: float = Field(0.5, ge=0, le=5, description="Shorter gaps of a contour are closed, wider ones left as openings; metres.")


class WallParams(Stage):
    """Faces to walls."""

    min_thickness: float = Field(0.05, gt=0, le=1, description="Thinnest wall in metres.")
    max_thickness: float = Field(0.60, gt=0, le=2, description="Thickest wall in metres.")


class OpeningParams(Stage):
    """Doors, windows and passages."""

    min_confidence: float = Field(0.4, ge=0, le=1, description="Openings that are less certain are left out.")
    min_door_width: float = Field(0.6, gt=0, le=5, description="Narrowest door in metres.")
    max_door_width: float = Field(2.5, gt=0, le=20, description="Widest door in metres; what is wider is a passage or a glass front.")
    min_door_height: float = Field(1.8, gt=0, le=5, description="Lowest door in metres.")
    max_door_height: float = Field(2.6, gt=0, le=10, description="Highest door in metres.")
    frame: float = Field(
        0.04, ge=0, le=0.2, description="Width of a door frame in metres where it lies in the plane of the wall and cannot be told from it."
    )


class IfcParams(Stage):
    """The IFC file."""

    version: Literal["IFC4", "IFC4X3"] = Field("IFC4", description="Schema of the file; IFC4 is read by most programs.")


class DrawingParams(Stage):
    """Floor plans: SVG, PDF, PNG and DXF."""

    scale: int | None = Field(
        None, ge=1, le=100_000, description="Denominator of the scale, 100 for 1:100; none: the largest usual one that serves."
    )
    paper: Literal["A4", "A3", "A2", "A1", "A0"] | None = Field(None, description="Size of the sheet; none: the smallest that serves.")
    theme: Literal["print", "dark"] = Field("print", description="Colours.")
    underlay: bool = Field(False, description="Lay a picture of the scan under the plan.")


class HousesParams(Stage):
    """Houses of an outdoor scan."""

    storey_height: float = Field(3.0, gt=1, le=10, description="Usual height of a storey in metres.")
    least_area: float = Field(8.0, gt=0, le=10000, description="Smallest footprint of a house in square metres.")
    least_coverage: float = Field(0.3, ge=0, le=1, description="Least share of an outline along which a wall was seen.")
    right_angles: bool = Field(True, description="Square up walls whose directions agree with a right angle within their uncertainty.")
    terrain_spacing: float = Field(1.0, gt=0, le=100, description="Distance between the grid points of the ground in metres.")
    spot_spacing: float = Field(10.0, gt=0, le=1000, description="Distance between spot heights in metres.")
    spot_radius: float = Field(0.5, gt=0, le=100, description="Radius within which ground points make a spot height in metres.")
    slice_low: float = Field(1.5, ge=0, le=50, description="Method topology: lower border of the slice above the ground in metres.")
    slice_high: float = Field(1.7, gt=0, le=50, description="Method topology: upper border of the slice above the ground in metres.")
    grid_size: float = Field(0.2, gt=0, le=5, description="Method topology: side of a grid cell in metres.")
    neighbours: int = Field(8, ge=2, le=100, description="Method topology: number of nearest cells among which the outline goes on.")
    angle_threshold: float = Field(
        179.5, gt=90, le=180, description="Method topology: corners of a larger angle are left out of the outline, degrees."
    )


class SimulateParams(Stage):
    """A virtual scan; the defaults are those of a backpack with two spinning multi-line heads."""

    movement: Literal["walk", "stations"] = Field("walk", description="Walked through the building, or standing on tripods.")
    head_tilts: tuple[float, ...] = Field(
        (10.0, 70.0),
        min_length=1,
        max_length=8,
        description="Angle between the spin axis of each head and the vertical, degrees, tilted backwards.",
    )
    lines: int = Field(16, ge=1, le=256, description="Laser lines of each head.")
    line_fov: float = Field(30.0, gt=0, le=180, description="Angle between the outermost lines in degrees.")
    spin_rate: float = Field(10.0, gt=0, le=100, description="Turns of a head per second.")
    speed: float = Field(0.8, gt=0, le=5, description="Walking speed in metres per second.")
    sensor_height: float = Field(1.75, gt=0, le=5, description="Height of the sensor above the floor in metres.")
    max_range: float = Field(60.0, gt=0, le=1000, description="Largest measured distance in metres.")
    range_noise: float = Field(0.012, ge=0, le=0.5, description="Standard deviation of a measured distance in metres.")
    dropout: float = Field(0.03, ge=0, lt=1, description="Share of rays that give nothing.")
    mixed_pixels: float = Field(0.01, ge=0, le=1, description="Share of rays wide enough to average two surfaces at an edge.")
    drift: float = Field(0.015, ge=0, le=1, description="Root mean square error of the positions of the path in metres.")
    drift_yaw: float = Field(0.03, ge=0, le=5, description="Root mean square error of the headings of the path in degrees.")
    glass_return: float = Field(0.08, ge=0, le=1, description="Share of rays that return from a pane.")
    glass_reflection: float = Field(0.04, ge=0, le=1, description="Share of rays that a pane mirrors, seen as ghosts behind it.")
    furniture: bool = Field(True, description="Furnish the rooms and build surroundings.")
    people: int = Field(0, ge=0, le=10, description="People who walk along with the scanner.")
    map_tilt: float | None = Field(
        None, ge=0, le=90, description="Tilt of the scan's axes in degrees; none: drawn from the seed, up to 15."
    )
    map_yaw: float | None = Field(None, ge=-360, le=360, description="Turn of the scan's axes in degrees; none: drawn from the seed.")
    map_origin: tuple[float, float, float] = Field(
        (0.0, 0.0, 0.0), description="Scan coordinates of the first sensor position in metres, such as UTM."
    )


class Params(Stage):
    """All stages of the toolkit."""

    read: ReadParams = ReadParams()
    slope: SlopeParams = SlopeParams()
    slices: SlicesParams = SlicesParams()
    walls: WallParams = WallParams()
    houses: HousesParams = HousesParams()
    ifc: IfcParams = IfcParams()
    drawing: DrawingParams = DrawingParams()
    openings: OpeningParams = OpeningParams()


PRESETS = {
    "paper-room": SlopeParams(
        grid_count=200,
        gror_radius=0.01,
        gror_neighbours=10,
        magnification=100,
        merge_gap=10,
        merge_offset=10,
        min_pixels=3,
        corner_gap=40,
        refit=False,
    ),
    "paper-floor": SlopeParams(
        grid_count=600,
        gror_radius=0.03,
        gror_neighbours=10,
        magnification=10,
        merge_gap=5,
        merge_offset=5,
        min_pixels=3,
        corner_gap=8,
        refit=False,
    ),
    "paper-rooms": SlopeParams(
        grid_count=300,
        gror_radius=0.03,
        gror_neighbours=10,
        magnification=10,
        merge_gap=15,
        merge_offset=15,
        min_pixels=3,
        corner_gap=5,
        refit=False,
    ),
}


def preset(name: str) -> Params:
    """Parameters of a published scene (Remote Sensing 2021, 13, 4930, table 5).

    Parameters
    ----------
    name : str
        ``paper-room``, ``paper-floor`` or ``paper-rooms`` (scenes 1, 2 and 3). The paper does not say from how many pixels on it keeps
        a line; the presets say 3.

    Raises
    ------
    ConfigError
        If there is no preset of that name.

    Examples
    --------
    >>> preset("paper-room").slope.magnification
    100.0
    """
    if name not in PRESETS:
        raise ConfigError(f"no preset is called {name!r}; expected one of {', '.join(PRESETS)}")
    return Params(slope=PRESETS[name])
