"""Walls of any model as closed surfaces, and the upright faces that a scan can be held against."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from indoor_bim.export.guids import storey_guids
from indoor_bim.export.mesh import storey_parts
from indoor_bim.model import Building

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_UPRIGHT = 0.05  # largest height component of the normal of an upright face
_ALONG = np.cos(np.radians(30.0))  # faces that look along the wall, its ends and reveals, are left out
_STRAIGHT = 0.3  # share by which one direction outweighs the others in a straight wall
_SAME_PLANE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Surface of an element.

    Parameters
    ----------
    id, name, guid, storey : str
        Identifier, name, GlobalId and storey.
    vertices : (n, 3) float64
        Corners, metres.
    triangles : (m, 3) int64
        Counter-clockwise when seen from outside.
    """

    id: str
    name: str
    guid: str
    storey: str
    vertices: Floats
    triangles: Ints


@dataclass(frozen=True, slots=True, eq=False)
class WallModel:
    """What of a model can be held against a scan.

    Parameters
    ----------
    walls : tuple of Body
        Walls.
    others : tuple of Body
        All other elements: what is not a wall, but explains what a scan shows.
    storeys : tuple of (str, float)
        Names and floor levels, metres, bottom up.
    scan_to_model : (4, 4) float64, optional
        Where the model says it lies in its scan.
    source : str
        Name of that scan, if known.
    detail : callable, optional
        Reads walls with openings, and other elements, of the storeys of given names, or of all for None, where they were not read yet.
    """

    walls: tuple[Body, ...]
    others: tuple[Body, ...]
    storeys: tuple[tuple[str, float], ...]
    scan_to_model: Floats | None = None
    source: str = ""
    detail: Callable[[Collection[str] | None], tuple[tuple[Body, ...], tuple[Body, ...]]] | None = None

    def detailed(self, names: Collection[str] | None) -> Self:
        """Return the model with openings and other elements, where it came without: of some storeys, or of all for None."""
        if self.detail is None:
            return self
        walls, others = self.detail(names)
        return replace(self, walls=walls, others=others, detail=None)


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Triangles of the upright faces of walls.

    Parameters
    ----------
    corners : (m, 3, 3) float64
        Corners of each triangle, metres.
    normal : (m, 2) float64
        Outward normal in plan.
    wall : (m,) int64
        Place of its wall in the model.
    plane : (m,) int64
        Number of the plane that it lies in; faces of different walls have different numbers.
    """

    corners: Floats
    normal: Floats
    wall: Ints
    plane: Ints


def bodies_of_building(building: Building) -> WallModel:
    """Walls and other elements of a building model.

    Parameters
    ----------
    building : Building
        Model, metres.
    """
    walls: list[Body] = []
    others: list[Body] = []
    for storey in building.storeys:
        guids = storey_guids(building.source, storey)
        names = {wall.id: wall.name for wall in storey.walls}
        for part in storey_parts(storey):
            body = Body(part.id, names.get(part.id, part.id), guids[part.id], storey.name, part.vertices, part.triangles)
            (walls if part.material == "wall" else others).append(body)
    storeys = tuple((storey.name, storey.elevation) for storey in building.storeys)
    return WallModel(tuple(walls), tuple(others), storeys, np.array(building.transform_cloud_to_model), building.source)


def upright_faces(walls: Sequence[Body]) -> Faces:
    """Long upright faces of walls; ends, reveals of openings, tops and bottoms are left out.

    Parameters
    ----------
    walls : sequence of Body
        Walls, straight or curved.
    """
    parts = [_long_faces(body) for body in walls]
    counts = [len(corners) for corners, _, _ in parts]
    first = np.concatenate([[0], np.cumsum([plane.max(initial=-1) + 1 for _, _, plane in parts])]).astype(np.int64)
    return Faces(
        corners=np.concatenate([np.zeros((0, 3, 3)), *(corners for corners, _, _ in parts)]),
        normal=np.concatenate([np.zeros((0, 2)), *(normal for _, normal, _ in parts)]),
        wall=np.repeat(np.arange(len(parts)), counts),
        plane=np.concatenate([np.zeros(0, dtype=np.int64), *(plane + first[k] for k, (_, _, plane) in enumerate(parts))]),
    )


def _long_faces(body: Body) -> tuple[Floats, Floats, Ints]:
    """Corners (m, 3, 3), normals in plan (m, 2) and planes (m,) of the faces that look across a wall."""
    corners = body.vertices[body.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    upright = (size > 1e-9) & (np.abs(cross[:, 2]) < _UPRIGHT * size)
    corners, cross, size = corners[upright], cross[upright], size[upright]
    normal = cross[:, :2] / np.maximum(np.linalg.norm(cross[:, :2], axis=1), 1e-12)[:, None]
    double = (size * (normal[:, 0] + 1j * normal[:, 1]) ** 2).sum() / max(size.sum(), 1e-12)
    if abs(double) > _STRAIGHT:
        angle = np.angle(double) / 2
        across = np.abs(normal @ [np.cos(angle), np.sin(angle)]) > _ALONG
        corners, normal = corners[across], normal[across]
    offset = np.einsum("ij,ij->i", corners[:, 0, :2], normal)
    key = np.column_stack([np.round(np.degrees(np.arctan2(normal[:, 1], normal[:, 0])) % 360.0), np.round(offset / _SAME_PLANE)])
    _, plane = np.unique(key, axis=0, return_inverse=True)
    return corners, normal, plane.reshape(-1).astype(np.int64)


def face_cells(faces: Faces, *, cell: float) -> tuple[Floats, Ints, Ints]:
    """Square cells of a grid on every face.

    Parameters
    ----------
    faces : Faces
        Faces of walls.
    cell : float
        Side of a cell, metres.

    Returns
    -------
    centre : (k, 3) float64
        Centres of the cells that lie on a face, metres.
    key : (k, 3) int64
        Plane, column and row of each cell, sorted and unique.
    wall : (k,) int64
        Wall that it lies on.
    """
    keys: list[Ints] = []
    centres: list[Floats] = []
    walls: list[Ints] = []
    for corners, normal, wall, plane in zip(faces.corners, faces.normal, faces.wall, faces.plane, strict=True):
        along = np.array([-normal[1], normal[0]])
        flat = np.column_stack([corners[:, :2] @ along, corners[:, 2]]) / cell
        low, high = np.floor(flat.min(axis=0)).astype(int), np.ceil(flat.max(axis=0)).astype(int)
        column, row = (axis.ravel() for axis in np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1])))
        middle = np.column_stack([column, row]) + 0.5
        inside = _inside(middle, flat)
        column, row, middle = column[inside], row[inside], middle[inside] * cell
        offset = corners[0, :2] @ normal
        keys.append(np.column_stack([np.full(len(column), plane), column, row]))
        centres.append(np.column_stack([middle[:, :1] * along + offset * normal, middle[:, 1]]))
        walls.append(np.full(len(column), wall))
    key, first = np.unique(np.concatenate([np.zeros((0, 3), dtype=np.int64), *keys]), axis=0, return_index=True)
    centre = np.concatenate([np.zeros((0, 3)), *centres])[first]
    return centre, key, np.concatenate([np.zeros(0, dtype=np.int64), *walls])[first]


def _inside(points: Floats, triangle: Floats) -> NDArray[np.bool_]:
    """Whether points (n, 2) lie in a triangle (3, 2), its border included."""
    edge = np.roll(triangle, -1, axis=0) - triangle
    side = edge[:, 0] * (points[:, None, 1] - triangle[:, 1]) - edge[:, 1] * (points[:, None, 0] - triangle[:, 0])
    return np.asarray((side >= -1e-9).all(axis=1) | (side <= 1e-9).all(axis=1))
