"""What each idea of the method `auto` is worth: leave one out at a time and compare the model with the known building.

Usage: ``python benchmarks/ablation.py [--points 500000] [--only NAME]``. Prints a Markdown table, means over three walked scans of
buildings with curtains, cupboards and people in them. `LEFT_OUT` says what takes the place of each idea.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np

from indoor_bim import Cloud, auto, storeys
from indoor_bim.auto import auto_storey
from indoor_bim.cloud.levels import level
from indoor_bim.model import Building, Storey
from indoor_bim.openings import find_openings
from indoor_bim.plan import line_search
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

EVERYTHING, NO_TIMES, NO_CUT = "everything", "path and times not told", "face lines as walls, no minimum cut"
Stand_in = tuple[Any, str, Callable[..., Any]]
LEFT_OUT: dict[str, tuple[Stand_in, ...]] = {
    EVERYTHING: (),
    NO_TIMES: (),
    NO_CUT: (),
    "one size of strips": ((line_search, "thinly_scanned", lambda points, *_, **__: np.zeros(len(points), dtype=bool)),),
    "lines on strips, not on points": ((line_search, "fit_to_points", lambda lines, points: lines),),
    "curtains and hangings kept": (
        (line_search, "without_curtains", lambda lines, points: lines),
        (line_search, "hangings", lambda lines, evidence: np.zeros(len(lines), dtype=bool)),
    ),
    "drift not asked for": ((line_search, "largest_double", lambda lines, points: 0.0),),
    "hidden walls left open": ((auto, "hidden_wall", lambda cells, wall, *_, **__: np.zeros(len(wall), dtype=bool)),),
    "furniture and niches kept": ((auto, "_behind_built_ins", lambda outlines, folded: tuple(outlines)),),
    "beams kept": ((auto, "without_beams", lambda tails, heads, *_: (tails, heads)),),
    "every wall its own direction": ((storeys, "align_faces", lambda faces: faces),),
    "every wall its own thickness": ((storeys, "share_thickness", lambda walls: walls),),
}


def reconstruct(scan: SimulatedScan, left_out: str) -> Building:
    """Run the stages of `auto` without one of its ideas."""
    levelled = level(Cloud(scan.points, gps_time=scan.gps_time, trajectory=scan.trajectory))
    times = None if left_out == NO_TIMES else scan.gps_time
    found_storeys: list[Storey] = []
    with ExitStack() as stack:
        for module, name, stand_in in LEFT_OUT[left_out]:
            stack.enter_context(mock.patch.object(module, name, stand_in))
        for number in range(len(levelled.storeys)):
            found = auto_storey(levelled, number, times)
            plan = found.plan
            if left_out == NO_CUT:
                faces = Segments.from_ends(*found.lines.ends())
                plan = StoreyPlan(replace(faces, sided=np.ones(len(faces), dtype=bool)), plan.floor, plan.ceiling, seen=plan.seen)
            storey = storey_from_plan(plan, number=number + 1).storey
            if storey.walls:
                found_storeys.append(find_openings(storey, levelled.points, trajectory=levelled.trajectory, gps_time=times))
    return Building("scan", tuple(found_storeys), transform_cloud_to_model=levelled.frame.rows())


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
    rows: dict[str, list[list[float]]] = {name: [] for name in LEFT_OUT}
    for case in [options.only] if options.only else CASES:
        make, seed = CASES[case]
        scan = simulate(make(), profile="backpack", points=options.points, seed=seed)
        for name in LEFT_OUT:
            rows[name].append(figures(reconstruct(scan, name), scan.truth))
    print("| | walls | rooms | corners | doors | windows | faces, mm | thickness, mm |")
    print("|---|---|---|---|---|---|---|---|")
    for name, found in rows.items():
        mean = np.nanmean(np.array(found), axis=0)
        cells = [f"{value:.2f}" for value in mean[:5]] + [f"{value:.1f}" for value in mean[5:]]
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
