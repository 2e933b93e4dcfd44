"""Lines, corners and heights of the slope method, and the method as a whole (Remote Sensing 2021, 13, 4930)."""

import numpy as np
import pytest
from clouds import rooms_cloud, tilted

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.pca_levelling import level_by_pca
from indoor_bim.errors import ConfigError, NothingToReconstructError
from indoor_bim.frame import Frame
from indoor_bim.params import Params, preset
from indoor_bim.plan.facing import orient_by_free_space
from indoor_bim.plan.heights import line_heights
from indoor_bim.plan.line_placement import place_on_points
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.skeleton import NO_SLOPE
from indoor_bim.plan.slope_corners import correct_ends, join_corners
from indoor_bim.plan.slope_lines import SlopeLines, find_slope_lines, grow_lines, merge_lines, to_segments
from indoor_bim.plan.support import measure_support
from indoor_bim.slope import slope_stages

ROOM = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (1.5, 4.0), (0.0, 2.5)]


def lines_of(*rows):
    """Lines from (slope, first, last) with one pixel per step."""
    slope, first, last = zip(*rows, strict=True)
    first, last = np.array(first, dtype=float), np.array(last, dtype=float)
    count = np.abs(last - first).max(axis=1).astype(int) + 1
    return SlopeLines(np.array(slope), count, (first + last) / 2 * count[:, None], first, last)


def slopes_image(height, width, *runs):
    image = np.full((height, width), NO_SLOPE, dtype=np.int8)
    for slope, rows, columns in runs:
        image[rows, columns] = slope
    return image


def cloud_of(points):
    origin = points.mean(axis=0).round(2)
    return Cloud(points=points - origin, frame=Frame(origin, np.eye(3), 1.0, np.zeros(3)))


def test_lines_grow_through_equal_slopes_only():
    lines = grow_lines(slopes_image(6, 9, (0, 1, slice(0, 5)), (2, slice(2, 6), 5), (0, 4, slice(7, 9))))
    assert lines.slope.tolist() == [0, 0, 2]
    assert lines.count.tolist() == [5, 2, 4]
    assert lines.first.tolist() == [[0, 1], [7, 4], [5, 2]]
    assert lines.last.tolist() == [[4, 1], [8, 4], [5, 5]]
    assert lines.midpoint.tolist() == [[2, 1], [7.5, 4], [5, 3.5]]


def test_empty_image_has_no_lines():
    assert len(grow_lines(np.full((4, 4), NO_SLOPE, dtype=np.int8))) == 0


def test_short_lines_are_dropped_before_merging():
    image = slopes_image(3, 20, (0, 1, slice(0, 8)), (0, 1, slice(9, 11)), (0, 1, slice(12, 20)))
    assert find_slope_lines(image, min_pixels=3, merge_gap=3, merge_offset=1).count.tolist() == [8, 8]
    assert find_slope_lines(image, min_pixels=1, merge_gap=3, merge_offset=1).count.tolist() == [18]


def test_figure_16_three_pieces_become_one():
    merged = merge_lines(lines_of((0, (0, 0), (9, 0)), (0, (12, 1), (20, 1)), (0, (24, 0), (30, 0))), merge_gap=5, merge_offset=np.inf)
    assert merged.first.tolist() == [[0, 0]]
    assert merged.last.tolist() == [[30, 0]]
    assert merged.count.tolist() == [26]
    assert merged.midpoint[0, 1] == pytest.approx(9 / 26)


def test_gap_slope_and_offset_keep_lines_apart():
    def count(*rows, offset=np.inf):
        return len(merge_lines(lines_of(*rows), merge_gap=5, merge_offset=offset))

    assert count((0, (0, 0), (9, 0)), (0, (14, 0), (20, 0))) == 2
    assert count((0, (0, 0), (9, 0)), (2, (10, 1), (10, 9))) == 2
    assert count((0, (0, 0), (9, 0)), (0, (12, 3), (20, 3))) == 1
    assert count((0, (0, 0), (9, 0)), (0, (12, 3), (20, 3)), offset=2) == 2


def test_merging_does_not_depend_on_the_order_of_lines():
    rng = np.random.default_rng(0)
    starts = rng.integers(0, 200, size=(60, 2)).astype(float)
    lengths = rng.integers(3, 20, size=60)
    slopes = rng.choice([0, 1, -1, 2], size=60)
    step = {0: (1, 0), 1: (1, 1), -1: (1, -1), 2: (0, 1)}
    rows = [(k, s, s + n * np.array(step[k])) for k, s, n in zip(slopes, starts, lengths, strict=True)]

    def result(order):
        merged = merge_lines(lines_of(*(rows[i] for i in order)), merge_gap=12, merge_offset=4)
        return sorted(map(tuple, np.column_stack([merged.slope, merged.count, merged.total, merged.first, merged.last]).tolist()))

    assert result(range(60)) == result(rng.permutation(60))
    assert len(result(range(60))) < 60


