"""Gaps of a contour at the heights of its slices: candidates for doors and windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.layer_image import LayerImage, Layers, hits_along
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.slice_heights import Slice

Floats = NDArray[np.float64]

WALL_SHARE = 0.3  # of the steps in a layer of a gap: where more are hit, the wall goes on
THRESHOLD = 0.25  # metres: what begins lower reaches the floor
CEILING_GAP = 0.10  # metres: what ends closer to the ceiling reaches it
JAMB = 0.20  # metres beside a gap that are looked at
BEFORE = (0.15, 0.30, 0.45, 0.60, 0.75)  # metres before a face: where the things stand that hide it
HIDDEN_SHARE = 0.5  # of the steps of a gap with something before them


@dataclass(frozen=True, slots=True)
class ContourGap:
    """Gap in a face.

    Parameters
    ----------
    p, q : (float, float)
        Its ends in plan, metres.
    bottom, top : float
        Height of its lower and upper edge above the floor, metres.
    edges : float
        Share of its four edges beside which the face was seen; floor and ceiling count as edges.
    hidden : bool
        True where something stands before it: then nothing tells whether the wall goes on.
    """

    p: tuple[float, float]
    q: tuple[float, float]
    bottom: float
    top: float
    edges: float
    hidden: bool


def contour_gaps(
    faces: Segments, image: LayerImage, slices: Sequence[Slice], *, height: float, reach: float, narrowest: float = 0.5
) -> tuple[ContourGap, ...]:
    """Gaps of faces at the height of any of the slices.

    Parameters
    ----------
    faces : Segments
        Faces of the contour, metres; those across its gaps as well. Free space to the left where `sided`.
    image : LayerImage
        Layers hit in plan.
    slices : sequence of Slice
        Slices.
    height : float
        From floor to ceiling, metres.
    reach : float
        Points within this distance of a face lie on it, metres.
    narrowest : float
        Narrower gaps are none, metres.

    Returns
    -------
    tuple of ContourGap
        Sorted by position.
    """
    if not len(faces):
        return ()
    hits = hits_along(image, faces.p, faces.q, reach=reach)
    before = [hits_along(image, faces.p, faces.q, reach=image.bits.cell, shift=shift) for shift in BEFORE]
    gaps = []
    for k, hit in enumerate(hits):
        step = float(faces.length[k]) / len(hit)
        front = np.asarray(np.stack([rows[k] for rows in before]).any(axis=0))
        for first, last in _runs(hit, image, slices, least=narrowest / step):
            rows = _empty_layers(hit[first:last], image, slices)
            if rows is None:
                continue
            beside = hit[max(first - round(JAMB / step), 0) : first], hit[last : last + max(round(JAMB / step), 1)]
            edges = [bool(side.size and side[:, rows].any()) for side in beside]
            bottom, top = rows.start * image.layer, min(rows.stop * image.layer, height)
            bottom = 0.0 if bottom < THRESHOLD else bottom
            to_ceiling = height - top < CEILING_GAP
            edges += [bottom > 0 or rows.start * image.layer < THRESHOLD, not to_ceiling]
            hidden = bool(front[first:last, rows].any(axis=1).mean() > HIDDEN_SHARE)
            d = faces.direction[k]
            ends = [tuple(float(round(x, 6)) for x in faces.p[k] + at * step * d) for at in (first, last)]
            gaps.append(ContourGap(ends[0], ends[1], bottom, height if to_ceiling else top, float(np.mean(edges)), hidden))  # type: ignore[arg-type]
    return tuple(sorted(gaps, key=lambda gap: (gap.p, gap.q)))


def _runs(hit: Layers, image: LayerImage, slices: Sequence[Slice], *, least: float) -> list[tuple[int, int]]:
    """Ranges of steps that are empty at the height of a slice, joined where they overlap."""
    empty = np.zeros(len(hit), dtype=bool)
    for part in slices:
        at_slice = np.logical_not(hit[:, image.rows(part.low, part.high)].any(axis=1))
        for first, last in _ranges(at_slice):
            if last - first >= least:
                empty[first:last] = True
    return _ranges(empty)


def _ranges(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _empty_layers(hit: Layers, image: LayerImage, slices: Sequence[Slice]) -> slice | None:
    """Layers without wall around the height of a slice, the most of them."""
    inset = min(1, (len(hit) - 1) // 2)
    wall = hit[inset : len(hit) - inset].mean(axis=0) > WALL_SHARE
    best: slice | None = None
    for part in slices:
        rows = image.rows(part.low, part.high)
        middle = (rows.start + rows.stop - 1) // 2
        if wall[middle]:
            continue
        below, above = np.flatnonzero(wall[:middle]), np.flatnonzero(wall[middle:])
        found = slice(int(below[-1]) + 1 if len(below) else 0, middle + int(above[0]) if len(above) else image.count)
        if best is None or found.stop - found.start > best.stop - best.start:
            best = found
    return best
