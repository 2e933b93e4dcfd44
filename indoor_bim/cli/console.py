"""What the commands share: options, messages on stderr, progress bars, data on stdout."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import typer

Progress = Callable[[str, float], None]

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.", rich_help_panel="Messages")]
Verbose = Annotated[
    int, typer.Option("--verbose", "-v", count=True, metavar="", help="Say more; -vv: everything.", rich_help_panel="Messages")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON.", rich_help_panel="Messages")]


def set_up_messages(*, quiet: bool = False, verbose: int = 0) -> None:
    """Send the library's log to stderr: warnings, with ``-v`` information, with ``-vv`` everything, with ``-q`` errors."""
    from rich.console import Console
    from rich.logging import RichHandler

    level = logging.ERROR if quiet else (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    log = logging.getLogger("indoor_bim")
    log.setLevel(level)
    log.handlers[:] = [RichHandler(console=Console(stderr=True), show_time=False, show_path=False, markup=False)]
    logging.getLogger().addHandler(logging.NullHandler())  # what other libraries log is no message of ours


def say(text: str, *, quiet: bool = False) -> None:
    """Write a message to stderr."""
    if not quiet:
        typer.echo(text, err=True)


def warn(warnings: Sequence[str], *, quiet: bool = False) -> None:
    """Write each warning on its own line to stderr."""
    for warning in warnings:
        say(f"warning: {warning}", quiet=quiet)


def emit(text: str) -> None:
    """Write data to stdout."""
    typer.echo(text)


def emit_json(value: Any) -> None:
    """Write data to stdout as JSON; numbers that are not finite become null."""
    emit(json.dumps(_finite(value), indent=2, ensure_ascii=False, default=str, allow_nan=False))


def emit_rows(rows: Sequence[tuple[str, str]]) -> None:
    """Write names and values to stdout in two columns."""
    width = max((len(name) for name, _ in rows), default=0)
    for name, value in rows:
        emit(f"{name:<{width}}  {value}".rstrip())


@contextmanager
def progress_bars(*, quiet: bool = False) -> Iterator[Progress | None]:
    """Give a callback that draws one bar per stage on stderr; None where nobody looks.

    Parameters
    ----------
    quiet : bool
        Draw nothing.

    Yields
    ------
    callable or None
        Takes the name of a stage and the share of it that is done, 0 to 1.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description:<24}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as bars:
        tasks: dict[str, Any] = {}

        def update(stage: str, share: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=share)

        yield update


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if value - value == 0 else None
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return value