@pytest.mark.parametrize("k", [1, -1])
def test_diagonal_end_moves_to_the_foot_of_the_perpendicular(k):
    rng = np.random.default_rng(1)
    ends, midpoint = rng.normal(size=(20, 2)), rng.normal(size=(20, 2))
    direction = np.array([1.0, k]) / np.sqrt(2)
    foot = midpoint + ((ends - midpoint) @ direction)[:, None] * direction
    assert np.allclose(correct_ends(ends, midpoint, np.full(20, k)), foot)


def test_points_on_the_line_stay():
    for k, end in ((0, (9.0, 2.0)), (2, (3.0, 8.0)), (1, (6.0, 5.0)), (-1, (6.0, -1.0))):
        assert correct_ends(np.array([end]), np.array([[3.0, 2.0]]), np.array([k])).tolist() == [list(end)]


def test_horizontal_and_vertical_ends():
    ends, midpoint = np.array([[1.0, 2.0], [1.0, 2.0]]), np.array([[5.0, 7.0], [5.0, 7.0]])
    assert correct_ends(ends, midpoint, np.array([0, 2])).tolist() == [[1.0, 7.0], [5.0, 2.0]]


@pytest.mark.parametrize(
    ("slopes", "ends", "corner"),
    [
        ((0, 2), (((0, 0), (8, 0)), ((9, 1), (9, 7))), (9, 0)),
        ((1, -1), (((0, 0), (4, 4)), ((5, 3.6), (8, 0.6))), (4.3, 4.3)),
        ((0, 1), (((0, 0), (8, 0)), ((9, 1), (12, 4))), (8, 0)),
        ((2, -1), (((0, 0), (0, 8)), ((1, 9), (4, 6))), (0, 10)),
    ],
)
def test_corner_is_the_intersection(slopes, ends, corner):
    p, q = np.array([e[0] for e in ends], dtype=float), np.array([e[1] for e in ends], dtype=float)
    p, q = join_corners(p, q, np.array(slopes), corner_gap=3)
    assert q[0] == pytest.approx(corner)
    assert p[1] == pytest.approx(corner)


def test_parallel_and_distant_ends_do_not_meet():
    p, q = np.array([[0.0, 0.0], [9.0, 1.0]]), np.array([[8.0, 0.0], [15.0, 1.0]])
    assert np.array_equal(join_corners(p, q, np.array([0, 0]), corner_gap=3)[1], q)
    p, q = np.array([[0.0, 0.0], [9.0, 4.0]]), np.array([[8.0, 0.0], [9.0, 9.0]])
    assert np.array_equal(join_corners(p, q, np.array([0, 2]), corner_gap=3)[1], q)


def test_to_segments_restores_metres():
    raster = Raster(np.zeros((40, 40), dtype=bool), np.array([100.0, 50.0]), 0.1)
    segments = to_segments(lines_of((0, (0, 0), (20, 0)), (2, (22, 1), (22, 30))), raster, corner_gap=5)
    assert segments.p == pytest.approx(np.array([[100.05, 50.05], [102.25, 50.05]]))
    assert segments.q == pytest.approx(np.array([[102.25, 50.05], [102.25, 53.05]]))


def test_lines_move_to_the_median_of_their_points():
    raster = Raster(np.zeros((40, 100), dtype=bool), np.zeros(2), 0.02)
    rng = np.random.default_rng(2)
    xy = np.column_stack([rng.uniform(0.1, 1.9, 2000), 0.413 + rng.normal(scale=0.004, size=2000)])
    xy = np.concatenate([xy, np.column_stack([rng.uniform(0.1, 1.9, 300), rng.uniform(0.42, 0.47, 300)])])
    placed = place_on_points(lines_of((0, (5, 21), (94, 21))), raster, xy, reach=0.06)
    assert (placed.midpoint[0, 1] + 0.5) * 0.02 == pytest.approx(0.4137, abs=0.001)
    assert placed.midpoint[0, 0] == 49.5


def test_height_is_the_largest_near_the_midpoint():
    xy = np.array([[0.0, 0.0], [0.02, 0.0], [0.5, 0.0]])
    z = np.array([1.0, 2.1, 2.9])
    assert line_heights(np.array([[0.0, 0.0]]), xy, z, radius=0.1, storey_height=2.5).tolist() == [2.1]
    assert line_heights(np.array([[0.0, 0.0]]), xy, z, radius=0.1, storey_height=2.2).tolist() == [2.2]
    assert line_heights(np.array([[0.3, 0.0]]), xy, z, radius=0.1).tolist() == [2.9]
    assert np.isnan(line_heights(np.array([[0.3, 0.0]]), xy[:0], z[:0], radius=0.1)).all()


