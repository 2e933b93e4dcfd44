"""What each idea of the method `auto` is worth: leave one out at a time and compare the model with the known building.

Usage: ``python benchmarks/ablation.py [--points 500000] [--only NAME]``. Prints a Markdown table, means over three walked scans.

- ``auto``: everything.
- ``no times``: the path of the scanner and the times of the points are not told; faces have no side, rays no origin.
- ``no minimum cut``: face lines become walls as they are; rooms are what these enclose.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from indoor_bim import Cloud
from indoor_bim.auto import auto_storey
from indoor_bim.cloud.levels import level
from indoor_bim.model import Building, Storey
from indoor_bim.openings import find_openings
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.storey_plan import StoreyPlan
from indoor_bim.quality.compare import compare
from indoor_bim.simulate import SimulatedScan, demo_house, office_floor, simulate, two_storeys
from indoor_bim.storeys import storey_from_plan

CASES: dict[str, tuple[Callable[[], Building], int]] = {
    "demo": (demo_house, 3),
    "office": (lambda: office_floor(offices=4, seed=1), 5),
    "two-storeys": (two_storeys, 6),
}


@dataclass(frozen=True, slots=True)
class Variant:
    """Ideas that are in use."""

    times: bool = True
    minimum_cut: bool = True


VARIANTS = {
    "auto": Variant(),
    "no times": Variant(times=False),
    "no minimum cut": Variant(minimum_cut=False),
}


def reconstruct(scan: SimulatedScan, variant: Variant) -> Building:
    """Run the stages of `auto` that a variant leaves in use."""
    levelled = level(Cloud(scan.points, gps_time=scan.gps_time, trajectory=scan.trajectory))
    times = scan.gps_time if variant.times else None
    path = levelled.trajectory
    sensor = None if times is None or path is None else sensor_positions(path, times)
    storeys: list[Storey] = []
    for number in range(len(levelled.storeys)):
        found = auto_storey(levelled, number, sensor)
        plan = found.plan
        if not variant.minimum_cut:
            faces = Segments.from_ends(*found.lines.ends())
            plan = StoreyPlan(replace(faces, sided=np.ones(len(faces), dtype=bool)), plan.floor, plan.ceiling, seen=plan.seen)
        storey = storey_from_plan(plan, number=number + 1).storey
        if storey.walls:
            storeys.append(find_openings(storey, levelled.points, trajectory=path, gps_time=times))
    return Building("scan", tuple(storeys), transform_cloud_to_model=levelled.frame.rows())


def figures(building: Building, truth: Building) -> list[float]:
    """F1 of walls, rooms, corners, doors and windows; median face distance and thickness error in millimetres."""
    found = compare(building, truth)
    scores = (found.walls, found.rooms_85, found.corners, found.doors, found.windows)
    lengths = (found.faces.median_mm, found.thickness_mm)
    return [np.nan if score.f1 is None else score.f1 for score in scores] + [np.nan if value is None else value for value in lengths]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=500_000, help="points of each scan")
    parser.add_argument("--only", choices=sorted(CASES), help="use this building alone")
    options = parser.parse_args()
    rows: dict[str, list[list[float]]] = {name: [] for name in VARIANTS}
    for case in [options.only] if options.only else CASES:
        make, seed = CASES[case]
        scan = simulate(make(), profile="backpack", points=options.points, seed=seed)
        for name, variant in VARIANTS.items():
            rows[name].append(figures(reconstruct(scan, variant), scan.truth))
    print("| | walls | rooms | corners | doors | windows | faces, mm | thickness, mm |")
    print("|---|---|---|---|---|---|---|---|")
    for name, found in rows.items():
        mean = np.nanmean(np.array(found), axis=0)
        cells = [f"{value:.2f}" for value in mean[:5]] + [f"{value:.1f}" for value in mean[5:]]
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
