"""Wall points in thin strips of the plan: how much of the column up to the ceiling is filled, seen from which side."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.block_image import BlockImage
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.sparse_image import SparseImage

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CLEARANCE = 0.06
"""Nearest that wall points come to the surface overhead, metres."""
REACH = 2
"""Strips across that are taken together."""
BLUR = 0.015
"""Standard deviation of the smoothing across, metres."""
APART = 0.04
"""Least distance between the faces of one side, metres."""
FEW_POINTS = 20_000
FEW_STRIPS = 200_000
"""So many points in so many strips are taken by numpy and scipy, sooner than the compiled loops are loaded."""
LEAST_EVIDENCE = 0.35
"""Share of the column below the ceiling that a wall fills at least."""


@dataclass(frozen=True, slots=True)
class Strips:
    """Size of the strips and of the height layers in them.

    Parameters
    ----------
    along, across : float
        Sides of a strip, metres.
    even : int
        Number of even layers between the floor and the fine layers.
    fine : int
        Number of fine layers right below the surface overhead.
    fine_height : float
        Height of a fine layer, metres.
    band : (int, int)
        Layers that tell walls from furniture: first, and one past the last.
    below : (int, int), optional
        Layers right below these, which have to be filled as well.
    tall : (int, int)
        Layers that high furniture does not fill.
    """

    along: float = 0.10
    across: float = 0.01
    even: int = 20
    fine: int = 4
    fine_height: float = 0.05
    band: tuple[int, int] = (20, 24)
    below: tuple[int, int] | None = (17, 20)
    tall: tuple[int, int] = (8, 20)

    @property
    def layers(self) -> int:
        """Number of layers."""
        return self.even + self.fine


BELOW_CEILING = Strips()
"""Walls stand alone right below the ceiling."""
WHOLE_COLUMN = Strips(band=(2, 20), below=None)
"""For storeys whose ceiling was not seen."""
THIN = Strips(along=0.20, across=0.01, even=10, fine=2, fine_height=0.10, band=(10, 12), below=(5, 9), tall=(4, 9))
"""For surfaces that hold some hundred points per square metre."""
FAR = Strips(along=0.40, across=0.02, even=5, fine=1, fine_height=0.30, band=(5, 6), below=(1, 4), tall=(1, 4))
"""For surfaces that hold some ten points per square metre."""


def height_layers(points: WallPoints, strips: Strips = BELOW_CEILING) -> Ints:
    """Height layer of each point: fine ones right below the overhead surface, even ones from the floor up to these."""
    below_top = strips.layers - 1 - np.floor((points.depth - CLEARANCE) / strips.fine_height).astype(np.int64)
    from_floor = np.clip((points.rise * strips.even).astype(np.int64), 0, strips.even - 1)
    return np.where(below_top >= strips.even, np.minimum(below_top, strips.layers - 1), from_floor)


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Wall points sorted into thin strips along one direction, for both sides they can be seen from."""

    angle: float
    low: Floats
    strips: Strips
    masks: BlockImage
    crest: Ints
    evidence: SparseImage

    def bare(self) -> Sweep:
        """The sweep with its evidence alone, which takes little memory."""
        return replace(self, masks=BlockImage.of(np.zeros((2, 0, 0), dtype=np.uint32)), crest=np.zeros((0, 3), dtype=np.int64))


def sweep(points: WallPoints, angle: float, *, strips: Strips = BELOW_CEILING) -> Sweep:
    """Heights hit in every strip of the plan.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    angle : float
        Direction of the strips, radians.
    strips : Strips
        Their size.

    Returns
    -------
    Sweep
        Bit k of ``masks[side, u, v]`` is set where height layer k was hit from that side (0: from the left of the direction); ``crest``
        (n, 3) holds side, u and v of the strips on crests, ascending.
    """
    cosine, sine = float(np.cos(angle)), float(np.sin(angle))
    if len(points) <= FEW_POINTS and int(np.prod(strip_grid(points, cosine, sine, strips)[1])) <= FEW_STRIPS:
        low, whole = strip_masks(points, cosine, sine, strips)
        filled = wall_evidence(whole, strips)
        places = np.flatnonzero(crests(whole, strips) & (filled >= LEAST_EVIDENCE))
        masks, evidence = BlockImage.of(whole), BlockImage.of(filled)
    else:
        from indoor_bim.plan.strip_filters import crests_of_many, evidence_of_many, masks_of_many

        low, masks = masks_of_many(points, cosine, sine, strips)
        evidence = evidence_of_many(masks, strips)
        places = crests_of_many(masks, strips, evidence)
    crest = np.column_stack(np.unravel_index(places, masks.shape))
    shown = _and_beside(places, masks.shape[2])
    return Sweep(angle, low, strips, masks, crest, SparseImage.at_places(masks.shape, shown, evidence.at(shown)))


def lower_corner(u: float, v: float, strips: Strips) -> Floats:
    """Lower corner of the strips whose points begin at (u, v), with a margin, metres."""
    return np.array(
        [np.floor(u / strips.along) * strips.along - 5 * strips.along, np.floor(v / strips.across) * strips.across - 10 * strips.across]
    )


def strip_grid(points: WallPoints, cosine: float, sine: float, strips: Strips) -> tuple[Floats, tuple[int, int, int]]:
    """Lower corner (2,) of the strips along a direction, metres, and their numbers: two sides, along and across."""
    x, y = points.xy.T
    u, v = x * cosine + y * sine, x * -sine + y * cosine
    low = lower_corner(u.min(), v.min(), strips)
    return low, (2, int((u.max() - low[0]) / strips.along) + 6, int((v.max() - low[1]) / strips.across) + 11)


