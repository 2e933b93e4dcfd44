"""Openings in a wall with known holes."""

from __future__ import annotations

import inspect
from dataclasses import replace

import numpy as np
import pytest
from scanned_wall import HEIGHT, LENGTH, Hole, Scan, Screen, leaf, scan, storey

from indoor_bim.model import Storey
from indoor_bim.openings import find_openings
from indoor_bim.params import OpeningParams
from indoor_bim.plan.openings import name_opening
from indoor_bim.wall_views import wall_views, write_wall_pictures

DOOR = Hole(1.213, 2.118, 0.0, 2.087)
WINDOW = Hole(3.407, 4.791, 0.913, 2.204, pane=0.1)


def openings(measured: Scan, **options):
    return find_openings(measured.storey, measured.points, **{**measured.given(), **options}).walls[0].openings


def open_leaf(*, swing: int = 1, angle: float = 90.0) -> np.ndarray:
    return leaf(DOOR.start, 1.0, DOOR.end - DOOR.start, swing=swing, angle=angle)


@pytest.fixture(scope="module")
def both() -> Scan:
    return scan([DOOR, WINDOW], extra=open_leaf())


def sides(opening):
    return opening.start, opening.start + opening.width, opening.sill, opening.sill + opening.height


def test_sizes_are_exact_on_clean_data(both):
    door, window = openings(both, frame=0.0)
    assert (door.kind, window.kind) == ("door", "window")
    assert sides(door) == pytest.approx((DOOR.start, DOOR.end, DOOR.bottom, DOOR.top), abs=0.004)
    assert sides(window) == pytest.approx((WINDOW.start, WINDOW.end, WINDOW.bottom, WINDOW.top), abs=0.004)
    assert min(door.confidence, window.confidence) > 0.85
    assert door.evidence.support > 1000
    assert door.evidence.sides == 2


def test_the_storey_itself_is_left_alone(both):
    found = find_openings(both.storey, both.points, **both.given())
    assert both.storey.walls[0].openings == ()
    assert replace(found, walls=both.storey.walls) == both.storey


