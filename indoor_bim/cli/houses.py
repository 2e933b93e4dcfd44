"""Command about outdoor scans: houses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from indoor_bim.cli.console import AsJson, Quiet, Verbose, emit_json, emit_rows, progress_bars, say, set_up_messages, warn
from indoor_bim.cli.parameters import ConfigFile, Settings
from indoor_bim.cli.scan import Scan


def houses(
    scan: Scan,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the results; made if missing.")],
    method: Annotated[str | None, typer.Option(metavar="NAME", help="lines, the default, or topology, the published way.")] = None,
    storey_height: Annotated[float | None, typer.Option(metavar="M", help="Usual height of a storey in metres. Default: 3.0.")] = None,
    attributes: Annotated[
        Path | None, typer.Option(metavar="TABLE.csv", help="Materials and other attributes, with a column id, or columns x and y.")
    ] = None,
    corners: Annotated[
        Path | None, typer.Option(metavar="CORNERS.csv", help="Surveyed corners (id, x, y) to compare the footprints with.")
    ] = None,
    crs: Annotated[str | None, typer.Option(metavar="EPSG:CODE", help="Coordinate reference system. Default: that of the file.")] = None,
    to: Annotated[str | None, typer.Option(metavar="KIND,...", help="What to write. Default: everything.")] = None,
    config: ConfigFile = None,
    set_: Settings = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Find the houses of an outdoor scan: footprints, heights, storeys and 3-D models.

    Needs no parameters: `indoor-bim houses village.laz -o out`
    """
    from indoor_bim.config import load_params
    from indoor_bim.houses import DEFAULT_METHOD
    from indoor_bim.houses import houses as run

    set_up_messages(quiet=quiet, verbose=verbose)
    sets = list(set_ or ())
    if storey_height is not None:
        sets.append(f"houses.storey_height={storey_height!r}")
    if crs is not None:
        sets.append(f'read.crs="{crs}"')
    formats = None if to is None else [kind.strip().lower() for kind in to.split(",") if kind.strip()]
    with progress_bars(quiet=quiet) as progress:
        result = run(
            scan,
            output,
            method=method or DEFAULT_METHOD,
            params=load_params(config, sets),
            attributes=attributes,
            corners=corners,
            formats=formats,
            progress=progress,
        )
    warn(result.warnings, quiet=quiet)
    found = result.village.houses
    if as_json:
        rows = [
            {"id": house.id, "area_m2": house.area, "storeys": house.storeys, "height_m": house.height, "corners": len(house.footprint)}
            for house in found
        ]
        emit_json({"houses": rows, "folder": str(output), "seconds": result.timings, "warnings": result.warnings})
    elif not quiet:
        emit_rows(
            [
                (house.id, f"{house.area:8.2f} m2  {house.height:5.2f} m  {house.storeys} storeys  {len(house.footprint)} corners")
                for house in found
            ]
        )
        distances = result.accuracy.distances
        if len(distances):
            share = f"{len(distances)} of {len(result.accuracy.corners)}"
            say(f"Surveyed corners: {share}, mean {distances.mean():.3f} m, max {distances.max():.3f} m")
        say(f"Results: {output}")
