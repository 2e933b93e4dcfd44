"""What a drawn page is made of: strokes, arcs and texts in millimetres of paper, in named layers."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from math import cos, radians, sin
from typing import TYPE_CHECKING, Literal

from indoor_bim.model import Point2

if TYPE_CHECKING:
    import shapely

_WIDTHS = {
    0.32: "ijlIJ ,.'·",
    0.40: "()-[]t/:;f|\\",
    0.44: "!r²",
    0.52: '*_°–"',
    0.56: "?Lcsz",
    0.60: "Fkvxy",
    0.64: "$0123456789EPSTYabdeghnopqu{}ß",
    0.72: "ABCKRVXZ",
    0.76: "HNU",
    0.80: "&DGOQ",
    0.84: "#+<=>^w~±×",
    0.88: "M",
    1.00: "@Wm…%",
}
_WIDTH = {character: width for width, characters in _WIDTHS.items() for character in characters}
_UNKNOWN_WIDTH = 1.0
_BOLD = 1.13
_ASCENT, _DESCENT = 0.78, 0.24


@dataclass(frozen=True, slots=True)
class Stroke:
    """Lines through corners; closed lines may be filled by their style."""

    lines: tuple[tuple[Point2, ...], ...]
    style: str
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Arc:
    """Part of a circle from one point to another, less than half of it."""

    start: Point2
    end: Point2
    radius: float
    clockwise: bool
    style: str


@dataclass(frozen=True, slots=True)
class Text:
    """One line of text; `at` lies on its baseline and `size` is the height of the type, millimetres."""

    at: Point2
    text: str
    size: float
    anchor: Literal["start", "middle", "end"] = "start"
    angle: float = 0.0
    style: str = "text"
    bold: bool = False

    @property
    def box(self) -> shapely.Polygon:
        """Rectangle that the text covers."""
        import shapely

        width = text_width(self.text, self.size, bold=self.bold)
        left = {"start": 0.0, "middle": -width / 2, "end": -width}[self.anchor]
        up, down = -_ASCENT * self.size, _DESCENT * self.size
        c, s = cos(radians(self.angle)), sin(radians(self.angle))
        corners = [(left, up), (left + width, up), (left + width, down), (left, down)]
        return shapely.Polygon([(self.at[0] + c * x - s * y, self.at[1] + s * x + c * y) for x, y in corners])


Mark = Stroke | Arc | Text


@dataclass(frozen=True, slots=True)
class Item:
    """Marks that belong to one element of the building or of the page."""

    marks: tuple[Mark, ...]
    kind: str = ""
    id: str = ""
    title: str = ""


@dataclass(frozen=True, slots=True)
class Layer:
    """Named group of items, drawn in the order given."""

    name: str
    label: str
    items: tuple[Item, ...]

    @property
    def texts(self) -> list[Text]:
        """All texts of the layer."""
        return [mark for item in self.items for mark in item.marks if isinstance(mark, Text)]


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Estimate the width of a line of sans-serif text from the usual widths of its letters, on the wide side.

    Parameters
    ----------
    text : str
        Characters.
    size : float
        Height of the type, millimetres.
    bold : bool
        Bold type.

    Returns
    -------
    float
        Width in millimetres.

    Examples
    --------
    >>> round(text_width("Kitchen", 2.5), 1)
    9.8
    """
    plain = (c for c in unicodedata.normalize("NFD", text) if not unicodedata.combining(c))
    return size * sum(_WIDTH.get(c, _UNKNOWN_WIDTH) for c in plain) * (_BOLD if bold else 1.0)


def shorten(text: str, size: float, *, width: float, bold: bool = False) -> str:
    """Cut a line of text so that it fits, with an ellipsis where something is left out.

    Parameters
    ----------
    text : str
        Characters.
    size : float
        Height of the type, millimetres.
    width : float
        Room for it, millimetres.
    bold : bool
        Bold type.

    Returns
    -------
    str
        The text, or its beginning and an ellipsis.

    Examples
    --------
    >>> shorten("Conference room", 2.5, width=15)
    'Conferen…'
    """
    if text_width(text, size, bold=bold) <= width:
        return text
    for length in range(len(text) - 1, 0, -1):
        shorter = text[:length].rstrip() + "…"
        if text_width(shorter, size, bold=bold) <= width:
            return shorter
    return ""


def wrap(text: str, size: float, *, width: float) -> list[str]:
    """Break a text into lines that fit, at blanks; a longer word is cut.

    Parameters
    ----------
    text : str
        Words.
    size : float
        Height of the type, millimetres.
    width : float
        Room for each line, millimetres.

    Returns
    -------
    list of str
        Lines.

    Examples
    --------
    >>> wrap("No walls were found.", 2.5, width=20)
    ['No walls were', 'found.']
    """
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, size) <= width:
            lines[-1] = longer
        else:
            lines.append(shorten(word, size, width=width))
    return [line for line in lines if line]
