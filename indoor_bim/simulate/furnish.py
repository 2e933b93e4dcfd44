"""Furniture and surroundings: what a scan shows besides the building, placed by seed and no part of the truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Building, Room, Storey
from indoor_bim.simulate.mesh import Box
from indoor_bim.simulate.walk import Stair, stairs

if TYPE_CHECKING:
    import shapely

Points = NDArray[np.float64]

_DOOR_CLEARANCE, _PATH_CLEARANCE, _GAP = 1.0, 0.25, 0.03


def furnish(building: Building, path: Points, leaves: Sequence[Box], *, rng: np.random.Generator) -> list[Box]:
    """Furniture for all rooms, clear of doors and of the walked path.

    Cupboards (some to the ceiling), desks with chairs and shelves stand along walls; radiators and curtains hang at windows.

    Parameters
    ----------
    building : Building
        Building to furnish.
    path : (m, 3) float64
        Walked path of the feet, metres.
    leaves : sequence of Box
        Door leaves, which stay free to stand where they are.
    rng : numpy.random.Generator
        Draws kinds, sizes and places.
    """
    import shapely

    boxes: list[Box] = []
    for storey in building.storeys:
        feet = path[np.abs(path[:, 2] - storey.elevation) < 2.0, :2]
        keep_clear = [_around_doors(storey)]
        if len(feet) > 1:
            keep_clear.append(shapely.LineString(feet).buffer(_PATH_CLEARANCE))
        keep_clear += [_flight_outline(stair) for stair in stairs(building) if storey.elevation in (stair.bottom, stair.top)]
        taken = shapely.union_all([*keep_clear, *(leaf.outline for leaf in leaves)])
        at_windows = _at_windows(storey, taken, rng)
        boxes += at_windows
        taken = shapely.union_all([taken, *(box.outline for box in at_windows)])
        for room in storey.rooms:
            for group in _along_walls(room, rng):
                outline = shapely.union_all([box.outline for box in group])
                if room.outline.polygon.contains(outline) and not outline.intersects(taken):
                    boxes += group
                    taken = taken.union(outline.buffer(_GAP))
    return boxes


def stair_steps(building: Building) -> list[Box]:
    """Steps of all flights, as blocks on the ground."""
    steps = []
    for stair in stairs(building):
        foot, head = np.asarray(stair.foot), np.asarray(stair.head)
        count = int(np.ceil((stair.top - stair.bottom) / 0.19))
        run, angle = (head - foot) / count, float(np.arctan2(*(head - foot)[::-1]))
        rise = (stair.top - stair.bottom) / count
        for k in range(count - 1):
            centre = foot + run * (k + 0.5)
            top = stair.bottom + rise * (k + 1)
            steps.append(Box(tuple(centre.tolist()), angle, float(np.linalg.norm(run)), stair.width, max(stair.bottom, top - 0.3), top))
    return steps


def surroundings(building: Building) -> list[Box]:
    """Ground and a neighbour's front to be seen through the windows."""
    corners = np.array([xy for storey in building.storeys for slab in storey.slabs for xy in slab.outline.exterior])
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre, size = (low + high) / 2, high - low
    ground = building.storeys[0].elevation - 0.35
    x, y = centre.tolist()
    return [
        Box((x, y), 0.0, float(size[0]) + 60, float(size[1]) + 60, ground - 0.1, ground),
        Box((x, float(low[1]) - 9), 0.0, float(size[0]) + 8, 0.3, ground, ground + 6),
        Box((float(high[0]) + 7, y), 0.0, 0.3, 4.0, ground, ground + 4),
    ]


def _around_doors(storey: Storey) -> shapely.Geometry:
    import shapely

    lines = []
    for wall in storey.walls:
        axis = shapely.LineString(wall.axis)
        for opening in wall.openings:
            if opening.kind != "window":
                jambs = [axis.interpolate(u) for u in (opening.start, opening.start + opening.width)]
                lines.append(shapely.LineString(jambs).buffer(wall.thickness / 2 + _DOOR_CLEARANCE, cap_style="flat"))
    return shapely.union_all(lines)


def _flight_outline(stair: Stair) -> shapely.Geometry:
    import shapely

    return shapely.LineString([stair.foot, stair.head]).buffer(stair.width / 2 + 0.1)


