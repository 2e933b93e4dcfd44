"""The command line: help, version, data on stdout, messages on stderr, exit codes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from indoor_bim import __version__
from indoor_bim.cli import main
from indoor_bim.config import load_params
from indoor_bim.export.json import read_json, write_json
from indoor_bim.model import Building
from indoor_bim.params import Params
from indoor_bim.simulate import single_room

Captured = pytest.CaptureFixture[str]
COMMANDS = ["reconstruct", "info", "houses", "compare", "export", "check", "demo", "simulate", "config"]


@pytest.fixture
def model(tmp_path: Path) -> Path:
    write_json(single_room(), tmp_path / "model.json")
    return tmp_path / "model.json"


@pytest.fixture
def points(tmp_path: Path) -> Path:
    file = tmp_path / "scan.xyz"
    file.write_text("".join(f"{x} {y} {z}\n" for x in range(5) for y in range(4) for z in (0, 3)))
    return file


def test_help_lists_every_command(capsys: Captured) -> None:
    assert main(["--help"]) == 0
    out, err = capsys.readouterr()
    assert all(command in out for command in COMMANDS)
    assert not err


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command: str, capsys: Captured) -> None:
    assert main([command, "--help"]) == 0
    assert f"indoor-bim {command}" in capsys.readouterr().out


def test_version(capsys: Captured) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"indoor-bim {__version__}\n"


@pytest.mark.parametrize(
    "arguments",
    [["nonsense"], ["reconstruct"], ["reconstruct", "x.laz"], ["config", "--no-such"], ["simulate", "-o", "x", "--points", "0"]],
)
def test_wrong_usage_is_exit_code_2(arguments: list[str], capsys: Captured) -> None:
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert not out
    assert "Traceback" not in err


def test_config_prints_what_it_reads_back(capsys: Captured, tmp_path: Path) -> None:
    assert main(["config"]) == 0
    file = tmp_path / "p.toml"
    file.write_text(capsys.readouterr().out)
    assert load_params(file) == Params()
    assert main(["config", "--config", str(file), "--preset", "paper-room", "--set", "walls.max_thickness=0.5"]) == 0
    printed = tomllib.loads(capsys.readouterr().out)
    assert (printed["slope"]["magnification"], printed["walls"]["max_thickness"]) == (100.0, 0.5)


def test_config_schema_is_that_of_the_parameters(capsys: Captured) -> None:
    assert main(["config", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(Params.model_json_schema()))


def test_info(points: Path, capsys: Captured) -> None:
    assert main(["info", str(points), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["points"], found["extent"], found["source"]) == (40, [4.0, 3.0, 3.0], "scan.xyz")
    assert main(["info", str(points), "--set", "read.unit=ft"]) == 0
    assert "1.22 x 0.91 x 0.91 m" in capsys.readouterr().out


def test_reconstruct_writes_the_kinds_asked_for(tmp_path: Path, capsys: Captured) -> None:
    assert main(["simulate", "-o", str(tmp_path), "--building", "room", "--profile", "clean", "--points", "30000", "-q"]) == 0
    out = tmp_path / "out"
    assert main(["reconstruct", str(tmp_path / "scan.laz"), "-o", str(out), "--to", "json, svg", "--method", "slope", "--json"]) == 0
    stdout, stderr = capsys.readouterr()
    assert not stderr
    assert json.loads(stdout)["counts"]["walls"] == 4
    assert sorted(path.name for path in out.iterdir()) == ["model.json", "params.toml", "plan.svg"]
    load_params(out / "params.toml")
    assert main(["compare", str(out / "model.json"), str(tmp_path / "truth.json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["height_mm"] < 10


def test_export_writes_the_kinds_asked_for(model: Path, tmp_path: Path, capsys: Captured) -> None:
    assert main(["export", str(model), "--to", "obj, .JSON,obj", "-o", str(tmp_path / "new" / "folder")]) == 0
    assert sorted(path.name for path in (tmp_path / "new" / "folder").iterdir()) == ["model.json", "model.mtl", "model.obj"]
    out, err = capsys.readouterr()
    assert not out
    assert len(err.splitlines()) == 2


def test_export_knows_its_kinds(model: Path, tmp_path: Path, capsys: Captured) -> None:
    before = sorted(tmp_path.iterdir())
    assert main(["export", str(model), "--to", "obj,docx"]) == 2
    assert capsys.readouterr().err.startswith("error: --to obj,docx: no writer for docx; there are dxf, geojson, ")
    assert sorted(tmp_path.iterdir()) == before


def test_export_beside_the_model_leaves_the_model_alone(model: Path) -> None:
    before = model.read_bytes()
    assert main(["export", str(model), "--to", "json,obj", "-q"]) == 0
    assert model.read_bytes() == before
    assert model.with_suffix(".obj").exists()


def test_check_of_a_valid_ifc_and_of_a_broken_one(model: Path, capsys: Captured) -> None:
    assert main(["export", str(model), "--to", "ifc", "-q"]) == 0
    ifc = model.with_suffix(".ifc")
    assert main(["check", str(ifc), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["valid"], report["faults"]) == (True, [])
    text = ifc.read_text()
    start = text.index("=IFCBUILDINGSTOREY(") + len("=IFCBUILDINGSTOREY(")
    ifc.write_text(text[:start] + "$" + text[text.index(",", start) :])
    assert main(["check", str(ifc)]) == 5
    out, err = capsys.readouterr()
    assert "not optional" in out
    assert err.startswith(f"error: {ifc}: ")


def test_check_of_files_that_are_neither(tmp_path: Path, model: Path, capsys: Captured) -> None:
    assert main(["check", str(model)]) == 0
    (tmp_path / "empty.ifc").write_bytes(b"")
    for name, code in (("empty.ifc", 3), ("none.ifc", 3), ("none.json", 3), ("a.docx", 2)):
        assert main(["check", str(tmp_path / name)]) == code
        assert capsys.readouterr().err.startswith(f"error: {tmp_path / name}: ")


def test_compare_of_a_model_with_itself(model: Path, capsys: Captured) -> None:
    assert main(["compare", str(model), str(model)]) == 0
    assert "mm" in capsys.readouterr().out
    assert main(["compare", str(model), str(model), "--json"]) == 0
    json.loads(capsys.readouterr().out)


def test_simulate_writes_scan_path_and_truth(tmp_path: Path, capsys: Captured) -> None:
    def arguments(folder: str) -> list[str]:
        return ["simulate", "-o", str(tmp_path / folder), "--building", "room", "--profile", "clean", "--points", "2000", "--seed", "3"]

    assert main(arguments("a")) == 0
    out, err = capsys.readouterr()
    assert not out
    assert err.splitlines() == [str(tmp_path / "a" / name) for name in ("scan.laz", "trajectory.csv", "truth.json")]
    assert main([*arguments("b"), "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    for name in ("scan.laz", "trajectory.csv", "truth.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert isinstance(read_json(tmp_path / "a" / "truth.json"), Building)


def test_messages_follow_the_verbosity(tmp_path: Path, capsys: Captured) -> None:
    missing = str(tmp_path / "none.laz")
    for flags, traceback in (([], False), (["-q"], False), (["-v"], False), (["-vv"], True)):
        assert main(["info", missing, *flags]) == 3
        out, err = capsys.readouterr()
        assert not out
        assert ("Traceback" in err) == traceback
        assert err.splitlines()[-1].startswith(f"error: {missing}: no such file")


def test_ctrl_c_is_130(monkeypatch: pytest.MonkeyPatch, points: Path) -> None:
    def interrupt(*args: object, **kwargs: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("indoor_bim.cloud.scan_info.info", interrupt)
    assert main(["info", str(points)]) == 130


def test_a_closed_pipe_is_no_traceback() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as closed:
        done = subprocess.run([sys.executable, "-m", "indoor_bim", "config"], stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode != 0