@pytest.mark.parametrize("angle", [0.3, 1.9, -2.5])
def test_turning_and_moving_the_building_changes_nothing(both, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    shift = np.array([31.0, -17.0, 2.9])

    def moved(points):
        return points @ turn.T + shift

    ends = moved(np.array([[0, 0, 0], [LENGTH, 0, 0]]))[:, :2]
    wall = replace(both.storey.walls[0], axis=tuple(map(tuple, ends.tolist())), base=2.9)
    path = np.column_stack([both.trajectory[:, 0], moved(both.trajectory[:, 1:])])
    found = find_openings(replace(both.storey, walls=(wall,)), moved(both.points), trajectory=path, gps_time=both.gps_time)
    for here, there in zip(openings(both), found.walls[0].openings, strict=True):
        assert here.kind == there.kind
        assert sides(here) == pytest.approx(sides(there), abs=0.001)


def test_the_order_of_the_points_changes_nothing(both):
    order = np.random.default_rng(3).permutation(len(both.points))
    shuffled = replace(both, points=both.points[order], gps_time=both.gps_time[order])
    assert openings(shuffled) == openings(both)


def test_the_number_of_threads_changes_nothing(both, monkeypatch):
    wall = both.storey.walls[0]
    twice = replace(both.storey, walls=(wall, replace(wall, id="S1-W002", axis=wall.axis[::-1]), replace(wall, id="S1-W003", base=0.1)))
    found = []
    for threads in (1, 3):
        for module in ("wall_views", "plan.wall_rays", "threads"):
            monkeypatch.setattr(f"indoor_bim.{module}.threads_for", lambda _, threads=threads: threads)
        found.append(find_openings(twice, both.points, **both.given()))
    assert found[0] == found[1]
    assert all(len(wall.openings) == 2 for wall in found[0].walls)


def test_a_wall_drawn_the_other_way_has_the_same_openings_mirrored(both):
    wall = both.storey.walls[0]
    turned = replace(both, storey=replace(both.storey, walls=(replace(wall, axis=wall.axis[::-1]),)))
    for here, there in zip(openings(both), openings(turned)[::-1], strict=True):
        assert here.start == pytest.approx(LENGTH - there.start - there.width, abs=0.001)
        assert (here.sill, here.height) == pytest.approx((there.sill, there.height), abs=0.001)


@pytest.mark.parametrize("hinge", ["start", "end"])
@pytest.mark.parametrize("swing", [1, -1])
@pytest.mark.parametrize("angle", [70.0, 90.0, 120.0])
def test_an_open_leaf_tells_hinge_and_swing(hinge, swing, angle):
    jamb, outward = (DOOR.start, 1.0) if hinge == "start" else (DOOR.end, -1.0)
    panel = leaf(jamb, outward, DOOR.end - DOOR.start, swing=swing, angle=angle)
    (door,) = openings(scan([DOOR], extra=panel), frame=0.0)
    assert (door.hinge, door.swing, door.leaves) == (hinge, "left" if swing == 1 else "right", 1)


def test_two_leaves_make_a_double_door():
    wide = Hole(1.5, 3.3, 0.0, 2.1)
    panels = np.vstack([leaf(1.5, 1.0, 0.9, swing=1), leaf(3.3, -1.0, 0.9, swing=1)])
    (door,) = openings(scan([wide], extra=panels), frame=0.0)
    assert (door.leaves, door.swing, door.hinge) == (2, "left", None)
    assert door.width == pytest.approx(1.8, abs=0.006)


@pytest.mark.parametrize(("left", "right"), [(0.04, 0.12), (0.08, 0.08), (0.16, 0.0), (0.0, 0.16)])
def test_a_closed_leaf_in_the_wall_is_a_door(left, right):
    closed = replace(DOOR, depth=left, depth_right=right)
    (door,) = openings(scan([closed]), frame=0.0)
    assert door.kind == "door"
    assert sides(door) == pytest.approx((DOOR.start, DOOR.end, DOOR.bottom, DOOR.top), abs=0.006)
    assert (door.hinge, door.swing) == (None, None)


@pytest.mark.parametrize(
    "made",
    [{"holes": [replace(DOOR, depth=0.02, depth_right=0.0)]}, {"screens": [Screen(DOOR.start, DOOR.end, 0.0, DOOR.top, 0.02)]}],
    ids=["behind", "before"],
)
def test_a_closed_leaf_two_centimetres_off_the_face_is_a_door(made):
    measured = scan(**made)
    noise = np.random.default_rng(6).normal(0, 0.012, measured.points.shape)
    (door,) = openings(replace(measured, points=measured.points + noise))
    assert door.kind == "door"
    assert sides(door) == pytest.approx((DOOR.start, DOOR.end, DOOR.bottom, DOOR.top), abs=0.02)
    assert door.confidence <= 0.5


@pytest.mark.parametrize("turn", [0.03, -0.03])
def test_a_closed_door_is_found_in_a_wall_that_was_drawn_askew(turn):
    closed = Hole(2.0, 3.8, 0.0, 2.1, depth=0.06, depth_right=0.0)
    measured = scan([closed], sides=(1,))
    dy = LENGTH / 2 * np.tan(turn)
    wall = replace(measured.storey.walls[0], axis=((0.0, -dy), (LENGTH, dy)), thickness_measured=False)
    (door,) = openings(replace(measured, storey=replace(measured.storey, walls=(wall,))), frame=0.0)
    assert door.kind == "door"
    assert sides(door) == pytest.approx((closed.start, closed.end, closed.bottom, closed.top), abs=0.02)


def test_a_frame_in_the_plane_of_the_wall_has_the_given_width():
    closed = replace(DOOR, depth=0.08, depth_right=0.08)
    (plain,) = openings(scan([closed]), frame=0.0)
    (framed,) = openings(scan([closed]), frame=0.05)
    assert framed.width - plain.width == pytest.approx(0.10, abs=1e-3)
    assert framed.height - plain.height == pytest.approx(0.05, abs=1e-3)


def test_a_hole_without_leaf_and_frame_is_a_passage():
    (passage,) = openings(scan([DOOR]))
    assert (passage.kind, passage.leaves, passage.hinge, passage.swing) == ("opening", 0, None, None)
    assert sides(passage) == pytest.approx((DOOR.start, DOOR.end, DOOR.bottom, DOOR.top), abs=0.004)


def test_what_was_seen_from_one_room_may_have_its_leaf_in_the_other():
    (door,) = openings(scan([DOOR], sides=(1,)))
    assert (door.kind, door.swing) == ("door", None)


def test_a_wide_passage_below_a_beam_is_no_window():
    beam = Hole(1.0, 4.7, 0.0, 2.25)
    (passage,) = openings(scan([beam]))
    assert passage.kind == "opening"
    assert sides(passage) == pytest.approx((beam.start, beam.end, beam.bottom, beam.top), abs=0.006)


def test_a_glazed_hole_close_above_the_floor_is_a_window():
    low = Hole(2.0, 3.0, 0.10, 2.1, pane=0.1)
    (window,) = openings(scan([low]))
    assert window.kind == "window"
    assert sides(window) == pytest.approx((low.start, low.end, low.bottom, low.top), abs=0.01)


def test_a_closed_leaf_behind_a_threshold_is_a_door():
    (door,) = openings(scan([Hole(2.0, 3.6, 0.08, 2.1, depth=0.062)], sides=(1,)))
    assert door.kind == "door"
    frame = inspect.signature(name_opening).parameters["frame"].default
    assert sides(door) == pytest.approx((2.0 - frame, 3.6 + frame, 0.0, 2.1 + frame), abs=0.01)


@pytest.mark.parametrize("sill", [0.10, 0.20, 0.90])
def test_a_window_through_which_nothing_came_back_is_found_by_its_reveals(sill):
    dark = Hole(2.0, 3.0, sill, 2.1)
    measured = scan([dark], sides=(1,))
    returned = measured.points[:, 1] > -0.11
    (window,) = openings(replace(measured, points=measured.points[returned], gps_time=measured.gps_time[returned]))
    assert window.kind == "window"
    assert sides(window) == pytest.approx((dark.start, dark.end, dark.bottom, dark.top), abs=0.005)


@pytest.mark.parametrize("side", ["start", "end"])
def test_a_hole_at_the_end_of_a_wall_is_none(side):
    assert openings(scan([Hole(0.0, 1.0, 0.0, 2.1) if side == "start" else Hole(LENGTH - 1.0, LENGTH, 0.0, 2.1)])) == ()


@pytest.mark.parametrize("side", ["start", "end"])
def test_a_window_that_the_end_of_its_wall_cuts_off_is_found_as_far_as_the_wall_goes(side):
    start, end = (0.0, 1.0) if side == "start" else (LENGTH - 1.0, LENGTH)
    (window,) = openings(scan([Hole(start, end, 0.9, 2.1, pane=0.1)]))
    assert window.kind == "window"
    cell = 0.06
    assert sides(window) == pytest.approx((start, end, 0.9, 2.1), abs=cell)
    assert sides(window)[2:] == pytest.approx((0.9, 2.1), abs=0.01)
    assert openings(scan([Hole(start, end, 0.9, 2.1, depth=0.12, depth_right=0.0)])) == ()


def test_a_passage_up_to_the_ceiling_is_an_opening():
    (passage,) = openings(scan([Hole(2.0, 3.2, 0.0, HEIGHT)]))
    assert (passage.kind, passage.leaves) == ("opening", 0)
    assert passage.height == pytest.approx(HEIGHT, abs=0.01)


def test_the_path_through_a_wall_proves_a_door():
    (seen,) = openings(scan([DOOR], extra=open_leaf()))
    (walked,) = openings(scan([DOOR], extra=open_leaf(), walk=[((1.7, 1.5), (1.7, -1.5))]))
    assert seen.confidence < walked.confidence == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    "made",
    [
        pytest.param({"holes": [Hole(2.0, 3.0, 0.8, 1.8, depth=0.15, depth_right=0.0)]}, id="niche"),
        pytest.param({"holes": [Hole(2.0, 3.0, 0.0, 2.1, depth=0.10, depth_right=0.0)]}, id="niche down to the floor"),
        pytest.param({"screens": [Screen(1.0, 2.0, 0.0, 2.1, 0.6)]}, id="cupboard"),
        pytest.param({"screens": [Screen(1.0, 2.0, 0.9, 2.1, 0.08)]}, id="board"),
        pytest.param({"unseen": [Screen(1.0, 2.0, 0.0, 2.1, 0.0)], "sides": (1,)}, id="unscanned"),
        pytest.param({"screens": [Screen(1.0, 2.0, 0.0, 2.1, 0.6)], "sides": (1,)}, id="cupboard seen from one side"),
        pytest.param({"screens": [Screen(2.0, 3.0, 0.0, HEIGHT, 0.03)]}, id="pilaster up to the ceiling"),
        pytest.param({"screens": [Screen(0.5, 5.5, 0.0, 2.1, 0.02)]}, id="panelling"),
        pytest.param({}, id="plain wall"),
    ],
)
@pytest.mark.parametrize("path_known", [True, False])
def test_what_is_not_an_opening(made, path_known):
    measured = scan(**made)
    given = measured.given() if path_known else {"trajectory": None, "gps_time": None}
    assert openings(measured, **given) == ()


