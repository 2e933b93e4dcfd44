"""The tables of the paper behind the method `slices`: how many wall lines are recognised, by their length, and how close corners come.

Usage: ``python benchmarks/line_recognition.py [--only NAME] [--points N] [--scenes DIR]``. Prints two Markdown tables.

- Recognition rate of lines of 5-15, 15-25, 25-35 and more than 35 cm: a line counts as recognised when a line of the result looks the
  same way within 10 degrees, lies within 5 cm (and half the line's length) of it and covers more than half of it; above 35 cm several
  lines may do so together, below 35 cm the line of the result must not be more than twice as long. Once for the completed contour, once
  for the faces of the walls in the model.
- Root mean square error of the corners of the room in a workshop hall with eight corners.

Generated: the hall, and a hall whose walls have steps of 10, 20 and 30 cm, scanned from tripods and walked with a backpack. Scenes that
another scanner simulation made are added where a folder of them is given or lies at ``../shared/scenes``; what their scan did not hit
is not asked for.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_bim import Cloud, reconstruct
from indoor_bim.cloud.read import as_cloud
from indoor_bim.frame import Frame
from indoor_bim.model import Building, Outline, Storey
from indoor_bim.simulate import simulate
from indoor_bim.simulate.layout import door, lay_out_storey, window

Floats = NDArray[np.float64]

CLASSES = ((0.05, 0.15), (0.15, 0.25), (0.25, 0.35), (0.35, math.inf))
NAMES = ("5-15 cm", "15-25 cm", "25-35 cm", "> 35 cm")
OFFSET, COS = 0.05, math.cos(math.radians(10.0))
SEEN = 0.2  # of a line's bins that the scan hit
BIN, NEAR = 0.05, 0.03  # metres
SEAM = 0.002  # metres: walls that are this close touch
SCENES = Path(__file__).resolve().parents[2] / "shared" / "scenes"


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Directed lines (n, 2) to (n, 2) in one frame, free space to the left, metres."""

    p: Floats
    q: Floats

    @property
    def length(self) -> Floats:
        """Lengths in metres."""
        return np.hypot(*(self.q - self.p).T)


def workshop_hall() -> Building:
    """Hall of a workshop with eight corners: 18 x 12 m, 4.5 m high, two corners cut out."""
    ring = [(0.0, 0.0), (18.0, 0.0), (18.0, 8.0), (14.0, 8.0), (14.0, 12.0), (4.0, 12.0), (4.0, 9.0), (0.0, 9.0)]
    openings = [
        [
            door(3.0, width=2.4, height=2.6, hinge="start"),
            window(9.0, width=3.0, sill=1.2, height=1.6),
            window(14.5, width=3.0, sill=1.2, height=1.6),
        ],
        [window(4.0, width=2.4, sill=1.2, height=1.6)],
        [],
        [door(1.8, hinge="end")],
        [window(3.0, width=2.4, sill=1.2, height=1.6), window(7.0, width=2.4, sill=1.2, height=1.6)],
        [],
        [],
        [window(4.5, width=2.4, sill=1.2, height=1.6)],
    ]
    return Building("Workshop hall", (lay_out_storey(1, ring, 0.36, openings, [], [("Hall", (9.0, 5.0))], height=4.5),))


def stepped_hall() -> Building:
    """Hall of 20 x 11 m whose long walls jump forth and back by 10, 20 and 30 cm."""
    steps = (0.10, 0.20, 0.30, 0.10, 0.20, 0.30)
    south, north = [(0.0, 0.0)], [(20.0, 11.0)]
    for side, start, way in ((south, 0.0, 1.0), (north, 11.0, -1.0)):
        y = start
        for k, step in enumerate(steps):
            x = (1.5 + 3.0 * k) if way > 0 else 20.0 - (1.5 + 3.0 * k)
            side += [(x, y), (x, y + way * step), (x + way * 1.4, y + way * step), (x + way * 1.4, y)]
    ring = [(round(x, 3), round(y, 3)) for x, y in [*south, (20.0, 0.0), *north, (0.0, 11.0)]]
    openings = [[] for _ in ring]
    openings[len(ring) - 1] = [door(5.5, hinge="start")]
    return Building("Stepped hall", (lay_out_storey(1, ring, 0.36, openings, [], [("Hall", (10.0, 5.5))], height=3.2),))


def rings_of(outline: Outline) -> Iterator[Floats]:
    """Exterior and holes; the inside of the outline lies to the left."""
    yield np.array(outline.exterior)
    for hole in outline.holes:
        yield np.array(hole)


def lines_of(rings: Sequence[Floats]) -> Lines:
    """Sides of rings."""
    return Lines(np.concatenate(list(rings)), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings]))


