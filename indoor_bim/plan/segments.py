"""Line segments in plan, the common product of all line-finding stages."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Segments of wall faces in plan, one row each, metres.

    Parameters
    ----------
    p, q : (m, 2) float64
        End points. Where `sided` is True, free space (the side the face was seen from) lies to the LEFT of p -> q.
    sided : (m,) bool
        True where the side of free space is known.
    support : (m,) int64
        Number of points on the segment.
    rmse : (m,) float64
        Root mean square distance of these points from the segment.
    coverage : (m,) float64
        Share of the face that was hit, 0 to 1.
    covariance : (m, 2, 2) float64
        Covariance of the line in polar form (direction of the normal in radians, distance of the origin along it in metres); NaN where not
        estimated.
    top : (m,) float64
        Height of the upper edge above the floor, metres; NaN where not known.
    deviation : (m,) float64
        Distance from the segment that the local medians of the points keep to along 95 % of it, metres; NaN where not measured.
    """

    p: Floats
    q: Floats
    sided: NDArray[np.bool_]
    support: Ints
    rmse: Floats
    coverage: Floats
    covariance: Floats
    top: Floats
    deviation: Floats

    @classmethod
    def from_ends(cls, p: Floats, q: Floats) -> Self:
        """Segments with end points only; everything else unknown.

        Parameters
        ----------
        p, q : (m, 2) float64
            End points, metres.
        """
        p = np.asarray(p, dtype=np.float64).reshape(-1, 2)
        q = np.asarray(q, dtype=np.float64).reshape(-1, 2)
        m = len(p)
        return cls(
            p=p,
            q=q,
            sided=np.zeros(m, dtype=bool),
            support=np.zeros(m, dtype=np.int64),
            rmse=np.full(m, np.nan),
            coverage=np.zeros(m),
            covariance=np.full((m, 2, 2), np.nan),
            top=np.full(m, np.nan),
            deviation=np.full(m, np.nan),
        )

    def __len__(self) -> int:
        return len(self.p)

    @property
    def length(self) -> Floats:
        """(m,) float64 lengths in metres."""
        metres: Floats = np.hypot(*(self.q - self.p).T)
        return metres

    @property
    def direction(self) -> Floats:
        """(m, 2) float64 unit vectors from p to q."""
        unit: Floats = (self.q - self.p) / np.maximum(self.length, 1e-12)[:, None]
        return unit

    @property
    def normal(self) -> Floats:
        """(m, 2) float64 unit normals, to the left of p -> q."""
        d = self.direction
        return np.column_stack([-d[:, 1], d[:, 0]])

    def take(self, rows: Ints | NDArray[np.bool_]) -> Self:
        """Segments of the given rows (indices or mask)."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})
