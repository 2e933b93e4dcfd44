"""Commands about models: compare, export and check."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from indoor_bim.cli.console import AsJson, Quiet, Verbose, emit, emit_json, say, set_up_messages

Model = Annotated[Path, typer.Argument(metavar="MODEL.json", help="Building model, as `reconstruct` writes it.")]


def compare(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model: .json of `reconstruct`, or anybody's .ifc.")],
    other: Annotated[Path, typer.Argument(metavar="SCAN|MODEL", help="Scan, known building or another model of the same one.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="DIR", help="Folder for deviations as JSON, coloured cloud (PLY) and plan (SVG)."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Measure a model against a scan or another model: wall by wall, in millimetres.

    Two models of `reconstruct` are compared element by element: walls, rooms, corners, doors and windows.
    """
    set_up_messages(quiet=quiet, verbose=verbose)
    if model.suffix.lower() == other.suffix.lower() == ".json" and output is None:
        from indoor_bim.export.json import read_json
        from indoor_bim.quality.compare import compare as measure

        comparison = measure(read_json(model), read_json(other))
        if as_json:
            emit_json(comparison.as_dict())
        else:
            emit(comparison.table())
        return
    from indoor_bim.cloud.read import read
    from indoor_bim.outputs import prepare_folder
    from indoor_bim.quality.against import against_model, against_scan, read_wall_model
    from indoor_bim.quality.deviation_report import deviation_data, deviation_table, write_deviations

    folder = prepare_folder(output, formats=()) if output else None
    walls = read_wall_model(model)
    if other.suffix.lower() in (".json", ".ifc"):
        deviations = against_model(walls, read_wall_model(other))
    else:
        deviations = against_scan(walls, read(other))
    say(deviations.message, quiet=quiet)
    if as_json:
        emit_json(deviation_data(deviations))
    else:
        emit(deviation_table(deviations))
    for path in write_deviations(deviations, walls, folder) if folder else ():
        say(str(path), quiet=quiet)


def export(
    model: Model,
    to: Annotated[
        str, typer.Option("--to", metavar="KIND,...", help="Kinds of file: ifc, obj, ply, gltf, geojson, svg, dxf, pdf, png, json.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder for the files. Default: beside the model.")
    ] = None,
    schema: Annotated[str | None, typer.Option(metavar="IFC4|IFC4X3", help="Schema of the IFC file.")] = None,
    scale: Annotated[str | None, typer.Option(metavar="N", help="Scale of the plans: 100 for 1:100. Default: what fits.")] = None,
    paper: Annotated[str | None, typer.Option(metavar="A4...A0", help="Paper of the plans. Default: what fits.")] = None,
    theme: Annotated[str | None, typer.Option(metavar="print|dark", help="Colours of the plans.")] = None,
    underlay: Annotated[
        Path | None, typer.Option(metavar="SCAN", help="Scan to lay under the plans, the one the model was made of.")
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write a model in other formats.

    `indoor-bim export out/model.json --to ifc,svg,dxf --schema IFC4X3 --scale 100`
    """
    from indoor_bim.config import load_params
    from indoor_bim.errors import ConfigError
    from indoor_bim.export.json import read_json
    from indoor_bim.export.registry import KINDS, write
    from indoor_bim.outputs import plan_style, prepare_folder

    set_up_messages(quiet=quiet, verbose=verbose)
    kinds = [kind.strip().lower().lstrip(".") for kind in to.split(",") if kind.strip()]
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown or not kinds:
        known = ", ".join(sorted(KINDS))
        raise ConfigError(f"--to {to}: {'no writer for ' + unknown[0] if unknown else 'names no kind of file'}; there are {known}")
    chosen = {"ifc.version": schema, "drawing.scale": scale, "drawing.paper": paper, "drawing.theme": theme}
    params = load_params(sets=[f"{name}={value}" for name, value in chosen.items() if value is not None])
    building = read_json(model)
    underlays = {}
    if underlay is not None:
        from indoor_bim.cloud.read import read
        from indoor_bim.quality.density import scan_underlays

        underlays = scan_underlays(building, read(underlay))
    folder = prepare_folder(output, formats=()) if output else model.parent
    for ending in dict.fromkeys(KINDS[kind] for kind in kinds):
        path = folder / (model.stem + ending)
        if path.resolve() == model.resolve():
            continue
        write(building, path, schema=params.ifc.version, style=plan_style(params, underlays))
        say(str(path), quiet=quiet)


def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="IFC file or building model in JSON.")],
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Check an IFC file against its schema, rules and what a model must hold, or a JSON model against its schema."""
    from indoor_bim.errors import ConfigError, ValidationError

    set_up_messages(quiet=quiet, verbose=verbose)
    checked: tuple[str, ...] = ("schema",)
    faults: list[dict[str, str]] = []
    if file.suffix.lower() == ".ifc":
        import dataclasses

        from indoor_bim.quality.check import check_ifc

        report = check_ifc(file)
        checked, faults = report.checked, [dataclasses.asdict(finding) for finding in report.findings]
    elif file.suffix.lower() == ".json":
        from indoor_bim.export.json import read_json

        read_json(file)
    else:
        raise ConfigError(f"{file}: expected a file that ends in .ifc or .json")
    if as_json:
        emit_json({"file": str(file), "valid": not faults, "checked": checked, "faults": faults})
    elif faults:
        emit(_fault_table(faults))
    elif not quiet:
        emit(f"{file}: valid ({', '.join(checked)})")
    if "buildingSMART" in checked and "deliverable" not in checked:
        say("not checked against the deliverable; for that: pip install 'indoor-bim[ids]'", quiet=quiet)
    if faults:
        raise ValidationError(f"{file}: {len(faults)} {'fault' if len(faults) == 1 else 'faults'}")


def _fault_table(faults: list[dict[str, str]]) -> str:
    """One row for each rule that is broken, with the first place where it is, and how often."""
    rows: dict[str, list[dict[str, str]]] = {}
    for fault in faults:
        rows.setdefault(fault["rule"], []).append(fault)
    width = max(len(rule) for rule in rows)
    lines = [f"{'':8} {'count':>5}  {'rule':<{width}}  first"]
    for rule, found in rows.items():
        first = " ".join(f"{found[0]['message']} {found[0]['entity']}".split())
        lines.append(f"{found[0]['severity']:8} {len(found):5}  {rule:<{width}}  {first}")
    return "\n".join(lines)
