"""Command about parameters: config."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from indoor_bim.cli.console import emit, emit_json

ConfigFile = Annotated[
    Path | None,
    typer.Option(
        "--config", "-c", metavar="FILE.toml", help="Parameters, as `indoor-bim config` prints them.", rich_help_panel="Parameters"
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="STAGE.NAME=VALUE", help="One parameter; may be given again; wins over the file.", rich_help_panel="Parameters"
    ),
]
Preset = Annotated[
    str | None,
    typer.Option(
        "--preset",
        metavar="NAME",
        help="Hand-set values of a published scene: paper-room, paper-floor, paper-rooms.",
        rich_help_panel="Parameters",
    ),
]


_SIZE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*([kMGT]?i?B?)\s*", re.IGNORECASE)


def gigabytes(size: str) -> float:
    """Size in units of 10**9 bytes.

    Raises
    ------
    ConfigError
        If the text is no size.

    Examples
    --------
    >>> gigabytes("2GB"), gigabytes("1500 MB"), gigabytes("1.5"), gigabytes("1GiB")
    (2.0, 1.5, 1.5, 1.073741824)
    """
    match = _SIZE.fullmatch(size)
    if match is None:
        from indoor_bim.errors import ConfigError

        raise ConfigError(f"--max-memory {size}: expected a size such as 2GB or 800MB")
    unit = match[2].upper() or "GB"
    power = " KMGT".index(unit[0]) if unit[0] in "KMGT" else 0
    return float(match[1]) * float(1024 if "I" in unit else 1000) ** power / 1e9


def config(
    config: ConfigFile = None,
    set_: Settings = None,
    preset: Preset = None,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON Schema of the parameters instead.")] = False,
) -> None:
    """Print every parameter as commented TOML: default, unit and bounds.

    `indoor-bim config > params.toml`, change what you like, then `indoor-bim reconstruct SCAN --config params.toml`.
    """
    from indoor_bim import __version__
    from indoor_bim.config import load_params, to_toml
    from indoor_bim.params import Params

    if schema:
        emit_json(Params.model_json_schema())
        return
    params = load_params(config, set_ or (), preset)
    header = [f"Parameters of indoor-bim {__version__}.", "Those without a value are derived from the scan."]
    emit(to_toml(params, header=header).rstrip("\n"))
