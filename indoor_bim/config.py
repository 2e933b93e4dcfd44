"""Parameters from presets, TOML files and the command line, and back to TOML.

Later sources win: defaults, preset, file, single settings.
"""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from indoor_bim.errors import ConfigError
from indoor_bim.params import PRESETS, Params

_METRES = MappingProxyType({"mm": 0.001, "cm": 0.01, "dm": 0.1, "m": 1.0, "ft": 0.3048, "in": 0.0254})
_QUANTITY = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\W\d]+|°|%)\s*$")
_UNITS = (r"pixels per metre", r"square metres", r"metres", r"millimetres", r"pixels", r"degrees", r"seconds")


def load_params(config: Path | str | None = None, sets: Sequence[str] = (), preset: str | None = None) -> Params:
    """Parameters from a preset, a TOML file and single settings, checked against names, types and bounds.

    Parameters
    ----------
    config : path, optional
        TOML file with one table per stage.
    sets : sequence of str
        Settings ``stage.name=value``; they win over the file.
    preset : str, optional
        One of `indoor_bim.params.PRESETS`; the file and the settings win over it.

    Raises
    ------
    ConfigError
        If a file cannot be read, or a name, type or value is wrong; the message names every fault and its place.

    Examples
    --------
    >>> load_params(sets=["slope.gror_radius=0.05"]).slope.gror_radius
    0.05
    >>> load_params(sets=["slope.gror_radus=0.05"])
    Traceback (most recent call last):
    indoor_bim.errors.ConfigError: slope.gror_radus: no such parameter in --set; did you mean slope.gror_radius?
    """
    layers: list[tuple[str, Mapping[str, Any]]] = []
    if preset is not None:
        if preset not in PRESETS:
            raise ConfigError(f"no preset {preset!r}{_nearest(preset, PRESETS)}; there are {', '.join(PRESETS)}")
        layers.append((f"preset {preset}", {"slope": PRESETS[preset].model_dump(exclude_unset=True)}))
    if config is not None:
        layers.append((str(config), _read_toml(Path(config))))
    layers.extend(("--set", _setting(text)) for text in sets)

    merged: dict[str, Any] = {}
    origin: dict[tuple[str, ...], str] = {}
    for name, stages in layers:
        for stage, values in stages.items():
            origin[(stage,)] = name
            if not isinstance(values, Mapping):
                merged[stage] = values
                continue
            if not isinstance(merged.get(stage), dict):
                merged[stage] = {}
            merged[stage].update(values)
            origin.update({(stage, key): name for key in values})
    try:
        return Params.model_validate_json(json.dumps(merged, default=str), strict=True)
    except ValidationError as error:
        faults = [_fault(tuple(map(str, e["loc"])), e, origin) for e in error.errors()]
        raise ConfigError("\n".join(faults)) from None


def to_toml(params: Params, *, header: Sequence[str] = (), derived: Mapping[str, Any] | None = None) -> str:
    """Write parameters as commented TOML, which `load_params` reads back to the same parameters.

    Parameters
    ----------
    params : Params
        Parameters to write; those that are None appear as comments.
    header : sequence of str
        Lines of the comment at the top.
    derived : mapping of str to value, optional
        Values that a run derived from the scan, by ``stage.name``; written in place of None.

    Examples
    --------
    >>> from indoor_bim.params import PRESETS, Params
    >>> print(to_toml(Params(), header=["defaults"]).splitlines()[0])
    # defaults
    """
    found = derived or {}
    lines = [f"# {line}".rstrip() for line in header]
    for stage, model in _stages(params):
        lines += ["", f"# {_summary(type(model))}", f"[{stage}]"]
        for name, field in type(model).model_fields.items():
            value = getattr(model, name)
            lines += ["", f"# {describe(field)}"]
            if value is not None:
                lines.append(f"{name} = {_toml_value(value)}")
            elif f"{stage}.{name}" in found:
                lines.append(f"{name} = {_toml_value(found[f'{stage}.{name}'])}  # derived from the scan")
            else:
                lines.append(f"# {name} =")
    return "\n".join(lines).lstrip("\n") + "\n"


def describe(field: FieldInfo) -> str:
    """Sentence of a parameter, with its bounds.

    Examples
    --------
    >>> from indoor_bim.params import WallParams
    >>> describe(WallParams.model_fields["min_thickness"])
    'Thinnest wall in metres. Greater than 0, at most 1.'
    """
    words = {"gt": "greater than {}", "ge": "at least {}", "lt": "less than {}", "le": "at most {}"}
    limits = [words[kind].format(_short(value)) for kind in words for value in _constraint(field, kind)]
    choices = _choices(field)
    if choices:
        limits.append("one of " + ", ".join(choices))
    text = field.description or ""
    return text if not limits else f"{text} {', '.join(limits).capitalize()}."