def _at_windows(storey: Storey, taken: shapely.Geometry, rng: np.random.Generator) -> list[Box]:
    """Radiators under sills and drawn-back curtains, on the inner side of outer walls (left of their axes)."""
    boxes = []
    for wall in storey.walls:
        a, b = np.asarray(wall.axis[0]), np.asarray(wall.axis[1])
        along = (b - a) / wall.length
        normal, angle = np.array([-along[1], along[0]]), float(np.arctan2(along[1], along[0]))
        for opening in wall.openings:
            if opening.kind != "window" or not wall.external:
                continue
            middle = a + along * (opening.start + opening.width / 2) + normal * wall.thickness / 2
            if opening.sill > 0.6 and rng.random() < 0.7:
                centre = middle + normal * 0.09
                boxes.append(
                    Box(tuple(centre.tolist()), angle, opening.width * 0.8, 0.1, wall.base + 0.12, wall.base + opening.sill - 0.12)
                )
            if rng.random() < 0.4:
                boxes += _curtain(middle + along * (opening.width / 2 + 0.05), along, normal, wall.base, wall.height)
    return [box for box in boxes if not box.outline.intersects(taken)]


def _curtain(start: Points, along: Points, normal: Points, base: float, height: float) -> list[Box]:
    """Folds of a drawn-back curtain beside a window, 0.4 m wide."""
    folds = []
    for k in range(8):
        slope = 0.8 if k % 2 else -0.8
        centre = start + along * 0.05 * (k - 4) + normal * 0.13
        angle = float(np.arctan2(along[1], along[0])) + slope
        folds.append(Box(tuple(centre.tolist()), angle, 0.075, 0.004, base + 0.03, base + height - 0.04))
    return folds


def _along_walls(room: Room, rng: np.random.Generator) -> list[list[Box]]:
    """Candidate groups of furniture along the edges of a room, in drawing order."""
    ring = np.asarray(room.outline.exterior)
    groups = []
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        length = float(np.linalg.norm(b - a))
        for _ in range(int(length / 0.9)):
            along = (b - a) / length
            normal = np.array([-along[1], along[0]])
            place = a + along * rng.uniform(0.0, length)
            groups.append(_group(place, along, normal, room.floor, room.height, rng))
    return groups


def _group(place: Points, along: Points, normal: Points, floor: float, height: float, rng: np.random.Generator) -> list[Box]:
    angle = float(np.arctan2(along[1], along[0]))

    def box(offset: float, out: float, length: float, width: float, bottom: float, top: float) -> Box:
        centre = place + along * offset + normal * (_GAP + out + width / 2)
        return Box(tuple(centre.tolist()), angle, length, width, floor + bottom, floor + top)

    kind = rng.choice(["cupboard", "built-in", "desk", "shelf", "boxes"], p=[0.3, 0.1, 0.35, 0.15, 0.1])
    width = float(rng.uniform(0.8, 1.6))
    if kind == "cupboard":
        return [box(0, 0, width, float(rng.uniform(0.35, 0.6)), 0.0, float(rng.uniform(0.8, 2.1)))]
    if kind == "built-in":
        return [box(0, 0, width, 0.6, 0.0, height - 0.002)]
    if kind == "shelf":
        return [box(0, 0, width, 0.3, z, z + 0.02) for z in (0.1, 0.5, 0.9, 1.3, 1.7)] + [
            box(s * width / 2, 0, 0.02, 0.3, 0.0, 1.8) for s in (-1, 1)
        ]
    if kind == "boxes":
        return [box(0, 0, 0.4, 0.4, 0.0, 0.35), box(0.42, 0, 0.35, 0.35, 0.0, 0.5)]
    top = [box(0, 0, width, 0.7, 0.71, 0.74)]
    legs = [box(s * (width / 2 - 0.05), out, 0.05, 0.05, 0.0, 0.71) for s in (-1, 1) for out in (0.02, 0.63)]
    chair = [box(0, 0.8, 0.45, 0.45, 0.42, 0.47), box(0, 1.25, 0.42, 0.04, 0.47, 0.95), box(0, 1.0, 0.05, 0.05, 0.0, 0.42)]
    screen = [box(float(rng.uniform(-0.2, 0.2)), 0.1, 0.5, 0.04, 0.85, 1.2)]
    return top + legs + chair + screen
