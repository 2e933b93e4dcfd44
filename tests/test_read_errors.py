"""Bad input: one clear message each, which names the file, what was found and what to do."""

import contextlib

import numpy as np
import pytest
from test_read import box_points, pcd_header, text_rows

from indoor_bim.cloud.read import as_cloud, read, read_trajectory
from indoor_bim.cloud.write import write_las, write_ply
from indoor_bim.errors import ReadError, WriteError

PNG = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(range(256)) * 4
PLY_HEAD = b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\nend_header\n"

BAD_BYTES = [
    ("scan.las", b"", "empty"),
    ("scan.las", PNG, "no LAS signature"),
    ("scan.laz", PNG, "no LAS signature"),
    ("scan.las", b"LASF" + bytes(400), "damaged"),
    ("scan.ply", PNG, "no PLY signature"),
    ("scan.pcd", PNG, "no PCD header"),
    ("scan.xyz", PNG, "binary data"),
    ("scan.csv", PNG, "binary data"),
    ("scan.pts", PNG, "binary data"),
    ("scan.e57", PNG, "no E57 signature"),
    ("scan.e57", b"ASTM-E57" + bytes(100), "damaged"),
    ("scan.png", PNG, r"extension '\.png'.*\.laz"),
    ("scan", b"1 2 3\n", r"extension '\(none\)'"),
    ("scan.xyz", b"x y z\n", "expected x, y, z"),
    ("scan.xyz", b"1 2\n3 4\n", "expected x, y, z"),
    ("scan.xyz", b"1 2 3\n4 5 6\n7 eight 9\n", "line 3.*'eight'"),
    ("scan.xyz", b"# head\n1 2 3\n4 5\n", "line 3|columns change"),
    ("scan.xyz", b"1 2 3\n", "single point"),
    ("scan.xyz", b"1 2 3\n1 2 3\n1 2 3\n", "3 points that are all equal"),
    ("scan.xyz", b"nan nan nan\ninf 2 3\n", "no point with finite coordinates among 2"),
    ("scan.pts", b"5\n1 2 3\n4 5 6\n", "2 of 5"),
    ("scan.pts", b"0\n", "0 points"),
    ("scan.pcd", pcd_header(2, "binary") + bytes(30), "1 of 2"),
    ("scan.pcd", pcd_header(0, "binary"), "0 points"),
    ("scan.pcd", pcd_header(2, "zipped"), "zipped"),
    ("scan.pcd", pcd_header(2, "binary_compressed") + b"\x10\0\0\0\x30\0\0\0abc", "of 2"),
    ("scan.pcd", pcd_header(2, "ascii").replace(b"FIELDS x y z", b"FIELDS a b c") + b"1 2 3\n4 5 6\n", "no usable fields"),
    ("scan.ply", PLY_HEAD + bytes(30), "1 of the 2"),
    ("scan.ply", PLY_HEAD.replace(b"vertex 2", b"vertex 0"), "0 points"),
    ("scan.ply", PLY_HEAD.replace(b"double y", b"double w") + bytes(48), "no vertices with x, y and z"),
    ("scan.ply", PLY_HEAD.replace(b"double y", b"quad y") + bytes(48), "property quad y"),
    ("scan.ply", PLY_HEAD.replace(b"binary_little_endian", b"morse") + bytes(48), "no known format"),
    (
        "scan.ply",
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
        "1 of the 3",
    ),
]


@pytest.mark.parametrize(("name", "content", "message"), BAD_BYTES, ids=[f"{i}-{case[0]}" for i, case in enumerate(BAD_BYTES)])
def test_bad_files(tmp_path, capfd, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ReadError, match=message) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert "expected" in str(caught.value) or "copy" in str(caught.value) or "export" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("share", [0.02, 0.2, 0.5, 0.9, 0.999])
@pytest.mark.parametrize("name", ["scan.laz", "scan.las"])
def test_cut_short_las(tmp_path, name, share, capfd):
    write_las(tmp_path / "whole.las", box_points(count=200_000)) if name.endswith("las") else write_las(
        tmp_path / "whole.laz", box_points(count=200_000)
    )
    whole = (tmp_path / f"whole{name[-4:]}").read_bytes()
    path = tmp_path / name
    path.write_bytes(whole[: int(len(whole) * share)])
    with pytest.raises(ReadError, match="damaged or cut short"):
        read(path)
    assert capfd.readouterr() == ("", "")


