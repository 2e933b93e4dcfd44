"""Strips of many points, beside their twins in numpy and scipy: the same to the bit."""

import numpy as np
import pytest

from indoor_bim.plan import block_image
from indoor_bim.plan.block_image import BLOCK, BlockImage
from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.sparse_image import SparseImage
from indoor_bim.plan.strip_filters import crests_of_many, evidence_of_many, masks_of_many
from indoor_bim.plan.strip_loops import largest_near
from indoor_bim.plan.strips import (
    BELOW_CEILING,
    FAR,
    FEW_POINTS,
    THIN,
    WHOLE_COLUMN,
    crests,
    evidence_along,
    strip_masks,
    sweep,
    wall_evidence,
)


def wall_points(*, sided, count=40_000, seed=0):
    """A room of 4 m by 3 m, points on its walls up to the ceiling, on furniture and nowhere in particular."""
    rng = np.random.default_rng(seed)
    t, side, noise = rng.random(count), rng.integers(0, 4, count), rng.normal(0, 0.008, count)
    x = np.choose(side, [4 * t, 4 + noise, 4 * t, noise])
    y = np.choose(side, [noise, 3 * t, 3 + noise, 3 * t])
    height = rng.random(count) * 2.44
    stray = rng.random(count) < 0.1
    x[stray], y[stray] = rng.uniform(-0.3, 4.3, stray.sum()), rng.uniform(-0.3, 3.3, stray.sum())
    xy = np.round(np.column_stack([x, y]), 2 if seed else 9)
    return WallPoints(xy, height / 2.5, 2.5 - height, np.tile([2.0, 1.5], (count, 1)) if sided else None)


@pytest.mark.parametrize("strips", [BELOW_CEILING, WHOLE_COLUMN, THIN, FAR])
@pytest.mark.parametrize(("angle", "sided", "seed"), [(0.0, True, 0), (np.pi / 2, False, 1), (0.3, True, 2)])
def test_many_points_give_what_their_twins_give(strips, angle, sided, seed):
    points = wall_points(sided=sided, seed=seed)
    assert len(points) > FEW_POINTS
    low, masks = strip_masks(points, np.cos(angle), np.sin(angle), strips)
    many_low, many_masks = masks_of_many(points, np.cos(angle), np.sin(angle), strips)
    assert np.array_equal(many_low, low)
    assert np.array_equal(many_masks.whole(), masks)
    evidence, crest = wall_evidence(masks, strips), crests(masks, strips)
    many_evidence = evidence_of_many(many_masks, strips)
    assert np.array_equal(many_evidence.whole(), evidence)
    crest &= evidence >= 0.35
    assert np.array_equal(crests_of_many(many_masks, strips, many_evidence), np.flatnonzero(crest))
    swept = sweep(points, angle, strips=strips)
    assert np.array_equal(swept.masks.whole(), masks)
    assert np.array_equal(swept.crest, np.argwhere(crest))
    shown = swept.evidence.whole()
    assert ((shown == 0) | (shown == evidence)).all()
    assert (shown[crest] > 0).all()
    assert not shown[:, :, 1:-1][~(crest[:, :, 1:-1] | crest[:, :, 2:] | crest[:, :, :-2])].any()
    u, v = np.indices(shown.shape[1:])
    assert np.array_equal(swept.evidence.at(1, u, v), shown[1])
    assert swept.bare().evidence is swept.evidence
    if angle == 0.0:
        assert (shown > 0.35).sum() > 20


@pytest.mark.parametrize("sided", [True, False])
@pytest.mark.parametrize("room", [3, 4, 100])
def test_there_is_room_for_all_blocks(sided, room, monkeypatch):
    points = wall_points(sided=sided)
    whole = masks_of_many(points, 1.0, 0.0, BELOW_CEILING)[1]
    assert len(whole.values) > 200
    monkeypatch.setattr(block_image, "FIRST_SLOTS", room)
    assert np.array_equal(masks_of_many(points, 1.0, 0.0, BELOW_CEILING)[1].whole(), whole.whole())


@pytest.mark.parametrize("strips", [BELOW_CEILING, FAR])
@pytest.mark.parametrize("shape", [(2, 9, 70), (2, 4, 200), (2, 40, 64)])
@pytest.mark.parametrize("share", [0.02, 0.6])
def test_strips_hit_up_to_the_border_give_what_their_twins_give(strips, shape, share):
    rng = np.random.default_rng(shape[1])
    masks = np.where(rng.random(shape) < share, rng.integers(0, 2**strips.layers, shape), 0).astype(np.uint32)
    masks[:, :, 20:24] |= np.uint32(2**strips.layers - 1)
    masks[0, :, :2] |= np.uint32(2**strips.layers - 1)
    masks[1, :, BLOCK - 1 : BLOCK] |= np.uint32(2**strips.layers - 1)
    evidence = wall_evidence(masks, strips)
    many_masks = BlockImage.of(masks)
    many_evidence = evidence_of_many(many_masks, strips)
    assert np.array_equal(many_evidence.whole(), evidence)
    assert (evidence >= 0.35).any()
    places = np.flatnonzero(crests(masks, strips) & (evidence >= 0.35))
    assert np.array_equal(crests_of_many(many_masks, strips, many_evidence), places)


@pytest.mark.parametrize(("angle", "offset"), [(0.0, 0.004), (np.pi, -3.0), (0.004 + np.pi, -2.995), (0.01, -9.0)])
def test_evidence_along_a_line_is_the_largest_near_it(angle, offset):
    swept = sweep(wall_points(sided=True), 0.0)
    found = evidence_along(swept, angle, offset, -3.0, 5.0)
    t = -3.0 + 0.1 * (np.arange(80) + 0.5)
    direction, normal = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    uv = np.floor((t[:, None] * direction + offset * normal - swept.low) / [0.1, 0.01]).astype(int)
    image = swept.evidence.whole()[int(np.cos(angle) < 0)]
    inside = (uv >= [0, 3]).all(axis=1) & (uv < np.array(image.shape) - [0, 3]).all(axis=1)
    expected = [image[u, v - 3 : v + 4].max() if ok else 0 for (u, v), ok in zip(uv, inside, strict=True)]
    assert found.tolist() == expected
    assert (found > 0.5).sum() > 20 or abs(offset) > 5


def test_values_near_a_line_reach_three_strips_to_either_side():
    image = np.zeros((2, 3, 12), dtype=np.float32)
    image[1, 1, 5] = 0.7
    sparse = SparseImage.of(image)
    found = np.zeros(12)
    largest_near(sparse.places, sparse.values, 1, 3, 12, np.full(12, 1.5), np.arange(12) + 0.5, found)
    assert np.flatnonzero(found).tolist() == [3, 4, 5, 6, 7, 8]


@pytest.mark.parametrize("shape", [(3, BLOCK), (2, 5, 1), (2, 4, 3 * BLOCK + 7), (2, 0, 0)])
def test_an_image_in_blocks_is_the_whole_one(shape):
    rng = np.random.default_rng(4)
    image = np.where(rng.random(shape) < 0.02, rng.integers(1, 99, shape), 0).astype(np.uint32)
    blocks = BlockImage.of(image)
    assert np.array_equal(blocks.whole(), image)
    assert np.array_equal(blocks.at(np.arange(image.size)), image.ravel())
    assert np.array_equal(blocks.side(1).whole(), image[1])
    assert np.array_equal(blocks.nonzero(), np.nonzero(image))
    assert not blocks.values[0].any()
    assert blocks.values[1:].any(axis=1).all()