def test_without_the_path_openings_are_found_by_their_reveals(both):
    door, window = openings(both, trajectory=None, gps_time=None, frame=0.0)
    assert (door.kind, window.kind) == ("door", "window")
    assert sides(door) == pytest.approx((DOOR.start, DOOR.end, DOOR.bottom, DOOR.top), abs=0.015)
    assert sides(window) == pytest.approx((WINDOW.start, WINDOW.end, WINDOW.bottom, WINDOW.top), abs=0.015)
    assert max(door.confidence, window.confidence) <= 0.6


def test_the_floor_in_a_wall_shows_a_door_without_reveals(both):
    x, y, z = both.points.T
    in_wall = np.abs(y) < 0.098
    floor = replace(both, points=both.points[~in_wall | (z < 0.01) & (np.abs(x - 1.66) < 0.45)], gps_time=None)
    (door,) = openings(floor, trajectory=None, gps_time=None, frame=0.0)
    assert sides(door) == pytest.approx((DOOR.start, DOOR.end, DOOR.bottom, DOOR.top), abs=0.02)
    hidden = replace(both, points=both.points[~in_wall], gps_time=None)
    assert openings(hidden, trajectory=None, gps_time=None) == ()


def test_a_path_without_times_is_no_path(both):
    timeless = both.trajectory.copy()
    timeless[:, 0] = np.nan
    assert openings(both, trajectory=timeless) == openings(both, trajectory=None, gps_time=None)


