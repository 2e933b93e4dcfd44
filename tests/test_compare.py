"""Comparison of a building with the known one: each defect moves its own figure and no other."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely

from indoor_bim.frame import Frame
from indoor_bim.model import Building, Opening, Outline, Storey, Wall
from indoor_bim.quality.compare import compare
from indoor_bim.quality.comparison import Comparison, Score
from indoor_bim.quality.matching import covered_share
from indoor_bim.quality.placement import place_in_frame_of
from indoor_bim.simulate.building import demo_house, office_floor, single_room, two_storeys

SCORES = ("storeys", "walls", "rooms_50", "rooms_85", "corners", "doors", "windows")
LENGTHS = ("thickness_mm", "height_mm", "floor_mm", "length_mm", "width_mm")


def defects(comparison: Comparison) -> set[str]:
    """Names of all figures that are not perfect."""
    names = {name for name in SCORES if getattr(comparison, name).f1 != 1.0}
    names |= {name for name in LENGTHS if (getattr(comparison, name) or 0.0) > 1e-6}
    faces = comparison.faces
    names |= {name for name in ("completeness", "correctness") if getattr(faces, name) != 1.0}
    names |= {name for name in ("median_mm", "p95_mm") if (getattr(faces, name) or 0.0) > 1e-6}
    return names | ({"missing"} if comparison.missing_walls else set()) | ({"extra"} if comparison.extra_walls else set())


def with_walls(building: Building, change: dict[str, Wall | None], *, added: tuple[Wall, ...] = ()) -> Building:
    storey = building.storeys[0]
    walls = tuple(w for wall in storey.walls if (w := change.get(wall.id, wall)) is not None)
    return replace(building, storeys=(replace(storey, walls=walls + added), *building.storeys[1:]))


def box_wall(wall: Wall, *, shift: tuple[float, float] = (0.0, 0.0), thickness: float | None = None) -> Wall:
    """The wall as the plain rectangle about its axis, shortened to its footprint, moved and resized."""
    thickness = thickness or wall.thickness
    axis = shapely.affinity.translate(shapely.LineString(wall.axis), *shift)
    rectangle = shapely.affinity.translate(shapely.LineString(wall.axis).intersection(shapely.Polygon(wall.footprint)), *shift)
    footprint = Outline.from_polygon(rectangle.buffer(thickness / 2, cap_style="flat")).exterior
    return replace(wall, axis=tuple(axis.coords), thickness=thickness, footprint=footprint)


def wall_of(building: Building, number: int) -> Wall:
    return building.storeys[0].walls[number - 1]


@pytest.mark.parametrize("building", [demo_house(), office_floor(seed=3), two_storeys(), single_room(cut_corner=1.0)], ids=lambda b: b.name)
def test_truth_against_itself_is_perfect(building: Building) -> None:
    comparison = compare(building, building)
    assert defects(comparison) == set()
    assert comparison.faces.median_mm == pytest.approx(0.0, abs=1e-6)


def test_model_frames_do_not_matter() -> None:
    truth = demo_house()
    scan_from_model = Frame(
        np.array([5e5, 5.4e6, 300.0]), np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1.0]]), 1.0, np.array([1.0, 2, 3])
    )
    truth = replace(truth, transform_cloud_to_model=scan_from_model.rows())
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    other = replace(truth, transform_cloud_to_model=scan_from_model.then(quarter, (4.0, -7.0, 2.5)).rows())
    turned = place_in_frame_of(truth, other)
    assert turned.storeys[0].elevation == pytest.approx(2.5)
    assert wall_of(turned, 1).axis[1] == pytest.approx((4.0, 11.6 - 7.0))
    comparison = compare(turned, truth)
    assert all(getattr(comparison, name).f1 == 1.0 for name in SCORES)
    assert all(getattr(comparison, name) < 1e-3 for name in LENGTHS)
    assert comparison.faces.p95_mm < 1e-3


def test_identifiers_do_not_matter() -> None:
    truth = demo_house()
    ids = [wall.id for wall in truth.storeys[0].walls]
    renamed = with_walls(truth, {old: replace(wall_of(truth, k + 1), id=ids[k - 3]) for k, old in enumerate(ids)})
    assert defects(compare(renamed, truth)) == set()


def test_moved_wall_moves_its_faces() -> None:
    truth = demo_house()
    wall = wall_of(truth, 11)
    moved = with_walls(truth, {wall.id: box_wall(wall, shift=(0.03, 0.0))})
    comparison = compare(moved, truth)
    assert defects(comparison) == {"p95_mm"}
    assert comparison.faces.p95_mm == pytest.approx(30.0, abs=1e-6)


def share_without_partition(truth: Building) -> float:
    """Share of the faces that bound rooms without the two of the last partition of the demo house."""
    return 1 - 2 * (3.6 - 0.15 - 0.10) / sum(room.outline.polygon.length for room in truth.storeys[0].rooms)


def test_wall_moved_too_far_is_missing_and_extra() -> None:
    truth = demo_house()
    wall = wall_of(truth, 11)
    comparison = compare(with_walls(truth, {wall.id: box_wall(wall, shift=(wall.thickness, 0.0))}), truth)
    assert comparison.missing_walls == comparison.extra_walls == (wall.id,)
    assert comparison.walls == Score(10, 11, 10, 11)
    assert comparison.faces.completeness == pytest.approx(share_without_partition(truth), abs=5e-3)


def test_removed_wall() -> None:
    truth = demo_house()
    wall = wall_of(truth, 11)
    comparison = compare(with_walls(truth, {wall.id: None}), truth)
    assert defects(comparison) == {"walls", "missing", "completeness", "corners"}
    assert comparison.missing_walls == (wall.id,)
    assert comparison.walls.recall == pytest.approx(10 / 11)
    assert comparison.walls.precision == 1.0
    assert comparison.faces.completeness == pytest.approx(share_without_partition(truth), abs=5e-3)


def test_extra_wall() -> None:
    truth = demo_house()
    extra = replace(wall_of(truth, 11), id="x", openings=(), axis=((2.0, 0.5), (2.0, 3.0)), thickness=0.12)
    extra = replace(extra, footprint=((1.94, 0.5), (2.06, 0.5), (2.06, 3.0), (1.94, 3.0)))
    comparison = compare(with_walls(truth, {}, added=(extra,)), truth)
    assert defects(comparison) == {"walls", "extra", "correctness", "corners"}
    assert comparison.extra_walls == ("x",)
    assert comparison.walls == Score(11, 11, 11, 12)
    assert comparison.corners.recall == 1.0


def test_thicker_wall_counts_where_both_faces_were_measured() -> None:
    truth = demo_house()
    wall = wall_of(truth, 11)
    thicker = box_wall(wall, thickness=0.16)
    comparison = compare(with_walls(truth, {wall.id: thicker}), truth)
    assert defects(comparison) == {"thickness_mm", "p95_mm"}
    assert comparison.thickness_mm == pytest.approx(40.0 / 6)
    assert comparison.faces.p95_mm == pytest.approx(20.0, abs=1e-6)
    guessed = compare(with_walls(truth, {wall.id: replace(thicker, thickness_measured=False)}), truth)
    assert guessed.thickness_mm == pytest.approx(0.0, abs=1e-9)


def test_thinner_wall_is_incorrect_as_well_as_incomplete() -> None:
    truth = demo_house()
    wall = wall_of(truth, 7)
    comparison = compare(with_walls(truth, {wall.id: box_wall(wall, thickness=0.06)}), truth)
    assert defects(comparison) == {"thickness_mm", "completeness", "correctness", "p95_mm", "corners"}
    assert comparison.faces.correctness == pytest.approx(comparison.faces.completeness, abs=0.01)


def test_outer_faces_are_not_asked_for() -> None:
    truth = single_room()
    storey = truth.storeys[0]
    inside = shapely.Polygon(storey.rooms[0].outline.exterior)
    thin = inside.buffer(0.06, join_style="mitre")
    ring = list(inside.buffer(0.03, join_style="mitre").exterior.coords)
    walls = []
    for k, (a, b) in enumerate(itertools.pairwise(ring)):
        body = thin.difference(inside).intersection(shapely.LineString([a, b]).buffer(0.03, cap_style="square"))
        for wall in walls:
            body = body.difference(shapely.Polygon(wall.footprint))
        walls.append(
            replace(
                storey.walls[0],
                id=f"w{k}",
                axis=(a, b),
                thickness=0.06,
                thickness_measured=False,
                openings=(),
                footprint=Outline.from_polygon(body).exterior,
            )
        )
    result = replace(truth, storeys=(replace(storey, walls=tuple(walls)),))
    comparison = compare(result, truth)
    assert defects(comparison) == {"doors", "windows"}
    assert comparison.thickness_mm is None


def test_split_and_merged_walls_are_free() -> None:
    truth = demo_house()
    wall = wall_of(truth, 6)
    (x0, y), (x1, _) = wall.axis
    middle = (x0 + x1) / 2
    footprint = shapely.Polygon(wall.footprint)
    halves = [
        replace(
            wall,
            id=f"half{k}",
            axis=((a, y), (b, y)),
            openings=(),
            footprint=Outline.from_polygon(footprint.intersection(shapely.box(a, -1, b, 20))).exterior,
        )
        for k, (a, b) in enumerate(((x0, middle), (middle, x1)))
    ]
    split = with_walls(truth, {wall.id: halves[0]}, added=(halves[1],))
    comparison = compare(split, truth)
    assert comparison.walls == Score(11, 11, 12, 12)
    assert defects(comparison) == {"doors"}
    assert defects(compare(truth, with_walls(truth, {wall.id: replace(halves[0], openings=wall.openings)}, added=(halves[1],)))) <= {
        "doors"
    }


def storey_changed(building: Building, **change: object) -> Building:
    return replace(building, storeys=(replace(building.storeys[0], **change), *building.storeys[1:]))  # type: ignore[arg-type]


def test_storey_height_and_level() -> None:
    truth = demo_house()
    comparison = compare(storey_changed(truth, height=2.612), truth)
    assert defects(comparison) == {"height_mm"}
    assert comparison.height_mm == pytest.approx(12.0)
    raised = compare(storey_changed(truth, elevation=-0.02), truth)
    assert defects(raised) == {"floor_mm"}
    assert raised.floor_mm == pytest.approx(20.0)


def test_missing_and_extra_storey() -> None:
    truth = two_storeys()
    ground = replace(truth, storeys=truth.storeys[:1])
    missing = compare(ground, truth)
    assert missing.storeys == Score(1, 2, 1, 1)
    assert missing.missing_walls == tuple(wall.id for wall in truth.storeys[1].walls)
    extra = compare(truth, ground)
    assert extra.storeys == Score(1, 1, 1, 2)
    assert extra.extra_walls == missing.missing_walls
    assert extra.rooms_85.precision == 0.5


def test_room_grown_over_its_wall() -> None:
    truth = demo_house()
    rooms = truth.storeys[0].rooms
    guest = rooms[-1]
    grown = replace(guest, outline=Outline.from_polygon(shapely.box(7.96, 0.15, 11.53, 3.5)))
    comparison = compare(storey_changed(truth, rooms=(*rooms[:-1], grown)), truth)
    assert defects(comparison) == {"length_mm"}
    assert comparison.length_mm == pytest.approx(80.0)
    half = replace(guest, outline=Outline.from_polygon(shapely.box(7.96, 0.15, 11.45, 2.2)))
    assert defects(compare(storey_changed(truth, rooms=(*rooms[:-1], half)), truth)) == {"rooms_85"}
    assert defects(compare(storey_changed(truth, rooms=rooms[:2] + rooms[3:]), truth)) >= {"rooms_50", "rooms_85"}


def opening_moved(building: Building, kind: str, shift: float) -> Building:
    storey: Storey = building.storeys[0]
    wall = next(wall for wall in storey.walls if any(o.kind == kind for o in wall.openings))
    moved: list[Opening] = [replace(o, start=o.start + shift) if k == 0 else o for k, o in enumerate(wall.openings)]
    return with_walls(building, {wall.id: replace(wall, openings=tuple(moved))})


@pytest.mark.parametrize(("kind", "figure"), [("door", "doors"), ("window", "windows"), ("opening", "doors")])
def test_opening_must_overlap_by_more_than_half(kind: str, figure: str) -> None:
    truth = demo_house()
    assert defects(compare(opening_moved(truth, kind, 0.2), truth)) == set()
    assert defects(compare(opening_moved(truth, kind, 0.6), truth)) == {figure}


def test_table_and_dict_hold_every_figure() -> None:
    truth = two_storeys()
    comparison = compare(replace(truth, storeys=truth.storeys[:1]), truth)
    table = comparison.table()
    assert "missing walls: s2-wall-01" in table
    assert "extra walls" not in table
    data = comparison.as_dict()
    assert data["walls"]["f1"] == comparison.walls.f1
    assert set(data) == set(Comparison.__slots__)
    empty = compare(replace(truth, storeys=()), replace(truth, storeys=()))
    assert empty.walls.f1 is None
    assert empty.table().count("-\n") >= 7


def test_covered_share_agrees_with_counting() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        intervals = [tuple(sorted(pair)) for pair in rng.integers(0, 100, size=(rng.integers(0, 6), 2)).tolist()]
        cells = np.zeros(100, dtype=bool)
        for start, end in intervals:
            cells[start:end] = True
        assert covered_share(intervals, 100.0) == pytest.approx(cells.mean())
