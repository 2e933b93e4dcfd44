"""The sums of `strips` over many points: the same to the bit, side by side in threads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan import strip_loops as loops
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.strips import APART, BLUR, CLEARANCE, REACH, Strips, layer_bits, lower_corner
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


def evidence_of_many(masks: NDArray[np.uint32], strips: Strips) -> NDArray[np.floating]:
    """As `strips.wall_evidence`."""
    filled, below = _filled_by_count(strips)
    first, last = strips.tall
    tall = (np.arange(33, dtype=np.float32) / (last - first)) >= 0.6
    out: NDArray[np.floating] = np.zeros(masks.shape, dtype=np.float32)

    def side(k: int) -> None:
        best, thinly, first_mean, second_mean = np.zeros((4, *masks.shape[1:]), dtype=np.float32)
        width = round(7 * strips.along / strips.across)
        loops.fill(masks[k], REACH, layer_bits(strips.band), below, layer_bits(strips.tall), tall, filled, best, thinly)
        loops.mean_along(best, 7, first_mean)
        loops.mean_across(best, width, second_mean)
        loops.mean_along(thinly, 15, out[k])
        loops.leave_out(best, first_mean, second_mean, thinly, out[k])
        loops.mean_across(thinly, width, first_mean)
        loops.join_and_smooth(best, thinly, first_mean, out[k])

    in_threads(side, range(len(masks)), threads=2)
    return out


def crests_of_many(masks: NDArray[np.uint32], strips: Strips) -> NDArray[np.bool_]:
    """As `strips.crests`."""
    sigma = BLUR / strips.across
    reach = int(3 * sigma + 0.5)
    kernel: Any = np.exp(-0.5 / (sigma * sigma) * np.arange(-reach, reach + 1) ** 2)
    kernel = (kernel / kernel.sum())[reach:]
    counts = np.arange(33)
    weight = 0.1 * counts.astype(np.float32)[:, None] + counts.astype(np.uint8)
    out = np.zeros(masks.shape, dtype=bool)

    def side(k: int) -> None:
        layers, density = np.zeros((2, *masks.shape[1:]), dtype=np.float32)
        loops.weigh_layers(masks[k], layer_bits(strips.band), weight, kernel, layers)
        loops.mean_along(layers, 5, density)
        loops.largest_across(density, round(APART / strips.across), out[k])

    in_threads(side, range(len(masks)), threads=2)
    return out


def _filled_by_count(strips: Strips) -> tuple[NDArray[np.floating], np.uint32]:
    """Share that is filled, by the numbers of layers hit in the band and below it (33, 33), and the bits of the latter."""
    counts = np.arange(33, dtype=np.float32)
    share = counts / (strips.band[1] - strips.band[0])
    if strips.below is None:
        return np.repeat(share[:, None], 33, axis=1), np.uint32(0)
    first, last = strips.below
    return share[:, None] * (0.5 + counts / (2 * (last - first)))[None], layer_bits(strips.below)
