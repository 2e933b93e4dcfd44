"""Commands about models: compare, export and check."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from indoor_bim.cli.console import AsJson, Quiet, Verbose, emit, emit_json, say, set_up_messages

Model = Annotated[Path, typer.Argument(metavar="MODEL.json", help="Building model, as `reconstruct` writes it.")]


def compare(
    model: Model,
    truth: Annotated[Path, typer.Argument(metavar="TRUTH.json", help="Known building, or another model of the same one.")],
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Measure how far a model is from the truth, or from another model, in millimetres."""
    from indoor_bim.export.json import read_json
    from indoor_bim.quality.compare import compare as measure

    set_up_messages(quiet=quiet, verbose=verbose)
    comparison = measure(read_json(model), read_json(truth))
    if as_json:
        emit_json(comparison.as_dict())
    else:
        emit(comparison.table())


def export(
    model: Model,
    to: Annotated[str, typer.Option("--to", metavar="KIND,...", help="Kinds of file: ifc, obj, ply, svg, json.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder for the files. Default: beside the model.")
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write a model in other formats.

    `indoor-bim export out/model.json --to ifc,svg`
    """
    from indoor_bim.errors import ConfigError
    from indoor_bim.export.json import read_json
    from indoor_bim.export.registry import WRITERS, write
    from indoor_bim.outputs import prepare_folder

    set_up_messages(quiet=quiet, verbose=verbose)
    endings = list(dict.fromkeys("." + kind.strip().lower().lstrip(".") for kind in to.split(",") if kind.strip()))
    unknown = [ending for ending in endings if ending not in WRITERS]
    if unknown or not endings:
        known = ", ".join(ending[1:] for ending in sorted(WRITERS))
        raise ConfigError(f"--to {to}: {'no writer for ' + unknown[0][1:] if unknown else 'names no kind of file'}; there are {known}")
    building = read_json(model)
    folder = prepare_folder(output, formats=()) if output else model.parent
    for ending in endings:
        path = folder / (model.stem + ending)
        if path.resolve() == model.resolve():
            continue
        write(building, path)
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
        emit("\n".join(" ".join(f"{fault['rule']}: {fault['message']} {fault['entity']}".split()) for fault in faults))
    elif not quiet:
        emit(f"{file}: valid ({', '.join(checked)})")
    if faults:
        raise ValidationError(f"{file}: {len(faults)} {'fault' if len(faults) == 1 else 'faults'}")
