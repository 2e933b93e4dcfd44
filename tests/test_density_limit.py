"""Which points stay when there are too many: by what they are, wherever and in whatever order they come."""

import numpy as np
import pytest

from indoor_bim.cloud import density, las_sample
from indoor_bim.cloud.density import DensitySample
from indoor_bim.cloud.density_limit import MOST_PER_CUBE, DensityLimit, kept_rows
from indoor_bim.cloud.las import LasFile
from indoor_bim.cloud.las_sample import sample_las
from indoor_bim.cloud.read import read
from indoor_bim.cloud.write import write_las
from indoor_bim.errors import ReadError
from indoor_bim.params import ReadParams


def dense_points(count=60_000, seed=0):
    """A wall that is dense in the middle, 3 cm rough, and a thin cloud around it, in millimetres."""
    rng = np.random.default_rng(seed)
    wall = np.column_stack([rng.normal(2000, 400, count), rng.normal(1000, 30, count), rng.uniform(0, 2500, count)])
    return np.rint(np.vstack([wall, rng.uniform(-500, 4500, (count // 10, 3))])).astype(np.int32)


def sampled(steps, *, per_cube=32, points=10**9, pieces=1):
    kind = np.dtype([("row", np.int64)])
    sample = DensitySample(side=(100, 100, 100), limit=DensityLimit(per_cube, points, least_per_cube=1), kind=kind)
    rows = np.arange(len(steps))
    for part in np.array_split(rows, pieces):
        sample.add(steps[part], part.view(kind))
    kept = sample.kept()
    row = sample.attribute("row", kept)
    assert np.array_equal(sample.steps(kept), steps[row])
    return row, sample.most


def mixed(steps):
    """Twin of the hash, one step of plain whole numbers after the other."""
    word, mask = 0, 2**64 - 1
    x, y, z = (int(value) & mask for value in steps)
    word = x * 0x9E3779B97F4A7C15 & mask
    word ^= word >> 32
    word = (word ^ y) * 0xC2B2AE3D27D4EB4F & mask
    word ^= word >> 29
    word = (word ^ z) * 0x165667B19E3779F9 & mask
    word ^= word >> 32
    return (word * 0x9E3779B97F4A7C15 & mask) >> 32


def test_kept_points_are_those_of_a_plain_count():
    steps = dense_points(6000)
    words = np.array([mixed(row) for row in steps])
    cubes, member = np.unique(steps // 100, axis=0, return_inverse=True)
    halvings = np.zeros(len(cubes), dtype=int)
    for cube in range(len(cubes)):
        while (words[member == cube] < 2.0 ** (32 - halvings[cube])).sum() > 8:
            halvings[cube] += 1
    around = np.array([halvings[(np.abs(cubes - cube) <= 1).all(axis=1)].max() for cube in cubes])
    assert around.max() >= 2
    assert np.array_equal(sampled(steps, per_cube=8)[0], np.flatnonzero(words < 2.0 ** (32 - around[member])))


@pytest.mark.parametrize("points", [10**9, 16_000])
def test_neither_order_nor_pieces_matter(points):
    steps = dense_points()
    rows, most = sampled(steps, points=points)
    shuffled = np.random.default_rng(1).permutation(len(steps))
    for order, pieces in ((np.arange(len(steps)), 7), (shuffled, 1), (shuffled[::-1], 13)):
        again, again_most = sampled(steps[order], points=points, pieces=pieces)
        assert most == again_most
        assert np.array_equal(np.sort(order[again]), rows)


@pytest.mark.parametrize("points", [10**9, 60_000])
def test_little_room_at_first_changes_nothing(monkeypatch, points):
    steps = np.vstack([dense_points(), np.random.default_rng(4).integers(0, 9000, (40_000, 3))]).astype(np.int32)
    roomy = sampled(steps, points=points)
    for name in ("LEAST_ROOM", "MOST_ROOM", "FIRST_LINES"):
        monkeypatch.setattr(density, name, 1 << 10)
    narrow = sampled(steps, points=points, pieces=9)
    assert roomy[1] == narrow[1]
    assert np.array_equal(roomy[0], narrow[0])


def test_there_are_never_more_points_than_allowed():
    steps = dense_points()
    rows, most = sampled(steps, points=16_000)
    assert most < 32
    assert 4000 < len(rows) <= 16_000
    row_count = np.unique(steps[rows] // 100, axis=0, return_counts=True)[1]
    assert row_count.max() <= most


def test_thin_clouds_stay_whole():
    steps = np.random.default_rng(2).integers(0, 20_000, (50_000, 3)).astype(np.int32)
    assert np.array_equal(sampled(steps)[0], np.arange(len(steps)))


def test_a_wall_keeps_its_place_and_its_roughness():
    steps = dense_points(400_000)[:400_000]
    kept = steps[sampled(steps, per_cube=16)[0]]
    middle = np.abs(steps[:, 0] - 2000) < 300
    thinned = np.abs(kept[:, 0] - 2000) < 300
    assert thinned.sum() < 0.2 * middle.sum()
    sigma = 30 / np.sqrt(thinned.sum())
    assert abs(kept[thinned, 1].mean() - 1000) < 4 * sigma
    assert kept[thinned, 1].std() == pytest.approx(30, rel=0.03)


def test_cubes_grow_where_even_few_points_each_are_too_many():
    points = np.random.default_rng(3).uniform(0, 3, (30_000, 3))
    rows, most = kept_rows(points, limit=DensityLimit(64, 2000), metres=1.0)
    assert most >= 16
    assert 300 < len(rows) <= 2000


def test_files_and_clouds_in_memory_are_thinned_alike(tmp_path):
    points = dense_points() / 1000.0
    path = tmp_path / "scan.laz"
    time = np.arange(len(points)) + 1.0
    write_las(path, points, gps_time=time, classification=np.full(len(points), 6))
    limit = DensityLimit(32, 10**9)
    raw = sample_las(path, limit=limit)
    whole = read(path)
    assert raw.per_cube == 32
    assert 1000 < len(raw.points) < 0.6 * len(points)
    np.testing.assert_allclose(raw.points, points[raw.gps_time.astype(int) - 1], atol=1e-9)
    thinned = read(path, limit=limit)
    assert thinned.derived == {"read.per_cube": 32}
    assert np.array_equal(thinned.gps_time, raw.gps_time)
    assert (thinned.classification == 6).all()
    few = read(path, limit=DensityLimit(32, 10**9, above=len(points)))
    assert few.derived == {}
    assert np.array_equal(few.points, whole.points)
    xyz = tmp_path / "scan.xyz"
    np.savetxt(xyz, points, fmt="%.3f")
    from_text = read(xyz, limit=limit)
    assert from_text.derived == {"read.per_cube": 32}
    assert 0.8 < len(from_text) / len(thinned) < 1.25


def test_memory_asked_for_is_in_the_parameters_of_the_run(tmp_path):
    from indoor_bim.cli.parameters import gigabytes
    from indoor_bim.cloud.density_limit import limit_for
    from indoor_bim.errors import ConfigError

    assert limit_for(per_cube=None, max_memory=None).above == 4_000_000
    assert limit_for(per_cube=10, max_memory=None).above == 0
    assert limit_for(per_cube=None, max_memory=gigabytes("1GB")).points < limit_for(per_cube=None, max_memory=2.0).points
    with pytest.raises(ConfigError, match="such as 2GB"):
        gigabytes("much")


def test_more_points_of_a_cube_than_can_be_counted_cannot_be_asked_for():
    assert {bound.le for bound in ReadParams.model_fields["per_cube"].metadata if hasattr(bound, "le")} == {MOST_PER_CUBE}
    cube = np.random.default_rng(6).integers(0, 100, (2 * MOST_PER_CUBE, 3)).astype(np.int32)
    rows, most = sampled(cube, per_cube=10**6)
    assert most == MOST_PER_CUBE
    assert 0.2 * MOST_PER_CUBE < len(rows) <= MOST_PER_CUBE


def test_pieces_of_a_file_keep_the_same_points(tmp_path, monkeypatch):
    path = tmp_path / "scan.laz"
    points = dense_points() / 1000.0
    write_las(path, points, gps_time=np.arange(len(points)) + 1.0, intensity=np.arange(len(points)) % 999)
    limit = DensityLimit(32, 10**9)
    whole = sample_las(path, limit=limit)
    monkeypatch.setattr(las_sample, "PIECE", 5000)
    pieces = sample_las(path, limit=limit)
    for name in ("points", "gps_time", "intensity"):
        assert np.array_equal(getattr(whole, name), getattr(pieces, name))
    np.testing.assert_allclose(pieces.points, points[pieces.gps_time.astype(int) - 1], atol=1e-9)


def test_what_goes_wrong_while_a_piece_is_thinned_is_named(tmp_path, monkeypatch):
    path = tmp_path / "scan.laz"
    write_las(path, dense_points(6000) / 1000.0)
    whole = LasFile.records

    def cut_short(file, **options):
        yield from whole(file, **options)
        raise OSError("failed to fill whole buffer")

    monkeypatch.setattr(LasFile, "records", cut_short)
    with pytest.raises(ReadError, match=r"scan\.laz: the LAS/LAZ file is damaged or cut short \(failed to fill whole buffer\)"):
        sample_las(path, limit=DensityLimit(8, 10**9))
    monkeypatch.setattr(LasFile, "records", whole)
    monkeypatch.setattr(DensitySample, "_make_room", lambda *_: 1 / 0)
    with pytest.raises(ReadError, match=r"scan\.laz"):
        sample_las(path, limit=DensityLimit(8, 10**9))
