"""Weighted line fits in polar form with their covariance.

After Pfister, Roumeliotis, Burdick, *Weighted line fitting algorithms for mobile robot map building and efficient data representation*,
ICRA 2003.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ANGLE_SETTLED = 1e-8  # radians
ROUNDS = 30


@dataclass(frozen=True, slots=True, eq=False)
class PolarLines:
    """Lines x cos(alpha) + y sin(alpha) = radius, one row each.

    Parameters
    ----------
    alpha : (m,) float64
        Direction of the normal, radians in (-pi, pi].
    radius : (m,) float64
        Signed distance of the origin along the normal, metres.
    covariance : (m, 2, 2) float64
        Covariance of alpha and radius.
    """

    alpha: Floats
    radius: Floats
    covariance: Floats

    def __len__(self) -> int:
        return len(self.alpha)

    @property
    def normal(self) -> Floats:
        """(m, 2) float64 unit normals."""
        return np.column_stack([np.cos(self.alpha), np.sin(self.alpha)])

    @property
    def along(self) -> Floats:
        """(m, 2) float64 unit directions; the normal lies to the left of them."""
        return np.column_stack([np.sin(self.alpha), -np.cos(self.alpha)])

    def take(self, rows: Ints | NDArray[np.bool_]) -> Self:
        """Lines of the given rows (indices or mask)."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})

    def facing(self, towards: Floats) -> Self:
        """Return the same lines, their normals turned to the side of the points (m, 2); covariances follow."""
        turn = (self.normal * towards).sum(axis=1) < self.radius
        sign = np.where(turn, -1.0, 1.0)
        covariance = self.covariance.copy()
        covariance[:, 0, 1] *= sign
        covariance[:, 1, 0] *= sign
        return replace(self, alpha=_wrapped(self.alpha + np.pi * turn), radius=self.radius * sign, covariance=covariance)

    def moved(self, origin: Floats) -> Self:
        """Return the same lines with respect to another origin (2,) or (m, 2); covariances follow."""
        shift = np.broadcast_to(origin, (len(self), 2))
        lever = (shift * self.along).sum(axis=1)
        jacobian = np.zeros((len(self), 2, 2))
        jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
        jacobian[:, 1, 0] = lever
        covariance = jacobian @ self.covariance @ jacobian.transpose(0, 2, 1)
        return replace(self, radius=self.radius - (shift * self.normal).sum(axis=1), covariance=covariance)


def point_covariance(points: Floats, scanner: Floats, *, range_noise: float, bearing_noise: float) -> Floats:
    """Covariance of measured points: range noise along the ray, bearing noise across it (section 1.3; Pfister et al., equation 5).

    Parameters
    ----------
    points : (n, 2) float64
        Points, metres.
    scanner : (n, 2) float64
        Position of the scanner at the time of each, metres.
    range_noise : float
        Standard deviation of a distance, metres.
    bearing_noise : float
        Standard deviation of a bearing, radians.

    Returns
    -------
    (n, 2, 2) float64
        Square metres.

    Examples
    --------
    >>> point_covariance(np.array([[10.0, 0.0]]), np.zeros((1, 2)), range_noise=0.02, bearing_noise=0.001).round(6).tolist()
    [[[0.0004, 0.0], [0.0, 0.0001]]]
    """
    ray = points - scanner
    square = np.maximum((ray**2).sum(axis=1), 1e-12)
    outer = ray[:, :, None] * ray[:, None, :] / square[:, None, None]
    across = np.eye(2) - outer
    out: Floats = range_noise**2 * outer + (bearing_noise**2 * square)[:, None, None] * across
    return out


