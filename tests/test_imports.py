"""`import indoor_bim` and `indoor-bim --help` stay light; every public name can be had."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import indoor_bim

HEAVY = {"open3d", "ifcopenshell", "skimage", "scipy", "shapely", "matplotlib", "networkx", "laspy", "pye57", "numpy"}


def modules_after(code: str) -> set[str]:
    program = f"{code}\nimport json, sys\nprint(json.dumps(sorted({{name.partition('.')[0] for name in sys.modules}})))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_the_package_imports_nothing_heavy() -> None:
    assert not modules_after("import indoor_bim") & (HEAVY | {"pydantic", "typer", "rich"})


@pytest.mark.parametrize("arguments", [["--help"], ["reconstruct", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(arguments: list[str]) -> None:
    assert not modules_after(f"from indoor_bim.cli import main\nassert main({arguments!r}) == 0") & HEAVY


@pytest.mark.parametrize("name", indoor_bim.__all__)
def test_every_public_name_can_be_had(name: str) -> None:
    assert getattr(indoor_bim, name) is not None
    assert name in dir(indoor_bim)


def test_names_are_lazy_and_typed_alike() -> None:
    assert set(indoor_bim._HOME) == set(indoor_bim.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'reconstrct'"):
        indoor_bim.reconstrct  # noqa: B018


def test_export_is_a_package_and_a_function(tmp_path: Path) -> None:
    building = indoor_bim.Building("hut")
    indoor_bim.export(building, tmp_path / "hut.json")
    from indoor_bim.export.json import read_json

    assert read_json(tmp_path / "hut.json") == building
    assert indoor_bim.read_model(tmp_path / "hut.json") == building
    indoor_bim.export(building, tmp_path / "again.json")
