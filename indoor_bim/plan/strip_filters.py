"""The sums of `strips` over many points: the same to the bit, side by side in threads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan import strip_loops as loops
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.strips import APART, BLUR, CLEARANCE, LEAST_EVIDENCE, REACH, Strips, layer_bits, lower_corner
from indoor_bim.threads import in_threads

Floats = NDArray[np.float64]


def masks_of_many(points: WallPoints, cosine: float, sine: float, strips: Strips) -> tuple[Floats, NDArray[np.uint32]]:
    """As `strips.strip_masks`."""
    xy, rise, depth = (np.ascontiguousarray(values) for values in (points.xy, points.rise, points.depth))
    sensor = np.zeros((0, 2)) if points.sensor is None else np.ascontiguousarray(points.sensor)
    u0, v0, u1, v1 = loops.turned_bounds(xy, cosine, sine)
    low = lower_corner(u0, v0, strips)
    shape = (2, int((u1 - low[0]) / strips.along) + 6, int((v1 - low[1]) / strips.across) + 11)
    masks = np.zeros(shape, dtype=np.uint32)
    sizes = (strips.along, strips.across, strips.even, strips.layers, strips.fine_height, CLEARANCE)
    loops.set_layers(xy, sensor, rise, depth, cosine, sine, low[0], low[1], *sizes, masks)
    return low, masks


def evidence_of_many(masks: NDArray[np.uint32], strips: Strips) -> tuple[NDArray[np.floating], tuple[NDArray[np.bool_], ...]]:
    """As `strips.wall_evidence`, and for each side the blocks in which it is strong somewhere."""
    filled, below = _filled_by_count(strips)
    first, last = strips.tall
    tall = (np.arange(33, dtype=np.float32) / (last - first)) >= 0.6
    width = round(7 * strips.along / strips.across)
    out: NDArray[np.floating] = np.zeros(masks.shape, dtype=np.float32)

    def side(k: int) -> NDArray[np.bool_]:
        strong: NDArray[np.bool_]
        hit, some, strong = np.zeros((3, masks.shape[1], -(-masks.shape[2] // loops.BLOCK)), dtype=bool)
        best, thinly, kept = np.zeros((3, *masks.shape[1:]), dtype=np.float32)
        loops.hit_blocks(masks[k], REACH, layer_bits(strips.band), hit)
        bits = (layer_bits(strips.band), below, layer_bits(strips.tall))
        loops.fill(masks[k], _blocks(hit, rows=1), REACH, *bits, tall, filled, best, thinly, some)
        blocks = _blocks(some)
        loops.leave_out(best, thinly, blocks, width, 7, 15, kept, out[k])
        loops.join(kept, out[k], blocks, width)
        loops.smooth(kept, _blocks(some, rows=2), LEAST_EVIDENCE, out[k], strong)
        return strong

    return out, tuple(in_threads(side, range(len(masks)), threads=2))


def crests_of_many(
    masks: NDArray[np.uint32], strips: Strips, evidence: NDArray[np.floating], strong: tuple[NDArray[np.bool_], ...]
) -> NDArray[np.int64]:
    """Places in the flat image that are crests as in `strips.crests` and hold strong evidence, ascending."""
    sigma = BLUR / strips.across
    reach = int(3 * sigma + 0.5)
    kernel: Any = np.exp(-0.5 / (sigma * sigma) * np.arange(-reach, reach + 1) ** 2)
    kernel = (kernel / kernel.sum())[reach:]
    counts = np.arange(33)
    weight = 0.1 * counts.astype(np.float32)[:, None] + counts.astype(np.uint8)
    apart = round(APART / strips.across)

    def side(k: int) -> NDArray[np.int64]:
        blocks = _blocks(strong[k])
        places = np.zeros(len(blocks) * loops.BLOCK, dtype=np.int64)
        count = loops.crest_places(masks[k], blocks, layer_bits(strips.band), weight, kernel, 5, apart, evidence[k], LEAST_EVIDENCE, places)
        found: NDArray[np.int64] = k * evidence[k].size + np.sort(places[:count])
        return found

    return np.concatenate(in_threads(side, range(len(masks)), threads=2))


def _blocks(hit: NDArray[np.bool_], *, rows: int = 0) -> NDArray[np.int64]:
    """Row and number of the blocks that were hit, and of those so many rows away."""
    near = hit.copy()
    for k in range(1, rows + 1):
        near[k:] |= hit[:-k]
        near[:-k] |= hit[k:]
    return np.ascontiguousarray(np.argwhere(near))


def _filled_by_count(strips: Strips) -> tuple[NDArray[np.floating], np.uint32]:
    """Share that is filled, by the numbers of layers hit in the band and below it (33, 33), and the bits of the latter."""
    counts = np.arange(33, dtype=np.float32)
    share = counts / (strips.band[1] - strips.band[0])
    if strips.below is None:
        return np.repeat(share[:, None], 33, axis=1), np.uint32(0)
    first, last = strips.below
    return share[:, None] * (0.5 + counts / (2 * (last - first)))[None], layer_bits(strips.below)
