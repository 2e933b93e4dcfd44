"""Rectangular holes in the picture of a wall: places that rays went into."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.labels import connected_cells
from indoor_bim.plan.wall_picture import WallPicture

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

CLEARLY = 4  # times as many rays from one side went in as met the face
SMALLEST_SIDE = 0.30  # metres: smaller holes are sockets, pipes and gaps in the scan
LEAST_RAYS = 30
NARROW_BAR = 0.20  # metres: mullions, transoms and stripes without rays do not end a hole
THIN_BAR = 0.08  # metres: no pier or beam is thinner, mullions may be
FULL_LINE = 0.35  # a row or column belongs to a hole when it is open over this share of its typical length


@dataclass(frozen=True, slots=True)
class Hole:
    """Rectangle that rays went into, metres along the wall and up from its foot.

    Parameters
    ----------
    start, end, bottom, top : float
        Its sides.
    """

    start: float
    end: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """Width in metres."""
        return self.end - self.start

    @property
    def height(self) -> float:
        """Height in metres."""
        return self.top - self.bottom


def cell_states(picture: WallPicture) -> tuple[Bools, Bools]:
    """Open cells and wall cells of a picture; the others are unknown.

    A cell takes the majority of the rays in the 3 x 3 cells around it; where there are fewer than two, nothing is known. A recess
    that one side shows clearly is open, whatever the other side shows: the leaf of a door may lie in the plane of one face.

    Parameters
    ----------
    picture : WallPicture
        Picture of one wall.

    Returns
    -------
    open_cells, wall_cells : (rows, columns) bool
        Cells that rays went into; cells whose face was hit.
    """
    entered, face = (np.stack([around(side) for side in counts]) for counts in (picture.entered, picture.face))
    known = (entered + face).sum(axis=0) >= 2
    open_cells = known & (entered.sum(axis=0) > face.sum(axis=0))
    open_cells |= (entered >= CLEARLY * np.maximum(face, 1)).any(axis=0)
    return open_cells, known & ~open_cells


def blind_cell_states(picture: WallPicture) -> tuple[Bools, Bools]:
    """Cells without hits on a face, taken for open where the path of the scanner is not known, and wall cells.

    Parameters
    ----------
    picture : WallPicture
        Picture of one wall.

    Returns
    -------
    open_cells, wall_cells : (rows, columns) bool
        Cells around which no face was hit, or more was hit inside the wall; the others.
    """
    entered, face = around(picture.entered.sum(axis=0)), around(picture.face.sum(axis=0))
    wall_cells = (face >= 2) & (face >= entered)
    return ~wall_cells, wall_cells


def find_holes(
    open_cells: Bools, wall_cells: Bools, *, cell: float, min_width: float = SMALLEST_SIDE, min_height: float = SMALLEST_SIDE
) -> list[Hole]:
    """Rectangles around connected open cells, to the nearest cell.

    Parameters
    ----------
    open_cells, wall_cells : (rows, columns) bool
        States of the cells.
    cell : float
        Side of a cell, metres.
    min_width, min_height : float
        Smallest holes, metres.

    Examples
    --------
    >>> state = np.zeros((30, 50), dtype=bool)
    >>> state[:20, 10:20] = True
    >>> find_holes(state, ~state, cell=0.1)
    [Hole(start=1.0, end=2.0, bottom=0.0, top=2.0)]
    """
    bridged = open_cells | (_closed(open_cells) & ~wall_cells)
    labels, boxes = connected_cells(bridged)
    holes: list[Hole] = []
    for number, ((low, left), (high, right)) in enumerate(boxes.tolist(), start=1):
        if (high - low) * cell < min_height or (right - left) * cell < min_width:
            continue
        box = slice(low, high), slice(left, right)
        part, wall = (labels[box] == number) & open_cells[box], wall_cells[box]
        if np.count_nonzero(part) * cell**2 < SMALLEST_SIDE**2 / 2:
            continue
        for first, last in _runs(part, wall, cell=cell):
            for bottom, top in _runs(part[:, first:last].T, wall[:, first:last].T, cell=cell)[:1]:
                hole = Hole(*(round(k * cell, 9) for k in (left + first, left + last, low + bottom, low + top)))
                if hole.width >= min_width and hole.height >= min_height:
                    holes.append(hole)
    return sorted(holes, key=lambda hole: (hole.start, hole.bottom))


def _runs(part: Bools, wall: Bools, *, cell: float) -> list[tuple[int, int]]:
    """Stretches of columns that are open over most of their typical length, longest first: the first column, and one more than the last."""
    from indoor_bim.plan.opening_loops import open_runs

    runs = np.zeros((part.shape[1], 2), dtype=np.int64)
    found = [(begin, end) for begin, end in runs[: open_runs(part, wall, cell, FULL_LINE, NARROW_BAR, THIN_BAR, runs)].tolist()]
    return sorted(found, key=lambda run: (run[0] - run[1], run[0]))


def _closed(cells: Bools) -> Bools:
    """Cells after those next to set ones, 3 x 3, are set, and those next to ones that are not set are not."""
    wide = np.zeros((cells.shape[0] + 4, cells.shape[1] + 4), dtype=bool)
    wide[2:-2, 2:-2] = cells
    rows = wide[:-2] | wide[1:-1] | wide[2:]
    grown = rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]
    rows = grown[:-2] & grown[1:-1] & grown[2:]
    closed: Bools = rows[:, :-2] & rows[:, 1:-1] & rows[:, 2:]
    return closed


def around(counts: NDArray) -> NDArray:
    """Sums over the 3 x 3 cells around each cell.

    Parameters
    ----------
    counts : (rows, columns) array
        Values of the cells.
    """
    wide = np.zeros((counts.shape[0] + 2, counts.shape[1] + 2), dtype=counts.dtype)
    wide[1:-1, 1:-1] = counts
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    total: NDArray = rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]
    return total
