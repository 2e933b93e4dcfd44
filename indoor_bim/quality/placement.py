"""Moving a building model from its own frame into that of another model of the same scan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.frame import Frame
from indoor_bim.model import Building, Outline, Point2, Ring, Storey


def place_in_frame_of(building: Building, other: Building) -> Building:
    """The building in the model coordinates of another one; both are placed in the scan by their transforms.

    Lengths and heights keep; plan coordinates and levels are moved.

    Parameters
    ----------
    building, other : Building
        Models of the same scan.

    Raises
    ------
    ValueError
        If a transform is not a similarity.
    """
    move = Frame.from_matrix(other.transform_cloud_to_model).matrix @ np.linalg.inv(
        Frame.from_matrix(building.transform_cloud_to_model).matrix
    )
    storeys = tuple(_placed_storey(storey, move) for storey in building.storeys)
    return replace(building, storeys=storeys, transform_cloud_to_model=other.transform_cloud_to_model)


def _placed_storey(storey: Storey, move: NDArray[np.float64]) -> Storey:
    def ring(points: Ring, level: float) -> Ring:
        placed = np.column_stack([np.asarray(points), np.full(len(points), level), np.ones(len(points))]) @ move.T
        return tuple((float(x), float(y)) for x, y in placed[:, :2])

    def outline(shape: Outline, level: float) -> Outline:
        return Outline(ring(shape.exterior, level), tuple(ring(hole, level) for hole in shape.holes))

    def height(level: float, point: Point2) -> float:
        return float(move[2] @ [point[0], point[1], level, 1.0])

    corners = [xy for wall in storey.walls for xy in wall.axis] + [xy for room in storey.rooms for xy in room.outline.exterior]
    middle = np.mean(corners, axis=0) if corners else np.zeros(2)
    centre = (float(middle[0]), float(middle[1]))
    walls = []
    for wall in storey.walls:
        start, end = ring(wall.axis, wall.base)
        walls.append(replace(wall, axis=(start, end), footprint=ring(wall.footprint, wall.base), base=height(wall.base, wall.axis[0])))
    return replace(
        storey,
        elevation=height(storey.elevation, centre),
        walls=tuple(walls),
        joints=tuple(replace(joint, point=ring((joint.point,), storey.elevation)[0]) for joint in storey.joints),
        curves=tuple(
            replace(
                c,
                centre=ring((c.centre,), storey.elevation)[0],
                ends=(ring(c.ends, storey.elevation)[0], ring(c.ends, storey.elevation)[1]),
            )
            for c in storey.curves
        ),
        columns=tuple(replace(c, footprint=ring(c.footprint, c.base), base=height(c.base, c.footprint[0])) for c in storey.columns),
        rooms=tuple(replace(r, outline=outline(r.outline, r.floor), floor=height(r.floor, r.outline.exterior[0])) for r in storey.rooms),
        slabs=tuple(replace(s, outline=outline(s.outline, s.level), level=height(s.level, s.outline.exterior[0])) for s in storey.slabs),
    )
