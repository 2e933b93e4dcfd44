"""How a plan is to look: scale, paper, colours, and pictures of the scan to lie under it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Theme = Literal["print", "dark"]
Paper = Literal["A4", "A3", "A2", "A1", "A0"]


@dataclass(frozen=True, slots=True)
class Underlay:
    """Picture that lies under the plan.

    Parameters
    ----------
    png : bytes
        PNG file.
    bounds : (float, float, float, float)
        Least x and y, greatest x and y of the picture in model coordinates, metres.
    """

    png: bytes
    bounds: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class PlanStyle:
    """Choices for drawing plans.

    Parameters
    ----------
    scale : int, optional
        Denominator: 100 for 1:100; by default the largest usual scale that serves.
    paper : {"A4", "A3", "A2", "A1", "A0"}, optional
        Size of the sheet; by default the smallest that serves.
    theme : {"print", "dark"}
        Colours.
    underlays : mapping of str to Underlay
        Pictures of the scan by the identifier of the storey that they show.
    """

    scale: int | None = None
    paper: Paper | None = None
    theme: Theme = "print"
    underlays: Mapping[str, Underlay] = field(default_factory=dict)


USUAL = PlanStyle()
