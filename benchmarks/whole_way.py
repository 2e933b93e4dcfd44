"""Time and memory of the whole way from a LAZ file to the model, beside laspy reading the same file; how both grow with the file.

Usage: ``python benchmarks/whole_way.py [--points 200_000,2_000_000,20_000_000] [--rounds 3] [--max-memory GIGABYTES] [--floors 1]``.
Nothing is written; imports and the loading of compiled code do not count. Every figure is the least of the rounds, each in a process of
its own. Scans are simulated once and kept (`conftest.office_scan`).
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

from conftest import office_scan

PROGRAM = """
import json, resource, sys, time
import laspy, indoor_bim
from indoor_bim.config import load_params
what, path, warm, memory = sys.argv[1:]
params = load_params(sets=[f"read.max_memory={memory}"] if memory != "None" else [])
work = laspy.read if what == "laspy" else lambda file: indoor_bim.reconstruct(file, params=params)
if what != "laspy":
    work(warm)
clock, processor = time.perf_counter(), time.process_time()
done = work(path)
found = {"clock": time.perf_counter() - clock, "processor": time.process_time() - processor}
found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
found["stages"] = {} if what == "laspy" else {name: round(seconds, 2) for name, seconds in done.timings.items()}
print(json.dumps(found))
"""


def measured(what: str, path: Path, warm: Path, *, rounds: int, memory: float | None) -> dict[str, float]:
    """Least seconds and gigabytes of some rounds."""
    runs = []
    for _ in range(rounds):
        command = [sys.executable, "-c", PROGRAM, what, str(path), str(warm), str(memory)]
        runs.append(json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout))
    best = min(runs, key=lambda run: run["clock"])
    return best | {key: min(run[key] for run in runs) for key in ("clock", "processor", "memory")}


def main() -> None:
    """Print one row for each size."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--points", default="200_000,2_000_000,20_000_000")
    options.add_argument("--rounds", type=int, default=3)
    options.add_argument("--max-memory", type=float)
    options.add_argument("--floors", type=int, default=1, help="office floors side by side that the points are spread over")
    chosen = options.parse_args()
    warm = office_scan(200_000)
    before: dict[str, float] | None = None
    print("      points | laspy: clock, processor | auto: clock, processor, GB | ratio of clocks, processors | growth")
    for count in (int(text) for text in chosen.points.split(",")):
        path = office_scan(count, floors=chosen.floors)
        laspy = measured("laspy", path, warm, rounds=chosen.rounds, memory=None)
        auto = measured("auto", path, warm, rounds=chosen.rounds, memory=chosen.max_memory)
        ratios = f"{auto['clock'] / laspy['clock']:5.1f} {auto['processor'] / laspy['processor']:5.1f}"
        growth = f"{auto['processor'] / before['processor']:.1f}" if before else ""
        print(
            f"{count:12,} | {laspy['clock']:6.2f} {laspy['processor']:6.2f} | {auto['clock']:7.2f} {auto['processor']:6.2f} "
            f"{auto['memory']:5.2f} | {ratios} | {growth}  {auto['stages']}",
            flush=True,
        )
        before = auto


if __name__ == "__main__":
    main()