def wall_lines(storey: Storey) -> Lines:
    """Faces of the walls of a model: the outline of their footprints, the wall to the right."""
    return faces_of([shapely.Polygon(wall.footprint) for wall in storey.walls])


def faces_of(polygons: Sequence[shapely.Polygon]) -> Lines:
    """Faces of walls: the outline of polygons, the wall to the right; seams where walls touch are no faces."""
    grown = [polygon.buffer(SEAM, join_style="mitre") for polygon in polygons]
    union = shapely.union_all(grown).buffer(-SEAM, join_style="mitre").simplify(SEAM / 2)
    parts = [part for part in shapely.get_parts(union) if part.geom_type == "Polygon"]
    rings = [np.array(ring.coords)[:-1] for part in parts for ring in (part.exterior, *part.interiors)]
    return lines_of([ring if shapely.is_ccw(shapely.LinearRing(ring)) != _is_hole(ring, union) else ring[::-1] for ring in rings])


def _is_hole(ring: Floats, union: shapely.Geometry) -> bool:
    return not union.buffer(1e-4).contains(shapely.Polygon(ring).representative_point())


def recognised(truth: Lines, result: Lines) -> NDArray[np.bool_]:
    """Which lines of the truth are recognised."""
    out = np.zeros(len(truth.p), dtype=bool)
    if not len(result.p):
        return out
    way = (result.q - result.p) / np.maximum(result.length, 1e-9)[:, None]
    for k, (p, q, length) in enumerate(zip(truth.p, truth.q, truth.length, strict=True)):
        d = (q - p) / max(length, 1e-9)
        n = np.array([-d[1], d[0]])
        ends = np.sort([(result.p - p) @ d, (result.q - p) @ d], axis=0)
        overlap = np.minimum(ends[1], length) - np.maximum(ends[0], 0.0)
        offset = np.abs(((result.p + result.q) / 2 - p) @ n)
        hit = (np.abs(way @ d) >= COS) & (offset <= min(OFFSET, length / 2)) & (overlap > 0)
        if length <= CLASSES[-1][0]:
            out[k] = (hit & (overlap > 0.5 * length) & (overlap > 0.5 * result.length)).any()
        else:
            parts = shapely.union_all([shapely.LineString([(a, 0.0), (b, 0.0)]) for a, b in np.clip(ends.T[hit], 0.0, length)])
            out[k] = parts.length > 0.5 * length
    return out


def seen(lines: Lines, points: Floats) -> NDArray[np.bool_]:
    """Lines that enough of was hit between 30 cm above the floor and the ceiling."""
    tree = shapely.STRtree(shapely.points(points[:, :2]))
    out = np.zeros(len(lines.p), dtype=bool)
    for k, (p, q, length) in enumerate(zip(lines.p, lines.q, lines.length, strict=True)):
        near = points[tree.query(shapely.LineString([p, q]), predicate="dwithin", distance=NEAR), :2]
        bins = max(round(length / BIN), 1)
        at = np.clip(((near - p) @ (q - p) / length**2 * bins).astype(np.int64), 0, bins - 1)
        out[k] = (np.bincount(at, minlength=bins) >= 3).mean() >= SEEN
    return out


def in_frame(lines: Lines, matrix: Floats) -> Lines:
    """Lines moved by a 4 x 4 matrix."""

    def move(xy: Floats) -> Floats:
        return (np.column_stack([xy, np.zeros(len(xy)), np.ones(len(xy))]) @ matrix.T)[:, :2]

    return Lines(move(lines.p), move(lines.q))


def row(name: str, truth: Lines, asked: NDArray[np.bool_], results: dict[str, Lines]) -> dict[str, list[tuple[int, int]]]:
    """Print and return found and asked lines of each class for each kind of result."""
    counts = {}
    for kind, lines in results.items():
        found = recognised(truth, lines)
        pairs = []
        for low, high in CLASSES:
            mine = asked & (truth.length > low) & (truth.length <= high)
            pairs.append((int((mine & found).sum()), int(mine.sum())))
        counts[kind] = pairs
        print(f"| {name} | {kind} | " + " | ".join(f"{a / n:.2f} ({a}/{n})" if n else "-" for a, n in pairs) + " |", flush=True)
    return counts


def corner_errors(truth: Floats, result: Floats) -> Floats:
    """Distance of each true corner from the nearest corner of the result, metres."""
    return np.min(np.hypot(*(truth[:, None] - result[None]).transpose(2, 0, 1)), axis=1) if len(result) else np.full(len(truth), np.nan)


