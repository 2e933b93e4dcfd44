"""Split-and-merge: points of a slice in plan to line-like sets."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.image import thicken, wall_image
from indoor_bim.plan.skeleton import thin_to_skeleton
from indoor_bim.plan.skeleton_paths import skeleton_paths

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Chains:
    """Places along walls in the order in which one comes by them.

    Parameters
    ----------
    places : (k, 2) float64
        Mean of the points around each place, metres.
    chain : (k,) int64
        Chain that each place belongs to, ascending.
    member : (n,) int64
        Place that each point was counted to.
    """

    places: Floats
    chain: Ints
    member: Ints


def chain_points(xy: Floats, *, pixel: float) -> Chains:
    """Bring points into an order along the walls that they lie on: that of the skeleton of their image.

    A moving scanner, or several standpoints, leave no order of their own that runs along walls.

    Parameters
    ----------
    xy : (n, 2) float64
        Points, metres.
    pixel : float
        Side of a pixel, metres; points up to two of them apart hang together.
    """
    from scipy.ndimage import distance_transform_edt

    image = wall_image(xy, magnification=1 / pixel, margin=3)
    pixels, walk = skeleton_paths(thin_to_skeleton(_closed(image.image)))
    number = np.full(image.image.shape, -1, dtype=np.int64)
    number[pixels[:, 0], pixels[:, 1]] = np.arange(len(pixels))
    nearest = distance_transform_edt(number < 0, return_distances=False, return_indices=True)
    at = image.pixel(xy)
    member = number[nearest[0][at[:, 0], at[:, 1]], nearest[1][at[:, 0], at[:, 1]]]
    size = np.bincount(member, minlength=len(pixels))
    # sums of whole micrometres do not depend on the order of the points
    whole = np.rint((xy - image.origin) * 1e6)
    sums = np.column_stack([np.bincount(member, weights=whole[:, k], minlength=len(pixels)) for k in (0, 1)])
    filled = size > 0
    places = np.where(filled[:, None], image.origin + sums / np.maximum(size, 1)[:, None] * 1e-6, image.centre(pixels))
    return Chains(places, walk, member)


def split_and_merge(chains: Chains, *, distance: float, gap: float) -> Ints:
    """Split chains until every piece is a line without gaps, then merge neighbours that are one line (section 1.2, step 3).

    Parameters
    ----------
    chains : Chains
        Places in order.
    distance : float
        No place of a piece lies farther from its line, metres.
    gap : float
        Neighbours in a piece are no farther apart, metres.

    Returns
    -------
    (k,) int64
        Number of the piece of each place.

    Examples
    --------
    >>> corner = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [2, 9]], dtype=float)
    >>> split_and_merge(Chains(corner, np.zeros(6, dtype=np.int64), np.arange(6)), distance=0.1, gap=2.0).tolist()
    [0, 0, 0, 1, 1, 2]
    """
    step = np.hypot(*np.diff(chains.places, axis=0).T)
    cut = (np.diff(chains.chain) != 0) | (step > gap)
    bounds = np.concatenate([[0], np.flatnonzero(cut) + 1, [len(chains.places)]])
    piece = np.zeros(len(chains.places), dtype=np.int64)
    number = 0
    for start, stop in itertools.pairwise(bounds.tolist()):
        if start == stop:
            continue
        for first, last in _merged(chains.places, _split(chains.places, start, stop, distance=distance), distance=distance):
            piece[first:last] = number
            number += 1
    return piece


def drop_small(piece: Ints, xy: Floats, *, min_length: float, min_points: int) -> Ints:
    """Number of the piece of each point, from 0; -1 for those of pieces that are too short or have too few points (section 1.2, step 4).

    Parameters
    ----------
    piece : (n,) int64
        Piece of each point; negative: none.
    xy : (n, 2) float64
        Points, metres.
    min_length : float
        Least distance between the first and the last point, metres.
    min_points : int
        Least number of points.
    """
    count = int(piece.max(initial=-1)) + 1
    inside = piece >= 0
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, piece[inside], xy[inside])
    np.maximum.at(high, piece[inside], xy[inside])
    size = np.bincount(piece[inside], minlength=count)
    keep = size >= min_points
    keep[keep] &= np.hypot(*(high[keep] - low[keep]).T) >= min_length
    number = np.where(keep, np.cumsum(keep) - 1, -1)
    out: Ints = np.where(inside, number[piece], -1) if count else piece
    return out


def _closed(image: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Image whose lines are several pixels thick and without holes of a pixel."""
    grown = thicken(image)
    background = ~grown
    return ~thicken(background) | image


def _split(places: Floats, start: int, stop: int, *, distance: float) -> list[tuple[int, int]]:
    """Ranges of places, none of which lies farther than `distance` from the chord of its range."""
    done: list[tuple[int, int]] = []
    open_ranges = [(start, stop)]
    while open_ranges:
        first, last = open_ranges.pop()
        if last - first < 3:
            done.append((first, last))
            continue
        p, chord = places[first], places[last - 1] - places[first]
        offset = places[first:last] - p
        length = float(np.hypot(*chord))
        off = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0]) / length if length > 1e-9 else np.hypot(*offset.T)
        farthest = int(np.argmax(np.round(off, 9)))
        if off[farthest] <= distance:
            done.append((first, last))
            continue
        middle = first + min(max(farthest + 1, 1), last - first - 1)
        open_ranges += [(middle, last), (first, middle)]
    return sorted(done)


def _merged(places: Floats, ranges: list[tuple[int, int]], *, distance: float) -> list[tuple[int, int]]:
    """Ranges joined with their neighbours as long as all places of a range lie within `distance` of its best line, the best first."""
    ranges = list(ranges)
    cost = [_worst(places[a[0] : b[1]]) for a, b in itertools.pairwise(ranges)]
    while cost and min(cost) <= distance:
        k = int(np.argmin(np.round(cost, 9)))
        ranges[k : k + 2] = [(ranges[k][0], ranges[k + 1][1])]
        del cost[k]
        if k > 0:
            cost[k - 1] = _worst(places[ranges[k - 1][0] : ranges[k][1]])
        if k < len(cost):
            cost[k] = _worst(places[ranges[k][0] : ranges[k + 1][1]])
    return ranges


def _worst(places: Floats) -> float:
    """Largest distance of places (k, 2) from the line that fits them best, metres."""
    offset = places - places.mean(axis=0)
    xx, xy, yy = float((offset[:, 0] ** 2).sum()), float((offset[:, 0] * offset[:, 1]).sum()), float((offset[:, 1] ** 2).sum())
    angle = np.arctan2(2 * xy, xx - yy) / 2
    return float(np.abs(offset @ np.array([-np.sin(angle), np.cos(angle)])).max())
