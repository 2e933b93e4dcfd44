"""Accuracy ratchet: reconstruct virtual scans of known buildings and refuse figures worse than the recorded ones.

Usage: ``python benchmarks/accuracy.py [--method auto] [--only NAME] [--update]``. The record is ``accuracy.json`` beside this
file. Exit code 1 names every figure that fell; ``--update`` records the present figures.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from indoor_bim.model import Building
from indoor_bim.quality.compare import compare
from indoor_bim.quality.comparison import Comparison
from indoor_bim.simulate import demo_house, office_floor, rounded_house, simulate, single_room, two_storeys, write_scan
from indoor_bim.simulate.scanner import Profile

RECORD = Path(__file__).with_name("accuracy.json")
POINTS = 500_000
SHARE_TOLERANCE = 0.03  # less than one element in a case: what another processor may change
LENGTH_TOLERANCE_MM, LENGTH_TOLERANCE_SHARE = 0.5, 0.10

CASES: dict[str, tuple[Callable[[], Building], Profile, int]] = {
    "demo-clean": (demo_house, "clean", 1),
    "demo-static": (demo_house, "static", 2),
    "demo-backpack": (demo_house, "backpack", 3),
    "cut-corner-backpack": (lambda: single_room(cut_corner=1.5), "backpack", 4),
    "office-backpack": (lambda: office_floor(offices=4, seed=1), "backpack", 5),
    "two-storeys-backpack": (two_storeys, "backpack", 6),
    "rounded-clean": (rounded_house, "clean", 7),
    "rounded-static": (rounded_house, "static", 8),
    "rounded-backpack": (rounded_house, "backpack", 9),
}

Figures = dict[str, float | None]


def figures(comparison: Comparison) -> Figures:
    """Figures of a comparison: shares, where more is better, and lengths named ``_mm``, where less is better."""
    faces = comparison.faces
    return {
        "storey_f1": comparison.storeys.f1,
        "wall_f1": comparison.walls.f1,
        "completeness": faces.completeness,
        "correctness": faces.correctness,
        "corner_f1": comparison.corners.f1,
        "room50_f1": comparison.rooms_50.f1,
        "room85_f1": comparison.rooms_85.f1,
        "door_f1": comparison.doors.f1,
        "window_f1": comparison.windows.f1,
        "face_median_mm": faces.median_mm,
        "face_p95_mm": faces.p95_mm,
        "thickness_mm": comparison.thickness_mm,
        "height_mm": comparison.height_mm,
        "length_mm": comparison.length_mm,
        "width_mm": comparison.width_mm,
    }


def fallen(case: str, recorded: Figures, measured: Figures) -> list[str]:
    """Sentences on all figures of a case that are worse than recorded by more than the tolerance."""
    sentences = []
    for name, before in recorded.items():
        now = measured.get(name)
        if before is None:
            continue
        if name.endswith("_mm"):
            limit = before * (1 + LENGTH_TOLERANCE_SHARE) + LENGTH_TOLERANCE_MM
            worse = now is None or now > limit
        else:
            limit = before - SHARE_TOLERANCE
            worse = now is None or now < limit
        if worse:
            sentences.append(f"{case}: {name} fell from {before:.4g} to {'nothing' if now is None else f'{now:.4g}'} (limit {limit:.4g})")
    return sentences


def measure(case: str, *, method: str) -> Figures:
    """Simulate, reconstruct and compare one case."""
    from indoor_bim.cloud.read import read
    from indoor_bim.pipeline import reconstruct

    make, profile, seed = CASES[case]
    scan = simulate(make(), profile=profile, points=POINTS, seed=seed)
    with TemporaryDirectory() as folder:
        write_scan(scan, folder)
        result = reconstruct(read(Path(folder, "scan.laz")), method=method)
    rounded = {name: None if value is None else round(value, 4) for name, value in figures(compare(result.building, scan.truth)).items()}
    return rounded


def main(arguments: list[str] | None = None) -> int:
    """Run the ratchet; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--method", default="auto", help="reconstruction method")
    parser.add_argument("--only", choices=sorted(CASES), help="run this case alone")
    parser.add_argument("--update", action="store_true", help="record the present figures")
    options = parser.parse_args(arguments)
    record: dict[str, dict[str, Figures]] = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    known = record.setdefault(options.method, {})
    complaints: list[str] = []
    for case in [options.only] if options.only else list(CASES):
        start = time.perf_counter()
        measured = measure(case, method=options.method)
        texts = (
            f"{name} {'-' if value is None else format(value, '.1f' if name.endswith('_mm') else '.3f')}"
            for name, value in measured.items()
        )
        print(f"{case} ({time.perf_counter() - start:.0f} s): {', '.join(texts)}")
        if options.update:
            known[case] = measured
        elif case not in known:
            complaints.append(f"{case}: not recorded for method {options.method}; run with --update")
        else:
            complaints += fallen(case, known[case], measured)
    if options.update:
        RECORD.write_text(json.dumps(record, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
