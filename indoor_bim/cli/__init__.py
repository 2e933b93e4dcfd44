"""Command line: `indoor-bim`. Data goes to stdout, messages and progress bars to stderr."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Sequence
from typing import Annotated

import typer

from indoor_bim import __version__
from indoor_bim.cli import building, houses, parameters, scan, virtual
from indoor_bim.errors import IndoorBimError

app = typer.Typer(
    name="indoor-bim",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 done, 2 wrong usage, 3 unreadable input, 4 nothing to reconstruct, 5 validation failed, 130 interrupted.",
)

app.command(rich_help_panel="Your scan")(scan.reconstruct)
app.command(rich_help_panel="Your scan")(scan.info)
app.command(rich_help_panel="Your scan")(houses.houses)
app.command(rich_help_panel="Its model")(building.compare)
app.command(rich_help_panel="Its model")(building.export)
app.command(rich_help_panel="Its model")(building.check)
app.command(rich_help_panel="Known buildings")(virtual.demo)
app.command(rich_help_panel="Known buildings")(virtual.simulate)
app.command(rich_help_panel="Parameters")(parameters.config)


def _print_version(value: bool) -> None:
    if value:
        typer.echo(f"indoor-bim {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and stop.")] = False,
) -> None:
    """From a laser scan of a building to its model: IFC, floor plan, mesh and JSON."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; default: those of this process.
    """
    try:
        app(args=None if argv is None else list(argv), prog_name="indoor-bim")
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    except IndoorBimError as error:
        if logging.getLogger("indoor_bim").isEnabledFor(logging.DEBUG):
            traceback.print_exc()
        typer.echo(f"error: {error}", err=True)
        return error.exit_code
    return 0
