"""Rooms: what walls enclose, as far as somebody saw its floor or ceiling."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from indoor_bim.plan.raster import Raster

if TYPE_CHECKING:
    import networkx as nx
    import shapely


def room_polygons(
    graph: nx.Graph, footprints: list[shapely.Polygon], *, min_area: float = 1.0, min_width: float = 0.5
) -> list[shapely.Polygon]:
    """Free space inside every loop of the wall graph.

    Parameters
    ----------
    graph : networkx.Graph
        Planar graph of corners and wall stretches (`wall_graph`), metres.
    footprints : list of shapely.Polygon
        Outlines of the walls.
    min_area : float
        Smallest room, square metres.
    min_width : float
        Smallest diameter of the largest circle that fits into a room, metres.

    Returns
    -------
    list of shapely.Polygon
        Rooms, sorted by position; no two overlap, none overlaps a wall.
    """
    import shapely

    lines = [shapely.LineString(edge) for edge in sorted(tuple(sorted(edge)) for edge in graph.edges)]
    walls = shapely.union_all(footprints, grid_size=1e-6) if footprints else shapely.Polygon()
    rooms = []
    for cell in shapely.get_parts(shapely.polygonize(lines)):
        for part in shapely.get_parts(shapely.difference(cell, walls, grid_size=1e-6)):
            if part.geom_type == "Polygon" and part.area >= min_area and not part.buffer(-min_width / 2).is_empty:
                rooms.append(part.simplify(0.001))
    return sorted(rooms, key=lambda room: tuple(np.round([*room.representative_point().coords[0], room.area], 4)))


def observed_share(polygon: shapely.Polygon, seen: Raster) -> float:
    """Share of a polygon's area that lies under pixels other than zero.

    Parameters
    ----------
    polygon : shapely.Polygon
        Plan polygon, metres.
    seen : Raster
        Image that is not zero where floor or ceiling was seen.
    """
    import shapely

    low = seen.pixel(np.array([polygon.bounds[:2]]))[0]
    high = seen.pixel(np.array([polygon.bounds[2:]]))[0]
    rows, columns = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij")
    centres = seen.centre(np.column_stack([rows.ravel(), columns.ravel()]))
    centres = centres[shapely.contains_xy(polygon, centres[:, 0], centres[:, 1])]
    return float((seen.sample(centres) != 0).mean()) if len(centres) else 0.0
