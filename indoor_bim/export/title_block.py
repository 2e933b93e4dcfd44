"""What a plan says about itself: title block, scale bar, north arrow, legend and remarks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot
from statistics import median
from typing import Self

from indoor_bim.export.drawing import is_supported
from indoor_bim.export.marks import Item, Layer, Mark, Stroke, Text, shorten, text_width, wrap
from indoor_bim.export.page import Page, Rect, View
from indoor_bim.export.room_tags import area_text
from indoor_bim.model import Building, Room, Storey

_CAPTION, _BODY, _HEADLINE = 1.8, 2.5, 4.0
_INSET = 1.5
_NOTE, _NOTE_LEADING = 2.0, 3.0
_BAR_LENGTHS = (0.1, 0.2, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_ARROW = 4.5
_BAR_WIDTH, _BAR_HEIGHT = 80.0, 19.0
_NARROW = 150.0
_COLUMN = 62.0


def title_layer(building: Building, storey: Storey | None, page: Page, view: View | None) -> Layer:
    """Draw the frame and the title block.

    Parameters
    ----------
    building : Building
        Model.
    storey : Storey or None
        Storey that is drawn, if any.
    page : Page
        Sheet.
    view : View or None
        Way to the sheet, if a plan is drawn.

    Returns
    -------
    Layer
        Border, cells and their texts.
    """
    block = page.title
    row = block.height / 3
    cells: list[tuple[Rect, str, str]] = []
    columns = ((0.0, 86.0), (86.0, 66.0), (152.0, 38.0))
    table = (
        (("Project", building.name), ("Floor plan", storey.name if storey else "—"), ("Scale", f"1:{view.scale}" if view else "—")),
        (("Scan", building.source), ("Method", building.method), ("Paper, lengths", f"{page.paper}, metres")),
        _accuracy(storey),
    )
    for i, line in enumerate(table):
        for (x, width), (caption, text) in zip(columns, line, strict=True):
            cells.append((Rect(block.x + x, block.y + i * row, width, row), caption, text))
    marks: list[Mark] = [Stroke((page.frame.ring, block.ring), "frame", closed=True)]
    inner = [((block.x, block.y + i * row), (block.right, block.y + i * row)) for i in (1, 2)]
    inner += [((block.x + x, block.y), (block.x + x, block.bottom)) for x, _ in columns[1:]]
    marks.append(Stroke(tuple(inner), "cell"))
    for i, (cell, caption, text) in enumerate(cells):
        marks += _cell(cell, caption, text, size=_HEADLINE if i < len(columns) else _BODY)
    return Layer("title-block", "Title block", (Item(tuple(marks), "title-block"),))


def notes_layer(building: Building, storey: Storey, page: Page, view: View, *, numbered: tuple[tuple[int, Room], ...]) -> Layer:
    """Draw scale bar, north arrow, legend of the lines used, numbered rooms and remarks.

    Parameters
    ----------
    building : Building
        Model.
    storey : Storey
        Storey that is drawn.
    page : Page
        Sheet.
    view : View
        Way to the sheet.
    numbered : tuple of (int, Room)
        Rooms whose names did not fit into them.

    Returns
    -------
    Layer
        What stands in the notes field of the page.
    """
    field = page.notes
    items = [Item(tuple(_scale_bar(field, view)), "scale-bar")]
    north = _north(building)
    if north is not None:
        items.append(Item(tuple(_north_arrow(field, north)), "north"))
    remarks = [f"{number}  {room.name}, {area_text(room)}" for number, room in numbered]
    remarks += _legend(storey)
    remarks += building.warnings
    items.append(Item(tuple(_note_texts(remarks, field)), "notes"))
    return Layer("notes", "Notes", tuple(items))


def blank_layer(building: Building, storey: Storey | None, page: Page) -> Layer:
    """Say in words why there is no plan to draw."""
    place = page.drawing
    width = min(place.width - 20, 200.0)
    missing = f"{storey.name} has no walls, columns or rooms." if storey else "The model has no storeys."
    lines = [("No floor plan", 7.0, True), ("", 4.0, False), (missing, 3.5, False)]
    lines += [(line, 3.5, False) for warning in building.warnings for line in wrap(warning, 3.5, width=width)]
    height = sum(1.5 * size for _, size, _ in lines)
    y = place.centre[1] - height / 2
    texts = []
    for text, size, bold in lines:
        y += 1.5 * size
        if text:
            texts.append(Text((place.centre[0], y), text, size, "middle", bold=bold))
    return Layer("notes", "Notes", (Item(tuple(texts), "notes"),))


def _accuracy(storey: Storey | None) -> tuple[tuple[str, str], ...]:
    walls = storey.walls if storey else ()
    deviations = [wall.evidence.rmse for wall in walls if wall.evidence.rmse is not None]
    deviation = f"{1000 * median(deviations):.0f} mm" if deviations else "not known"
    one_sided = sum(wall.evidence.sides < 2 for wall in walls)
    coverage = f"{sum(wall.evidence.coverage for wall in walls) / len(walls):.0%}" if walls else "—"
    return (
        ("Points from their wall face, root mean square, median of walls", deviation),
        ("Walls seen from one side only", f"{one_sided} of {len(walls)}"),
        ("Wall surface seen", coverage),
    )


def _cell(cell: Rect, caption: str, text: str, *, size: float) -> Iterator[Mark]:
    width = cell.width - 2 * _INSET
    yield Text((cell.x + _INSET, cell.y + 3.2), shorten(caption, _CAPTION, width=width), _CAPTION, style="caption")
    fitting = min(size, max(_BODY, size * width / max(text_width(text, size), 1e-6)))
    yield Text((cell.x + _INSET, cell.bottom - 2.6), shorten(text, fitting, width=width) or "—", fitting)


def _scale_bar(field: Rect, view: View) -> Iterator[Mark]:
    unit = next((length for length in _BAR_LENGTHS if length * view.mm_per_metre >= 9), _BAR_LENGTHS[-1])
    step = unit * view.mm_per_metre
    x, y = field.x + 4, field.bottom - 6
    cells = [Rect(x + i * step, y, step, 1.5) for i in range(4)]
    yield Stroke(tuple(cell.ring for cell in cells[::2]), "bar-dark", closed=True)
    yield Stroke(tuple(cell.ring for cell in cells[1::2]), "bar-light", closed=True)
    for i in range(5):
        yield Text((x + i * step, y - 1), f"{i * unit:g}", _NOTE, "middle")
    yield Text((x + 4 * step + 2.5, y + 1.5), "m", _NOTE)


def _north(building: Building) -> tuple[float, float] | None:
    """Grid north as a unit vector on paper, when the scan's coordinate system is known."""
    if building.crs is None:
        return None
    rows = building.transform_cloud_to_model
    x, y = rows[0][1], -rows[1][1]
    length = hypot(x, y)
    return (x / length, y / length) if length > 0 else None


