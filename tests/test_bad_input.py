"""Scans that are none: each has its own message and exit code, and leaves nothing half-written."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_bim.cli import main
from indoor_bim.export.json import read_json

Points = NDArray[np.float64]
Captured = pytest.CaptureFixture[str]


def write_laz(path: Path, points: Points) -> Path:
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales = np.full(3, 0.001)
    las = laspy.LasData(header)
    las.xyz = points
    las.write(str(path))
    return path


def write_xyz(path: Path, points: Points) -> Path:
    np.savetxt(path, points, fmt="%.4f")
    return path


def room(*, floor: bool = True, ceiling: bool = True, walls: bool = True) -> Points:
    """Surfaces of a room of 6 x 4 x 2.7 m, a point every 5 cm, with a millimetre of noise."""
    x, y, z = np.arange(0.025, 6, 0.05), np.arange(0.025, 4, 0.05), np.arange(0.025, 2.7, 0.05)
    parts = []
    for there, level in ((floor, 0.0), (ceiling, 2.7)):
        if there:
            parts.append(np.column_stack([grid.ravel() for grid in np.meshgrid(x, y, level)]))
    if walls:
        for grid in (np.meshgrid(x, [0.0, 4.0], z), np.meshgrid([0.0, 6.0], y, z)):
            parts.append(np.column_stack([axis.ravel() for axis in grid]))
    points = np.concatenate(parts)
    return points + np.random.default_rng(0).normal(scale=0.001, size=points.shape)


def no_such_file(folder: Path) -> Path:
    return folder / "none.laz"


def directory(folder: Path) -> Path:
    (folder / "folder.laz").mkdir()
    return folder / "folder.laz"


def empty_file(folder: Path) -> Path:
    (folder / "empty.laz").touch()
    return folder / "empty.laz"


def truncated(folder: Path) -> Path:
    whole = write_laz(folder / "whole.laz", room()).read_bytes()
    (folder / "cut.laz").write_bytes(whole[: len(whole) * 2 // 3])
    return folder / "cut.laz"


def truncated_header(folder: Path) -> Path:
    (folder / "cut.las").write_bytes(write_laz(folder / "whole.laz", room()).read_bytes()[:100])
    return folder / "cut.las"


def picture(folder: Path) -> Path:
    (folder / "photo.las").write_bytes(b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + bytes(500))
    return folder / "photo.las"


def zero_points(folder: Path) -> Path:
    return write_laz(folder / "zero.laz", np.zeros((0, 3)))


def one_point(folder: Path) -> Path:
    return write_laz(folder / "one.laz", np.ones((1, 3)))


def equal_points(folder: Path) -> Path:
    return write_laz(folder / "equal.laz", np.ones((1000, 3)))


def not_a_number(folder: Path) -> Path:
    return write_xyz(folder / "nan.xyz", np.full((100, 3), np.nan))


def infinite(folder: Path) -> Path:
    return write_xyz(folder / "inf.xyz", np.full((100, 3), np.inf))


def unknown_extension(folder: Path) -> Path:
    return write_xyz(folder / "scan.docx", room())


def no_extension(folder: Path) -> Path:
    return write_xyz(folder / "scan", room())


def two_columns(folder: Path) -> Path:
    return write_xyz(folder / "flat.xyz", room()[:, :2])


UNREADABLE: list[tuple[Callable[[Path], Path], str]] = [
    (no_such_file, "no such file"),
    (directory, "folder"),
    (empty_file, "empty"),
    (truncated, "."),
    (truncated_header, "."),
    (picture, "."),
    (zero_points, "0 points"),
    (one_point, "single point"),
    (equal_points, "all equal"),
    (not_a_number, "finite"),
    (infinite, "finite"),
    (unknown_extension, r"\.docx"),
    (no_extension, "extension"),
    (two_columns, "column"),
]


@pytest.mark.parametrize(("make", "words"), UNREADABLE, ids=lambda value: getattr(value, "__name__", ""))
@pytest.mark.parametrize("command", ["reconstruct", "info"])
def test_unreadable_scans(make: Callable[[Path], Path], words: str, command: str, tmp_path: Path, capsys: Captured) -> None:
    scan, out = make(tmp_path), tmp_path / "out"
    assert main([command, str(scan), *(["-o", str(out)] if command == "reconstruct" else [])]) == 3
    stdout, stderr = capsys.readouterr()
    assert not stdout
    assert stderr.startswith(f"error: {scan}: ")
    assert re.search(words, stderr)
    assert "Traceback" not in stderr
    assert not out.exists() or not any(out.iterdir())


def test_each_unreadable_scan_has_its_own_message(tmp_path: Path, capsys: Captured) -> None:
    messages = []
    for i, (make, _) in enumerate(UNREADABLE):
        folder = tmp_path / str(i)
        folder.mkdir()
        scan = make(folder)
        main(["info", str(scan)])
        messages.append(re.sub(r"[\d,]+", "", capsys.readouterr().err.replace(str(scan), "")))
    pairs = {("unknown_extension", "no_extension")}
    names = [make.__name__ for make, _ in UNREADABLE]
    for i, first in enumerate(messages):
        for j in range(i):
            assert first != messages[j] or (names[j], names[i]) in pairs


def without_floor() -> Points:
    return room(floor=False)


def without_ceiling() -> Points:
    return room(ceiling=False)


def without_walls() -> Points:
    return room(walls=False)


def ceiling_only() -> Points:
    return room(floor=False, walls=False)


def two_dimensional() -> Points:
    return room()[:, :3] * [1.0, 1.0, 0.0]


def line() -> Points:
    return room() * [1.0, 0.0, 0.0]


def noise() -> Points:
    return np.random.default_rng(0).normal(size=(5000, 3))


@pytest.mark.parametrize("method", ["auto", "slope"])
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (without_walls, "floor and ceiling, but hardly a point between them"),
        (ceiling_only, "a (floor|ceiling) and hardly anything else"),
        (two_dimensional, "in one plane .* two dimensions"),
        (line, "on one line"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_nothing_to_reconstruct(make: Callable[[], Points], words: str, method: str, tmp_path: Path, capsys: Captured) -> None:
    scan = write_laz(tmp_path / "scan.laz", make())
    out = tmp_path / "out"
    assert main(["reconstruct", str(scan), "-o", str(out), "-q", "--method", method]) == 4
    stderr = capsys.readouterr().err
    assert stderr.startswith("error: ")
    assert re.search(words, stderr)
    assert "scan.laz" in stderr
    assert "Traceback" not in stderr
    assert sorted(path.name for path in out.iterdir()) == ["model.ifc", "model.json", "model.mtl", "model.obj", "params.toml", "plan.svg"]
    building = read_json(out / "model.json")
    assert not building.storeys
    assert f"error: {building.warnings[-1]}" == stderr.strip()


@pytest.mark.parametrize(
    ("make", "missing"), [(without_floor, "floor"), (without_ceiling, "ceiling")], ids=lambda value: getattr(value, "__name__", value)
)
def test_a_missing_plane_is_told(make: Callable[[], Points], missing: str, tmp_path: Path, capsys: Captured) -> None:
    scan = write_laz(tmp_path / "scan.laz", make())
    code = main(["reconstruct", str(scan), "-o", str(tmp_path / "out")])
    stderr = capsys.readouterr().err
    assert code in (0, 4)
    assert missing in stderr
    assert "Traceback" not in stderr


def test_pure_noise_is_no_crash(tmp_path: Path, capsys: Captured) -> None:
    scan = write_laz(tmp_path / "scan.laz", noise())
    assert main(["reconstruct", str(scan), "-o", str(tmp_path / "out")]) in (0, 4)
    assert "Traceback" not in capsys.readouterr().err


def test_some_points_that_are_not_finite_are_left_out_and_told(tmp_path: Path, capsys: Captured) -> None:
    points = room()
    points[::50] = np.nan
    points[1::50, 1] = np.inf
    scan = write_xyz(tmp_path / "scan.xyz", points)
    assert main(["reconstruct", str(scan), "-o", str(tmp_path / "out")]) == 0
    assert "not finite" in capsys.readouterr().err


@pytest.mark.parametrize("place", ["file", "file/sub", "/proc/none"])
def test_an_output_folder_that_cannot_be(place: str, tmp_path: Path, capsys: Captured) -> None:
    (tmp_path / "file").write_text("keep me")
    scan = write_laz(tmp_path / "scan.laz", room())
    out = tmp_path / place
    assert main(["reconstruct", str(scan), "-o", str(out)]) == 2
    assert capsys.readouterr().err.startswith(f"error: {out}: cannot make this folder (")
    assert (tmp_path / "file").read_text() == "keep me"


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("slope.gror_radus=0.1", "did you mean slope.gror_radius"),
        ("slope.gror_radius=3cm", "write 0.03"),
        ("slope.gror_radius=3", "greater than 1 (metres)"),
    ],
)
def test_wrong_parameters(setting: str, words: str, tmp_path: Path, capsys: Captured) -> None:
    scan = write_laz(tmp_path / "scan.laz", room())
    out = tmp_path / "out"
    assert main(["reconstruct", str(scan), "-o", str(out), "--set", setting]) == 2
    assert words in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("option", "words"), [(["--method", "slop"], 'method: there is no "slop"'), (["--to", "ifc,docx"], 'formats: there is no "docx"')]
)
def test_wrong_names(option: list[str], words: str, tmp_path: Path, capsys: Captured) -> None:
    scan = write_laz(tmp_path / "scan.laz", room())
    assert main(["reconstruct", str(scan), "-o", str(tmp_path / "out"), *option]) == 2
    assert capsys.readouterr().err.startswith(f"error: {words}; expected ")
    assert not (tmp_path / "out").exists()


def test_a_trajectory_that_is_none(tmp_path: Path, capsys: Captured) -> None:
    scan = write_laz(tmp_path / "scan.laz", room())
    for name, content in (("none.csv", None), ("words.csv", "once upon a time\n"), ("empty.csv", "")):
        path = tmp_path / name
        if content is not None:
            path.write_text(content)
        assert main(["info", str(scan), "--trajectory", str(path)]) == 3
        assert capsys.readouterr().err.startswith(f"error: {path}")
