"""Stretches of faces along which a wall stands: full enough columns of hits from low down up to near the ceiling.

A wall that was seen through a door is hit in few places, a beam below the ceiling in many, all of them high up, and furniture
in many, all of them low. So columns tell a wall where the share of the whole face that was hit does not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.intervals import Interval, merge_intervals, overlap
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

COLUMN, LAYER = 0.10, 0.10  # metres along and up the face
HIGH = 0.85  # share of the storey height that walls come up to; doors and cupboards are lower
LOW = (0.1, 0.5)  # shares of the storey height between which walls are hit as well; lintels and beams end higher, floors lie lower
LEAST_FILL = 0.25  # of the layers of a wall's column
LEAST_SHARE = 0.3  # of the columns of a stretch of a doubtful face
LARGEST_GAP = 1.0  # metres within it in which no wall shows
SAME_DIRECTION = 6  # decimals of the angle


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """What stands in the columns along one face, from p to q.

    Parameters
    ----------
    wall : (c,) bool
        Hit above `HIGH`, within `LOW` and in `LEAST_FILL` of all layers.
    passage : (c,) bool
        Floor where the face would stand, and no hit within `LOW`.
    """

    wall: Mask
    passage: Mask


def columns_of(
    faces: Segments, points: Floats, floor: Floats, *, reach: float, height: float, column: float = COLUMN, layer: float = LAYER
) -> list[Columns]:
    """Tell along each face where a wall stands and where one walks through.

    Parameters
    ----------
    faces : Segments
        Faces, metres. They are treated direction by direction: made for few directions.
    points : (n, 3) float64
        Wall points, metres, z above the floor.
    floor : (k, 2) float64
        Floor points in plan, metres.
    reach : float
        Points within this distance of a face belong to it, metres.
    height : float
        Height of the storey, metres.
    column, layer : float
        Size of the cells along and up the face, metres.

    Examples
    --------
    >>> faces = Segments.from_ends([[0.0, 0.0]], [[0.3, 0.0]])
    >>> wall = [[0.05, 0.0, z] for z in np.arange(0.3, 2.4, 0.1)]
    >>> points = np.array([*wall, [0.15, 0.0, 2.4], [0.25, 0.0, 0.4]])
    >>> columns = columns_of(faces, points, np.array([[0.15, 0.0], [0.25, 0.0]]), reach=0.05, height=2.5)[0]
    >>> columns.wall.tolist(), columns.passage.tolist()
    ([True, False, False], [False, True, False])
    """
    layers = max(round(height / layer), 1)
    row = np.clip((points[:, 2] / height * layers).astype(np.int64), 0, layers - 1)
    share = points[:, 2] / height
    zone = np.select([share >= HIGH, (share >= LOW[0]) & (share <= LOW[1])], [0, 1], 2)
    hits = _hit_cells(faces, points[:, :2], row, layers, reach=reach, side=column)
    zones = _hit_cells(faces, points[:, :2], zone, 3, reach=reach, side=column)
    floors = _hit_cells(faces, floor, np.zeros(len(floor), dtype=np.int64), 1, reach=reach, side=column)
    return [
        Columns(where[:, 0] & where[:, 1] & (hit.mean(axis=1) >= LEAST_FILL), through[:, 0] & ~where[:, 1])
        for hit, where, through in zip(hits, zones, floors, strict=True)
    ]


def _hit_cells(faces: Segments, xy: Floats, layer: NDArray[np.int64], layers: int, *, reach: float, side: float) -> list[Mask]:
    """Cells (columns, layers) of each face that hold a point."""
    counts = np.maximum(np.rint(faces.length / side).astype(np.int64), 1)
    cells = [np.zeros((count, layers), dtype=bool) for count in counts]
    angle = np.round(np.arctan2(faces.direction[:, 1], faces.direction[:, 0]), SAME_DIRECTION)
    for value in np.unique(angle):
        rows = np.flatnonzero(angle == value)
        axis, normal = faces.direction[rows[0]], faces.normal[rows[0]]
        along, across = xy @ axis, xy @ normal
        order = np.argsort(across, kind="stable")
        in_order = across[order]
        for row in rows:
            offset, start = float(faces.p[row] @ normal), float(faces.p[row] @ axis)
            near = order[np.searchsorted(in_order, offset - reach) : np.searchsorted(in_order, offset + reach)]
            place = (along[near] - start) / faces.length[row]
            inside = (place >= 0) & (place <= 1)
            column = np.minimum((place[inside] * counts[row]).astype(np.int64), counts[row] - 1)
            cells[row][column, layer[near[inside]]] = True
    return cells


def wall_share(columns: list[Columns]) -> Floats:
    """Share (m,) of the columns of each face in which a wall stands."""
    return np.array([along.wall.mean() for along in columns])


def wall_stretches(
    faces: Segments, columns: list[Columns], *, known: Mask, doubtful: Mask, widest: float = 1.6, shortest: float = 0.6
) -> Segments:
    """Known walls without wide passages, and of doubtful ones what is a wall after all.

    Parameters
    ----------
    faces : Segments
        Faces, metres.
    columns : list of Columns
        What stands along each, as `columns_of` tells.
    known, doubtful : (m,) bool
        Faces that are known to be walls, and those of which the columns shall tell.
    widest : float
        Widest passage that a known wall goes on over, metres.
    shortest : float
        Shortest stretch of a doubtful face that is a wall, and shortest part of a known one beside a passage, metres.

    Returns
    -------
    Segments
        Faces that are walls, in the order of the rows.
    """
    rows: list[int] = []
    ends: list[Interval] = []
    for k in np.flatnonzero(known | doubtful):
        length = float(faces.length[k])
        side = length / len(columns[k].wall)
        standing = ~columns[k].passage if known[k] else columns[k].wall
        places: list[Interval] = [(i * side, (i + 1) * side) for i in np.flatnonzero(standing).tolist()]
        if known[k]:
            spans = _up_to_the_ends(merge_intervals(places, gap=widest), length, widest)
            spans = spans if len(spans) == 1 else [span for span in spans if span[1] - span[0] >= shortest]
        else:
            spans = [span for span in merge_intervals(places, gap=LARGEST_GAP) if _is_wall(span, places, shortest)]
        rows += [int(k)] * len(spans)
        ends += spans
    table = faces.take(np.array(rows, dtype=np.int64))
    start, end = np.array(ends).reshape(-1, 2).T
    share = (end - start) / np.maximum(table.length, 1e-12)
    whole = (share > 1 - 1e-9)[:, None]
    return replace(
        table,
        p=np.where(whole, table.p, table.p + start[:, None] * table.direction),
        q=np.where(whole, table.q, table.p + end[:, None] * table.direction),
        support=np.round(table.support * share).astype(np.int64),
    )


def _up_to_the_ends(spans: list[Interval], length: float, widest: float) -> list[Interval]:
    """Spans of a face, the outer ones up to its ends where no more than a passage is between; the whole face without any."""
    if not spans:
        return [(0.0, length)]
    if spans[0][0] <= widest:
        spans = [(0.0, spans[0][1]), *spans[1:]]
    return [*spans[:-1], (spans[-1][0], length)] if length - spans[-1][1] <= widest else spans


def _is_wall(span: Interval, places: list[Interval], shortest: float) -> bool:
    length = span[1] - span[0]
    return length >= shortest and sum(overlap(span, place) for place in places) >= LEAST_SHARE * length
