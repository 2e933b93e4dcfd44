"""The sums of `strips` over many points: the same to the bit, side by side in threads, and in blocks that are not empty alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan import strip_loops as loops
from indoor_bim.plan.block_image import BLOCK, BlockImage, bits_of_points, slots_of
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.strips import APART, BLUR, CLEARANCE, LEAST_EVIDENCE, REACH, Strips, layer_bits, lower_corner
from indoor_bim.threads import in_threads

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def masks_of_many(points: WallPoints, cosine: float, sine: float, strips: Strips) -> tuple[Floats, BlockImage]:
    """As `strips.strip_masks`."""
    xy, rise, depth = (np.ascontiguousarray(values) for values in (points.xy, points.rise, points.depth))
    sensor = np.zeros((0, 2)) if points.sensor is None else np.ascontiguousarray(points.sensor)
    u0, v0, u1, v1 = loops.turned_bounds(xy, cosine, sine)
    low = lower_corner(u0, v0, strips)
    rows, columns = int((u1 - low[0]) / strips.along) + 6, int((v1 - low[1]) / strips.across) + 11
    sizes = (strips.along, strips.across, strips.even, strips.layers, strips.fine_height, CLEARANCE)
    place = (cosine, sine, low[0], low[1])

    def set_layers(*image: Any) -> None:
        loops.set_layers(xy, sensor, rise, depth, *place, *sizes, *image)

    return low, bits_of_points(set_layers, (2, rows, columns), points=len(xy))


def evidence_of_many(masks: BlockImage, strips: Strips) -> BlockImage:
    """As `strips.wall_evidence`."""
    filled, below = _filled_by_count(strips)
    first, last = strips.tall
    tall = (np.arange(33, dtype=np.float32) / (last - first)) >= 0.6
    size, columns = round(7 * strips.along / strips.across), masks.shape[2]

    def side(k: int) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        hit = np.zeros(masks.slot[k].shape, dtype=bool)
        loops.hit_blocks(masks.slot[k], masks.values, REACH, layer_bits(strips.band), hit)
        hit = _with_rows_beside(hit, 1)
        slot, blocks, some = slots_of(hit), _blocks(hit), np.zeros(np.count_nonzero(hit), dtype=bool)
        best, thinly, kept, long_enough = np.zeros((4, len(blocks) + 1, BLOCK), dtype=np.float32)
        bits = (layer_bits(strips.band), below, layer_bits(strips.tall))
        loops.fill(masks.slot[k], masks.values, columns, blocks, REACH, *bits, tall, filled, best, thinly, some)
        hit[hit] = some
        blocks = blocks[some]
        loops.leave_out(best, thinly, slot, columns, blocks, size, 7, 15, kept, long_enough)
        loops.join(kept, long_enough, slot, columns, blocks, size)
        hit = _with_rows_beside(hit, 2)
        blocks = _blocks(hit)
        smoothed = np.zeros((len(blocks) + 1, BLOCK), dtype=np.float32)
        loops.smooth(kept, slot, blocks, smoothed)
        return slots_of(hit), smoothed

    (slot, values), (other_slot, other_values) = in_threads(side, range(2), threads=2)
    other_slot[other_slot > 0] += len(values) - 1
    return BlockImage(masks.shape, np.stack([slot, other_slot]), np.concatenate([values, other_values[1:]]))


def crests_of_many(masks: BlockImage, strips: Strips, evidence: BlockImage) -> NDArray[np.int64]:
    """Places in the flat image that are crests as in `strips.crests` and hold strong evidence, ascending."""
    sigma = BLUR / strips.across
    reach = int(3 * sigma + 0.5)
    kernel: Any = np.exp(-0.5 / (sigma * sigma) * np.arange(-reach, reach + 1) ** 2)
    kernel = (kernel / kernel.sum())[reach:]
    counts = np.arange(33)
    weight = 0.1 * counts.astype(np.float32)[:, None] + counts.astype(np.uint8)
    apart = round(APART / strips.across)
    _, rows, columns = masks.shape
    strong: Bools = np.greater_equal(evidence.values, LEAST_EVIDENCE).any(axis=1)

    def side(k: int) -> NDArray[np.int64]:
        blocks = _blocks(strong[evidence.slot[k]])
        places = np.zeros(len(blocks) * BLOCK, dtype=np.int64)
        smoothing = (layer_bits(strips.band), weight, kernel, 5, apart)
        shown = (evidence.slot[k], evidence.values, LEAST_EVIDENCE)
        count = loops.crest_places(masks.slot[k], masks.values, columns, blocks, *smoothing, *shown, places)
        found: NDArray[np.int64] = k * rows * columns + np.sort(places[:count])
        return found

    return np.concatenate(in_threads(side, range(2), threads=2))


def _with_rows_beside(hit: Bools, count: int) -> Bools:
    """Blocks that are hit, and those of so many rows beside them."""
    near = hit.copy()
    for k in range(1, count + 1):
        near[k:] |= hit[:-k]
        near[:-k] |= hit[k:]
    return near


def _blocks(hit: Bools) -> NDArray[np.int64]:
    """Row and number (n, 2) of the blocks that are hit."""
    return np.ascontiguousarray(np.argwhere(hit))


def _filled_by_count(strips: Strips) -> tuple[NDArray[np.floating], np.uint32]:
    """Share that is filled, by the numbers of layers hit in the band and below it (33, 33), and the bits of the latter."""
    counts = np.arange(33, dtype=np.float32)
    share = counts / (strips.band[1] - strips.band[0])
    if strips.below is None:
        return np.repeat(share[:, None], 33, axis=1), np.uint32(0)
    first, last = strips.below
    return share[:, None] * (0.5 + counts / (2 * (last - first)))[None], layer_bits(strips.below)
