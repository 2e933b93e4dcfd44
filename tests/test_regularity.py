from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plans import FLAT, box, faces_of_rooms, turned

from indoor_bim.plan.alignment import align_faces, share_lines
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.shared_thickness import share_thickness
from indoor_bim.plan.walls import Walls, walls_from_faces


def wall_table(*rows: tuple[float, float, bool]) -> Walls:
    """Walls of given thickness and length, measured or not, 1 m apart."""
    n = len(rows)
    y = np.arange(n, dtype=float)
    return Walls(
        p=np.column_stack([np.zeros(n), y]),
        q=np.column_stack([[r[1] for r in rows], y]),
        thickness=np.array([r[0] for r in rows]),
        measured=np.array([r[2] for r in rows]),
        seen_left=np.ones(n, dtype=bool),
        support=np.full(n, 100),
        coverage=np.ones(n),
        rmse=np.full(n, 0.02),
        top=np.full(n, 2.5),
    )


def test_walls_of_one_build_share_their_thickness():
    walls = wall_table((0.10, 4, True), (0.13, 4, True), (0.118, 8, True), (0.24, 5, True), (0.25, 5, True))
    assert share_thickness(walls).thickness == pytest.approx([0.1165] * 3 + [0.245] * 2)


def test_assumed_thicknesses_neither_count_nor_change():
    walls = wall_table((0.10, 4, True), (0.11, 4, False))
    assert share_thickness(walls).thickness.tolist() == [0.10, 0.11]


def test_an_accurate_scan_tells_thicknesses_apart():
    walls = replace(wall_table((0.10, 4, True), (0.12, 4, True)), rmse=np.full(2, 0.002))
    assert share_thickness(walls).thickness.tolist() == [0.10, 0.12]


def test_a_chain_of_small_differences_is_not_one_build():
    walls = wall_table(*((0.10 + 0.015 * k, 4, True) for k in range(10)))
    shared = share_thickness(walls).thickness
    assert np.abs(shared - walls.thickness).max() <= 0.04
    assert len(set(np.round(shared, 6))) > 1


def test_sharing_leaves_exact_walls_alone():
    walls = walls_from_faces(faces_of_rooms(*FLAT))
    assert share_thickness(walls).thickness == pytest.approx(walls.thickness, abs=1e-12)


@pytest.mark.parametrize(("degrees", "length", "squared"), [(0.2, 6.0, True), (0.2, 30.0, False), (2.0, 1.0, False), (2.0, 6.0, False)])
def test_only_what_a_bent_map_explains_is_turned(degrees, length, squared):
    a = np.radians(degrees)
    for base in (0.0, np.pi / 2):
        end = length * np.array([np.cos(base + a), np.sin(base + a)])
        out = align_faces(Segments.from_ends([[0.0, 0.0]], [end]), tolerance=0.02)
        off = np.abs(out.direction[0]).min()
        assert off == pytest.approx(0.0 if squared else np.sin(a), abs=1e-12)
        assert (out.p + out.q) / 2 == pytest.approx(end[None] / 2)


def test_the_tolerance_is_the_accuracy_of_the_scan():
    faces = replace(faces_of_rooms(box(0, 0, 4, 3)), q=np.array([[4.0, 0.01], [4, 3], [0, 3], [0, 0]]))
    assert align_faces(replace(faces, rmse=np.full(4, 0.001))).q[0].tolist() == [4.0, 0.01]
    assert align_faces(replace(faces, rmse=np.full(4, 0.02))).q[0].tolist() == [4.0, 0.005]


def bent_facade(*offsets: float) -> Segments:
    """Rooms 4 m wide along y = 0, each with its own error of place, seen from above."""
    x = 4.2 * np.arange(len(offsets))
    faces = Segments.from_ends(np.column_stack([x, offsets]), np.column_stack([x + 4.0, offsets]))
    return replace(faces, sided=np.full(len(offsets), True))


@pytest.mark.parametrize("degrees", [0.0, 37.0, 90.0, 180.0])
def test_the_pieces_of_a_facade_lie_on_one_line(degrees):
    shared = share_lines(turned(bent_facade(0.0, 0.018, -0.01, 0.004), degrees))
    straight = turned(bent_facade(*[0.003] * 4), degrees)
    np.testing.assert_allclose(shared.p, straight.p, atol=1e-12)
    np.testing.assert_allclose(shared.q, straight.q, atol=1e-12)


def test_steps_and_other_sides_and_other_directions_stay():
    step = bent_facade(0.0, 0.10)
    backs = Segments.from_ends(step.q + np.array([0.0, 0.01]), step.p + np.array([0.0, 0.01]))
    across = Segments.from_ends([[0.0, 0.0], [0.0, 0.01]], [[0.0, 3.0], [3.0, 3.01]])
    for faces in (step, replace(bent_facade(0.0, 0.02), sided=np.zeros(2, dtype=bool)), replace(across, sided=np.full(2, True))):
        assert share_lines(faces).p.tolist() == faces.p.tolist()
    both = share_lines(
        replace(Segments.from_ends(np.vstack([step.p, backs.p]), np.vstack([step.q, backs.q])), sided=np.full(4, True)), tolerance=0.03
    )
    assert both.p[:2].tolist() == step.p.tolist()


def test_no_face_moves_farther_than_the_tolerance_spans():
    offsets = np.random.default_rng(5).uniform(-0.3, 0.3, 60)
    faces = bent_facade(*offsets)
    shared = share_lines(faces, tolerance=0.03)
    assert np.abs(shared.p - faces.p).max() <= 0.06
    assert len(np.unique(shared.p[:, 1])) <= 20
    assert np.array_equal(shared.p[:, 0], faces.p[:, 0])