def test_a_path_of_another_clock_is_no_path(both):
    other = both.trajectory.copy()
    other[:, 0] += 1e6
    assert openings(both, trajectory=other) == openings(both, trajectory=None, gps_time=None)


def test_furniture_under_a_window_does_not_make_it_a_door():
    measured = scan([WINDOW], screens=[Screen(3.0, 5.2, 0.0, 0.8, 0.5)])
    assert [o.kind for o in openings(measured)] == ["window"]


def test_a_window_between_pilasters_is_found():
    pilasters = [Screen(0.0, 2.6, 0.0, HEIGHT, 0.12), Screen(5.6, 6.0, 0.0, HEIGHT, 0.12)]
    measured = scan([WINDOW], screens=pilasters, sides=(1,))
    wall = measured.storey.walls[0]
    outer = replace(wall, axis=((0.0, 0.07), (LENGTH, 0.07)), thickness=0.30, thickness_measured=False)
    (window,) = openings(replace(measured, storey=replace(measured.storey, walls=(outer,))))
    assert window.kind == "window"
    assert sides(window) == pytest.approx((WINDOW.start, WINDOW.end, WINDOW.bottom, WINDOW.top), abs=0.01)


def test_the_edge_of_a_stair_is_no_jamb():
    measured = scan([Hole(1.0, 3.0, 0.9, HEIGHT)], sides=(1,))
    assert [o.kind for o in openings(measured)] == ["window"]
    steps = [Hole(3.0 + 0.15 * k, 3.15 + 0.15 * k, 0.9 + 0.17 * k, HEIGHT) for k in range(10)]
    assert openings(scan([Hole(1.0, 3.0, 0.9, HEIGHT), *steps], sides=(1,))) == ()


