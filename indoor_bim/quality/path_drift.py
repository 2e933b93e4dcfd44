"""How a scanner's map is bent along its path, as far as the walls of a model tell.

A map made by walking drifts by centimetres over tens of seconds. What drifts moves all walls seen at that time together, each
along its own normal; a wall that stands elsewhere than modelled is off alone, and at all times. So small shifts and turns along the
path, smooth in time, are fitted to the distances of all walls together with an offset of each plane, of which most are zero (least absolute
values), with weights that fall with the residual (iteratively reweighted least squares; Beaton and Tukey, Technometrics 16, 1974).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from indoor_bim.quality.unique_rows import unique_rows

if TYPE_CHECKING:
    from scipy import sparse

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

KNOT = 5.0  # seconds between knots: drift changes more slowly
STRETCH = 1.0  # metres along a face that one observation covers
FEWEST = 10  # points of an observation
SPREAD = 0.005  # metres: of an observation, by what the scanner and the wall itself do
WALK = (0.01, np.radians(0.05))  # change of shift and turn between neighbouring knots
SIZE = (0.04, np.radians(0.3))  # of shift and turn
OWN, LEAST_OWN = 0.005, 0.0005  # metres: what a plane is off by itself, mostly little, but now and then much; least amount told
ITERATIONS = 25
TUKEY = 4.685  # spreads beyond which an observation has no weight


@dataclass(frozen=True, slots=True, eq=False)
class PathDrift:
    """Shift and turn in plan that take the map back, at knots along the path.

    Parameters
    ----------
    time : (k,) float64
        Knots, seconds, ascending.
    shift : (k, 2) float64
        Shift at each knot, metres.
    turn : (k,) float64
        Turn about the scanner at each knot, radians; 0 where the scanner's place is not known.
    """

    time: Floats
    shift: Floats
    turn: Floats

    def displacement(self, xy: Floats, time: Floats, scanner: Floats | None) -> Floats:
        """Where points (n, 2) of given times (n,) move, seen from the scanner at (n, 2), metres."""
        moved = np.column_stack([np.interp(time, self.time, self.shift[:, k]) for k in (0, 1)])
        if scanner is not None:
            arm = xy - scanner
            moved += np.interp(time, self.time, self.turn)[:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
        return moved

    @property
    def largest(self) -> float:
        """Largest shift about the median one, metres."""
        return float(np.hypot(*(self.shift - np.median(self.shift, axis=0)).T).max())


def path_drift(xy: Floats, normal: Floats, distance: Floats, plane: Ints, time: Floats, scanner: Floats | None = None) -> PathDrift | None:
    """Fit the drift of a map to the distances of its points from the faces of walls.

    Parameters
    ----------
    xy : (n, 2) float64
        Points on faces, metres.
    normal : (n, 2) float64
        Unit normals of their faces.
    distance : (n,) float64
        Signed distance of each point from its face, metres.
    plane : (n,) int64
        Number of the plane that each face lies in.
    time : (n,) float64
        Time of each point, seconds.
    scanner : (n, 2) float64, optional
        Where the scanner was; without it only shifts are fitted.

    Returns
    -------
    PathDrift or None
        None when there is too little to fit.
    """
    window = np.floor((time - time.min()) / KNOT).astype(np.int64) if len(time) else np.zeros(0, dtype=np.int64)
    along = np.floor((xy[:, 1] * normal[:, 0] - xy[:, 0] * normal[:, 1]) / STRETCH).astype(np.int64)
    rows, _, group, count = unique_rows(np.column_stack([window, plane, along]))
    if (count >= FEWEST).sum() < FEWEST:
        return None

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(group, weights=values, minlength=len(count)) / count)[count >= FEWEST]

    seen_at, off = mean(time), mean(distance)
    own = np.unique(rows[count >= FEWEST, 1], return_inverse=True)[1].reshape(-1)
    n = np.column_stack([mean(normal[:, 0]), mean(normal[:, 1])])
    knots = np.unique(np.floor((seen_at - seen_at.min()) / KNOT)) * KNOT + seen_at.min() + KNOT / 2
    arm = np.zeros_like(n) if scanner is None else np.column_stack([mean(xy[:, k] - scanner[:, k]) for k in (0, 1)])
    lever = n[:, 1] * arm[:, 0] - n[:, 0] * arm[:, 1]
    solution = _fit(seen_at, np.column_stack([n, lever]), off, own, knots)
    return PathDrift(knots, solution[:, :2], solution[:, 2])


def _fit(time: Floats, coefficient: Floats, off: Floats, plane: Ints, knots: Floats) -> Floats:
    """Parameters (k, 3) at the knots that bring observations to zero, but for an offset that each plane has of its own."""
    from scipy import sparse
    from scipy.sparse.linalg import spsolve

    k, planes = len(knots), int(plane.max()) + 1
    left = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, max(k - 2, 0))
    right = np.minimum(left + 1, k - 1)
    share = np.clip((time - knots[left]) / np.maximum(knots[right] - knots[left], 1e-9), 0.0, 1.0)
    bend = np.column_stack([3 * left, 3 * left + 1, 3 * left + 2, 3 * right, 3 * right + 1, 3 * right + 2, 3 * k + plane])
    values = np.column_stack([coefficient * (1 - share)[:, None], coefficient * share[:, None], -np.ones(len(time))])
    entries = (values.ravel(), (np.repeat(np.arange(len(time)), bend.shape[1]), bend.ravel()))
    design = sparse.csr_matrix(entries, shape=(len(time), 3 * k + planes)) / SPREAD
    prior = _smoothness(knots)
    target = -off / SPREAD
    found = np.zeros(3 * k + planes)
    for _ in range(ITERATIONS):
        residual = design @ found - target
        scale = max(1.0, 1.4826 * float(np.median(np.abs(residual))))
        weight = np.clip(1 - (residual / (TUKEY * scale)) ** 2, 0.0, None) ** 2
        weighted = design.multiply(weight[:, None]).tocsr()
        own = 1 / (OWN * np.maximum(np.abs(found[3 * k :]), LEAST_OWN))
        found = spsolve((weighted.T @ design + sparse.block_diag([prior, sparse.diags(own)])).tocsc(), weighted.T @ target)
    return np.asarray(found)[: 3 * k].reshape(k, 3)


def _smoothness(knots: Floats) -> sparse.spmatrix:
    """Inverse covariance (3 k, 3 k) of the parameters before anything was seen."""
    from scipy import sparse

    k = len(knots)
    size, walk = np.array([SIZE[0], SIZE[0], SIZE[1]]), np.array([WALK[0], WALK[0], WALK[1]])
    prior = sparse.kron(sparse.identity(k), sparse.diags(1 / size**2))
    if k == 1:
        return prior
    step = np.sqrt(np.diff(knots) / KNOT)
    change = sparse.kron(sparse.diags([-1 / step, 1 / step], [0, 1], shape=(k - 1, k)), sparse.diags(1 / walk))
    return prior + change.T @ change
