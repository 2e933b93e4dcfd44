"""Similarity transforms between scan coordinates and the coordinates that stages work in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_bim.model import Matrix4

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Similarity ``local = scale * rotation @ (scan - origin) + shift``.

    The origin is subtracted before anything is multiplied, so coordinates of millions of metres lose nothing.

    Parameters
    ----------
    origin : (3,) float64
        Point of the scan that the rotation turns about, in the scan's unit.
    rotation : (3, 3) float64
        Proper rotation from scan axes to local axes.
    scale : float
        Metres per unit of the scan.
    shift : (3,) float64
        Translation after rotation and scaling, metres.
    """

    origin: Points
    rotation: Points
    scale: float
    shift: Points

    @classmethod
    def identity(cls) -> Self:
        """Frame that changes nothing."""
        return cls(np.zeros(3), np.eye(3), 1.0, np.zeros(3))

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Self:
        """Frame of a 4 x 4 similarity matrix.

        Parameters
        ----------
        matrix : (4, 4) array_like
            Row-major matrix for column vectors.

        Raises
        ------
        ValueError
            If the matrix is not a similarity without reflection.
        """
        m = np.asarray(matrix, dtype=np.float64)
        if m.shape != (4, 4) or not np.isfinite(m).all():
            raise ValueError(f"expected a finite matrix of shape (4, 4), got shape {m.shape}")
        linear = m[:3, :3]
        scale = float(np.cbrt(np.linalg.det(linear)))
        if scale <= 0 or not np.allclose(linear @ linear.T, scale**2 * np.eye(3), rtol=1e-6, atol=1e-9 * scale**2):
            raise ValueError("expected a rotation with uniform scale: the matrix shears, mirrors or flattens")
        rotation = linear / scale
        origin = -rotation.T @ m[:3, 3] / scale
        return cls(origin, rotation, scale, np.zeros(3))

    @property
    def matrix(self) -> Points:
        """(4, 4) float64 matrix that takes scan coordinates to local coordinates."""
        m = np.eye(4)
        m[:3, :3] = self.scale * self.rotation
        m[:3, 3] = self.shift - m[:3, :3] @ self.origin
        return m

    def rows(self) -> Matrix4:
        """Return the matrix as nested tuples, as the building model keeps it."""
        m = self.matrix
        return tuple(tuple(float(x) for x in row) for row in m)  # type: ignore[return-value]

    def to_local(self, points: ArrayLike) -> Points:
        """Take scan coordinates (n, 3) to local coordinates (n, 3) in metres."""
        return (np.asarray(points, dtype=np.float64) - self.origin) @ (self.scale * self.rotation).T + self.shift

    def to_scan(self, points: ArrayLike) -> Points:
        """Take local coordinates (n, 3) in metres back to scan coordinates (n, 3)."""
        return (np.asarray(points, dtype=np.float64) - self.shift) @ (self.rotation / self.scale) + self.origin

    def then(self, rotation: ArrayLike, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Self:
        """Frame that also turns local coordinates by `rotation` (3, 3) and moves them by `shift` (3,) metres.

        Examples
        --------
        >>> quarter = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        >>> Frame.identity().then(quarter, (0, 0, 5)).to_local([[1.0, 0.0, 0.0]]).tolist()
        [[0.0, 1.0, 5.0]]
        """
        turn = np.asarray(rotation, dtype=np.float64)
        return type(self)(self.origin, turn @ self.rotation, self.scale, turn @ self.shift + np.asarray(shift, dtype=np.float64))
