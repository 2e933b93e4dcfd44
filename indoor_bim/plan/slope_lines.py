"""Lines of slope 0, 1, -1 or vertical in a skeleton (Remote Sensing 2021, 13, 4930, section 2.3 from figure 15 on)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.skeleton import VERTICAL, Slopes
from indoor_bim.plan.slope_corners import SLOPE_DIRECTION, correct_ends, join_corners

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class SlopeLines:
    """Lines made of pixels of equal slope, one row each, in pixels; x runs along columns, y along rows.

    Parameters
    ----------
    slope : (m,) int64
        0, 1, -1 or 2 (vertical).
    count : (m,) int64
        Number of pixels.
    total : (m, 2) float64
        Sums of their x and y.
    first, last : (m, 2) float64
        End points x, y: the pixels farthest back and farthest ahead along the line.
    """

    slope: Ints
    count: Ints
    total: Floats
    first: Floats
    last: Floats

    def __len__(self) -> int:
        return len(self.slope)

    @property
    def midpoint(self) -> Floats:
        """(m, 2) float64 means of the pixels."""
        return self.total / self.count[:, None]

    @property
    def direction(self) -> Floats:
        """(m, 2) float64 unit vectors along the lines."""
        return np.array([SLOPE_DIRECTION[int(k)] for k in self.slope]).reshape(-1, 2)

    def take(self, rows: Ints | NDArray[np.bool_]) -> Self:
        """Lines of the given rows (indices or mask)."""
        return type(self)(self.slope[rows], self.count[rows], self.total[rows], self.first[rows], self.last[rows])


def grow_lines(slopes: Slopes) -> SlopeLines:
    """Lines of neighbouring pixels with equal slope (section 2.3, figure 15, algorithm 4 steps 15 to 24).

    The paper grows from seeds (pixels with one neighbour, none, or two of different slope) to the neighbour of equal slope until
    there is none. The result, whatever the seeds, is the set of groups of pixels of equal slope that touch each other.

    Parameters
    ----------
    slopes : (rows, columns) int8
        Slopes of the skeleton.

    Returns
    -------
    SlopeLines
        Lines sorted by slope, then by the y and x of their topmost pixel.

    Examples
    --------
    >>> lines = grow_lines(np.array([[0, 0, 0, 3], [3, 3, 3, 2], [3, 3, 3, 2]], dtype=np.int8))
    >>> lines.slope.tolist(), lines.count.tolist(), lines.midpoint.tolist()
    ([0, 2], [3, 2], [[1.0, 0.0], [3.0, 1.5]])
    """
    from scipy import ndimage

    found = []
    for slope in (-1, 0, 1, VERTICAL):
        label, amount = ndimage.label(slopes == slope, structure=np.ones((3, 3)))
        if not amount:
            continue
        y, x = np.nonzero(label)
        line = label[y, x] - 1
        along = SLOPE_DIRECTION[slope][0] * x + SLOPE_DIRECTION[slope][1] * y
        order = np.lexsort((x, y, along, line))
        starts = np.searchsorted(line[order], np.arange(amount))
        ends = np.append(starts[1:], len(order)) - 1
        xy = np.column_stack([x, y]).astype(np.float64)
        found.append(
            SlopeLines(
                slope=np.full(amount, slope, dtype=np.int64),
                count=np.bincount(line, minlength=amount),
                total=np.column_stack([np.bincount(line, weights=axis, minlength=amount) for axis in xy.T]),
                first=xy[order[starts]],
                last=xy[order[ends]],
            )
        )
    return _joined(found)


def _joined(parts: list[SlopeLines]) -> SlopeLines:
    if not parts:
        none = np.zeros(0, dtype=np.int64)
        return SlopeLines(none, none, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 2)))
    return SlopeLines(*(np.concatenate([getattr(part, name) for part in parts]) for name in SlopeLines.__slots__))


def merge_lines(lines: SlopeLines, *, merge_gap: float, merge_offset: float) -> SlopeLines:
    """Lines of equal slope whose nearest end points are close, made one, until their number is stable (section 2.3, figure 16).

    The paper compares each line with all later ones, in the order in which they were found. Here the closest pairs come
    first and each line is merged once per round, ties by coordinates, so that the order of the lines does not matter.

    Parameters
    ----------
    lines : SlopeLines
        Lines, pixels.
    merge_gap : float
        Distance of end points below which lines are merged, pixels (d_p).
    merge_offset : float
        Largest distance across the lines between their midpoints, pixels. It keeps the two faces of a wall apart. The paper has
        no such limit: infinity.

    Returns
    -------
    SlopeLines
        Merged lines.
    """
    from scipy.spatial import cKDTree

    while len(lines) > 1:
        m = len(lines)
        ends = np.concatenate([lines.first, lines.last])
        pairs = cKDTree(ends).query_pairs(merge_gap, output_type="ndarray")
        a, b = np.sort(pairs % m, axis=1).T
        distance = np.hypot(*(ends[pairs[:, 0]] - ends[pairs[:, 1]]).T)
        step = lines.midpoint[b] - lines.midpoint[a]
        along = lines.direction[a]
        offset = np.abs(along[:, 0] * step[:, 1] - along[:, 1] * step[:, 0])
        fits = (a != b) & (lines.slope[a] == lines.slope[b]) & (distance < merge_gap) & (offset <= merge_offset)
        a, b, distance = a[fits], b[fits], distance[fits]
        if not len(a):
            break
        place = np.lexsort((lines.last[:, 0], lines.last[:, 1], lines.first[:, 0], lines.first[:, 1], lines.slope)).argsort()
        low, high = np.minimum(place[a], place[b]), np.maximum(place[a], place[b])
        free = np.ones(m, dtype=bool)
        couples = []
        for i in np.lexsort((high, low, distance)):
            if free[a[i]] and free[b[i]]:
                free[[a[i], b[i]]] = False
                couples.append((a[i], b[i]))
        first, second = np.array(couples).T
        lines = _joined([lines.take(free), _united(lines.take(first), lines.take(second))])
    return lines


def _united(a: SlopeLines, b: SlopeLines) -> SlopeLines:
    """Row-wise union of lines of equal slope."""
    along = a.direction

    def ahead(ends: Floats) -> Floats:
        return ends[:, 0] * along[:, 0] + ends[:, 1] * along[:, 1]

    return SlopeLines(
        slope=a.slope,
        count=a.count + b.count,
        total=a.total + b.total,
        first=np.where((ahead(a.first) <= ahead(b.first))[:, None], a.first, b.first),
        last=np.where((ahead(a.last) >= ahead(b.last))[:, None], a.last, b.last),
    )


def find_slope_lines(slopes: Slopes, *, min_pixels: int, merge_gap: float, merge_offset: float) -> SlopeLines:
    """Grow lines, drop those of few pixels and merge the rest (section 2.3).

    Parameters
    ----------
    slopes : (rows, columns) int8
        Slopes of the skeleton without faults.
    min_pixels : int
        Lines of fewer pixels are dropped.
    merge_gap, merge_offset : float
        See `merge_lines`, pixels.

    Returns
    -------
    SlopeLines
        Lines, pixels.
    """
    lines = grow_lines(slopes)
    return merge_lines(lines.take(lines.count >= min_pixels), merge_gap=merge_gap, merge_offset=merge_offset)


def to_segments(lines: SlopeLines, raster: Raster, *, corner_gap: float) -> Segments:
    """Lines with corrected end points and corners, in metres (sections 2.3 and 2.4).

    Parameters
    ----------
    lines : SlopeLines
        Merged lines, pixels.
    raster : Raster
        Image that the skeleton came from.
    corner_gap : float
        See `join_corners`, pixels.

    Returns
    -------
    Segments
        One per line, sorted by the coordinates of its ends.
    """
    p = correct_ends(lines.first, lines.midpoint, lines.slope)
    q = correct_ends(lines.last, lines.midpoint, lines.slope)
    p, q = join_corners(p, q, lines.slope, corner_gap=corner_gap)
    long = (p != q).any(axis=1)
    p, q = (raster.origin + (ends[long] + 0.5) * raster.cell for ends in (p, q))
    order = np.lexsort((q[:, 1], q[:, 0], p[:, 1], p[:, 0]))
    return Segments.from_ends(p[order], q[order])
