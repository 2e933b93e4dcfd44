"""Slices, range gate, walls up to the ceiling, gaps as openings, and a hall with eight corners."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely
from clouds import rooms_cloud
from plans import box

from indoor_bim import Cloud, reconstruct
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.frame import Frame
from indoor_bim.gap_openings import with_gap_openings
from indoor_bim.params import Params, SlicesParams
from indoor_bim.plan.contour_gaps import ContourGap, contour_gaps
from indoor_bim.plan.full_height import ends_lower, share_at_ceiling, with_heights
from indoor_bim.plan.layer_image import hits_along, layer_image
from indoor_bim.plan.range_gate import within_range
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.slice_heights import Slice, choose_slices, layer_evidence, slice_thickness
from indoor_bim.simulate import demo_house, simulate, single_room

HEIGHT = 2.5
SPEC = importlib.util.spec_from_file_location("line_recognition", Path(__file__).parents[1] / "benchmarks" / "line_recognition.py")
RECOGNITION = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = RECOGNITION
SPEC.loader.exec_module(RECOGNITION)


def panel(p, q, *, low=0.0, high=HEIGHT, spacing=0.02):
    """Points of an upright rectangle."""
    p, q = np.array(p, dtype=float), np.array(q, dtype=float)
    length = np.hypot(*(q - p))
    t, z = np.meshgrid(np.arange(spacing / 2, length, spacing) / length, np.arange(low + spacing / 2, high, spacing))
    return np.column_stack([p + t.reshape(-1, 1) * (q - p), z.ravel()])


def four_walls(size=5.0):
    corners = [(0, 0), (size, 0), (size, size), (0, size)]
    return [panel(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def test_slices_are_where_furniture_is_not():
    cupboards = [panel((0.6, y), (1.6, y), low=low, high=high) for y in np.arange(1, 4, 0.4) for low, high in ((0.0, 1.2), (1.7, 1.8))]
    evidence = layer_evidence(np.concatenate([*four_walls(), *cupboards]), height=HEIGHT)
    found = choose_slices(evidence, thickness=0.1)
    assert len(found) == 2
    assert all(part.low > 1.19 and not (part.high > 1.701 and part.low < 1.799) for part in found)
    assert found[1].middle - found[0].middle >= 0.4 - 1e-9


def test_more_slices_on_request_and_fewer_where_there_is_no_room():
    evidence = layer_evidence(np.concatenate(four_walls()), height=HEIGHT)
    assert [len(choose_slices(evidence, thickness=0.1, count=n)) for n in (1, 3)] == [1, 3]
    assert len(choose_slices(evidence, thickness=0.1, count=40)) < 10


def test_thickness_is_three_spacings_and_more_in_sparse_scans():
    dense = layer_evidence(np.concatenate(four_walls()), height=HEIGHT)
    assert slice_thickness(dense, spacing=0.05, height=HEIGHT) == pytest.approx(0.15)
    sparse = layer_evidence(np.concatenate(four_walls())[::7], height=HEIGHT)
    assert slice_thickness(sparse, spacing=0.02, height=HEIGHT) > slice_thickness(dense, spacing=0.02, height=HEIGHT) >= 0.06


def test_the_range_gate_drops_what_is_carried_along_and_what_lies_behind_windows():
    distance = np.concatenate([[0.2, 45.0], np.linspace(1, 8, 400)])
    assert within_range(distance).tolist() == [False, False] + [True] * 400
    assert within_range(distance, nearest=0.1, farthest=50.0).all()


def test_layers_along_a_line_are_those_of_the_points_beside_it():
    image = layer_image(np.concatenate([panel((0, 0), (2, 0)), panel((2, 0), (4, 0), low=1.0)]), height=HEIGHT)
    (hit,) = hits_along(image, np.array([[0.0, 0.0]]), np.array([[4.0, 0.0]]), reach=0.02)
    middle = np.arange(hit.shape[1]) * image.layer + image.layer / 2
    assert hit[:38].all()
    assert not hit[42:, middle < 0.95].any()
    assert hit[42:, middle > 1.05].all()
    (beside,) = hits_along(image, np.array([[0.0, 0.0]]), np.array([[4.0, 0.0]]), reach=0.02, shift=0.3)
    assert not beside.any()


def test_walls_reach_the_ceiling_and_doors_do_not():
    points = np.concatenate([panel((0, 0), (3, 0)), panel((0, 2), (1, 2), high=2.1), panel((0, 4), (0.2, 4), spacing=0.08)])
    faces = Segments.from_ends([[0, 0], [0, 2], [0, 4]], [[3, 0], [1, 2], [0.2, 4]])
    image = layer_image(points, height=HEIGHT)
    faces = with_heights(faces, image, height=HEIGHT, reach=0.02)
    assert faces.top == pytest.approx([2.5, 2.1, 2.5], abs=0.05)
    assert (share_at_ceiling(faces, points, height=HEIGHT, reach=0.02, depth=0.1) > 0.5).tolist()[:2] == [True, False]
    assert ends_lower(faces, image, height=HEIGHT, reach=0.02).tolist() == [False, True, False]


WALL = Segments.from_ends([[0, 0]], [[6, 0]])
SLICES = (Slice(1.1, 1.2), Slice(2.2, 2.3))


def wall_with_hole(*, bottom, top, start=2.0, end=3.0):
    parts = [panel((0, 0), (start, 0)), panel((end, 0), (6, 0)), panel((start, 0), (end, 0), low=top)]
    return np.concatenate([*parts, panel((start, 0), (end, 0), high=bottom)] if bottom > 0 else parts)


@pytest.mark.parametrize(("bottom", "top"), [(0.0, 2.0), (0.9, 2.1)])
def test_gaps_are_measured_on_the_points_of_the_wall(bottom, top):
    image = layer_image(wall_with_hole(bottom=bottom, top=top), height=HEIGHT)
    (gap,) = contour_gaps(WALL, image, SLICES, height=HEIGHT, reach=0.02)
    assert (gap.p[0], gap.q[0]) == pytest.approx((2.0, 3.0), abs=0.06)
    assert (gap.bottom, gap.top) == pytest.approx((bottom, top), abs=0.06)
    assert (gap.edges, gap.hidden) == (1.0, False)


def test_a_gap_behind_a_cupboard_is_hidden():
    points = np.concatenate([wall_with_hole(bottom=0.0, top=2.0), panel((1.9, 0.6), (3.1, 0.6), high=2.0)])
    (gap,) = contour_gaps(WALL, layer_image(points, height=HEIGHT), SLICES, height=HEIGHT, reach=0.02)
    assert gap.hidden


def test_gaps_become_openings_where_there_is_none_yet():
    storey = demo_house().storeys[0]
    bare = storey.walls[0]  # along y = 0, with a window at 2.3
    (x0, y0), _ = bare.axis
    place = [o.start + o.width for o in bare.openings]
    free = x0 + place[0] + 0.4
    door = ContourGap((free, y0), (free + 0.9, y0), 0.0, 2.0, 1.0, False)
    taken = ContourGap((x0 + bare.openings[0].start, y0), (x0 + place[0], y0), 0.9, 2.2, 1.0, False)
    hidden = ContourGap((free + 1.2, y0), (free + 1.9, y0), 0.0, 2.0, 1.0, True)
    doubtful = ContourGap((free + 1.2, y0), (free + 1.9, y0), 0.0, 2.0, 0.5, False)
    walls = with_gap_openings(storey, [door, taken, hidden, doubtful]).walls
    new = [o for o in walls[0].openings if o not in bare.openings]
    assert [(o.kind, round(o.width, 3), o.sill, o.height) for o in new] == [("door", 0.9, 0.0, 2.0)]
    assert new[0].confidence == pytest.approx(0.6)
    assert [w.openings for w in walls[1:]] == [w.openings for w in storey.walls[1:]]
    ids = [o.id for wall in walls for o in wall.openings]
    assert len(ids) == len(set(ids))


@pytest.fixture(scope="module")
def room():
    return simulate(single_room(cut_corner=1.5), profile="static", points=200_000, seed=2)


def corners_in_truth(result, scan):
    to_truth = Frame.from_matrix(scan.truth.transform_cloud_to_model).matrix @ np.linalg.inv(
        Frame.from_matrix(result.building.transform_cloud_to_model).matrix
    )
    (found,) = result.building.storeys[0].rooms
    ring = np.array(found.outline.exterior)
    return (np.column_stack([ring, np.zeros(len(ring)), np.ones(len(ring))]) @ to_truth.T)[:, :2]


@pytest.mark.parametrize(("profile", "seed", "largest"), [("static", 1, 0.010), ("backpack", 2, 0.024)])
def test_corners_of_a_hall_come_as_close_as_in_the_paper(profile, seed, largest):
    scan = simulate(RECOGNITION.workshop_hall(), profile=profile, points=1_000_000, seed=seed)
    result = reconstruct(Cloud(scan.points, gps_time=scan.gps_time, trajectory=scan.trajectory), method="slices")
    truth = np.array(scan.truth.storeys[0].rooms[0].outline.exterior)
    error = RECOGNITION.corner_errors(truth, corners_in_truth(result, scan))
    assert len(truth) == 8
    assert np.sqrt((error**2).mean()) < largest
    assert not any("range gate" in warning for warning in result.warnings)


def test_recognition_is_counted_by_the_rules_of_the_table():
    truth = RECOGNITION.Lines(np.array([[0.0, 0.0], [5.0, 0.0]]), np.array([[4.0, 0.0], [5.0, 0.2]]))

    def found(*lines):
        p, q = (np.array([line[k] for line in lines], dtype=float) for k in (0, 1))
        return RECOGNITION.recognised(truth, RECOGNITION.Lines(p, q)).tolist()

    assert found(([0, 0.04], [2.1, 0.04])) == [True, False]
    assert found(([0, 0.06], [4, 0.06])) == [False, False]
    assert found(([0, 0], [1.1, 0]), ([2.5, 0.01], [3.6, 0.01])) == [True, False]
    assert found(([5.01, 0], [5.01, 0.15])) == [False, True]
    assert found(([5.0, -3], [5.0, 3])) == [False, False]


def test_seams_of_touching_walls_are_not_asked_for():
    outer = [(0, 0), (4, 0), (4, 3), (0, 3), (0, 0.2), (0.2, 0.2), (0.2, 2.8), (3.8, 2.8), (3.8, 0.2), (0.2, 0.2), (0, 0.2)]
    lines = RECOGNITION.faces_of([shapely.Polygon(outer), shapely.box(2.0, 0.2, 2.1, 2.8)])
    assert np.sort(lines.length) == pytest.approx([1.7, 1.7, 1.8, 1.8, *[2.6] * 4, 3, 3, 4, 4], abs=1e-6)


def test_without_times_the_range_gate_is_skipped_and_that_is_said(room):
    result = reconstruct(room.points, method="slices")
    assert any("range gate was skipped" in warning for warning in result.warnings)
    truth = shapely.Polygon(room.truth.storeys[0].rooms[0].outline.exterior)
    assert result.building.storeys[0].rooms[0].area == pytest.approx(truth.area, rel=0.01)


def test_heights_can_be_given(room):
    params = Params(slices=SlicesParams(heights=(1.2, 2.8), thickness=0.1))
    result = reconstruct(room.points, method="slices", params=params)
    assert [round(part.middle, 6) for part in result.stages["lines"][0].slices] == [1.2, 2.8]
    with pytest.raises(NothingToReconstructError, match="choose other heights"):
        reconstruct(room.points, method="slices", params=Params(slices=SlicesParams(heights=(7.0,))))


def test_walls_in_any_direction_carry_their_covariance():
    points = rooms_cloud(box(0, 0, 5, 4), noise=0.003)
    result = reconstruct(points, method="slices")
    faces = result.stages["lines"][0].contour.segments
    assert len(faces) == 4
    assert np.linalg.eigvalsh(faces.covariance).min() > 0
    assert np.sqrt(faces.covariance[:, 0, 0]).max() < 0.001
