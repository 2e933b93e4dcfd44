"""A floor plan as a page of marks: which layers it has and in which order they lie."""

from __future__ import annotations

from dataclasses import dataclass

from indoor_bim.errors import WriteError
from indoor_bim.export.dimensions import dimension_layer, dimension_space
from indoor_bim.export.drawing import drawn_bounds, opening_layers, swing_areas, wall_layers
from indoor_bim.export.marks import Layer, Text
from indoor_bim.export.mesh import region
from indoor_bim.export.page import Page, View, blank_page, fit_page
from indoor_bim.export.plan_style import USUAL, PlanStyle
from indoor_bim.export.room_dimensions import room_dimensions
from indoor_bim.export.room_tags import room_layer, room_tags
from indoor_bim.export.title_block import blank_layer, notes_layer, title_layer
from indoor_bim.model import Building, Point2, Storey


@dataclass(frozen=True, slots=True)
class Plan:
    """Drawn page.

    Parameters
    ----------
    page : Page
        Sheet.
    view : View or None
        Way from the model to the sheet, if a plan is drawn.
    layers : tuple of Layer
        What lies on the sheet, in drawing order.
    room_lines : tuple of (point, point)
        Dimension lines inside rooms, metres.
    """

    page: Page
    view: View | None
    layers: tuple[Layer, ...]
    room_lines: tuple[tuple[Point2, Point2], ...] = ()

    @property
    def texts(self) -> list[Text]:
        """All texts of the page."""
        return [text for layer in self.layers for text in layer.texts]


def draw_plan(building: Building, *, storey: str | None = None, style: PlanStyle = USUAL) -> Plan:
    """Draw the plan of one storey.

    Parameters
    ----------
    building : Building
        Model, metres.
    storey : str, optional
        Identifier of the storey; by default the first one.
    style : PlanStyle
        Scale and paper.

    Returns
    -------
    Plan
        Page with its layers; a building without anything to draw gets a page that says why.

    Raises
    ------
    WriteError
        If there is no storey of that identifier, or if its plan does not fit the paper asked for.
    """
    shown = find_storey(building, storey)
    bounds = drawn_bounds(shown) if shown else None
    if shown is None or bounds is None:
        page = blank_page()
        return Plan(page, None, (blank_layer(building, shown, page), title_layer(building, shown, page, None)))
    page, view = fit_page(bounds, scale=style.scale, paper=style.paper, space=dimension_space(shown))
    solids = [region(element.footprint) for kind in (shown.walls, shown.columns) for element in kind]
    obstacles = [*swing_areas(shown, view), *(view.shape(shape) for shape in solids)]
    inner = room_dimensions(shown, view, obstacles=obstacles)
    tags = room_tags(shown, view, obstacles=[*obstacles, *inner.covered], dimensioned=inner.rooms)
    if tags.numbered:
        crowded = frozenset(room.id for _, room in tags.numbered)
        inner = room_dimensions(shown, view, obstacles=obstacles, skip=crowded)
        tags = room_tags(shown, view, obstacles=[*obstacles, *inner.covered], dimensioned=inner.rooms)
    layers = (
        room_layer(shown, view),
        *wall_layers(shown, view),
        *opening_layers(shown, view),
        inner.layer,
        tags.layer,
        dimension_layer(shown, view),
        notes_layer(building, shown, page, view, numbered=tags.numbered),
        title_layer(building, shown, page, view),
    )
    return Plan(page, view, layers, inner.lines)


def find_storey(building: Building, id: str | None) -> Storey | None:
    """Return the storey of an identifier, or the first one for None; None when the building has no storeys.

    Raises
    ------
    WriteError
        If there is no storey of that identifier.
    """
    if id is None:
        return building.storeys[0] if building.storeys else None
    for storey in building.storeys:
        if storey.id == id:
            return storey
    known = ", ".join(storey.id for storey in building.storeys) or "none"
    raise WriteError(f'there is no storey "{id}" to draw; the building has: {known}.')