def strip_masks(points: WallPoints, cosine: float, sine: float, strips: Strips) -> tuple[Floats, NDArray[np.uint32]]:
    """Lower corner (2,) and hit layers (2, u, v) of the strips along a direction."""
    low, shape = strip_grid(points, cosine, sine, strips)
    x, y = points.xy.T
    iu = ((x * cosine + y * sine - low[0]) / strips.along).astype(np.int64)
    iv = ((x * -sine + y * cosine - low[1]) / strips.across).astype(np.int64)
    bit = np.uint32(1) << height_layers(points, strips).astype(np.uint32)
    masks = np.zeros(shape, dtype=np.uint32)
    from_left = from_right = np.ones(len(x), dtype=bool)
    if points.sensor is not None:
        from_left = (points.sensor[:, 0] - x) * -sine + (points.sensor[:, 1] - y) * cosine > 0
        from_right = ~from_left
    for side, rows in enumerate((from_left, from_right)):
        np.bitwise_or.at(masks[side], (iu[rows], iv[rows]), bit[rows])
    return low, masks


def wall_evidence(masks: NDArray[np.uint32], strips: Strips, *, reach: int = REACH) -> NDArray[np.floating]:
    """Share of the band of height layers that is hit, per strip; what only crosses the direction is left out."""
    from scipy import ndimage

    joined = masks.copy()
    for k in range(1, reach + 1):
        joined[:, :, k:] |= masks[:, :, :-k]
        joined[:, :, :-k] |= masks[:, :, k:]
    best = filled_share(joined, strips)
    along = ndimage.uniform_filter1d(best, 7, axis=1)
    across = ndimage.uniform_filter1d(best, round(7 * strips.along / strips.across), axis=2)
    near = joined.copy()
    near[:, 1:] |= joined[:, :-1]
    near[:, :-1] |= joined[:, 1:]
    tall = np.bitwise_count(near & layer_bits(strips.tall)).astype(np.float32) / (strips.tall[1] - strips.tall[0])
    thinly = np.where(tall >= 0.6, filled_share(near, strips), 0)
    thinly[ndimage.uniform_filter1d(thinly, 15, axis=1) < 0.5] = 0
    best[across > np.maximum(along, 0.3)] = 0
    thinly[ndimage.uniform_filter1d(thinly, round(7 * strips.along / strips.across), axis=2) > 0.5] = 0
    best = np.maximum(best, thinly)
    smooth: NDArray[np.floating] = ndimage.median_filter(best, size=(1, 5, 1))
    return smooth


def crests(masks: NDArray[np.uint32], strips: Strips, *, apart: float = APART) -> NDArray[np.bool_]:
    """Strips where more of the column is hit than in any other within `apart` metres across."""
    from scipy import ndimage

    layers = 0.1 * np.bitwise_count(masks).astype(np.float32) + np.bitwise_count(masks & layer_bits(strips.band))
    density = ndimage.uniform_filter1d(ndimage.gaussian_filter1d(layers, BLUR / strips.across, axis=2, truncate=3), 5, axis=1)
    crest: NDArray[np.bool_] = density >= ndimage.maximum_filter1d(density, 2 * round(apart / strips.across) + 1, axis=2)
    return crest


def filled_share(masks: NDArray[np.uint32], strips: Strips) -> Floats:
    """Share of a band of height layers that is hit; the layers below it count as well."""
    share = np.bitwise_count(masks & layer_bits(strips.band)).astype(np.float32) / (strips.band[1] - strips.band[0])
    if strips.below is not None:
        first, last = strips.below
        share *= 0.5 + np.bitwise_count(masks & layer_bits(strips.below)).astype(np.float32) / (2 * (last - first))
    filled: Floats = share
    return filled


def layer_bits(band: tuple[int, int]) -> np.uint32:
    """Bits of the layers from the first up to the last, which is left out."""
    return np.uint32((1 << band[1]) - (1 << band[0]))


def _and_beside(places: Ints, columns: int) -> Ints:
    """Places of a flat image and of the neighbours across, ascending."""
    column = places % columns
    return np.unique(np.concatenate([places, places[column > 0] - 1, places[column < columns - 1] + 1]))


def evidence_along(swept: Sweep, angle: float, offset: float, start: float, end: float, *, step: float = BELOW_CEILING.along) -> Floats:
    """Wall evidence every `step` metres along a line seen from its left.

    Parameters
    ----------
    swept : Sweep
        Sweep in about the direction of the line, or against it.
    angle, offset : float
        Line as in `FaceLines`.
    start, end : float
        Extent, metres.
    step : float
        Distance between values, metres.
    """
    from indoor_bim.plan.strip_loops import largest_near

    along, across = np.array([np.cos(swept.angle), np.sin(swept.angle)]), np.array([-np.sin(swept.angle), np.cos(swept.angle)])
    count = max(round((end - start) / step), 1)
    t = start + (np.arange(count) + 0.5) * (end - start) / count
    xy = t[:, None] * np.array([np.cos(angle), np.sin(angle)]) + offset * np.array([-np.sin(angle), np.cos(angle)])
    u, v = (xy @ along - swept.low[0]) / swept.strips.along, (xy @ across - swept.low[1]) / swept.strips.across
    side = 0 if np.cos(angle - swept.angle) > 0 else 1
    out = np.zeros(count)
    largest_near(swept.evidence.places, swept.evidence.values, side, *swept.evidence.shape[1:], u, v, out)
    return out
