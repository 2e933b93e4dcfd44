"""Nearest points on surfaces of triangles, through Open3D's ray casting scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.quality.wall_bodies import Faces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """Nearest face of each point.

    Parameters
    ----------
    distance : (n,) float64
        Signed distance in metres: positive in front of the face, outside the wall.
    triangle : (n,) int64
        Triangle of the faces.
    square : (n,) bool
        Whether the point lies square in front of or behind the face, and not beyond its edge.
    """

    distance: Floats
    triangle: Ints
    square: NDArray[np.bool_]


def nearest_faces(points: Floats, faces: Faces, *, edge: float = 0.01) -> Nearest:
    """Find the nearest face of each point.

    Parameters
    ----------
    points : (n, 3) float64
        Points, metres.
    faces : Faces
        Faces of walls.
    edge : float
        How far beyond the edge of a face a point still counts as square to it, metres.
    """
    closest, triangle, length = _closest(points, faces.corners.reshape(-1, 3))
    away = points - closest
    signed = np.einsum("ij,ij->i", away[:, :2], faces.normal[triangle])
    return Nearest(signed, triangle, np.sqrt(np.maximum(length**2 - signed**2, 0.0)) <= edge)


def surface_distances(points: Floats, corners: Floats) -> Floats:
    """Distances (n,) of points (n, 3) from triangles whose corners (3 m, 3) follow each other, metres."""
    return _closest(points, corners)[2]


def _closest(points: Floats, corners: Floats) -> tuple[Floats, Ints, Floats]:
    """Closest points (n, 3), their triangles (n,) and distances (n,)."""
    import open3d

    o3d: Any = open3d

    if not len(corners) or not len(points):
        return np.full((len(points), 3), np.inf), np.zeros(len(points), dtype=np.int64), np.full(len(points), np.inf)
    origin = corners.mean(axis=0)  # single precision inside: keep coordinates small
    scene = o3d.t.geometry.RaycastingScene()
    index = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
    scene.add_triangles(o3d.core.Tensor((corners - origin).astype(np.float32)), o3d.core.Tensor(index))
    found = scene.compute_closest_points(o3d.core.Tensor((points - origin).astype(np.float32)))
    closest = found["points"].numpy().astype(np.float64) + origin
    return closest, found["primitive_ids"].numpy().astype(np.int64), np.linalg.norm(points - closest, axis=1)
