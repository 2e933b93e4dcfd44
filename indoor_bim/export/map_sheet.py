"""Map sheet of a village: footprints with labels, spot heights and a grid of scan coordinates, on paper at 1:500 or 1:1000."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, hypot

import numpy as np
import shapely

from indoor_bim.export.marks import Item, Layer, Mark, Stroke, Text, shorten, text_width, wrap
from indoor_bim.export.mesh import region
from indoor_bim.export.page import Page, Rect, View, fit_page
from indoor_bim.export.scan_coordinates import to_scan
from indoor_bim.model import Point2
from indoor_bim.outdoor.model import House, Village

SCALES = (500, 1000, 2000, 5000, 10_000)
PAPERS = ("A4", "A3", "A2", "A1", "A0")
EDGE = 12.0
LABEL_SIZES = (2.2, 2.0, 1.8, 1.6, 1.4, 1.2, 1.0)
SMALL, CAPTION, BODY, HEADLINE = 1.6, 1.8, 2.5, 4.0
GRID_MM = 100.0
CROSS = 2.0


@dataclass(frozen=True, slots=True)
class MapSheet:
    """Drawn sheet.

    Parameters
    ----------
    page : Page
        Paper.
    view : View
        Way from the model to the paper.
    layers : tuple of Layer
        What lies on it, in drawing order.
    """

    page: Page
    view: View
    layers: tuple[Layer, ...]


def draw_map(village: Village, *, scale: int | None = None) -> MapSheet:
    """Draw the sheet.

    Parameters
    ----------
    village : Village
        Houses and ground, metres.
    scale : int, optional
        Denominator, 500 for 1:500; by default the first of `SCALES` that fits A3, else on larger paper.

    Raises
    ------
    WriteError
        If the village does not fit the scale asked for on the largest paper.
    """
    page, view = _fit(_bounds(village), scale)
    layers = (
        Layer("grid", "Grid", (Item(tuple(_grid(village, page, view)), "grid"),)),
        Layer("houses", "Houses", tuple(_house(house, view) for house in village.houses)),
        _spots(village, view, page),
        Layer("labels", "Labels", tuple(Item(tuple(_label(house, view)), "label") for house in village.houses)),
        Layer("title-block", "Title block", (Item(tuple(_title(village, page, view)), "title-block"),)),
        Layer("notes", "Notes", (Item(tuple(_notes(village, page, view)), "notes"),)),
    )
    return MapSheet(page, view, layers)


def label_lines(house: House) -> tuple[str, ...]:
    """What stands in a house: material and storeys, and its area.

    Examples
    --------
    >>> label_lines(House("H1", ((0, 0), (8, 0), (8, 5), (0, 5)), 0.0, 6.0, 2, material="brick"))
    ('brick 2', '40.0 m²')
    """
    return " ".join(filter(None, (house.material, str(house.storeys)))), f"{house.area:.1f} m²"


def _bounds(village: Village) -> tuple[float, float, float, float]:
    points = [corner for house in village.houses for corner in house.footprint]
    spots = [(x, y) for x, y, _ in village.spot_heights]
    x0, y0, x1, y1 = shapely.MultiPoint(points or spots or [(0.0, 0.0)]).bounds
    return x0 - 5.0, y0 - 5.0, x1 + 5.0, y1 + 5.0


def _fit(bounds: tuple[float, float, float, float], scale: int | None) -> tuple[Page, View]:
    from indoor_bim.errors import WriteError

    papers = [(scale, paper) for paper in PAPERS] if scale is not None else []
    if scale is None:
        papers = [(s, paper) for s in SCALES[:2] for paper in PAPERS[:2]]
        papers += [(s, paper) for s in SCALES for paper in PAPERS]
    for denominator, paper in papers[:-1]:
        try:
            return fit_page(bounds, scale=denominator, paper=paper, space=EDGE)
        except WriteError:
            continue
    return fit_page(bounds, scale=papers[-1][0], paper=papers[-1][1], space=EDGE)


def _house(house: House, view: View) -> Item:
    seen = tuple((view.point(facade.start), view.point(facade.end)) for facade in house.facades if facade.seen)
    hidden = tuple((view.point(facade.start), view.point(facade.end)) for facade in house.facades if not facade.seen)
    ring = tuple(view.point(corner) for corner in house.footprint)
    marks: list[Mark] = [Stroke((ring,), "house-body", closed=True)]
    if seen or not hidden:
        marks.append(Stroke(seen or ((*ring, ring[0]),), "house-wall"))
    if hidden:
        marks.append(Stroke(hidden, "house-wall unseen"))
    return Item(tuple(marks), "house", house.id, f"{house.id}: {house.area:.2f} m², {house.height:.2f} m high, {house.storeys} storeys")


def _label(house: House, view: View) -> list[Text]:
    """Identifier, material and storeys, area: about the centroid, else where there is most room, as large as fits."""
    body = region(house.footprint)
    place = view.shape(body)
    centres = [house.centroid, shapely.maximum_inscribed_circle(body, tolerance=0.1).coords[0]]
    texts: list[Text] = []
    for size in LABEL_SIZES:
        for centre in centres:
            texts = _label_texts(house, view.point(centre), size)
            if all(place.contains(text.box) for text in texts):
                return texts
    return texts


def _label_texts(house: House, at: Point2, size: float) -> list[Text]:
    x, y = at
    texts = [Text((x, y - 0.75 * size), house.id, 0.8 * size, "middle", style="caption")]
    for i, line in enumerate(label_lines(house)):
        texts.append(Text((x, y + (0.6 + 1.25 * i) * size), line, size, "middle", bold=i == 0))
    return texts


def _spots(village: Village, view: View, page: Page) -> Layer:
    """Spot heights that lie on the sheet and on no house."""
    houses = shapely.union_all([house.polygon.buffer(0.5) for house in village.houses]) if village.houses else shapely.Polygon()
    place = page.drawing
    levels = to_scan(village.spot_heights or np.zeros((0, 3)), village.transform_cloud_to_model)[:, 2]
    items = []
    taken: list[shapely.Geometry] = []
    for (x, y, _), level in zip(village.spot_heights, levels.tolist(), strict=True):
        u, v = view.point((x, y))
        text = Text((u + 0.7, v + 0.6), f"{level:.2f}", SMALL, style="spot-text")
        box = text.box
        inside = place.x + 2 < u < place.right - 8 and place.y + 3 < v < place.bottom - 2
        if not inside or houses.contains(shapely.Point(x, y)) or view.shape(houses).intersects(box):
            continue
        if any(box.intersects(other) for other in taken):
            continue
        taken.append(box)
        dot = tuple((u + 0.3 * a, v + 0.3 * b) for a, b in ((1, 0), (0.5, 0.87), (-0.5, 0.87), (-1, 0), (-0.5, -0.87), (0.5, -0.87)))
        items.append(Item((Stroke((dot,), "spot", closed=True), text), "spot-height"))
    return Layer("spot-heights", "Spot heights", tuple(items))


def _grid(village: Village, page: Page, view: View) -> Iterator[Mark]:
    """Crosses at round scan coordinates, with the coordinates at the edges."""
    place = page.drawing
    step = GRID_MM / view.mm_per_metre
    corners = [view.model_point(corner) for corner in place.ring]
    rows = np.asarray(village.transform_cloud_to_model)
    scan = to_scan([(x, y, 0.0) for x, y in corners], village.transform_cloud_to_model)
    scale = hypot(*rows[:2, 0])
    spacing = _round_up(step / scale)
    low, high = scan[:, :2].min(axis=0), scan[:, :2].max(axis=0)
    xs = np.arange(ceil(low[0] / spacing), high[0] // spacing + 1) * spacing
    ys = np.arange(ceil(low[1] / spacing), high[1] // spacing + 1) * spacing
    z = float(scan[:, 2].mean())
    crosses: list[tuple[Point2, ...]] = []
    for x in xs:
        for y in ys:
            local = rows @ [x, y, z, 1.0]
            u, v = view.point((local[0], local[1]))
            if place.x + CROSS < u < place.right - CROSS and place.y + CROSS < v < place.bottom - CROSS:
                crosses += [((u - CROSS, v), (u + CROSS, v)), ((u, v - CROSS), (u, v + CROSS))]
                yield Text((u + 0.8, v - 0.8), f"{x:.0f}", SMALL, style="caption")
                yield Text((u + 0.8, v + 2.2), f"{y:.0f}", SMALL, style="caption")
    if crosses:
        yield Stroke(tuple(crosses), "grid-cross")


def _round_up(length: float) -> float:
    """Next of 1, 2, 5, 10, 20, ... that is not less, within a millimetre."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(next(power * factor for factor in (1, 2, 5, 10) if power * factor >= length - 1e-3))


