"""The accuracy ratchet names what fell, and nothing else."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from types import ModuleType

import pytest

from indoor_bim.quality.compare import compare
from indoor_bim.simulate import demo_house


@pytest.fixture
def accuracy() -> ModuleType:
    spec = importlib.util.spec_from_file_location("accuracy", Path(__file__).parents[1] / "benchmarks" / "accuracy.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_figures_within_tolerance_pass(accuracy: ModuleType) -> None:
    recorded = {"wall_f1": 0.9, "face_median_mm": 10.0, "door_f1": None}
    assert accuracy.fallen("case", recorded, {"wall_f1": 0.88, "face_median_mm": 11.4, "door_f1": None}) == []
    assert accuracy.fallen("case", recorded, {"wall_f1": 1.0, "face_median_mm": 1.0, "door_f1": 1.0}) == []


def test_every_fallen_figure_is_named(accuracy: ModuleType) -> None:
    recorded = {"wall_f1": 0.9, "face_median_mm": 10.0, "width_mm": 3.0}
    sentences = accuracy.fallen("case", recorded, {"wall_f1": 0.86, "face_median_mm": 11.7, "width_mm": None})
    assert [sentence.split()[1] for sentence in sentences] == ["wall_f1", "face_median_mm", "width_mm"]


def test_exit_code_and_update(
    accuracy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    perfect = accuracy.figures(compare(demo_house(), demo_house()))
    measured = dict(perfect)
    monkeypatch.setattr(accuracy, "RECORD", tmp_path / "accuracy.json")
    monkeypatch.setattr(accuracy, "measure", lambda case, method: dict(measured))
    assert accuracy.main(["--only", "demo-clean"]) == 1
    assert "not recorded" in capsys.readouterr().err
    assert accuracy.main(["--update"]) == 0
    assert set(json.loads((tmp_path / "accuracy.json").read_text())["auto"]) == set(accuracy.CASES)
    assert accuracy.main([]) == 0
    measured["corner_f1"] = 0.5
    assert accuracy.main(["--only", "demo-clean"]) == 1
    assert "demo-clean: corner_f1 fell from 1 to 0.5" in capsys.readouterr().err
