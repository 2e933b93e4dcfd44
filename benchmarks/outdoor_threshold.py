"""Vertices and areas of footprints against the threshold of the simplification, by the published way.

The counterpart of table 2 of Sensors 2024, 24, 5723 (2091 vertices before, 934 at 179.5, 523 at 179.0, 326 at 178.0 degrees),
and the default way for comparison. Usage: ``python benchmarks/outdoor_threshold.py [SCAN]``; without a scan, a simulated village.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.cloud.read import read
from indoor_bim.errors import NothingToReconstructError
from indoor_bim.houses import houses
from indoor_bim.outdoor.model import shoelace
from indoor_bim.outdoor.scene import see_scene
from indoor_bim.outdoor.topology import outlines
from indoor_bim.outdoor.wall_cells import upright_points
from indoor_bim.simulate.village import sample_village, scan_village

THRESHOLDS = (179.5, 179.0, 178.0)


def table(cloud: Cloud) -> str:
    """Markdown table of one scan."""
    scene = see_scene(cloud.points, cloud.classification)
    if scene is None:
        raise NothingToReconstructError(f"{cloud.source}: found no ground")
    walls = upright_points(scene.building, scene.above_ground)
    points, above_ground = scene.building[walls], scene.above_ground[walls]
    rows = []
    for threshold in (180.0, *THRESHOLDS):
        rings = outlines(points, above_ground, angle=threshold)
        area = sum(shoelace(tuple(map(tuple, ring.tolist())))[0] for ring in rings)
        rows.append((threshold, sum(len(ring) for ring in rings), area))
    (_, all_vertices, whole), *simplified = rows
    lines = [
        "| way | threshold | vertices | area m² | fewer vertices | area changed by |",
        "|---|---|---|---|---|---|",
        f"| topology | none | {all_vertices} | {whole:.4f} | 0.00 % | 0.000 ‰ |",
    ]
    for threshold, vertices, area in simplified:
        fewer, changed = 100 * (1 - vertices / all_vertices), 1000 * abs(area / whole - 1)
        lines.append(f"| topology | {threshold}° | {vertices} | {area:.4f} | {fewer:.2f} % | {changed:.3f} ‰ |")
    found = houses(cloud).village.houses
    lines.append(f"| lines | — | {sum(len(house.footprint) for house in found)} | {sum(house.area for house in found):.4f} | | |")
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scan", nargs="?", type=Path, help="outdoor scan; default: a simulated village")
    scan = parser.parse_args().scan
    print(table(read(scan, trajectory=False) if scan else scan_village(sample_village())))


if __name__ == "__main__":
    main()