def _title(village: Village, page: Page, view: View) -> Iterator[Mark]:
    block, row = page.title, page.title.height / 3
    rmse = [house.evidence.rmse for house in village.houses if house.evidence.rmse is not None]
    hidden = sum(facade.length for house in village.houses for facade in house.facades if not facade.seen)
    table = (
        (("Village", village.name), ("Houses", str(len(village.houses))), ("Scale", f"1:{view.scale}")),
        (("Scan", village.source), ("Method", village.method), ("Paper, lengths", f"{page.paper}, metres")),
        (
            ("Reference system", village.crs or "coordinates of the scan"),
            ("Points from their wall, root mean square", f"{1000 * float(np.median(rmse)):.0f} mm" if rmse else "not known"),
            ("Outline not seen", f"{hidden:.1f} m"),
        ),
    )
    columns = ((0.0, 86.0), (86.0, 66.0), (152.0, 38.0))
    yield Stroke((page.frame.ring, block.ring), "frame", closed=True)
    inner = [((block.x, block.y + i * row), (block.right, block.y + i * row)) for i in (1, 2)]
    yield Stroke((*inner, *(((block.x + x, block.y), (block.x + x, block.bottom)) for x, _ in columns[1:])), "cell")
    for i, line in enumerate(table):
        for (x, width), (caption, text) in zip(columns, line, strict=True):
            left, right = block.x + x + 1.5, width - 3.0
            yield Text((left, block.y + i * row + 3.2), shorten(caption, CAPTION, width=right), CAPTION, style="caption")
            size = HEADLINE if i == 0 else BODY
            size = min(size, max(BODY, size * right / max(text_width(text, size), 1e-6)))
            yield Text((left, block.y + (i + 1) * row - 2.6), shorten(text, size, width=right) or "—", size)


