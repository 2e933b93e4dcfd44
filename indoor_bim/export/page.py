"""Paper, scale and the frames of a drawn page; all in millimetres from its upper left corner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from indoor_bim.errors import WriteError
from indoor_bim.model import Point2

PAPERS: dict[str, tuple[float, float]] = {"A4": (297, 210), "A3": (420, 297), "A2": (594, 420), "A1": (841, 594), "A0": (1189, 841)}
MARGIN = 10.0
TITLE_WIDTH, TITLE_HEIGHT = 190.0, 36.0
NOTES_HEIGHT = 24.0
DIMENSION_SPACE = 26.0
USUAL_SCALES = (20, 25, 50, 100, 200, 500, 1000, 2000, 5000)

_CHOICES = (
    *((scale, "A4") for scale in (20, 25, 50)),
    *(
        (50, "A3"),
        (100, "A4"),
        (100, "A3"),
        (100, "A2"),
        (100, "A1"),
        (200, "A2"),
        (200, "A1"),
        (200, "A0"),
        (500, "A2"),
        (500, "A1"),
        (500, "A0"),
    ),
    *((scale, "A0") for scale in (1000, 2000, 5000, 10_000, 100_000)),
)


@dataclass(frozen=True, slots=True)
class Rect:
    """Upright rectangle; y grows downwards."""

    x: float
    y: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Right edge."""
        return self.x + self.width

    @property
    def bottom(self) -> float:
        """Lower edge."""
        return self.y + self.height

    @property
    def centre(self) -> Point2:
        """Middle."""
        return self.x + self.width / 2, self.y + self.height / 2

    @property
    def ring(self) -> tuple[Point2, ...]:
        """Four corners."""
        return (self.x, self.y), (self.right, self.y), (self.right, self.bottom), (self.x, self.bottom)


@dataclass(frozen=True, slots=True)
class Page:
    """Sheet of paper with its frames.

    Parameters
    ----------
    paper : str
        Name of the size.
    width, height : float
        Size of the sheet.
    """

    paper: str
    width: float
    height: float

    @property
    def frame(self) -> Rect:
        """Border line."""
        return Rect(MARGIN, MARGIN, self.width - 2 * MARGIN, self.height - 2 * MARGIN)

    @property
    def title(self) -> Rect:
        """Title block in the lower right corner."""
        return Rect(self.frame.right - TITLE_WIDTH, self.frame.bottom - TITLE_HEIGHT, TITLE_WIDTH, TITLE_HEIGHT)

    @property
    def notes(self) -> Rect:
        """Place for scale bar, legend and remarks: left of the title block, or above it on a narrow sheet."""
        if self.title.x - self.frame.x >= 60:
            return Rect(self.frame.x, self.title.y, self.title.x - self.frame.x, TITLE_HEIGHT)
        return Rect(self.frame.x, self.title.y - NOTES_HEIGHT, self.frame.width, NOTES_HEIGHT)

    @property
    def drawing(self) -> Rect:
        """Place for the plan and its dimensions."""
        return Rect(self.frame.x, self.frame.y, self.frame.width, self.notes.y - self.frame.y)


@dataclass(frozen=True, slots=True)
class View:
    """Way from model coordinates (metres, y up) to paper (millimetres, y down).

    Parameters
    ----------
    scale : int
        Denominator: 100 for 1:100.
    middle : (float, float)
        Model point, metres.
    place : (float, float)
        Where it lies on the paper, millimetres.
    """

    scale: int
    middle: Point2
    place: Point2

    @property
    def mm_per_metre(self) -> float:
        """Millimetres of paper for each metre of the building."""
        return 1000 / self.scale

    def point(self, point: Point2) -> Point2:
        """Take a model point to the paper.

        Examples
        --------
        >>> View(100, (0.0, 0.0), (50.0, 50.0)).point((1.0, 2.0))
        (60.0, 30.0)
        """
        x, y = point
        return (
            float(self.place[0] + (x - self.middle[0]) * self.mm_per_metre),
            float(self.place[1] - (y - self.middle[1]) * self.mm_per_metre),
        )

    def model_point(self, place: Point2) -> Point2:
        """Take a place on the paper back to the model.

        Examples
        --------
        >>> View(100, (0.0, 0.0), (50.0, 50.0)).model_point((60.0, 30.0))
        (1.0, 2.0)
        """
        x, y = place
        return (
            float(self.middle[0] + (x - self.place[0]) / self.mm_per_metre),
            float(self.middle[1] - (y - self.place[1]) / self.mm_per_metre),
        )

    def shape(self, shape: BaseGeometry) -> BaseGeometry:
        """Take a model shape to the paper."""
        factor = np.array([self.mm_per_metre, -self.mm_per_metre])
        return shapely.transform(shape, lambda corners: (corners - self.middle) * factor + self.place)


def fit_page(
    bounds: tuple[float, float, float, float], *, scale: int | None = None, paper: str | None = None, space: float = DIMENSION_SPACE
) -> tuple[Page, View]:
    """Choose the paper and the scale that show a plan well, and place it in the middle.

    Parameters
    ----------
    bounds : (float, float, float, float)
        Least x and y, greatest x and y of the plan, metres.
    scale : int, optional
        Denominator to keep to.
    paper : str, optional
        Key of `PAPERS` to keep to.
    space : float
        Room for dimension chains on each side, millimetres.

    Returns
    -------
    page : Page
        Sheet of a named size, landscape when both ways serve.
    view : View
        Way from the model to the sheet at a usual scale.

    Raises
    ------
    WriteError
        If the plan does not fit at that scale on that paper.

    Examples
    --------
    >>> page, view = fit_page((0, 0, 5, 4))
    >>> page.paper, page.width, view.scale
    ('A4', 297, 50)
    """
    x0, y0, x1, y1 = bounds
    for denominator, name in _choices(scale, paper):
        for width, height in (PAPERS[name], PAPERS[name][::-1]):
            page = Page(name, width, height)
            free_width, free_height = (side - 2 * space for side in (page.drawing.width, page.drawing.height))
            if (x1 - x0) * 1000 / denominator <= free_width and (y1 - y0) * 1000 / denominator <= free_height:
                return page, View(denominator, ((x0 + x1) / 2, (y0 + y1) / 2), page.drawing.centre)
    if scale is not None or paper is not None:
        asked = " ".join(([f"1:{scale}"] if scale else []) + ([f"on {paper}"] if paper else []))
        raise WriteError(f"a plan of {x1 - x0:.1f} x {y1 - y0:.1f} m does not fit {asked}; ask for a smaller scale or larger paper.")
    page = Page("A0", *PAPERS["A0"])
    return page, View(1_000_000, ((x0 + x1) / 2, (y0 + y1) / 2), page.drawing.centre)


def _choices(scale: int | None, paper: str | None) -> tuple[tuple[int, str], ...]:
    """Scales and papers to try, best first."""
    if scale is None and paper is None:
        return _CHOICES
    return tuple((s, name) for s in ((scale,) if scale else USUAL_SCALES) for name in ((paper,) if paper else PAPERS))


def blank_page() -> Page:
    """Return the sheet for a drawing that has nothing to show."""
    return Page("A4", *PAPERS["A4"])
