"""Every parameter of every stage, declared once: default, unit, bounds and one sentence.

TOML files, the JSON Schema, command line help and the parameter table of the documentation come from here.
``None`` means: derived from the scan.
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Stage(BaseModel):
    """Parameters of one stage: frozen, no unknown names, no infinite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class ReadParams(Stage):
    """Reading the scan."""

    unit: Literal["auto", "m", "dm", "cm", "mm", "ft", "us-ft", "in"] = Field("auto", description="Unit of the scan's coordinates; auto recognises millimetres.")
    up: Literal["auto", "z", "y", "x"] = Field("auto", description="Axis of the scan that points up; auto recognises y-up clouds.")
    crs: str | None = Field(None, pattern=r"^EPSG:\d+$", description="Coordinate reference system of the scan, as EPSG:code; none: from the file, if it says.")


class SlopeParams(Stage):
    """The published slope method (Remote Sensing 2021, 13, 4930)."""

    grid_count: int | None = Field(None, ge=10, le=5000, description="Cells along each side of the grid that finds floor and ceiling (n_fac); none: from the size.")
    gror_radius: float | None = Field(None, gt=0, le=1, description="Radius of the outlier removal in metres (r_GROR); none: from the point spacing.")
    gror_neighbours: int = Field(10, ge=1, le=1000, description="Neighbours that a point needs within the radius (n_GROR).")
    magnification: float | None = Field(None, gt=0, le=1000, description="Pixels per metre of the wall image (n_moc); none: from the point spacing.")
    merge_gap: float | None = Field(None, gt=0, le=1000, description="Largest gap in pixels between merged lines of equal slope (d_p); none: from the magnification.")
    corner_gap: float | None = Field(None, gt=0, le=1000, description="Largest distance in pixels between end points that become a corner (d_v); none: from the magnification.")


class WallParams(Stage):
    """Faces to walls."""

    min_thickness: float = Field(0.05, gt=0, le=1, description="Thinnest wall in metres.")
    max_thickness: float = Field(0.60, gt=0, le=2, description="Thickest wall in metres.")


class Params(Stage):
    """All stages of the toolkit."""

    read: ReadParams = ReadParams()
    slope: SlopeParams = SlopeParams()
    walls: WallParams = WallParams()