def _notes(village: Village, page: Page, view: View) -> Iterator[Mark]:
    field = page.notes
    unit = next(length for length in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if length * view.mm_per_metre >= 9 or length == 1000)
    step = unit * view.mm_per_metre
    x, y = field.x + 4, field.bottom - 6
    cells = [Rect(x + i * step, y, step, 1.5) for i in range(4)]
    yield Stroke(tuple(cell.ring for cell in cells[::2]), "bar-dark", closed=True)
    yield Stroke(tuple(cell.ring for cell in cells[1::2]), "bar-light", closed=True)
    for i in range(5):
        yield Text((x + i * step, y - 1), f"{i * unit}", 2.0, "middle")
    yield Text((x + 4 * step + 2.5, y + 1.5), "m", 2.0)
    rows = village.transform_cloud_to_model
    u, v = rows[0][1], -rows[1][1]
    length = hypot(u, v) or 1.0
    yield from _north(x + 4 * step + 16, field.bottom - 9, u / length, v / length)
    remarks = ["Labels: material, storeys, area. Spot heights in the height system of the scan.", *village.warnings]
    left = x + 4 * step + 26
    width = field.right - left - 3
    if width > 30:
        lines = [line for remark in remarks for line in wrap(remark, 2.0, width=width)]
        most = int((field.height - 3) / 3)
        lines = lines if len(lines) <= most else [*lines[: most - 1], "… more in the model"]
        for i, line in enumerate(lines):
            yield Text((left, field.y + 4 + 3 * i), line, 2.0)


def _north(x: float, y: float, u: float, v: float) -> Iterator[Mark]:
    tip, tail = (x + u * 4.5, y + v * 4.5), (x - u * 4.5, y - v * 4.5)
    wings = [(tail[0] + s * 2.5 * v, tail[1] - s * 2.5 * u) for s in (1, -1)]
    yield Stroke(((tip, wings[0], (x - u * 3, y - v * 3), wings[1]),), "north", closed=True)
    yield Text((x + u * 6.7, y + v * 6.7 + 0.9), "N", BODY, "middle", bold=True)
