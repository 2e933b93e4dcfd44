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


@dataclass(frozen=True, slots=True, eq=False)
class FaceIndex:
    """Faces of walls, prepared for many questions.

    Parameters
    ----------
    faces : Faces
        Faces of walls.
    scene : open3d.t.geometry.RaycastingScene
        Their triangles about `origin`, in single precision.
    origin : (3,) float64
        Point near them, metres.
    """

    faces: Faces
    scene: Any
    origin: Floats

    def nearest(self, points: Floats, *, edge: float = 0.01) -> Nearest:
        """Find the nearest face of each point.

        Parameters
        ----------
        points : (n, 3) float64
            Points, metres.
        edge : float
            How far beyond the edge of a face a point still counts as square to it, metres.
        """
        closest, triangle, length = _closest(points, self.scene, self.origin)
        away = points - closest
        signed = np.einsum("ij,ij->i", away[:, :2], self.faces.normal[triangle])
        return Nearest(signed, triangle, np.sqrt(np.maximum(length**2 - signed**2, 0.0)) <= edge)


def index_faces(faces: Faces) -> FaceIndex:
    """Prepare the faces of walls, of which there is one at least."""
    return FaceIndex(faces, *_scene(faces.corners.reshape(-1, 3)))


def surface_distances(points: Floats, corners: Floats) -> Floats:
    """Distances (n,) of points (n, 3) from triangles whose corners (3 m, 3) follow each other, metres; infinite without triangles."""
    if not len(corners) or not len(points):
        return np.full(len(points), np.inf)
    return _closest(points, *_scene(corners))[2]


def _scene(corners: Floats) -> tuple[Any, Floats]:
    import open3d

    o3d: Any = open3d
    origin = corners.mean(axis=0)  # single precision inside: keep coordinates small
    scene = o3d.t.geometry.RaycastingScene()
    index = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
    scene.add_triangles(o3d.core.Tensor((corners - origin).astype(np.float32)), o3d.core.Tensor(index))
    return scene, origin


def _closest(points: Floats, scene: Any, origin: Floats) -> tuple[Floats, Ints, Floats]:
    """Closest points (n, 3), their triangles (n,) and distances (n,)."""
    import open3d

    o3d: Any = open3d
    found = scene.compute_closest_points(o3d.core.Tensor((points - origin).astype(np.float32)))
    closest = found["points"].numpy().astype(np.float64) + origin
    return closest, found["primitive_ids"].numpy().astype(np.int64), np.linalg.norm(points - closest, axis=1)
