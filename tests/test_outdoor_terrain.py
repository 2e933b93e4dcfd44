"""Ground: terrain, spot heights, classes."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.outdoor.classes import classify, ground_points
from indoor_bim.outdoor.terrain import ground_mesh, ground_terrain, spot_heights
from indoor_bim.simulate.village import BUILDING, GROUND, ground_height, sample_village, scan_village


def test_a_plane_is_followed_also_under_a_gap() -> None:
    x, y = np.meshgrid(np.arange(0, 30, 0.25), np.arange(0, 20, 0.25))
    points = np.column_stack([x.ravel(), y.ravel(), 0.05 * x.ravel() - 0.02 * y.ravel()])
    outside = ~((np.abs(points[:, 0] - 15) < 4) & (np.abs(points[:, 1] - 10) < 4))
    terrain = ground_terrain(points[outside])
    asked = np.array([[5.3, 4.1], [15.0, 10.0]])
    assert terrain.at(asked) == pytest.approx([0.05 * 5.3 - 0.02 * 4.1, 0.05 * 15 - 0.02 * 10], abs=0.03)


def test_terrain_beyond_its_border_is_that_of_the_border() -> None:
    terrain = ground_terrain(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 3.0]]))
    assert terrain.at(np.array([[-50.0, 7.0], [50.0, 0.0], [0.5, 0.0]])).tolist() == [1.0, 3.0, 2.0]


def test_no_ground_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one"):
        ground_terrain(np.zeros((0, 3)))


def test_spot_heights_are_means_about_sampled_points() -> None:
    rng = np.random.default_rng(3)
    ground = np.column_stack([rng.uniform(0, 40, (4000, 2)), rng.normal(0, 0.05, 4000)])
    spots = spot_heights(ground, spacing=10.0, radius=1.0)
    assert len(spots) == 16
    for x, y, z in spots:
        samples = ground[np.hypot(*(ground[:, :2] - [x, y]).T) < 1.5]
        assert any(
            np.allclose(ground[np.hypot(*(ground[:, :2] - sample[:2]).T) <= 1.0].mean(axis=0), [x, y, z], atol=1e-12) for sample in samples
        )


def test_spot_heights_do_not_depend_on_the_order_of_points() -> None:
    rng = np.random.default_rng(4)
    ground = rng.uniform(0, 30, (2000, 3))
    assert np.array_equal(spot_heights(ground, spacing=7, radius=2), spot_heights(ground[rng.permutation(2000)], spacing=7, radius=2))


def test_ground_mesh_covers_the_terrain_and_faces_up() -> None:
    x, y = np.meshgrid(np.arange(6.0), np.arange(4.0))
    mesh = ground_mesh(ground_terrain(np.column_stack([x.ravel(), y.ravel(), x.ravel()])))
    corners = np.array(mesh.vertices)[np.array(mesh.triangles)]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (up > 0).all()
    assert up.sum() / 2 == pytest.approx(15.0)


def test_a_fine_terrain_is_thinned() -> None:
    x, y = np.meshgrid(np.arange(60.0), np.arange(60.0))
    terrain = ground_terrain(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]))
    assert len(ground_mesh(terrain, most=400).vertices) <= 441


def test_class_codes_are_used() -> None:
    points = np.zeros((100, 3))
    codes = np.array([GROUND] * 50 + [BUILDING] * 30 + [5] * 20, dtype=np.uint8)
    classes = classify(points, codes)
    assert classes.from_file
    assert classes.ground.sum() == 50
    assert classes.building.sum() == 30


def test_ground_without_class_codes() -> None:
    cloud = scan_village(sample_village()[:2])
    assert cloud.classification is not None
    ground = ground_points(cloud.points)
    true = cloud.classification == GROUND
    assert (ground & true).sum() > 0.99 * true.sum()
    high = cloud.points[:, 2] - ground_height(cloud.points[:, :2]) > 0.3
    assert not (ground & high).any()


def test_useless_class_codes_are_not_used() -> None:
    cloud = scan_village(sample_village()[5:])
    assert not classify(cloud.points, np.ones(len(cloud), dtype=np.uint8)).from_file
