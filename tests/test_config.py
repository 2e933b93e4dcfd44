"""Parameters to and from TOML; every fault has its own message."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoor_bim.config import describe, load_params, parameter_table, to_toml
from indoor_bim.errors import ConfigError
from indoor_bim.params import PRESETS, Params, preset

FIELDS = [(stage, name, field) for stage, model in Params() for name, field in type(model).model_fields.items()]


def message(**sources: Any) -> str:
    with pytest.raises(ConfigError) as caught:
        load_params(**sources)
    return str(caught.value)


def test_no_source_gives_the_defaults() -> None:
    assert load_params() == Params()


def test_settings_win_over_file_and_file_over_preset(tmp_path: Path) -> None:
    file = tmp_path / "p.toml"
    file.write_text("[slope]\ngror_radius = 0.02\ncorner_gap = 7\n")
    params = load_params(file, ["slope.corner_gap=9"], preset="paper-room")
    assert (params.slope.gror_radius, params.slope.corner_gap, params.slope.grid_count) == (0.02, 9.0, 200)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_those_of_the_parameters(name: str) -> None:
    assert load_params(preset=name) == preset(name)


@pytest.mark.parametrize("name", [None, *PRESETS])
def test_toml_reads_back_to_the_same_parameters(name: str | None, tmp_path: Path) -> None:
    params = load_params(preset=name, sets=["read.crs=EPSG:25832", "walls.max_thickness=0.5"])
    file = tmp_path / "p.toml"
    file.write_text(to_toml(params, header=["one", "", "two"]))
    assert load_params(file) == params


@given(radius=st.floats(1e-6, 1.0), neighbours=st.integers(1, 1000))
def test_toml_keeps_every_digit(radius: float, neighbours: int) -> None:
    params = load_params(sets=[f"slope.gror_radius={radius!r}", f"slope.gror_neighbours={neighbours}"])
    slope = tomllib.loads(to_toml(params))["slope"]
    assert (slope["gror_radius"], slope["gror_neighbours"]) == (radius, neighbours)


def test_derived_values_stand_in_for_none() -> None:
    text = to_toml(Params(), derived={"slope.gror_radius": 0.031, "walls.min_thickness": 99})
    slope = tomllib.loads(text)["slope"]
    assert slope["gror_radius"] == 0.031
    assert tomllib.loads(text)["walls"]["min_thickness"] == Params().walls.min_thickness
    assert "gror_radius = 0.031  # derived from the scan" in text


def test_out_of_bounds(tmp_path: Path) -> None:
    file = tmp_path / "site.toml"
    file.write_text("[slope]\ngror_radius = 3\n")
    assert message(config=file) == f"slope.gror_radius: 3 is greater than 1 (metres) in {file}"
    assert message(sets=["slope.gror_radius=0"]) == "slope.gror_radius: 0 is not greater than 0 (metres) in --set"
    assert message(sets=["slope.grid_count=9"]) == "slope.grid_count: 9 is less than 10 in --set"


def test_unknown_names_name_the_nearest(tmp_path: Path) -> None:
    file = tmp_path / "site.toml"
    file.write_text("[slope]\ngror_radus = 0.1\n")
    assert message(config=file) == f"slope.gror_radus: no such parameter in {file}; did you mean slope.gror_radius?"
    assert message(sets=["slop.gror_radius=0.1"]).startswith("slop: no such stage in --set; did you mean slope?; there are read, slope")
    assert message(preset="paper-rom").startswith("no preset 'paper-rom'; did you mean paper-room?; there are paper-room, ")


@pytest.mark.parametrize(
    ("value", "metres"),
    [("3cm", "0.03"), ("30 mm", "0.03"), ("0.03m", "0.03"), ("1in", "0.0254"), (".1 ft", "0.03048"), ("1e1 mm", "0.01")],
)
def test_a_length_with_a_unit_is_told_in_metres(value: str, metres: str) -> None:
    expected = f"slope.gror_radius: expected a number (metres), found {value!r} in --set; "
    assert message(sets=[f"slope.gror_radius={value}"]) == f"{expected}lengths are in metres and have no unit: write {metres}"


def test_other_units_and_types(tmp_path: Path) -> None:
    assert message(sets=["slope.magnification=50px"]).endswith("write the number without a unit, in pixels per metre")
    assert message(sets=["slope.gror_radius=wide"]) == "slope.gror_radius: expected a number (metres), found 'wide' in --set"
    assert message(sets=["slope.gror_neighbours=2.5"]) == "slope.gror_neighbours: expected a whole number, found 2.5 in --set"
    assert message(sets=["slope.gror_radius=nan"]) == "slope.gror_radius: nan is not a finite number in --set"
    assert message(sets=["slope.gror_radius=inf"]) == "slope.gror_radius: inf is not a finite number in --set"
    assert message(sets=["read.unit=km"]).startswith("read.unit: 'km' is none of auto, m, ")
    file = tmp_path / "site.toml"
    file.write_text('[slope]\ngror_radius = "0.03"\n')
    assert message(config=file) == f"slope.gror_radius: expected a number (metres), found '0.03' in {file}"
    file.write_text("slope = 1\n")
    assert message(config=file) == f"slope: expected a table [slope] of parameters in {file}, found 1"
    file.write_text("[slope]\ngror_radius = 2026-01-01\n")
    assert "expected a number (metres), found '2026-01-01'" in message(config=file)


def test_every_fault_is_told_at_once() -> None:
    assert len(message(sets=["slope.gror_radius=-1", "walls.min_thickness=2", "read.up=w"]).splitlines()) == 3


def test_unreadable_files(tmp_path: Path) -> None:
    assert message(config=tmp_path / "none.toml").startswith(f"{tmp_path / 'none.toml'}: no such configuration file; `indoor-bim config")
    assert message(config=tmp_path) == f"{tmp_path}: cannot read the configuration: Is a directory"
    (tmp_path / "a.toml").write_bytes(b"\x89PNG\xff")
    assert "not a text file" in message(config=tmp_path / "a.toml")
    (tmp_path / "b.toml").write_text("[slope]\ngror_radius = 3cm\n")
    assert re.search(r"not valid TOML: .*line 2.*numbers without units", message(config=tmp_path / "b.toml"))


@pytest.mark.parametrize("text", ["slope.gror_radius", "gror_radius=1", "=1", ".x=1", "slope.=1"])
def test_malformed_settings(text: str) -> None:
    assert message(sets=[text]).startswith(f"--set {text}: expected stage.name=value")


@pytest.mark.parametrize(("stage", "name", "field"), FIELDS, ids=lambda value: value if isinstance(value, str) else "")
def test_every_parameter_is_described_and_in_the_table(stage: str, name: str, field: Any) -> None:
    assert field.description
    assert field.description.endswith(".")
    assert f"| `{stage}.{name}` |" in parameter_table()
    assert describe(field).replace("|", "\\|") in parameter_table()
