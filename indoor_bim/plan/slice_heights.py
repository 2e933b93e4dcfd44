"""At which heights a storey is cut, and how thick the slices are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CELL = 0.10  # metres: side of the columns that are walls or not
LAYER = 0.05  # metres: height of a layer
WALL_FILL = 0.6  # of the layers that the fullest columns are hit in: from here on a column is wall
FULL = 0.95  # quantile of the hit layers that counts as the fullest
TOP_BAND, TOP_FILL = 0.30, 0.5  # metres below the ceiling, and share of its layers: what is hit there is wall too, above a door or window
FLAT = 2  # layers: what is hit in neither of those so far above and below is level, such as the underside of a lintel
CLEARANCE = 0.10  # metres above the floor and below the ceiling that are their own
THINNEST = 0.02  # metres: thinner slices gain nothing
POINTS_PER_METRE = 200  # of wall in plan and slice: what a line needs in order not to fall apart


@dataclass(frozen=True, slots=True)
class Slice:
    """Horizontal slice of a storey, metres above its floor."""

    low: float
    high: float

    @property
    def middle(self) -> float:
        """Height of its middle, metres."""
        return (self.low + self.high) / 2


@dataclass(frozen=True, slots=True, eq=False)
class LayerEvidence:
    """What each layer of a storey shows.

    Parameters
    ----------
    height : (k,) float64
        Middle of each layer above the floor, metres.
    hit : (k, m) bool
        Wall columns that are hit in each layer.
    clutter : (k,) int64
        Columns hit in each layer that are not beside a wall column, or level there: furniture, undersides of lintels.
    density : float
        Points on a metre of wall in plan per metre of height: the median of the wall columns.
    """

    height: Floats
    hit: NDArray[np.bool_]
    clutter: NDArray[np.int64]
    density: float


def layer_evidence(points: Floats, *, height: float, cell: float = CELL, layer: float = LAYER) -> LayerEvidence:
    """Which wall columns, and how much else, the layers of a storey show.

    A column of the plan is wall when it is hit in most layers from floor to ceiling, or right below the ceiling; furniture is not as tall.

    Parameters
    ----------
    points : (n, 3) float64
        Points between floor and ceiling, metres, z above the floor.
    height : float
        From floor to ceiling, metres.
    cell, layer : float
        Side of the columns and height of the layers, metres.
    """
    layers = max(int(np.floor((height - 2 * CLEARANCE) / layer)), 1)
    level = np.floor((points[:, 2] - CLEARANCE) / layer).astype(np.int64)
    within = (level >= 0) & (level < layers)
    place = np.floor(points[within, :2] / cell).astype(np.int64)
    place -= (place.min(axis=0) if len(place) else 0) - 1  # an empty column all around
    width = int(place[:, 1].max(initial=0)) + 2
    box, count = np.unique((place[:, 0] * width + place[:, 1]) * layers + level[within], return_counts=True)
    level = box % layers
    columns, column, filled = np.unique(box // layers, return_inverse=True, return_counts=True)
    # columns at the edge of a wall are hit here and there: the fullest tenth shows how many layers the scan reaches
    full = np.quantile(filled[filled > 0.3 * layers], FULL) if (filled > 0.3 * layers).any() else layers
    top = level >= layers - max(round(TOP_BAND / layer), 1)
    wall = (filled >= WALL_FILL * full) | (np.bincount(column[top], minlength=len(columns)) >= TOP_FILL * TOP_BAND / layer)
    number = np.cumsum(wall) - 1
    hit = np.zeros((layers, int(wall.sum())), dtype=bool)
    of_wall = wall[column]
    hit[level[of_wall], number[column[of_wall]]] = True
    beside = np.unique(columns[wall] + np.array([i * width + j for i in (-1, 0, 1) for j in (-1, 0, 1)])[:, None])
    alone = np.zeros((len(columns), layers + 2 * FLAT), dtype=bool)
    alone[column, level + FLAT] = True
    flat = alone[:, FLAT:-FLAT] & ~alone[:, : -2 * FLAT] & ~alone[:, 2 * FLAT :]  # nothing above, nothing below: seen from below or above
    other = ~of_wall & (~np.isin(columns, beside)[column] | flat[column, level])
    clutter = np.bincount(level[other], minlength=layers)
    points_in = np.bincount(column, weights=count)[wall]
    density = float(np.median(points_in)) / cell / (layers * layer) if wall.any() else 0.0
    middles: Floats = CLEARANCE + (np.arange(layers, dtype=np.float64) + 0.5) * layer
    return LayerEvidence(middles, hit, clutter, density)


def slice_thickness(evidence: LayerEvidence, *, spacing: float, height: float) -> float:
    """Thickness of the slices: three times the point spacing, so that at least three lines of the scan are in them (section 1.1).

    Where that leaves too few points on a wall to follow it, the slices are thicker.

    Parameters
    ----------
    evidence : LayerEvidence
        Layers of the storey.
    spacing : float
        Distance between neighbouring points, metres.
    height : float
        From floor to ceiling, metres.

    Returns
    -------
    float
        Metres; at most a tenth of the height, unless the spacing asks for more.
    """
    enough = POINTS_PER_METRE / max(evidence.density, 1e-9)
    return float(max(3 * spacing, THINNEST, min(enough, 0.10 * height)))


def choose_slices(evidence: LayerEvidence, *, thickness: float, count: int = 2, apart: float = 0.4) -> tuple[Slice, ...]:
    """Slices where most wall and least furniture is (section 1.1: two heights, chosen by the kind of building).

    The first slice is that whose layers show most wall columns, the share of other columns taken off; every further one, at least
    `apart` from the others, is chosen for what it adds.

    Parameters
    ----------
    evidence : LayerEvidence
        Layers of the storey.
    thickness : float
        Thickness of a slice, metres.
    count : int
        Number of slices.
    apart : float
        Least distance between the middles of two slices, metres.

    Returns
    -------
    tuple of Slice
        From the bottom up; fewer than `count` where the storey is too low for them.
    """
    layer = float(evidence.height[1] - evidence.height[0]) if len(evidence.height) > 1 else LAYER
    layers = min(max(round(thickness / layer), 1), len(evidence.height))
    starts = np.arange(max(len(evidence.height) - layers + 1, 1))
    shown = np.array([evidence.hit[s : s + layers].any(axis=0) for s in starts])
    clutter = np.array([evidence.clutter[s : s + layers].mean() for s in starts])
    middle = np.array([evidence.height[s : s + layers].mean() for s in starts])
    seen = np.zeros(shown.shape[1], dtype=bool)
    free = np.ones(len(starts), dtype=bool)
    chosen: list[float] = []
    while len(chosen) < count and free.any():
        walls = shown.sum(axis=1)
        clean = walls / np.maximum(walls + clutter, 1)
        gain = (0.5 * walls + (shown & ~seen).sum(axis=1)) * clean
        best = int(np.argmax(np.where(free, np.round(gain, 9), -1.0)))
        chosen.append(float(middle[best]))
        seen |= shown[best]
        free &= np.abs(middle - middle[best]) >= max(apart, thickness) - 1e-9
    return tuple(Slice(at - thickness / 2, at + thickness / 2) for at in sorted(chosen))