def fit_lines(points: Floats, group: Ints, covariance: Floats, *, count: int | None = None) -> PolarLines:
    """Fit a line to each group of points: the distances across it, each weighted by its variance, are least (section 1.3).

    The distance of a point from the line is rho cos(alpha - phi) - R. Its variance is the point's covariance seen along the current
    normal; the normal follows from the weights. Both are repeated until alpha settles. The covariance of alpha and R is the inverse of the
    weighted normal matrix.

    Parameters
    ----------
    points : (n, 2) float64
        Points, metres.
    group : (n,) int64
        Row of the line that each point belongs to; negative: none.
    covariance : (n, 2, 2) float64
        Covariance of each point, square metres, positive definite.
    count : int, optional
        Number of lines; None: the largest group and one.

    Returns
    -------
    PolarLines
        One row per group; NaN for groups with fewer than two different points.

    Examples
    --------
    >>> x = np.array([[0.0, 2.0], [1.0, 2.0], [2.0, 2.0]])
    >>> line = fit_lines(x, np.zeros(3, dtype=np.int64), np.broadcast_to(0.01**2 * np.eye(2), (3, 2, 2)))
    >>> np.degrees(line.alpha).round(6).tolist(), line.radius.round(6).tolist()
    ([90.0], [2.0])
    >>> np.sqrt(line.covariance[0, 0, 0]).round(6)  # 0.01 / sqrt(1 + 0 + 1)
    np.float64(0.007071)
    """
    inside = group >= 0
    points, group = points[inside], group[inside]
    xx, xy, yy = covariance[inside, 0, 0], covariance[inside, 0, 1], covariance[inside, 1, 1]
    m = int(group.max(initial=-1)) + 1 if count is None else count

    def total(values: Floats) -> Floats:
        return np.asarray(np.bincount(group, weights=values, minlength=m), dtype=np.float64)

    size = np.maximum(total(np.ones(len(group))), 1)
    start = np.column_stack([total(points[:, k]) / size for k in (0, 1)])
    local = points - start[group]  # near the origin, so that no digits are lost
    x, y = local.T
    angle = np.arctan2(2 * total(x * y), total(x * x) - total(y * y)) / 2 + np.pi / 2
    alpha = angle
    mean, spread, weights = np.zeros((m, 2)), np.zeros(m), np.zeros(m)
    rows, moving = np.arange(len(group)), np.ones(m, dtype=bool)
    for _ in range(ROUNDS):
        at = group[rows]

        def sums(values: Floats, at: Ints = at) -> Floats:
            return np.asarray(np.bincount(at, weights=values, minlength=m)[moving], dtype=np.float64)

        c, s = np.cos(alpha)[at], np.sin(alpha)[at]
        weight = 1 / (c * c * xx[rows] + 2 * c * s * xy[rows] + s * s * yy[rows])
        weights[moving] = sums(weight)
        for k in (0, 1):
            mean[moving, k] = sums(weight * local[rows, k]) / np.maximum(weights[moving], 1e-300)
        dx, dy = local[rows, 0] - mean[at, 0], local[rows, 1] - mean[at, 1]
        # the turn that makes along and across uncorrelated: the exact minimum for these weights
        wxx, wxy, wyy = sums(weight * dx * dx), sums(weight * dx * dy), sums(weight * dy * dy)
        target = np.arctan2(2 * wxy, wxx - wyy) / 2 + np.pi / 2
        turn = (target - alpha[moving] + np.pi / 2) % np.pi - np.pi / 2
        alpha[moving] += turn
        spread[moving] = (wxx + wyy) / 2 + np.hypot((wxx - wyy) / 2, wxy)
        moving[moving] = np.abs(turn) >= ANGLE_SETTLED
        if not moving.any():
            break
        rows = rows[moving[at]]
    normal = np.column_stack([np.cos(alpha), np.sin(alpha)])
    tangent = np.column_stack([-np.sin(alpha), np.cos(alpha)])
    middle = start + mean
    radius = (normal * middle).sum(axis=1)
    lever = (tangent * middle).sum(axis=1)
    fitted = (spread > 1e-12) & (weights > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        of_angle, of_offset = 1 / spread, 1 / weights
        matrix = np.array([[of_angle, lever * of_angle], [lever * of_angle, of_offset + lever**2 * of_angle]]).transpose(2, 0, 1)
    nothing = np.where(fitted, 0.0, np.nan)
    return PolarLines(_wrapped(alpha) + nothing, radius + nothing, np.where(fitted[:, None, None], matrix, np.nan))


def project_ends(points: Floats, group: Ints, lines: PolarLines) -> tuple[Floats, Floats]:
    """First and last point of each group, projected to its line (section 1.3).

    Parameters
    ----------
    points : (n, 2) float64
        Points, metres.
    group : (n,) int64
        Row of the line that each point belongs to; negative: none.
    lines : PolarLines
        Lines.

    Returns
    -------
    p, q : (m, 2) float64
        Ends, metres; the normal lies to the left of p -> q.
    """
    inside = group >= 0
    member = group[inside]
    along = (points[inside] * lines.along[member]).sum(axis=1)
    first, last = np.full(len(lines), np.inf), np.full(len(lines), -np.inf)
    np.minimum.at(first, member, along)
    np.maximum.at(last, member, along)
    foot = lines.radius[:, None] * lines.normal
    return foot + first[:, None] * lines.along, foot + last[:, None] * lines.along


def _wrapped(angle: Floats) -> Floats:
    """Angles in (-pi, pi]."""
    turned: Floats = -((np.pi - angle) % (2 * np.pi) - np.pi)
    return turned