def _north_arrow(field: Rect, north: tuple[float, float]) -> Iterator[Mark]:
    u, v = north
    x, y = field.x + 68, field.bottom - 9
    tip, tail = (x + u * _ARROW, y + v * _ARROW), (x - u * _ARROW, y - v * _ARROW)
    wings = [(tail[0] + s * 2.5 * v, tail[1] - s * 2.5 * u) for s in (1, -1)]
    yield Stroke(((tip, wings[0], (x - u * 3, y - v * 3), wings[1]),), "north", closed=True)
    yield Text((x + u * (_ARROW + 2.2), y + v * (_ARROW + 2.2) + 0.9), "N", _BODY, "middle", bold=True)


def _legend(storey: Storey) -> list[str]:
    """Sentences on the kinds of lines that the plan of a storey uses."""
    texts = []
    if any(not wall.thickness_measured for wall in storey.walls):
        texts.append("Wide hatch, far face dashed: one face seen; thickness, and outer lengths with it, assumed.")
    if any(not is_supported(wall) for wall in storey.walls):
        texts.append("Dashed walls: hardly seen by the scan.")
    return texts


def _note_texts(remarks: list[str], field: Rect) -> Iterator[Text]:
    """Remarks in columns above the scale bar, or beside it where they need more room; as many lines as there is room for."""
    above = Rect(field.x + 4, field.y, field.width - 7, field.height - _BAR_HEIGHT)
    columns = _Columns.of(above, remarks)
    if not columns.fit and field.width >= _NARROW:
        columns = _Columns.of(_beside(field), remarks)
    lines = columns.lines if columns.fit else (*columns.lines[: columns.room - 1], "… more in the model")
    for i, line in enumerate(lines):
        column, row = divmod(i, columns.rows)
        yield Text((columns.place.x + column * columns.width, columns.place.y + 3.5 + row * _NOTE_LEADING), line, _NOTE)


@dataclass(frozen=True, slots=True)
class _Columns:
    """Lines of text in columns of a place on the sheet."""

    place: Rect
    rows: int
    width: float
    lines: tuple[str, ...]

    @classmethod
    def of(cls, place: Rect, remarks: list[str]) -> Self:
        width = place.width / max(1, int(place.width // _COLUMN))
        lines = tuple(line for remark in remarks for line in wrap(remark, _NOTE, width=width - 3))
        return cls(place, int((place.height - 1) / _NOTE_LEADING), width, lines)

    @property
    def room(self) -> int:
        return self.rows * round(self.place.width / self.width)

    @property
    def fit(self) -> bool:
        return len(self.lines) <= self.room


def _beside(field: Rect) -> Rect:
    return Rect(field.x + _BAR_WIDTH, field.y, field.width - _BAR_WIDTH - 3, field.height)