def test_support_counts_what_lies_on_the_face():
    u, z = np.meshgrid(np.arange(0.05, 2, 0.1), np.arange(0.05, 1, 0.1))
    points = np.column_stack([u.ravel(), np.where(np.arange(u.size) % 2, 0.01, -0.01), z.ravel()])
    faces = Segments.from_ends([[2.0, 0.0], [0.0, 0.0], [0.0, 1.0]], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    measured = measure_support(faces, points, reach=0.02, height=2.0)
    assert measured.support.tolist() == [200, 100, 0]
    assert measured.rmse[:2] == pytest.approx(0.01)
    assert measured.coverage == pytest.approx([0.5, 0.5, 0.0])


def test_free_space_lies_to_the_left():
    free = Raster(np.zeros((60, 60), dtype=bool), np.zeros(2), 0.05)
    free.image[20:40, 20:40] = True
    square = np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]])
    for faces in (
        Segments.from_ends(square, np.roll(square, -1, axis=0)),
        Segments.from_ends(np.roll(square, -1, axis=0), square),
    ):
        turned = orient_by_free_space(faces, free)
        assert turned.sided.all()
        assert np.array_equal(turned.p, square)
    inside = orient_by_free_space(Segments.from_ends([[1.5, 1.3]], [[1.5, 1.7]]), free)
    assert not inside.sided.any()


@pytest.mark.parametrize(("tilt", "yaw"), [(0.0, 0.0), (17.0, 35.0), (8.0, -100.0)])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_room_with_a_diagonal_wall_comes_out_whole(tilt, yaw, noise):
    scan = tilted(rooms_cloud(ROOM, noise=noise), tilt=tilt, yaw=yaw)
    levelled = level_by_pca(cloud_of(scan))
    faces = slope_stages(levelled).segments
    lengths = sorted(faces.length[faces.length > 0.5])
    assert lengths == pytest.approx([1.5 * np.sqrt(2), 2.5, 4.0, 4.5, 6.0], abs=0.06)
    long = faces.take(faces.length > 0.5)
    assert long.sided.all()
    assert long.top == pytest.approx(2.5, abs=0.01)
    assert np.nanmax(long.rmse) < 0.02
    assert (long.coverage > 0.8).all()
    size = np.ptp(np.concatenate([long.p, long.q]), axis=0)
    assert sorted(size) == pytest.approx([4.0, 6.0], abs=0.01)


def test_two_faces_of_a_thin_wall_stay_two():
    rooms = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)], [(3.12, 0.0), (6.0, 0.0), (6.0, 3.0), (3.12, 3.0)]
    faces = slope_stages(level_by_pca(cloud_of(rooms_cloud(*rooms, noise=0.01)))).segments
    middle = (faces.p + faces.q)[:, 0] / 2
    between = faces.take((np.abs(faces.direction[:, 0]) < 0.01) & (faces.length > 2) & (np.abs(middle - middle.mean()) < 1))
    assert len(between) == 2
    assert np.ptp(between.p[:, 0]) == pytest.approx(0.12, abs=0.005)
    assert between.normal[0] @ between.normal[1] == pytest.approx(-1)


def test_result_does_not_depend_on_the_order_of_points():
    points = cloud_of(tilted(rooms_cloud(ROOM, noise=0.01), tilt=10, yaw=20)).points
    order = np.random.default_rng(3).permutation(len(points))
    first, second = (slope_stages(level_by_pca(Cloud(points=p))).segments for p in (points, points[order]))
    for name in Segments.__slots__:
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes(), name


def test_scan_far_from_the_origin_gives_the_same_faces():
    scan = tilted(rooms_cloud(ROOM, noise=0.01), tilt=10, yaw=20)
    near, far = (slope_stages(level_by_pca(cloud_of(scan + shift))).segments for shift in (0.0, [500_000.0, 5_800_000.0, 300.0]))
    assert near.p == pytest.approx(far.p, abs=1e-4)
    assert near.q == pytest.approx(far.q, abs=1e-4)


def test_preset_of_the_published_room_finds_the_room():
    chosen = preset("paper-room").slope
    levelled = level_by_pca(cloud_of(tilted(rooms_cloud(ROOM, spacing=0.02, noise=0.01), tilt=17, yaw=10)), grid_count=chosen.grid_count)
    faces = slope_stages(levelled, **chosen.model_dump(exclude={"grid_count"})).segments
    size = np.ptp(np.concatenate([faces.p, faces.q]), axis=0)
    assert sorted(size) == pytest.approx([4.0, 6.0], abs=0.06)


def test_presets_are_those_of_table_5():
    names = ("grid_count", "gror_radius", "gror_neighbours", "magnification", "merge_gap", "corner_gap")
    table = {
        "paper-room": (200, 0.01, 10, 100, 10, 40),
        "paper-floor": (600, 0.03, 10, 10, 5, 8),
        "paper-rooms": (300, 0.03, 10, 10, 15, 5),
    }
    for name, values in table.items():
        assert tuple(getattr(preset(name).slope, field) for field in names) == values
        assert preset(name).walls == Params().walls
    with pytest.raises(ConfigError, match="paper-room"):
        preset("paper-house")


def test_no_walls_dense_enough_is_an_error():
    levelled = level_by_pca(cloud_of(rooms_cloud(ROOM)))
    with pytest.raises(NothingToReconstructError, match="5000 others within"):
        slope_stages(levelled, gror_neighbours=5000, gror_radius=0.01)