def parameter_table() -> str:
    """Markdown tables of every parameter, one per stage."""
    lines: list[str] = []
    for stage, model in _stages(Params()):
        lines += [f"## `[{stage}]`", "", _summary(type(model)), "", "| parameter | default | meaning |", "|---|---|---|"]
        for name, field in type(model).model_fields.items():
            value = getattr(model, name)
            shown = "from the scan" if value is None else f"`{_toml_value(value)}`"
            lines.append(f"| `{stage}.{name}` | {shown} | {describe(field).replace('|', chr(92) + '|')} |")
        lines.append("")
    return "\n".join(lines)


def _stages(params: Params) -> Iterator[tuple[str, BaseModel]]:
    for stage in type(params).model_fields:
        yield stage, getattr(params, stage)


def _summary(model: type[BaseModel]) -> str:
    return (model.__doc__ or "").strip().splitlines()[0]


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such configuration file; `indoor-bim config > {path}` writes one with all defaults") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a text file; expected a configuration in TOML, as `indoor-bim config` prints it") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot read the configuration: {error.strerror}") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}; quote texts and write numbers without units") from None


def _setting(text: str) -> dict[str, dict[str, Any]]:
    name, equals, value = text.partition("=")
    stage, dot, key = name.strip().partition(".")
    if not (equals and dot and stage and key):
        raise ConfigError(f"--set {text}: expected stage.name=value, such as slope.gror_radius=0.03")
    try:
        parsed = tomllib.loads(f"value = {value.strip()}")["value"]
    except tomllib.TOMLDecodeError:
        parsed = value.strip()
    return {stage: {key: parsed}}


def _fault(place: tuple[str, ...], error: Any, origin: Mapping[tuple[str, ...], str]) -> str:
    name, kind, value, context = ".".join(place), error["type"], error["input"], error.get("ctx", {})
    source = origin.get(place[:2], origin.get(place[:1], "parameters"))
    stage = Params.model_fields.get(place[0])
    fields = (
        stage.annotation.model_fields if stage and isinstance(stage.annotation, type) and issubclass(stage.annotation, BaseModel) else {}
    )
    field = fields.get(place[1]) if len(place) > 1 else None
    unit = _unit(field) if field else None
    in_unit = f" ({unit})" if unit else ""
    if kind == "extra_forbidden":
        if len(place) == 1:
            return f"{name}: no such stage in {source}{_nearest(name, Params.model_fields)}; there are {', '.join(Params.model_fields)}"
        return f"{name}: no such parameter in {source}{_nearest(name, [f'{place[0]}.{key}' for key in fields])}"
    if kind == "model_type":
        return f"{name}: expected a table [{name}] of parameters in {source}, found {value!r}"
    if kind in _BOUNDS:
        bound, word = _BOUNDS[kind]
        return f"{name}: {_short(value)} is {word} {_short(context[bound])}{in_unit} in {source}"
    if kind == "finite_number":
        return f"{name}: {value} is not a finite number in {source}"
    if kind == "literal_error":
        return f"{name}: {value!r} is none of {', '.join(_choices(field)) if field else context['expected']} in {source}"
    if isinstance(value, str) and kind.startswith(("float", "int")):
        return f"{name}: expected a number{in_unit}, found {value!r} in {source}{_without_unit(value, unit)}"
    if kind.startswith("int"):
        return f"{name}: expected a whole number, found {value!r} in {source}"
    return f"{name}: {error['msg'][:1].lower()}{error['msg'][1:]}, found {value!r} in {source}"


_BOUNDS = MappingProxyType(
    {
        "greater_than": ("gt", "not greater than"),
        "greater_than_equal": ("ge", "less than"),
        "less_than": ("lt", "not less than"),
        "less_than_equal": ("le", "greater than"),
    }
)


def _without_unit(text: str, unit: str | None) -> str:
    match = _QUANTITY.match(text)
    if not match:
        return ""
    if unit == "metres" and match[2] in _METRES:
        return f"; lengths are in metres and have no unit: write {_short(round(float(match[1]) * _METRES[match[2]], 9))}"
    return f"; write the number without a unit{f', in {unit}' if unit else ''}"


def _nearest(name: str, names: Sequence[str] | Mapping[str, Any]) -> str:
    close = difflib.get_close_matches(name, list(names), n=1, cutoff=0.6)
    return f"; did you mean {close[0]}?" if close else ""


def _unit(field: FieldInfo) -> str | None:
    text = (field.description or "").lower()
    return next((unit for unit in _UNITS if re.search(rf"\b{unit}\b", text)), None)


def _constraint(field: FieldInfo, kind: str) -> list[Any]:
    return [getattr(meta, kind) for meta in field.metadata if getattr(meta, kind, None) is not None]


def _choices(field: FieldInfo) -> list[str]:
    annotation = field.annotation
    options = [annotation, *get_args(annotation)]
    return [str(choice) for option in options if get_origin(option) is Literal for choice in get_args(option)]


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml_value, value)) + "]"
    return json.dumps(str(value), ensure_ascii=False)
