"""Rooms that were only looked into, beside a corridor that was walked through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from clouds import rooms_cloud
from plans import box

from indoor_bim.cloud.cloud import Cloud, LevelledCloud
from indoor_bim.cloud.pca_levelling import level_by_pca
from indoor_bim.plan.segments import Segments
from indoor_bim.slope import SlopeStages, slope_stages
from indoor_bim.slope_afar import seen_faces, walls_afar
from indoor_bim.slope_plan import slope_plan
from indoor_bim.storeys import storey_from_plan

CORRIDOR = box(0, 0, 12, 2)
OFFICE = box(3, 2.2, 8, 7)


def glimpse(room: list[tuple[float, float]], per_square_metre: float) -> np.ndarray:
    """Few points of floor, ceiling and walls of a room, as seen through its door."""
    dense = rooms_cloud(room, spacing=0.02, noise=0.004)
    return dense[np.random.default_rng(3).random(len(dense)) < per_square_metre * 0.02**2]


@pytest.fixture(scope="module")
def looked_into() -> np.ndarray:
    office = glimpse(OFFICE, 20)
    return np.vstack([rooms_cloud(CORRIDOR, noise=0.004), office[office[:, 1] > 2.8]])


def made(points: np.ndarray) -> tuple[LevelledCloud, SlopeStages]:
    levelled = level_by_pca(Cloud(points=points))
    return levelled, slope_stages(levelled)


def test_a_room_that_was_looked_into_closes(looked_into):
    levelled, lines = made(looked_into)
    storey = storey_from_plan(slope_plan(levelled, lines), far_snap=2.0).storey
    areas = sorted(round(room.area, 1) for room in storey.rooms)
    assert len(areas) == 2
    assert areas[0] == pytest.approx(24, abs=0.5)
    assert areas[1] == pytest.approx(24, abs=1.2)  # its wall to the corridor was seen from the corridor only
    alone = storey_from_plan(slope_plan(levelled, lines, afar=False), far_snap=2.0).storey
    assert len(alone.rooms) == 1


def test_faces_afar_lie_on_their_points_and_look_at_the_room(looked_into):
    levelled, lines = made(looked_into)
    faces = walls_afar(levelled, lines, lines.segments)
    to_scan = levelled.frame.to_scan(np.column_stack([np.vstack([faces.p, faces.q]), np.zeros(2 * len(faces))]))[:, :2]
    p, q = to_scan[: len(faces)], to_scan[len(faces) :]
    middle, d = (p + q) / 2, (q - p) / faces.length[:, None]
    assert faces.sided.all()
    assert len(faces) == 3
    centre = np.array([5.5, 4.6])
    assert ((centre - middle) * (d @ np.array([[0, 1], [-1, 0]]))).sum(axis=1).min() > 0  # the room is to the left
    far = middle[:, 1].argmax()
    assert p[far, 1] == pytest.approx(7.0, abs=0.01)
    assert sorted(np.delete(middle[:, 0], far).round(2)) == pytest.approx([3.0, 8.0], abs=0.01)


def test_walls_afar_do_not_depend_on_the_order_of_the_points(looked_into):
    order = np.random.default_rng(1).permutation(len(looked_into))
    first, second = (walls_afar(*made(points), made(points)[1].segments) for points in (looked_into, looked_into[order]))
    assert np.allclose(first.p, second.p, atol=1e-9)
    assert np.allclose(first.q, second.q, atol=1e-9)


def test_places_seen_well_and_scans_without_such_places_give_none():
    levelled, lines = made(rooms_cloud(CORRIDOR, OFFICE, noise=0.004))
    assert len(walls_afar(levelled, lines, lines.segments)) == 0
    coarse = replace(lines, image=replace(lines.image, cell=0.12))
    assert len(walls_afar(levelled, coarse, lines.segments)) == 0


def test_what_lets_rays_pass_is_no_wall(looked_into):
    levelled, lines = made(looked_into)
    sensor = levelled.frame.to_local([[5.5, 1.0, 1.5]])[0]
    seen_from = np.tile(sensor, (len(levelled.points), 1))
    assert len(walls_afar(levelled, lines, lines.segments, seen_from)) == 3
    reflection = glimpse(box(3, 7.3, 8, 9.5), 60)
    levelled, lines = made(np.vstack([looked_into, reflection]))
    faces = walls_afar(levelled, lines, lines.segments, np.tile(levelled.frame.to_local([[5.5, 1.0, 1.5]])[0], (len(levelled.points), 1)))
    ends = levelled.frame.to_scan(np.column_stack([np.vstack([faces.p, faces.q]), np.zeros(2 * len(faces))]))[:, :2].reshape(2, -1, 2)
    along_x = np.abs(ends[0, :, 1] - ends[1, :, 1]) < 0.1
    assert not (np.abs(ends[:, along_x, 1] - 7.0) < 0.2).any()


def test_a_wall_seen_from_both_sides_has_two_faces():
    z = np.linspace(0.2, 2.4, 40)
    left, right = (np.column_stack([np.linspace(0, 4, 40), np.full(40, y), z]) for y in (0.04, -0.04))
    sensor = np.repeat([[2.0, 3.0, 1.5], [2.0, -3.0, 1.5]], 40, axis=0)
    faces = seen_faces(Segments.from_ends([[0.0, 0.0]], [[4.0, 0.0]]), np.vstack([left, right]), sensor)
    assert faces.p.round(3).tolist() == [[0.0, 0.04], [4.0, -0.04]]
    assert faces.q.round(3).tolist() == [[4.0, 0.04], [0.0, -0.04]]
    one = seen_faces(Segments.from_ends([[0.0, 0.0]], [[4.0, 0.0]]), np.vstack([left, right[:9]]), sensor[:49])
    assert one.p.round(3).tolist() == [[0.0, 0.04]]