def generated(name: str, building: Building, profile: str, *, points: int, seed: int) -> tuple[str, Floats, int] | None:
    """Scan, reconstruct, print recognition; return the errors of the corners of the room and how many the result has."""
    scan = simulate(building, profile=profile, points=points, seed=seed)  # type: ignore[arg-type]
    start = time.perf_counter()
    result = reconstruct(Cloud(scan.points, gps_time=scan.gps_time, trajectory=scan.trajectory), method="slices")
    seconds = time.perf_counter() - start
    to_truth = Frame.from_matrix(scan.truth.transform_cloud_to_model).matrix @ np.linalg.inv(
        Frame.from_matrix(result.building.transform_cloud_to_model).matrix
    )
    truth = lines_of(list(rings_of(building.storeys[0].rooms[0].outline)))
    contour = result.stages["lines"][0].plan.faces
    storey = result.building.storeys[0]
    lines = {"contour": in_frame(Lines(contour.p, contour.q), to_truth), "model": in_frame(wall_lines(storey), to_truth)}
    points = Frame.from_matrix(scan.truth.transform_cloud_to_model).to_local(scan.points)
    walls = points[(points[:, 2] > 0.3) & (points[:, 2] < storey.height - 0.1)]
    row(f"{name}, {profile}, {seconds:.0f} s", truth, seen(truth, walls), lines)
    corners = [in_frame(Lines(ring, ring), to_truth).p for room in storey.rooms for ring in rings_of(room.outline)]
    found = np.concatenate(corners) if corners else np.zeros((0, 2))
    return f"{name}, {profile}", corner_errors(truth.p, found), len(found)


def scene(folder: Path) -> None:
    """Reconstruct a scene with a truth file and print recognition."""
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    cloud = as_cloud(folder / "scan.laz")
    result = reconstruct(folder / "scan.laz", method="slices")
    to_truth = np.array(truth["transform"].get("model_from_cloud_fit") or truth["transform"]["model_from_cloud"])
    raw = cloud.frame.to_scan(cloud.points)
    points = raw @ to_truth[:3, :3].T + to_truth[:3, 3]
    levels = truth["storeys"] if "storeys" in truth else [truth["storey"]]
    unions = truth["wall_union"] if "storeys" in truth else [truth["wall_union"]]
    for number, (level, union) in enumerate(zip(levels, unions, strict=True)):
        if number >= len(result.building.storeys):
            break
        lines = faces_of([shapely.Polygon(polygon[0], polygon[1:]) for polygon in union])
        lines = Lines(lines.p[lines.length > CLASSES[0][0]], lines.q[lines.length > CLASSES[0][0]])
        height = (points[:, 2] > level["floor_z"] + 0.3) & (points[:, 2] < level["ceiling_z"] - 0.1)
        inverse = to_truth @ np.linalg.inv(Frame.from_matrix(result.building.transform_cloud_to_model).matrix)
        contour = result.stages["lines"][number].plan.faces
        found = {
            "contour": in_frame(Lines(contour.p, contour.q), inverse),
            "model": in_frame(wall_lines(result.building.storeys[number]), inverse),
        }
        row(f"{folder.name}{f' {number + 1}' if len(levels) > 1 else ''}", lines, seen(lines, points[height]), found)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="run the cases whose name holds this alone")
    parser.add_argument("--points", type=int, default=1_000_000, help="points of each generated scan")
    parser.add_argument("--scenes", type=Path, default=SCENES, help="folder of scenes with scan.laz and truth.json")
    options = parser.parse_args()
    print(f"| scan | lines of | {' | '.join(NAMES)} |\n|---|---|---|---|---|---|")
    corners = []
    for name, make in (("hall", workshop_hall), ("stepped hall", stepped_hall)):
        for seed, profile in enumerate(("static", "backpack"), 1):
            if not options.only or options.only in f"{name}, {profile}":
                corners.append(generated(name, make(), profile, points=options.points, seed=seed))
    folders = sorted(path.parent for path in options.scenes.glob("*/truth.json")) if options.scenes.is_dir() else []
    for folder in folders:
        if (not options.only or options.only in folder.name) and "houses" not in json.loads(
            (folder / "truth.json").read_text(encoding="utf-8")
        ):
            scene(folder)
    print("\n| scan | corners | of the result | within 5 cm | RMSE, m | largest, m |\n|---|---|---|---|---|---|")
    for found in corners:
        if found is not None:
            name, errors, count = found
            print(
                f"| {name} | {len(errors)} | {count} | {(errors < 0.05).sum()} | {np.sqrt((errors**2).mean()):.4f} | {errors.max():.4f} |"
            )


if __name__ == "__main__":
    main()