def test_drift_of_the_scanner_does_not_make_openings(both):
    drift = 0.03 * np.sin(both.gps_time / 4.0)
    points = both.points + np.column_stack([np.zeros_like(drift), drift, np.zeros_like(drift)])
    path = both.trajectory + np.column_stack(
        [np.zeros((len(both.trajectory), 2)), 0.03 * np.sin(both.trajectory[:, 0] / 4.0), np.zeros(len(both.trajectory))]
    )
    found = find_openings(both.storey, points, trajectory=path, gps_time=both.gps_time).walls[0].openings
    assert [o.kind for o in found] == ["door", "window"]
    for drifted, still in zip(found, openings(both), strict=True):
        assert sides(drifted) == pytest.approx(sides(still), abs=0.015)


def test_noise_of_a_walked_scanner_costs_centimetres(both):
    rng = np.random.default_rng(5)
    noisy = both.points + rng.normal(0, 0.015, both.points.shape)
    for measured, exact in zip(openings(replace(both, points=noisy)), openings(both), strict=True):
        assert measured.kind == exact.kind
        assert sides(measured) == pytest.approx(sides(exact), abs=0.03)


def test_what_is_less_certain_than_asked_for_is_left_out(both):
    assert openings(both, min_confidence=0.999) == ()


def test_no_walls_and_no_points():
    empty = Storey("S1", "Storey 1", 0.0, 2.5)
    assert find_openings(empty, np.zeros((0, 3))) == empty
    assert find_openings(storey(), np.zeros((0, 3))) == storey()


def test_names_count_through_the_storey(both):
    ids = [o.id for o in openings(both)]
    assert ids == ["S1-Door1", "S1-Window1"]


def test_every_parameter_is_declared_once():
    options = {p.name: p.default for p in inspect.signature(find_openings).parameters.values() if p.kind is p.KEYWORD_ONLY}
    declared = OpeningParams().model_dump()
    assert {name: options[name] for name in declared} == declared
    assert set(options) - set(declared) == {"trajectory", "gps_time", "intensity"}


def test_pictures_are_written_for_every_wall(both, tmp_path):
    (file,) = write_wall_pictures(both.storey, both.points, tmp_path, **both.given())
    assert file.name == "S1-W001.png"
    assert file.read_bytes().startswith(b"\x89PNG")


def test_the_picture_shows_face_hole_and_what_stands_before(both):
    measured = scan([DOOR], screens=[Screen(4.0, 5.0, 0.0, 2.0, 0.6)], sides=(1,))
    (view,) = wall_views(measured.storey, measured.points, **measured.given())
    cell = view.picture.cell

    def block(counts, x0, x1, z0, z1):
        return counts[..., int(z0 / cell) : int(z1 / cell), int(x0 / cell) : int(x1 / cell)]

    left, right = 0, 1
    assert block(view.picture.face[left], 2.5, 3.5, 0.3, 2.0).mean() > 1
    assert block(view.picture.face[left], 1.3, 2.0, 0.3, 2.0).sum() == 0
    assert block(view.picture.through[left], 1.3, 2.0, 0.6, 2.0).mean() > 1
    assert view.picture.face[right].sum() == view.picture.entered[right].sum() == 0
    assert block(view.picture.front, 4.1, 4.9, 0.3, 1.8).mean() > 0.5