def test_laz_with_damaged_bytes_never_ends_in_a_traceback(tmp_path):
    write_las(tmp_path / "scan.laz", box_points(count=30_000))
    whole = (tmp_path / "scan.laz").read_bytes()
    for place in (90, 100, 110, 230, 300, 380, 420, len(whole) // 2):
        damaged = bytearray(whole)
        damaged[place : place + 8] = b"\xff" * 8
        (tmp_path / "scan.laz").write_bytes(damaged)
        with contextlib.suppress(ReadError):
            read(tmp_path / "scan.laz")


def test_no_such_file_and_folder(tmp_path):
    with pytest.raises(ReadError, match="no such file"):
        read(tmp_path / "nothing.laz")
    with pytest.raises(ReadError, match="found a folder"):
        read(tmp_path)


def test_las_of_no_points(tmp_path):
    write_las(tmp_path / "scan.laz", np.zeros((0, 3)))
    with pytest.raises(ReadError, match="0 points"):
        read(tmp_path / "scan.laz")


@pytest.mark.parametrize(
    ("scan", "message"),
    [
        (np.zeros((0, 3)), "0 points"),
        (np.ones((1, 3)), "single point"),
        (np.ones((5, 3)), "all equal"),
        (np.full((5, 3), np.nan), "no point with finite"),
        (np.zeros((5, 2)), "2 coordinates"),
        (np.zeros(5), r"shape \(n, 3\)"),
        ("text", "no such file"),
        (object(), "shape|float"),
    ],
)
def test_bad_arrays(scan, message):
    with pytest.raises(ReadError, match=message):
        as_cloud(scan)


def test_flat_cloud_passes():
    points = box_points()
    points[:, 2] = 0.0
    assert np.ptp(as_cloud(points).points[:, 2]) == 0.0


PATH_ROWS = np.array([[0.0, 1.0, 2.0, 3.0], [0.5, 1.5, 2.5, 3.5]])


@pytest.mark.parametrize("head", ["", "t{d}x{d}y{d}z\n", "# t{d}x{d}y{d}z\n", "Time [s]{d}X [m]{d}Y [m]{d}Z [m]\n"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_trajectory_layouts(tmp_path, head, delimiter):
    path = tmp_path / "path.csv"
    path.write_text(head.format(d=delimiter) + text_rows(PATH_ROWS[::-1], delimiter=delimiter))
    assert np.array_equal(read_trajectory(path), PATH_ROWS)


def test_trajectory_by_white_space_and_by_name(tmp_path):
    path = tmp_path / "path.txt"
    path.write_text(text_rows(PATH_ROWS))
    assert np.array_equal(read_trajectory(path), PATH_ROWS)
    path.write_text(text_rows(PATH_ROWS[:, 1:]))
    assert np.array_equal(read_trajectory(path)[:, 1:], PATH_ROWS[:, 1:])
    assert np.isnan(read_trajectory(path)[:, 0]).all()
    path.write_text("x y z qw time\n1 2 3 1 0\n1.5 2.5 3.5 1 0.5\n")
    assert np.array_equal(read_trajectory(path), PATH_ROWS)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("t,x,y,z\n0,1,2,3\n1,2,x,3\n", "line 3.*'x'"),
        ("0,1\n1,2\n", "expected the columns t, x, y, z"),
        ("", "expected the columns"),
        ("0,1,2,3,4\n", "5 columns without names"),
        ("t,x,y,z\n0,1,nan,3\n", "row 1 .*not finite"),
    ],
)
def test_bad_trajectories(tmp_path, content, message):
    path = tmp_path / "path.csv"
    path.write_text(content)
    with pytest.raises(ReadError, match=message) as caught:
        read_trajectory(path)
    assert str(path) in str(caught.value)
    with pytest.raises(ReadError, match="no such trajectory"):
        read_trajectory(tmp_path / "none.csv")


def test_trajectory_beside_the_scan_goes_through_the_same_frame(tmp_path):
    points = box_points() + np.array([1000.0, 2000.0, 0.0])
    write_ply(tmp_path / "scan.ply", points * 1000)
    (tmp_path / "trajectory.csv").write_text("t,x,y,z\n" + text_rows(np.hstack([[[0.0]], points[:1] * 1000]), delimiter=","))
    cloud = read(tmp_path / "scan.ply", unit="mm")
    assert cloud.trajectory[0, 1:] == pytest.approx(cloud.points[0], abs=1e-9)
    assert read(tmp_path / "scan.ply", trajectory=False).trajectory is None
    other = as_cloud(points * 1000, unit="mm", trajectory=points[:3] * 1000)
    assert other.trajectory[:, 1:] == pytest.approx(other.points[:3], abs=1e-9)
    with pytest.raises(ReadError, match="expected \\(m, 4\\)"):
        as_cloud(points, trajectory=np.zeros((3, 7)))


def test_unwritable_places_leave_nothing_behind(tmp_path):
    with pytest.raises(WriteError, match="cannot be written"):
        write_las(tmp_path / "no" / "scan.laz", box_points())
    with pytest.raises(WriteError, match="finite points"):
        write_las(tmp_path / "scan.laz", np.full((2, 3), np.nan))
    with pytest.raises(WriteError, match="larger steps"):
        write_las(tmp_path / "scan.laz", [[0, 0, 0], [1e7, 0, 0]])
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(WriteError, match="cannot be written"):
        write_ply(tmp_path / "folder.ply", box_points())
    assert [path.name for path in tmp_path.iterdir()] == ["folder.ply"]
