"""Triangles of a building and its contents, for ray casting."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Building, Opening, Point2, Wall

if TYPE_CHECKING:
    import shapely

Triangles = NDArray[np.float64]

_FRAME, _LEAF = 0.06, 0.04


@dataclass(frozen=True, slots=True)
class Box:
    """Upright box turned about the vertical: centre in plan, angle in radians, length along the angle, width across, metres."""

    centre: Point2
    angle: float
    length: float
    width: float
    bottom: float
    top: float

    @property
    def outline(self) -> shapely.Polygon:
        """Plan outline as a shapely polygon."""
        import shapely

        along = np.array([np.cos(self.angle), np.sin(self.angle)]) * self.length / 2
        across = np.array([-np.sin(self.angle), np.cos(self.angle)]) * self.width / 2
        centre = np.asarray(self.centre)
        return shapely.Polygon([centre - along - across, centre + along - across, centre + along + across, centre - along + across])


def prism(polygon: shapely.Polygon, bottom: float, top: float) -> Triangles:
    """Triangles (n, 3, 3) of an upright prism over a plan polygon.

    Parameters
    ----------
    polygon : shapely.Polygon
        Plan outline with holes, metres.
    bottom, top : float
        Levels of the ends, metres.
    """
    import shapely

    lid = np.array([t.exterior.coords[:3] for t in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))])
    ends = [np.dstack([lid, np.full(lid.shape[:2], level)]) for level in (bottom, top)]
    sides = []
    for ring in (polygon.exterior, *polygon.interiors):
        coords = np.asarray(ring.coords)
        a, b = coords[:-1], coords[1:]
        low, high = np.full((len(a), 1), bottom), np.full((len(a), 1), top)
        a0, b0, a1, b1 = np.hstack([a, low]), np.hstack([b, low]), np.hstack([a, high]), np.hstack([b, high])
        sides += [np.stack([a0, b0, b1], axis=1), np.stack([a0, b1, a1], axis=1)]
    return np.concatenate([*ends, *sides])


def box_triangles(boxes: Iterable[Box]) -> Triangles:
    """Triangles (n, 3, 3) of upright boxes."""
    return np.concatenate([np.zeros((0, 3, 3)), *(prism(box.outline, box.bottom, box.top) for box in boxes)])


def shell_triangles(building: Building) -> Triangles:
    """Triangles (n, 3, 3) of walls with their openings cut through, columns and slabs, in model coordinates."""
    import shapely

    parts = [np.zeros((0, 3, 3))]
    for storey in building.storeys:
        for wall in storey.walls:
            parts += [prism(piece, bottom, top) for piece, bottom, top in _solid_pieces(wall)]
        parts += [prism(shapely.Polygon(column.footprint), column.base, column.base + column.height) for column in storey.columns]
        for slab in storey.slabs:
            bottom = slab.level - slab.thickness if slab.kind == "floor" else slab.level
            parts.append(prism(slab.outline.polygon, bottom, bottom + slab.thickness))
    return np.concatenate(parts)


def window_frames(building: Building) -> list[Box]:
    """Frames and posts of all windows, on the wall axis."""
    boxes = []
    for wall, opening in _openings(building, "window"):
        sill, head = wall.base + opening.sill, wall.base + opening.sill + opening.height
        posts = 2 if opening.width < 1.3 else 3
        for u in np.linspace(opening.start + _FRAME / 2, opening.start + opening.width - _FRAME / 2, posts):
            boxes.append(_on_axis(wall, float(u), _FRAME, _FRAME, sill, head))
        centre = opening.start + opening.width / 2
        boxes += [_on_axis(wall, centre, opening.width, _FRAME, z, z + _FRAME) for z in (sill, head - _FRAME)]
    return boxes


def glass_triangles(building: Building) -> Triangles:
    """Triangles (n, 3, 3) of the panes of all windows."""
    parts = [np.zeros((0, 3, 3))]
    for wall, opening in _openings(building, "window"):
        ends = [_point_on_axis(wall, opening.start + u) for u in (0.0, opening.width)]
        sill, head = wall.base + opening.sill, wall.base + opening.sill + opening.height
        a0, b0, b1, a1 = (np.array([*ends[k], z]) for k, z in ((0, sill), (1, sill), (1, head), (0, head)))
        parts.append(np.array([[a0, b0, b1], [a0, b1, a1]]))
    return np.concatenate(parts)


def door_leaves(building: Building, *, rng: np.random.Generator) -> list[Box]:
    """Leaves of all doors: closed on the wall axis, or turned out of the wall by 75 to 110 degrees where the door has a hinge.

    Parameters
    ----------
    building : Building
        Building whose doors are hung.
    rng : numpy.random.Generator
        Draws the angles.
    """
    leaves = []
    for wall, opening in _openings(building, "door"):
        bottom, top = wall.base + 0.01, wall.base + opening.height
        if opening.hinge is None:
            leaves.append(_on_axis(wall, opening.start + opening.width / 2, opening.width, _LEAF, bottom, top))
            continue
        along = _direction(wall)
        side = np.array([-along[1], along[0]]) * (1 if opening.swing == "left" else -1)
        closed = along if opening.hinge == "start" else -along
        jamb = opening.start if opening.hinge == "start" else opening.start + opening.width
        angle = np.radians(rng.uniform(75, 110))
        leaf = np.cos(angle) * closed + np.sin(angle) * side
        centre = np.asarray(_point_on_axis(wall, jamb)) + side * wall.thickness / 2 + leaf * opening.width / 2 + closed * _LEAF / 2
        leaves.append(Box(tuple(centre.tolist()), float(np.arctan2(leaf[1], leaf[0])), opening.width - 0.02, _LEAF, bottom, top))
    return leaves


def _solid_pieces(wall: Wall) -> list[tuple[shapely.Polygon, float, float]]:
    """Pieces of a wall about its openings, as plan polygon, bottom and top."""
    import shapely

    footprint, top = shapely.Polygon(wall.footprint), wall.base + wall.height
    spans = [(-wall.height, wall.base, wall.base)]
    for opening in sorted(wall.openings, key=lambda o: o.start):
        sill = wall.base + opening.sill
        spans += [(opening.start, sill, sill + opening.height), (opening.start + opening.width, wall.base, wall.base)]
    ends = [start for start, *_ in spans[1:]] + [wall.length + wall.height]
    pieces = []
    for (start, sill, head), end in zip(spans, ends, strict=True):
        centre = _point_on_axis(wall, (start + end) / 2)
        strip = Box(centre, _angle(wall), end - start, 4 * wall.thickness, 0, 1).outline
        for part in shapely.get_parts(footprint.intersection(strip)):
            if part.geom_type == "Polygon" and part.area > 1e-9:
                pieces += [(part, low, high) for low, high in ((wall.base, sill), (head, top)) if high - low > 1e-6]
    return pieces


def _openings(building: Building, kind: str) -> list[tuple[Wall, Opening]]:
    return [(wall, o) for storey in building.storeys for wall in storey.walls for o in wall.openings if o.kind == kind]


def _direction(wall: Wall) -> NDArray[np.float64]:
    return np.asarray(np.subtract(wall.axis[1], wall.axis[0]) / wall.length)


def _angle(wall: Wall) -> float:
    along = _direction(wall)
    return float(np.arctan2(along[1], along[0]))


def _point_on_axis(wall: Wall, distance: float) -> Point2:
    x, y = np.asarray(wall.axis[0]) + _direction(wall) * distance
    return float(x), float(y)


def _on_axis(wall: Wall, centre: float, length: float, width: float, bottom: float, top: float) -> Box:
    return Box(_point_on_axis(wall, centre), _angle(wall), length, width, bottom, top)
