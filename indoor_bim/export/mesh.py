"""The building as named closed surfaces of triangles: what OBJ, PLY and other mesh files are written from.

Every element is cut into cells in plan and bands in height: each pair of cell and band is solid or void. The surface is the
border between solid and void. Cells share their corners, bands share the triangles of their cells, so that each surface closes
exactly and holds no inner faces.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Building, Opening, Point2, Ring, Storey, Wall

if TYPE_CHECKING:
    import shapely
    from shapely.geometry.base import BaseGeometry

Corner = tuple[float, float, float]
Material = Literal["wall", "column", "floor", "ceiling", "door", "window", "frame", "space", "house", "ground"]

COLOURS: dict[Material, tuple[int, int, int]] = {
    "wall": (222, 217, 206),
    "column": (190, 182, 168),
    "floor": (168, 140, 108),
    "ceiling": (240, 240, 238),
    "door": (150, 102, 62),
    "window": (140, 190, 220),
    "frame": (236, 236, 232),
    "space": (196, 222, 200),
    "house": (214, 202, 184),
    "ground": (150, 160, 120),
}
OPACITY: dict[Material, float] = {"window": 0.4, "space": 0.3}

_GRID = 1e-6
_PANEL_THICKNESS: dict[str, float] = {"door": 0.04, "window": 0.02}


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Closed surface of one element.

    Parameters
    ----------
    id : str
        Identifier of the element in the model.
    material : str
        Kind of the element, a key of `COLOURS`.
    vertices : (n, 3) float64
        Corners in model coordinates, metres.
    triangles : (m, 3) int64
        Corners of each triangle, counter-clockwise when seen from outside.
    """

    id: str
    material: Material
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]

    @property
    def volume(self) -> float:
        """Enclosed volume in cubic metres."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@dataclass(frozen=True, slots=True)
class Void:
    """Prism taken out of an element."""

    region: shapely.Polygon
    bottom: float
    top: float


def building_parts(building: Building, *, spaces: bool = False) -> list[Part]:
    """Make the surfaces of all elements of a building.

    Parameters
    ----------
    building : Building
        Model, metres.
    spaces : bool
        Also make the air of each room a closed surface.

    Returns
    -------
    list of Part
        Walls with their openings cut out, door and window panels, columns and slabs, storey by storey.
    """
    return [part for storey in building.storeys for part in storey_parts(storey, spaces=spaces)]


def storey_parts(storey: Storey, *, spaces: bool = False) -> Iterator[Part]:
    """Make the surfaces of the elements of one storey.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    spaces : bool
        Also make the air of each room a closed surface.

    Yields
    ------
    Part
        Surface of a wall, panel, column, slab or room that has a volume.
    """
    for wall in storey.walls:
        yield from _part(wall.id, "wall", region(wall.footprint), wall.base, wall.base + wall.height, opening_voids(wall))
        for opening in wall.openings:
            if opening.kind != "opening":
                bottom, top = _opening_heights(wall, opening)
                yield from _part(opening.id, opening.kind, _panel(wall, opening), bottom, top)
    for column in storey.columns:
        yield from _part(column.id, "column", region(column.footprint), column.base, column.base + column.height)
    for slab in storey.slabs:
        bottom = slab.level - slab.thickness if slab.kind == "floor" else slab.level
        yield from _part(slab.id, slab.kind, region(slab.outline.exterior, slab.outline.holes), bottom, bottom + slab.thickness)
    if spaces:
        for room in storey.rooms:
            yield from _part(room.id, "space", region(room.outline.exterior, room.outline.holes), room.floor, room.floor + room.height)


def region(ring: Ring, holes: tuple[Ring, ...] = ()) -> BaseGeometry:
    """Return the area inside a ring and outside its holes; a ring that crosses itself gives several polygons, metres."""
    import shapely

    return shapely.make_valid(shapely.Polygon(ring, holes), method="structure", keep_collapsed=False)


def opening_region(wall: Wall, opening: Opening, *, depth: float | None = None) -> Ring:
    """Rectangle of an opening in plan.

    Parameters
    ----------
    wall : Wall
        Wall that holds the opening.
    opening : Opening
        Door, window or passage.
    depth : float, optional
        Extent across the wall, centred on its axis, metres; by default what goes through every part of the wall.

    Returns
    -------
    ring
        Four corners in metres, counter-clockwise, the first two on the right side of the axis.
    """
    origin, along, left = wall_frame(wall)
    offsets = (np.asarray(wall.footprint) - origin) @ left
    right_side, left_side = (offsets.min() - 1.0, offsets.max() + 1.0) if depth is None else (-depth / 2, depth / 2)
    start, end = opening.start, opening.start + opening.width
    corners = [origin + s * along + o * left for s, o in ((start, right_side), (end, right_side), (end, left_side), (start, left_side))]
    return tuple((float(x), float(y)) for x, y in corners)


def wall_frame(wall: Wall) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the first end of a wall's axis, its unit direction and the unit normal to its left, each (2,) float64 in metres."""
    origin, end = np.asarray(wall.axis, dtype=np.float64)
    along = (end - origin) / np.hypot(*(end - origin))
    return origin, along, np.array([-along[1], along[0]])


def opening_voids(wall: Wall) -> list[Void]:
    """Return the prisms that the openings of a wall take out of it."""
    import shapely

    return [Void(shapely.Polygon(opening_region(wall, opening)), *_opening_heights(wall, opening)) for opening in wall.openings]


