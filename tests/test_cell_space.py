"""What floor and ceiling say about cells, beside a twin in numpy."""

from __future__ import annotations

import numpy as np

from indoor_bim.plan.cells import cell_image, cut_into_cells
from indoor_bim.plan.free_space import FreeSpace, cell_space


def space(seed=0, shape=(140, 180)):
    """Floor and ceiling with holes, here and there without points near by."""
    rng = np.random.default_rng(seed)
    patches = [np.kron(rng.random((7, 9)), np.ones((20, 20)))[: shape[0], : shape[1]].astype(np.float32) for _ in range(2)]
    densities = [np.where(patch > 0.3, patch * 0.5, 0).astype(np.float32) for patch in patches]
    hits = [rng.random(shape) < density for density in densities]
    return FreeSpace(*hits, *densities, np.array([-0.2, -0.1]), 0.025)


def twin(cells, free):
    """Evidence, spanned and hit in numpy."""
    image = cell_image(cells.polygons, free.hit)
    within, count = image >= 0, len(cells.polygons)

    def total(values):
        return np.bincount(image[within], weights=values[within], minlength=count)

    ceiling, floor = free.ceiling_density, free.floor_density
    sure, floor_sure = ceiling / (ceiling + 0.02), floor / (floor + 0.02)
    share = np.clip(total(free.ceiling) / np.maximum(total(ceiling), 1e-9), 0, 1)
    expected = np.maximum(floor, 0.5 * np.median(floor[(sure > 0.5) & (floor > 0)]) * (floor > 0))
    floor_share = np.clip(total(free.floor * (1 - sure)) / np.maximum(total(expected * (1 - sure)), 1e-9), 0, 1)
    area = np.array([polygon.area for polygon in cells.polygons])
    for_room = np.clip(share / 0.3 - 1, -1, 1)
    firm = np.where(for_room < 0, total(sure * (1 - floor_sure)), total(sure))
    evidence = firm * for_room + total((1 - sure) * floor_sure) * np.clip(floor_share / 0.4 - 1, -0.3, 1)
    hit = total(free.hit.image) / np.maximum(np.bincount(image[within], minlength=count), 1)
    return evidence * 0.025**2 - 0.1 * area, (share > 0.3) & (total(sure) * 0.025**2 > 0.3 * area), hit


def test_sums_over_cells_are_those_of_the_twin():
    p = np.array([[0, 0], [0, 1.1], [0, 2], [0, 3], [0, 0], [1.3, 0], [2.2, 0], [4, 0], [0, 0]], dtype=float)
    q = np.array([[4, 0], [4, 1.3], [4, 2], [4, 3], [0, 3], [1.5, 3], [2.2, 3], [4, 3], [4, 3]], dtype=float)
    cells, free = cut_into_cells(p, q), space()
    assert len(cells.polygons) > 12
    found = cell_space(cells, free)
    inside, spanned, hit = twin(cells, free)
    np.testing.assert_allclose(found.inside, inside, rtol=0, atol=1e-6)
    assert np.array_equal(found.spanned, spanned)
    np.testing.assert_allclose(found.hit, hit, rtol=0, atol=1e-6)
    assert 0 < spanned.mean() < 1
