"""Floors and ceilings of the storeys of an upright scan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import StoreyLevels
from indoor_bim.cloud.heights import LEVEL_TOLERANCE, height_peaks, level_at
from indoor_bim.cloud.plane_pieces import CELL, level_pieces, patches

Floats = NDArray[np.float64]

_MIN_CLEAR_HEIGHT = 1.8
_MIN_STOREY_AREA = 2.0


def storey_levels(points: Floats) -> tuple[StoreyLevels, ...]:
    """Floors and ceilings of the storeys, from the bottom up.

    In every column of the plan the level surfaces that stand at least a room's height apart, with nothing level
    between them, are the bottom and top of a space. The bottoms that cover most area are floors; spaces that overlap in
    height for the most part belong to one storey. A ceiling is the top that most of the storey's area shares; where tops
    share no height (a pitched roof) there is none.

    Parameters
    ----------
    points : (n, 3) float64
        Thinned upright points, metres.

    Returns
    -------
    tuple of StoreyLevels
        Empty where no level surface was found.
    """
    flat = patches(points)
    overhead = flat.centre[np.abs(flat.normal[:, 2]) > np.cos(np.radians(60))]
    level = level_pieces(points)
    if not len(level):
        return ()
    bottoms, tops = _clear_spaces(overhead, level)
    if not len(bottoms):
        return _open_level(points, level[:, 2])
    storeys: list[StoreyLevels] = []
    groups: list[list[float]] = []
    for floor in height_peaks(bottoms, share=0.08):
        mine = np.abs(bottoms - floor) < LEVEL_TOLERANCE
        is_ceiling = (np.abs(tops - floor) < LEVEL_TOLERANCE).sum() > mine.sum()
        if is_ceiling or mine.sum() * CELL**2 < _MIN_STOREY_AREA:
            continue
        top = float(np.median(tops[mine]))
        for group in groups:
            overlap = min(top, group[1]) - max(floor, group[0])
            if overlap > 0.5 * min(top - floor, group[1] - group[0]):
                break
        else:
            groups.append([floor, top])
    for floor, _ in sorted(groups):
        mine = np.abs(bottoms - floor) < LEVEL_TOLERANCE
        ceilings = [z for z in height_peaks(tops[mine], share=1.0) if (np.abs(tops[mine] - z) < LEVEL_TOLERANCE).mean() > 0.3]
        storeys.append(StoreyLevels(level_at(points[:, 2], floor), level_at(points[:, 2], ceilings[0]) if ceilings else None))
    return tuple(storeys) if storeys else _open_level(points, level[:, 2])


def _clear_spaces(overhead: Floats, level: Floats) -> tuple[Floats, Floats]:
    """Bottom and top (k,) of the spaces between a level surface and the next surface at least a room's height above."""
    everything = np.vstack([overhead, level])
    is_level = np.arange(len(everything)) >= len(overhead)
    cells = np.floor(everything[:, :2] / CELL).astype(np.int64)
    cells -= cells.min(axis=0)
    column = cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]
    order = np.lexsort((everything[:, 2], column))
    column, z, is_level = column[order], everything[order, 2], is_level[order]
    # duplicates (a level piece stands in both lists) have no gap between them and drop out by themselves
    gap = (column[1:] == column[:-1]) & (z[1:] - z[:-1] >= _MIN_CLEAR_HEIGHT)
    below = np.flatnonzero(gap)
    lower_is_level = is_level[below] | ((below > 0) & is_level[np.maximum(below - 1, 0)] & (z[below] - z[np.maximum(below - 1, 0)] < 1e-9))
    below = below[lower_is_level]
    return z[below], z[below + 1]


def _open_level(points: Floats, height: Floats) -> tuple[StoreyLevels, ...]:
    """One storey of which only the floor or only the ceiling was seen."""
    peak = level_at(height, height_peaks(height, share=0.5)[0])
    above = int((points[:, 2] > peak + 0.3).sum())
    below = int((points[:, 2] < peak - 0.3).sum())
    return (StoreyLevels(peak, None),) if above >= below else (StoreyLevels(None, peak),)
