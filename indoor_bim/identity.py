"""GlobalIds that elements keep from run to run: they follow from where an element stands in the scan, not from its number.

A later run that finds one wall more renumbers all walls behind it; the others keep their GlobalIds all the same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from indoor_bim.export.guids import global_id
from indoor_bim.frame import Frame
from indoor_bim.model import Building, Column, Opening, Ring, Room, Slab, Storey, Wall

CELLS = (0.5, 0.5, 2.0)  # metres: what moves by much less usually stays in its cell, and so keeps its GlobalId
Element = TypeVar("Element", Wall, Opening, Column, Room, Slab)
Point3 = tuple[float, float, float]


def with_guids(building: Building) -> Building:
    """Give every element without a GlobalId one that follows from the scan's name and from where in the scan it stands.

    Parameters
    ----------
    building : Building
        Model, metres.

    Returns
    -------
    Building
        The same model; GlobalIds that were there stay.
    """
    frame = Frame.from_matrix(building.transform_cloud_to_model)
    used: Counter[str] = Counter()

    def named(elements: Sequence[Element], middles: Sequence[Point3]) -> tuple[Element, ...]:
        if not elements:
            return ()
        cells = np.round(frame.to_scan(middles) * frame.scale / CELLS).astype(int).tolist()
        guids: dict[int, str] = {}
        for i in sorted(range(len(elements)), key=lambda i: middles[i]):
            place = f"{building.source}/{type(elements[i]).__name__}/at {' '.join(map(str, cells[i]))}"
            used[place] += 1
            guids[i] = elements[i].guid or global_id(f"{place}/{used[place]}")
        return tuple(replace(element, guid=guids[i]) for i, element in enumerate(elements))

    def placed(storey: Storey) -> Storey:
        walls = tuple(replace(wall, openings=named(wall.openings, [_in_wall(wall, o) for o in wall.openings])) for wall in storey.walls)
        return replace(
            storey,
            walls=named(walls, [_on_axis(wall, wall.length / 2) for wall in walls]),
            columns=named(storey.columns, [_over(c.footprint, c.base) for c in storey.columns]),
            rooms=named(storey.rooms, [_over(room.outline.exterior, room.floor) for room in storey.rooms]),
            slabs=named(storey.slabs, [_over(slab.outline.exterior, slab.level) for slab in storey.slabs]),
        )

    return replace(building, storeys=tuple(placed(storey) for storey in building.storeys))


def _in_wall(wall: Wall, opening: Opening) -> Point3:
    return _on_axis(wall, opening.start + opening.width / 2)


def _on_axis(wall: Wall, along: float) -> Point3:
    (x0, y0), (x1, y1) = wall.axis
    share = along / wall.length
    return x0 + share * (x1 - x0), y0 + share * (y1 - y0), wall.base


def _over(ring: Ring, level: float) -> Point3:
    """Point above the middle of the area of a ring."""
    import shapely

    middle = shapely.Polygon(ring).centroid
    return float(middle.x), float(middle.y), level
