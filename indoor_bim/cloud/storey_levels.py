"""Floors and ceilings of the storeys of an upright scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.box_moments import box_moments
from indoor_bim.cloud.cloud import StoreyLevels
from indoor_bim.cloud.heights import LEVEL_TOLERANCE, height_peaks, level_at
from indoor_bim.cloud.plane_pieces import CELL, Patches, level_pieces, plane_pieces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_WIDE = 2 * CELL
"""Side of the plane pieces, metres: wide enough for thinly scanned floors."""
_LAYERS = 6
"""Level surfaces are told from walls in layers of a wide plane piece, 10 cm each."""
_MIN_CLEAR_HEIGHT = 1.8
_LOWEST_TABLE = 0.4
_HIGHEST_TABLE = 1.2
_AROUND = 4  # columns
_MIN_STOREY_AREA = 2.0


def storey_levels(points: Floats) -> tuple[StoreyLevels, ...]:
    """Floors and ceilings of the storeys, from the bottom up.

    In every column of the plan the level surfaces that stand at least a room's height apart, with nothing level
    between them, are the bottom and top of a space. The bottoms that cover most area are floors; spaces that overlap in
    height for the most part belong to one storey. Where most of a bottom has a lower one close around, it is the top of
    furniture, however much of the floor was seen. A ceiling is the top that most of the storey's area shares; where tops
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
    thin = box_moments(points, sides=(CELL, CELL, _WIDE / _LAYERS))
    level = level_pieces(thin)
    overhead = np.zeros((0, 3))
    tall = thin.merged((1, 1, _LAYERS))
    flat = plane_pieces(tall.merged((2, 2, 1)))
    if len(flat.centre):
        pieces, slope = _quarters(tall.mean, flat)
        overhead = pieces[slope < np.radians(60)]
        level = np.vstack([level, pieces[slope < np.radians(8)]])
    if not len(level):
        return ()
    bottoms, tops, columns = _clear_spaces(overhead, level)
    if not len(bottoms):
        return _open_level(points, level[:, 2])
    found: list[_Bottom] = []
    for floor in height_peaks(bottoms, share=0.08):
        mine = np.abs(bottoms - floor) < LEVEL_TOLERANCE
        is_ceiling = (np.abs(tops - floor) < LEVEL_TOLERANCE).sum() > mine.sum()
        if is_ceiling or mine.sum() * CELL**2 < _MIN_STOREY_AREA:
            continue
        found.append(_Bottom(floor, float(np.median(tops[mine])), columns[mine]))
    found.sort(key=lambda bottom: (-len(bottom.columns), bottom.floor))
    groups: list[_Bottom] = []
    for bottom in found:
        if not any(bottom.is_furniture(other) for other in found) and not any(bottom.overlaps(group) for group in groups):
            groups.append(bottom)
    storeys, height = [], np.ascontiguousarray(points[:, 2])
    for floor in sorted(group.floor for group in groups):
        mine = np.abs(bottoms - floor) < LEVEL_TOLERANCE
        ceilings = [z for z in height_peaks(tops[mine], share=1.0) if (np.abs(tops[mine] - z) < LEVEL_TOLERANCE).mean() > 0.3]
        storeys.append(StoreyLevels(level_at(height, floor), level_at(height, ceilings[0]) if ceilings else None))
    return tuple(storeys) if storeys else _open_level(points, level[:, 2])


@dataclass(frozen=True, slots=True, eq=False)
class _Bottom:
    """Bottom of spaces: its height, their usual top and the columns of the plan."""

    floor: float
    top: float
    columns: Ints

    def overlaps(self, other: _Bottom) -> bool:
        """Whether most of the lower of the two spaces is in the other."""
        common = min(self.top, other.top) - max(self.floor, other.floor)
        return common > 0.5 * min(self.top - self.floor, other.top - other.floor)

    def is_furniture(self, other: _Bottom) -> bool:
        """Whether the other bottom is that of the floor that this one stands on."""
        lower = self.floor - other.floor
        if not _LOWEST_TABLE < lower < _HIGHEST_TABLE or len(other.columns) < 0.1 * len(self.columns):
            return False
        from scipy.spatial import cKDTree

        distance, _ = cKDTree(other.columns).query(self.columns, p=np.inf, distance_upper_bound=_AROUND + 0.5)
        return bool((distance <= _AROUND).mean() > 0.7)


def _quarters(boxes: Floats, flat: Patches) -> tuple[Floats, Floats]:
    """Mean points (m, 3) of the boxes that lie in a wide plane piece, and the angle (m,) of the piece from level, radians."""
    wide, quarter = (np.floor(xyz / _WIDE).astype(np.int64) for xyz in (flat.centre, boxes))
    first, size = wide.min(axis=0), np.ptp(wide, axis=0) + 1
    inside = ((quarter >= first) & (quarter < first + size)).all(axis=1)
    boxes, quarter = boxes[inside], quarter[inside]
    key, wanted = (np.ravel_multi_index(tuple((cell - first).T), size) for cell in (wide, quarter))
    order = np.argsort(key)
    place = order[np.minimum(np.searchsorted(key[order], wanted), len(key) - 1)]
    found = key[place] == wanted
    return boxes[found], np.arccos(np.minimum(np.abs(flat.normal[place[found], 2]), 1.0))


def _clear_spaces(overhead: Floats, level: Floats) -> tuple[Floats, Floats, Ints]:
    """Bottoms, tops (k,) and columns (k, 2) of the spaces between a level surface and the next surface a room's height above."""
    everything = np.vstack([overhead, level])
    is_level = np.arange(len(everything)) >= len(overhead)
    cells = _columns(everything)
    first = cells.min(axis=0)
    width = int(cells[:, 1].max() - first[1]) + 1
    column = (cells[:, 0] - first[0]) * width + cells[:, 1] - first[1]
    order = np.lexsort((everything[:, 2], column))
    column, z, is_level = column[order], everything[order, 2], is_level[order]
    # duplicates (a level piece stands in both lists) have no gap between them and drop out by themselves
    gap = (column[1:] == column[:-1]) & (z[1:] - z[:-1] >= _MIN_CLEAR_HEIGHT)
    below = np.flatnonzero(gap)
    lower_is_level = is_level[below] | ((below > 0) & is_level[np.maximum(below - 1, 0)] & (z[below] - z[np.maximum(below - 1, 0)] < 1e-9))
    below = below[lower_is_level]
    return z[below], z[below + 1], first + np.column_stack(np.divmod(column[below], width))


def _columns(points: Floats) -> Ints:
    return np.floor(points[:, :2] / CELL).astype(np.int64)


def _open_level(points: Floats, height: Floats) -> tuple[StoreyLevels, ...]:
    """One storey of which only the floor or only the ceiling was seen."""
    peak = level_at(height, height_peaks(height, share=0.5)[0])
    above = int((points[:, 2] > peak + 0.3).sum())
    below = int((points[:, 2] < peak - 0.3).sum())
    return (StoreyLevels(peak, None),) if above >= below else (StoreyLevels(None, peak),)
