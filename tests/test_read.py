"""One scan in every format: nothing lost, whatever the offset and the order of the points."""

import subprocess
import sys

import laspy
import numpy as np
import pytest

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.density_limit import DensityLimit
from indoor_bim.cloud.las import iterate_chunks
from indoor_bim.cloud.raw import as_intensity
from indoor_bim.cloud.read import as_cloud, read
from indoor_bim.cloud.scan_info import info
from indoor_bim.cloud.write import write_las, write_ply
from indoor_bim.errors import ReadError

UTM = np.array([412_345.678, 5_812_345.123, 34.5])


def box_points(*, seed=0, size=(8.0, 6.0, 3.0), count=4000):
    """Points on floor, ceiling and four walls of a box."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 1, (count, 3))
    face = rng.integers(0, 6, count)
    points[np.arange(count), face // 2] = face % 2
    return points * size


def pcd_header(count, kind, size=8):
    return (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE {size} {size} {size}\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {kind}\n"
    ).encode()


def text_rows(points, *, delimiter=" ", extra=""):
    return "".join(delimiter.join(f"{value!r}" for value in row) + extra + "\n" for row in points.tolist())


def write_scan(path, points, kind):
    n = len(points)
    if kind == "ply":
        write_ply(path, points)
    elif kind == "ply-ascii":
        head = f"ply\nformat ascii 1.0\nelement vertex {n}\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
        path.write_text(head + text_rows(points))
    elif kind == "ply-big":
        head = f"ply\nformat binary_big_endian 1.0\nelement camera 1\nproperty float f\nelement vertex {n}\n"
        head += "property uchar red\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
        table = np.zeros(n, dtype=[("red", "u1"), ("x", ">f8"), ("y", ">f8"), ("z", ">f8")])
        table["x"], table["y"], table["z"] = points.T
        path.write_bytes(head.encode() + b"\0\0\0\0" + table.tobytes())
    elif kind == "pcd":
        path.write_bytes(pcd_header(n, "binary") + points.astype("<f8").tobytes())
    elif kind == "pcd-ascii":
        path.write_bytes(pcd_header(n, "ascii") + text_rows(points).encode())
    elif kind == "xyz":
        path.write_text(text_rows(points, extra=" 255 0 7"))
    elif kind == "xyz-header":
        path.write_text("//X Y Z R\n" + text_rows(points, extra=" 255"))
    elif kind == "csv":
        path.write_text("time,x,y,z\n" + "".join(f"{i},{x!r},{y!r},{z!r}\n" for i, (x, y, z) in enumerate(points.tolist())))
    elif kind == "asc-comma":
        path.write_text("x;y;z\n" + text_rows(points, delimiter=";").replace(".", ","))
    elif kind == "txt-tab":
        path.write_text("# a comment\n\n" + text_rows(points, delimiter="\t"))
    elif kind == "pts":
        path.write_text(f"{n}\n" + text_rows(points, extra=" -100 1 2 3"))
    elif kind == "pts-blocks":
        path.write_text(f"{n - 5}\n{text_rows(points[:-5])}5\n{text_rows(points[-5:])}")


EXACT = {
    "ply": "scan.ply",
    "ply-ascii": "scan.ply",
    "ply-big": "scan.PLY",
    "pcd": "scan.pcd",
    "pcd-ascii": "scan.pcd",
    "xyz": "scan.xyz",
    "xyz-header": "scan.txt",
    "csv": "scan.csv",
    "asc-comma": "scan.asc",
    "txt-tab": "scan.txt",
    "pts": "scan.pts",
    "pts-blocks": "scan.pts",
}


@pytest.mark.parametrize("kind", EXACT)
def test_formats_of_doubles_lose_nothing_at_utm_coordinates(tmp_path, kind):
    points = box_points() + UTM
    path = tmp_path / EXACT[kind]
    write_scan(path, points, kind)
    cloud = read(path)
    assert len(cloud) == len(points)
    assert np.abs(cloud.points + (cloud.frame.origin - UTM) - (points - UTM)).max() < 2e-9
    assert np.array_equal(cloud.frame.origin, np.round(cloud.frame.origin))
    assert np.abs(cloud.points).max() < 5
    assert cloud.source == path.name
    assert cloud.warnings == ()


@pytest.mark.parametrize("name", ["scan.las", "scan.laz"])
def test_las_keeps_coordinates_time_classes_and_intensity(tmp_path, name):
    points = np.round(box_points() + UTM, 3)
    time, classes, intensity = np.arange(len(points)) * 0.01, np.arange(len(points)) % 7, np.arange(len(points)) * 9
    write_las(tmp_path / name, points, gps_time=time, classification=classes, intensity=intensity)
    cloud = read(tmp_path / name)
    assert np.abs(cloud.frame.to_scan(cloud.points) - points).max() < 2e-9
    assert np.array_equal(cloud.gps_time, time)
    assert np.array_equal(cloud.classification, classes)
    assert np.array_equal(cloud.intensity, intensity)


def test_las_without_time_and_classes(tmp_path):
    write_las(tmp_path / "scan.laz", box_points())
    cloud = read(tmp_path / "scan.laz")
    assert cloud.gps_time is None
    assert cloud.classification is None
    assert cloud.intensity is None


def test_las_of_several_chunks_reports_progress(tmp_path, monkeypatch):
    monkeypatch.setattr("indoor_bim.cloud.las.CHUNK", 1500)
    points = np.round(box_points(), 3)
    write_las(tmp_path / "scan.laz", points)
    shares = []
    cloud = read(tmp_path / "scan.laz", progress=shares.append)
    assert shares == [0.375, 0.75, 1.0]
    assert np.abs(cloud.frame.to_scan(cloud.points) - points).max() < 1e-9


@pytest.mark.parametrize(
    ("wkt", "crs", "metres"),
    [
        (
            'PROJCS["UTM 32N",GEOGCS["g",UNIT["degree",0.017],AUTHORITY["EPSG","4258"]],UNIT["metre",1],AUTHORITY["EPSG","25832"]]',
            25832,
            1.0,
        ),
        (
            'COMPD_CS["both",PROJCS["a",UNIT["m",1],AUTHORITY["EPSG","25833"]],VERT_CS["h",AUTHORITY["EPSG","7837"]],AUTHORITY["EPSG","5555"]]',
            25833,
            1.0,
        ),
        (
            'PROJCRS["x",BASEGEOGCRS["b",ID["EPSG",4269]],LENGTHUNIT["ft",0.304800609601219],ID["EPSG",2263]]',
            2263,
            1200 / 3937,
        ),
    ],
)
def test_las_reference_from_wkt(tmp_path, wkt, crs, metres):
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales = np.full(3, 0.001)
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(wkt))
    las = laspy.LasData(header)
    las.xyz = box_points()
    las.write(tmp_path / "scan.laz")
    cloud = read(tmp_path / "scan.laz")
    assert cloud.crs == f"EPSG:{crs}"
    assert cloud.frame.scale == pytest.approx(metres)
    assert bool(cloud.warnings) == (metres != 1.0)
    assert read(tmp_path / "scan.laz", crs="EPSG:31467", unit="m").crs == "EPSG:31467"


def test_las_reference_from_geotiff_keys(tmp_path):
    header = laspy.LasHeader(version="1.2", point_format=1)
    header.scales = np.full(3, 0.001)
    keys = np.array([1, 1, 0, 2, 3072, 0, 1, 25832, 3076, 0, 1, 9001], dtype="<u2")
    header.vlrs.append(laspy.VLR("LASF_Projection", 34735, "", keys.tobytes()))
    las = laspy.LasData(header)
    las.xyz = box_points()
    las.write(tmp_path / "scan.las")
    assert read(tmp_path / "scan.las").crs == "EPSG:25832"


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("point_format", [0, 1, 3, 6, 7, 8])
@pytest.mark.parametrize("limit", [None, DensityLimit(64, 10**9)])
def test_attributes_of_every_point_format(tmp_path, suffix, point_format, limit):
    header = laspy.LasHeader(version="1.4" if point_format > 5 else "1.2", point_format=point_format)
    header.scales = np.full(3, 0.001)
    header.add_extra_dim(laspy.ExtraBytesParams("room", "uint16"))
    las = laspy.LasData(header)
    las.xyz = points = box_points()
    las.classification = np.arange(len(points)) % 20
    las.synthetic = np.arange(len(points)) % 2  # shares its byte with the class in the old formats
    las.intensity = np.arange(len(points)) * 7
    las["room"] = np.arange(len(points))
    if point_format:
        las.gps_time = 3.0 * np.arange(len(points)) + 1
    path = tmp_path / f"scan.{suffix}"
    las.write(path)
    cloud = read(path, limit=limit)
    assert np.abs(cloud.frame.to_scan(cloud.points) - points).max() < 1e-3
    assert np.array_equal(cloud.classification, las.classification)
    assert np.array_equal(cloud.intensity, las.intensity)
    assert cloud.gps_time is None if not point_format else np.array_equal(cloud.gps_time, las.gps_time)


def test_intensity_comes_from_ply_and_e57(tmp_path):
    points = np.random.default_rng(2).uniform(0, 3, (50, 3))
    strength = np.linspace(0, 1, 50)
    rows = "\n".join(" ".join(map(str, [*point, value])) for point, value in zip(points, strength, strict=True))
    columns = "".join(f"property double {name}\n" for name in ("x", "y", "z", "scalar_Intensity"))
    (tmp_path / "a.ply").write_text(f"ply\nformat ascii 1.0\nelement vertex 50\n{columns}end_header\n{rows}\n")
    expected = np.rint(strength * 65535).astype(np.uint16)
    assert np.array_equal(read(tmp_path / "a.ply").intensity, expected)
    pye57 = pytest.importorskip("pye57")
    data = {"cartesianX": points[:, 0], "cartesianY": points[:, 1], "cartesianZ": points[:, 2]}
    with pye57.E57(str(tmp_path / "a.e57"), mode="w") as file:
        file.write_scan_raw({**data, "intensity": strength})
    assert np.abs(read(tmp_path / "a.e57").intensity.astype(int) - expected).max() <= 1
    with pye57.E57(str(tmp_path / "b.e57"), mode="w") as file:
        file.write_scan_raw({**data, "intensity": strength})
        file.write_scan_raw(data)
    assert read(tmp_path / "b.e57").intensity is None


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([3, 5, 65535], [3, 5, 65535]),
        ([0, 131070], [0, 65535]),
        ([-2.0, 0.0, 2.0], [0, 2, 4]),
        ([np.nan, 0.5, 1.0], [0, 32768, 65535]),
    ],
)
def test_intensity_in_16_bits(values, expected):
    assert as_intensity(np.array(values)).tolist() == expected


@pytest.mark.parametrize("values", [[7.0, 7.0], [np.nan, np.inf]])
def test_intensity_that_tells_nothing(values):
    assert as_intensity(np.array(values)) is None


def test_e57_applies_poses_of_all_scans(tmp_path):
    pye57 = pytest.importorskip("pye57")
    points = box_points(count=600)
    with pye57.E57(str(tmp_path / "scan.e57"), mode="w") as file:
        for part, shift in ((points[:300], [0.0, 0.0, 0.0]), (points[300:], [1.0, 2.0, 0.0])):
            local = part - shift
            data = {f"cartesian{axis}": np.ascontiguousarray(local[:, i]) for i, axis in enumerate("XYZ")}
            file.write_scan_raw(data, rotation=np.array([1.0, 0.0, 0.0, 0.0]), translation=np.array(shift))
    cloud = read(tmp_path / "scan.e57")
    assert np.abs(cloud.frame.to_scan(cloud.points) - points).max() < 1e-6
    assert np.abs(cloud.frame.to_scan(cloud.trajectory[:, 1:]) - [[0, 0, 0], [1, 2, 0]]).max() < 1e-9


def test_compressed_pcd_and_open3d_files(tmp_path):
    o3d = pytest.importorskip("open3d")
    points = box_points()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    o3d.io.write_point_cloud(str(tmp_path / "scan.pcd"), cloud, compressed=True)
    assert b"binary_compressed" in (tmp_path / "scan.pcd").read_bytes()[:400]
    read_back = read(tmp_path / "scan.pcd")
    assert np.abs(read_back.frame.to_scan(read_back.points) - points).max() < 1e-6


def test_order_of_points_does_not_matter(tmp_path):
    points = box_points() + UTM
    order = np.random.default_rng(1).permutation(len(points))
    write_ply(tmp_path / "a.ply", points)
    write_ply(tmp_path / "b.ply", points[order])
    a, b = read(tmp_path / "a.ply"), read(tmp_path / "b.ply")
    assert np.array_equal(a.points[order], b.points)
    assert np.array_equal(a.frame.matrix, b.frame.matrix)
    assert info(a).spacing == info(b).spacing


def test_points_that_are_not_finite_are_left_out_with_a_count(tmp_path):
    points = box_points()
    points[[3, 70]] = [[np.nan, 0, 0], [0, -np.inf, 0]]
    times = np.arange(len(points), dtype=float)
    path = tmp_path / "scan.csv"
    path.write_text("t,x,y,z\n" + text_rows(np.column_stack([times, points]), delimiter=","))
    cloud = read(path)
    assert len(cloud) == len(points) - 2
    assert np.isfinite(cloud.points).all()
    assert "2 of 4,000 points" in cloud.warnings[0]
    assert 3.0 not in cloud.gps_time
    assert len(cloud.gps_time) == len(cloud)


def test_as_cloud_takes_arrays_open3d_clouds_and_clouds():
    o3d = pytest.importorskip("open3d")
    points = box_points()
    before = points.copy()
    legacy = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    tensor = o3d.t.geometry.PointCloud(o3d.core.Tensor(points))
    expected = as_cloud(points).points
    assert np.array_equal(as_cloud(legacy).points, expected)
    assert np.array_equal(as_cloud(tensor).points, expected)
    assert np.array_equal(points, before)
    assert np.array_equal(np.asarray(legacy.points), before)
    cloud = as_cloud(points.astype(np.float32))
    assert isinstance(cloud, Cloud)
    assert cloud.points.dtype == np.float64
    assert as_cloud(cloud) is cloud


def test_arrays_and_text_need_no_open3d():
    code = "import sys, numpy as np, indoor_bim.filters as f; from indoor_bim.cloud.scan_info import info\n"
    code += "info(np.random.default_rng(0).random((50, 3))); f.grid_radius_outlier_removal(np.zeros((9, 3)), 2, 0.1)\n"
    code += "raise SystemExit('open3d' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_info_describes_the_scan(tmp_path):
    x, y, z = np.meshgrid(np.arange(0, 4.01, 0.1), np.arange(0, 3.01, 0.1), [0.0, 2.5])
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    write_las(tmp_path / "scan.laz", points, gps_time=np.arange(len(points)), classification=np.where(points[:, 2] > 1, 6, 2))
    (tmp_path / "trajectory.csv").write_text("t,x,y,z\n0,1,1,1\n1,2,1,1\n")
    found = info(tmp_path / "scan.laz")
    assert found.points == len(points)
    assert found.extent == pytest.approx((4.0, 3.0, 2.5))
    assert found.spacing == pytest.approx(0.1)
    assert found.has_time
    assert found.classes == {2: len(points) // 2, 6: len(points) // 2}
    assert (found.up, found.unit_metres, found.trajectory, found.crs) == ("z", 1.0, 2, None)


def test_written_files_are_the_same_bytes_each_time(tmp_path):
    points = box_points()
    for name in ("a.laz", "b.laz"):
        write_las(tmp_path / name, points, intensity=np.arange(len(points)))
    assert (tmp_path / "a.laz").read_bytes() == (tmp_path / "b.laz").read_bytes()
    assert laspy.read(tmp_path / "a.laz").header.creation_date.year == 2000
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.laz", "b.laz"]


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_chunks_are_the_whole_file_in_pieces(tmp_path, suffix):
    points = np.random.default_rng(0).uniform(-5, 5, (2500, 3)).round(3)
    path = tmp_path / f"scan.{suffix}"
    write_las(path, points)
    chunks = list(iterate_chunks(path, size=1000))
    assert [len(chunk) for chunk in chunks] == [1000, 1000, 500]
    assert np.array_equal(np.concatenate(list(iterate_chunks(path, size=300))), np.concatenate(chunks))
    assert np.abs(np.concatenate(chunks) - points).max() < 1e-9


def test_a_file_cut_short_is_named_while_iterating(tmp_path):
    path = tmp_path / "scan.las"
    write_las(path, np.random.default_rng(0).uniform(-5, 5, (2500, 3)))
    path.write_bytes(path.read_bytes()[:-600])
    with pytest.raises(ReadError, match=r"scan\.las: the LAS/LAZ file is damaged or cut short"):
        list(iterate_chunks(path))
