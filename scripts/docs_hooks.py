"""Pages of the documentation that come from the code: parameters and the command line."""

from __future__ import annotations

import contextlib
import io
import os
from typing import Any

COMMANDS = ("reconstruct", "info", "houses", "export", "check", "compare", "demo", "simulate", "config")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put the tables in the place of their marks."""
    for mark, make in (("<!-- parameters -->", parameters), ("<!-- commands -->", commands)):
        if mark in markdown:
            markdown = markdown.replace(mark, make())
    return markdown


def parameters() -> str:
    """Tables of all parameters."""
    from indoor_bim.config import parameter_table

    return parameter_table()


def commands() -> str:
    """Help texts of all commands, as the program prints them."""
    return "\n".join(f"## `indoor-bim {name}`\n\n```text\n{_help(name)}\n```\n" for name in COMMANDS)


def _help(command: str) -> str:
    from indoor_bim.cli import main

    before = {name: os.environ.get(name) for name in ("COLUMNS", "NO_COLOR")}
    os.environ.update(COLUMNS="100", NO_COLOR="1")
    try:
        with contextlib.redirect_stdout(io.StringIO()) as out:
            main([command, "--help"])
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value
    return "\n".join(line.rstrip() for line in out.getvalue().strip("\n").splitlines())
