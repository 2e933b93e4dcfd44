"""Commands about known buildings: demo and simulate."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from indoor_bim.cli.console import AsJson, Quiet, Verbose, emit, emit_json, progress_bars, say, set_up_messages, warn
from indoor_bim.cli.scan import counts, summary

if TYPE_CHECKING:
    from indoor_bim.model import Building


class House(StrEnum):
    """Known buildings that come with the package."""

    DEMO = "demo"
    ROOM = "room"
    OFFICE = "office"
    STOREYS = "two-storeys"
    ROUNDED = "rounded"


class Profile(StrEnum):
    """Kinds of scan."""

    BACKPACK = "backpack"
    STATIC = "static"
    CLEAN = "clean"


Points = Annotated[int, typer.Option(min=1, help="Number of points.")]
Seed = Annotated[int, typer.Option(help="Draws noise, drift and furniture; the same seed gives the same scan.")]


def simulate(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for scan.laz, trajectory.csv and truth.json.")],
    building: Annotated[House, typer.Option(help="Known building.")] = House.DEMO,
    profile: Annotated[
        Profile, typer.Option(help="Walked backpack, static tripods, or static without errors and furniture.")
    ] = Profile.BACKPACK,
    points: Points = 500_000,
    seed: Seed = 0,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Scan a known building with a virtual LiDAR."""
    from indoor_bim.outputs import prepare_folder

    set_up_messages(quiet=quiet, verbose=verbose)
    folder = prepare_folder(output, formats=())
    for path in _scan(building, profile, points, seed, folder):
        say(str(path), quiet=quiet)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the scan and the results.")] = Path("out/demo"),
    points: Points = 500_000,
    seed: Seed = 0,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Scan a known house with a virtual LiDAR, reconstruct it, and tell how far the model is from the truth."""
    from indoor_bim.export.json import read_json
    from indoor_bim.outputs import prepare_folder
    from indoor_bim.pipeline import reconstruct
    from indoor_bim.quality.compare import compare

    set_up_messages(quiet=quiet, verbose=verbose)
    folder = prepare_folder(output, formats=())
    say(f"Scanning a known house with a virtual LiDAR: {points:,} points, walked, with noise, drift, glass and furniture ...", quiet=quiet)
    scan, _, truth = _scan(House.DEMO, Profile.BACKPACK, points, seed, folder)
    say(f"Reconstructing {scan} ...", quiet=quiet)
    with progress_bars(quiet=quiet) as progress:
        result = reconstruct(scan, folder, progress=progress)
    warn(result.building.warnings, quiet=quiet)
    comparison = compare(result.building, read_json(truth))
    if as_json:
        emit_json({"counts": counts(result.building), "errors": comparison.as_dict(), "seconds": dict(result.timings)})
        return
    emit("\n".join(f"{name:<12}{value}".rstrip() for name, value in summary(result.building)))
    emit("\nErrors against the truth\n")
    emit(comparison.table())
    emit(f"\nResults: {folder}: model.ifc, model.obj, plan.svg, model.json, params.toml")
    emit("Your own scan: .venv/bin/indoor-bim reconstruct SCAN.laz -o OUT")


def _scan(building: House, profile: Profile, points: int, seed: int, folder: Path) -> tuple[Path, Path, Path]:
    from indoor_bim.simulate import simulate as walk
    from indoor_bim.simulate import write_scan

    write_scan(walk(_house(building), profile=profile.value, points=points, seed=seed), folder)
    return folder / "scan.laz", folder / "trajectory.csv", folder / "truth.json"


def _house(name: House) -> Building:
    from indoor_bim.simulate import demo_house, office_floor, rounded_house, single_room, two_storeys

    houses = {
        House.DEMO: demo_house,
        House.ROOM: single_room,
        House.OFFICE: office_floor,
        House.STOREYS: two_storeys,
        House.ROUNDED: rounded_house,
    }
    return houses[name]()