def closed_surface(
    polygon: BaseGeometry, *, bottom: float, top: float, voids: Sequence[Void] = ()
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Triangulate the surface of an upright prism with upright prisms taken out.

    Parameters
    ----------
    polygon : shapely geometry
        Plan of the prism, metres.
    bottom, top : float
        Its lower and upper end, metres.
    voids : sequence of Void
        What is taken out; parts outside the prism do nothing.

    Returns
    -------
    vertices : (n, 3) float64
        Corners, metres, on a grid of a micrometre in plan.
    triangles : (m, 3) int64
        Corners of each triangle, counter-clockwise when seen from outside; empty when nothing is left.

    Examples
    --------
    >>> import shapely
    >>> vertices, triangles = closed_surface(shapely.box(0, 0, 2, 1), bottom=0, top=3)
    >>> vertices.shape, triangles.shape
    ((8, 3), (12, 3))
    """
    import shapely

    levels = sorted({bottom, top, *(level for void in voids for level in (void.bottom, void.top) if bottom < level < top)})
    cells = _cells(polygon, [void.region for void in voids])
    inside = shapely.point_on_surface(np.array(cells, dtype=object))
    solid = np.ones((len(cells), len(levels) - 1), dtype=bool)
    for void in voids:
        in_plan = shapely.intersects(void.region, inside)
        in_height = np.array([void.bottom < (low + high) / 2 < void.top for low, high in pairwise(levels)])
        solid &= ~np.outer(in_plan, in_height)
    corners = np.array([*_flat_faces(cells, solid, levels), *_upright_faces(cells, solid, levels)], dtype=np.float64)
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return _separate_pinches(vertices, index.reshape(-1, 3).astype(np.int64))


def _separate_pinches(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Give sheets of a surface that only touch along an edge their own corners, so that each edge has two triangles."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    _, edge, uses = np.unique(np.sort([start, end], axis=0), axis=1, return_inverse=True, return_counts=True)
    if (uses == 2).all():
        return vertices, triangles
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    follower = np.roll(np.arange(len(start)).reshape(-1, 3), -1, axis=1).ravel()
    paired = np.argsort(edge, kind="stable")
    one, other = paired[uses[edge[paired]] == 2].reshape(-1, 2).T
    rows, columns = np.concatenate([one, follower[one]]), np.concatenate([follower[other], other])
    count, corner = connected_components(coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(start), len(start))), directed=False)
    separate = np.zeros((count, 3))
    separate[corner] = vertices[start]
    return separate, corner.reshape(-1, 3).astype(np.int64)


def _part(id: str, material: Material, polygon: BaseGeometry, bottom: float, top: float, voids: Sequence[Void] = ()) -> Iterator[Part]:
    if polygon.area > _GRID and top > bottom:
        vertices, triangles = closed_surface(polygon, bottom=bottom, top=top, voids=voids)
        if len(triangles):
            yield Part(id, material, vertices, triangles)


def _opening_heights(wall: Wall, opening: Opening) -> tuple[float, float]:
    bottom = wall.base + opening.sill
    return bottom, min(bottom + opening.height, wall.base + wall.height)


def _panel(wall: Wall, opening: Opening) -> BaseGeometry:
    import shapely

    depth = min(_PANEL_THICKNESS[opening.kind], wall.thickness)
    return shapely.Polygon(opening_region(wall, opening, depth=depth)).intersection(region(wall.footprint))


def _cells(polygon: BaseGeometry, regions: Sequence[shapely.Polygon]) -> list[shapely.Polygon]:
    """Cut a polygon along the borders of regions; neighbours share every corner along their common border."""
    import shapely

    borders = [region.exterior.intersection(polygon) for region in regions]
    lines = shapely.union_all([polygon.boundary, *borders], grid_size=_GRID)
    cells = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    return [cell for cell in cells if cell.area > 0 and polygon.intersects(cell.point_on_surface())]


def _flat_faces(cells: list[shapely.Polygon], solid: NDArray[np.bool_], levels: list[float]) -> Iterator[list[Corner]]:
    import shapely

    for cell, bands in zip(cells, solid, strict=True):
        padded = np.concatenate([[False], bands, [False]]).astype(int)
        facing = np.diff(padded)
        if not facing.any():
            continue
        triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(cell))
        rings = [[(x, y) for x, y in shapely.orient_polygons(triangle).exterior.coords[:3]] for triangle in triangles]
        for level, turn in zip(levels, facing, strict=True):
            for ring in rings if turn else ():
                corners = [(x, y, level) for x, y in ring]
                yield corners if turn < 0 else corners[::-1]


def _upright_faces(cells: list[shapely.Polygon], solid: NDArray[np.bool_], levels: list[float]) -> Iterator[list[Corner]]:
    import shapely

    edges: dict[tuple[Point2, Point2], int] = {}
    for i, cell in enumerate(shapely.orient_polygons(np.array(cells, dtype=object))):
        for ring in (cell.exterior, *cell.interiors):
            edges |= dict.fromkeys(pairwise(ring.coords), i)
    for ((px, py), (qx, qy)), i in edges.items():
        beyond = edges.get(((qx, qy), (px, py)))
        for band, (low, high) in enumerate(pairwise(levels)):
            if solid[i, band] and (beyond is None or not solid[beyond, band]):
                yield [(px, py, low), (qx, qy, low), (qx, qy, high)]
                yield [(px, py, low), (qx, qy, high), (px, py, high)]
