"""Floor plans as PDF and PNG, drawn from the SVG by CairoSVG."""

from __future__ import annotations

import os
import re
from pathlib import Path
from types import ModuleType

from indoor_bim.errors import WriteError
from indoor_bim.export.files import replace_file
from indoor_bim.export.plan_style import USUAL, PlanStyle
from indoor_bim.export.svg import plan_paths, plan_svg
from indoor_bim.model import Building

DOTS_PER_INCH = 200
_DATE = re.compile(rb"(/CreationDate \(D:)[^)]*\)")


def write_pdf(building: Building, path: str | os.PathLike[str], *, style: PlanStyle = USUAL) -> list[Path]:
    """Write one PDF for each storey, at true scale; texts stay texts.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File of the first storey's plan; the others stand beside it, see `svg.plan_paths`.
    style : PlanStyle
        Scale, paper, colours and pictures of the scan.

    Returns
    -------
    list of pathlib.Path
        Files written.

    Raises
    ------
    WriteError
        If a file cannot be written, or if CairoSVG or the cairo library is not installed.
    """
    cairosvg = _cairosvg("PDF")
    paths = plan_paths(building, path)
    for target, storey in paths.items():
        pdf = cairosvg.svg2pdf(bytestring=plan_svg(building, storey=storey, style=style).encode("utf-8"))
        with replace_file(target) as draft:
            draft.write_bytes(_DATE.sub(_without_date, pdf))
    return list(paths)


def write_png(building: Building, path: str | os.PathLike[str], *, style: PlanStyle = USUAL) -> list[Path]:
    """Write one picture for each storey, at `DOTS_PER_INCH`.

    Parameters
    ----------
    building : Building
        Model, metres.
    path : path
        File of the first storey's plan; the others stand beside it, see `svg.plan_paths`.
    style : PlanStyle
        Scale, paper, colours and pictures of the scan.

    Returns
    -------
    list of pathlib.Path
        Files written.

    Raises
    ------
    WriteError
        If a file cannot be written, or if CairoSVG or the cairo library is not installed.
    """
    cairosvg = _cairosvg("PNG")
    paths = plan_paths(building, path)
    for target, storey in paths.items():
        png = cairosvg.svg2png(bytestring=plan_svg(building, storey=storey, style=style).encode("utf-8"), dpi=DOTS_PER_INCH)
        with replace_file(target) as draft:
            draft.write_bytes(png)
    return list(paths)


def _cairosvg(kind: str) -> ModuleType:
    try:
        import cairosvg
    except ImportError as error:
        raise WriteError(f"writing {kind} needs the package CairoSVG; install it: pip install 'indoor-bim[pdf]'") from error
    except OSError as error:
        raise WriteError(f"writing {kind} needs the cairo library (Debian: libcairo2, macOS: brew install cairo): {error}") from error
    return cairosvg  # type: ignore[no-any-return]


def _without_date(match: re.Match[bytes]) -> bytes:
    """Fixed date of the same length, so that equal plans give equal bytes and the offsets in the file stay right."""
    found = match.group(0)
    fixed = match.group(1) + b"19700101000000Z"
    return (fixed + b" " * (len(found) - len(fixed) - 1) + b")") if len(found) > len(fixed) else found
