"""Commands about scans: reconstruct and info."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from indoor_bim.cli.console import (
    AsJson,
    Quiet,
    Verbose,
    emit_json,
    emit_rows,
    progress_bars,
    say,
    set_up_messages,
    warn,
)
from indoor_bim.cli.parameters import ConfigFile, Preset, Settings, gigabytes

if TYPE_CHECKING:
    from indoor_bim.model import Building

Scan = Annotated[Path, typer.Argument(metavar="SCAN", help="LAS, LAZ, PLY, PCD, XYZ, PTS or E57.")]
Trajectory = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Path of the scanner: CSV or text with t, x, y, z. Default: trajectory.csv beside the scan."),
]


def reconstruct(
    scan: Scan,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the results; made if missing.")],
    method: Annotated[str | None, typer.Option(metavar="NAME", help="Method of reconstruction, such as slope, the published one.")] = None,
    to: Annotated[
        str, typer.Option(metavar="KIND,...", help="What to write of ifc, obj, ply, gltf, geojson, svg, dxf, pdf, png, json.")
    ] = "ifc,obj,svg,json",
    trajectory: Trajectory = None,
    crs: Annotated[
        str | None, typer.Option(metavar="EPSG:CODE", help="Coordinate reference system of the scan. Default: what the file says.")
    ] = None,
    title: Annotated[
        str | None, typer.Option(metavar="NAME", help="Name of the building. Default: that of the file, or of its folder.")
    ] = None,
    max_memory: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE", help="Most memory to use, such as 2GB: points are thinned out where they are densest. Default: no limit."
        ),
    ] = None,
    config: ConfigFile = None,
    set_: Settings = None,
    preset: Preset = None,
    debug: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write a picture of every wall, with what the scan hit, saw through and missed.")
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Make a building model from a scan: model.ifc, model.obj, model.json, plan.svg and params.toml.

    Needs no parameters: `indoor-bim reconstruct scan.laz -o out`
    """
    import json

    from indoor_bim.config import load_params
    from indoor_bim.pipeline import DEFAULT_METHOD
    from indoor_bim.pipeline import reconstruct as run

    set_up_messages(quiet=quiet, verbose=verbose)
    given = {
        "title": None if title is None else json.dumps(title),
        "crs": crs,
        "max_memory": None if max_memory is None else gigabytes(max_memory),
    }
    sets = [f"read.{name}={value}" for name, value in given.items() if value is not None]
    params = load_params(config, [*(set_ or ()), *sets], preset)
    formats = [kind.strip().lower() for kind in to.split(",") if kind.strip()]
    with progress_bars(quiet=quiet) as progress:
        result = run(
            scan,
            output,
            method=method or DEFAULT_METHOD,
            params=params,
            trajectory=trajectory,
            formats=formats,
            debug=debug,
            progress=progress,
        )
    warn(result.warnings, quiet=quiet)
    if as_json:
        emit_json({"counts": counts(result.building), "folder": str(output), "seconds": result.timings, "warnings": result.warnings})
    elif not quiet:
        emit_rows(summary(result.building))
        say(f"Results: {output}")


def info(
    scan: Scan,
    trajectory: Trajectory = None,
    config: ConfigFile = None,
    set_: Settings = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Say what is in a scan: points, size, unit, spacing, classes and what is doubtful."""
    import dataclasses

    from indoor_bim.cloud.scan_info import info as describe
    from indoor_bim.config import load_params

    set_up_messages(quiet=quiet, verbose=verbose)
    read = load_params(config, set_ or ()).read
    found = describe(scan, unit=read.unit, up=read.up, crs=read.crs, trajectory=trajectory)
    warn(found.warnings, quiet=quiet)
    if as_json:
        emit_json(dataclasses.asdict(found))
        return
    emit_rows(
        [
            ("file", found.source),
            ("points", f"{found.points:,}"),
            ("size", " x ".join(f"{length:.2f}" for length in found.extent) + " m"),
            ("spacing", f"{1000 * found.spacing:.1f} mm between neighbours (median)"),
            ("unit", f"{found.unit_metres:g} m"),
            ("up", f"{found.up} axis"),
            ("origin", ", ".join(f"{value:.3f}" for value in found.origin)),
            ("reference system", found.crs or "not given"),
            ("times", "yes" if found.has_time else "no"),
            ("trajectory", f"{found.trajectory:,} positions" if found.trajectory else "none"),
            ("classes", ", ".join(f"{code}: {count:,}" for code, count in found.classes.items()) or "none"),
        ]
    )


def counts(building: Building) -> dict[str, int]:
    """Number of elements of each kind."""
    walls = [wall for storey in building.storeys for wall in storey.walls]
    openings = [opening for wall in walls for opening in wall.openings]
    return {
        "storeys": len(building.storeys),
        "walls": len(walls),
        "rooms": sum(len(storey.rooms) for storey in building.storeys),
        "doors": sum(opening.kind == "door" for opening in openings),
        "windows": sum(opening.kind == "window" for opening in openings),
        "openings": sum(opening.kind == "opening" for opening in openings),
    }


def summary(building: Building) -> list[tuple[str, str]]:
    """Names and values that tell what a model holds."""
    rows = [(name, str(number)) for name, number in counts(building).items() if number]
    for storey in building.storeys:
        measured = sum(wall.thickness_measured for wall in storey.walls)
        rows += [
            (storey.name, f"{storey.height:.3f} m from floor to ceiling"),
            (
                "",
                f"{sum(wall.length for wall in storey.walls):.2f} m of walls, the thickness of {measured} of {len(storey.walls)} measured",
            ),
            ("", f"{sum(room.area for room in storey.rooms):.2f} m2 of rooms"),
        ]
    return rows
