"""Draw every picture of the documentation from the package's own virtual scans. Usage: python scripts/pictures.py [FOLDER]."""

from __future__ import annotations

import io
import os
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from PIL import Image

import indoor_bim
from indoor_bim.auto import AutoStages, auto_storey
from indoor_bim.cloud.cloud import CEILING, FLOOR, WALL, Cloud, LevelledCloud
from indoor_bim.cloud.levels import thin
from indoor_bim.cloud.pca_levelling import level_by_pca
from indoor_bim.export.svg import write_plans
from indoor_bim.methods import METHODS
from indoor_bim.model import Storey
from indoor_bim.params import Params
from indoor_bim.plan import evidence as ev
from indoor_bim.plan.overhead import fill_nearest, overhead_surface
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.scanner_path import sensor_positions
from indoor_bim.plan.strips import BELOW_CEILING, sweep
from indoor_bim.simulate import demo_house, rounded_house, simulate, write_scan
from indoor_bim.slope import SlopeStages, slope_stages
from indoor_bim.stages import Stages
from indoor_bim.wall_views import picture_png, wall_views

FOLDER = Path(__file__).parent.parent / "docs" / "images"
WIDTH = 7.2  # inches
Window = tuple[float, float, float, float]
FREE, SOLID, INK, RED = "#cfe3f5", "#f3f0ea", "#222222", "#c0392b"
SLOPES = (RED, INK, "#27ae60", "#2e7fc1")  # of slope -1, 0, 1 and vertical


def main(folder: Path = FOLDER) -> None:
    """Scan the demonstration house, run both methods stage by stage and draw what each stage made."""
    plt.rcParams.update({"font.size": 8, "axes.titlesize": 9, "axes.linewidth": 0.5, "figure.constrained_layout.use": True})
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        house, rounded = (Path(scratch) / name for name in ("house", "house with curved walls"))
        write_scan(simulate(demo_house(), profile="backpack", points=500_000, seed=0), house)
        draw_auto(indoor_bim.read(house / "scan.laz"), folder)
        write_plans(indoor_bim.reconstruct(house / "scan.laz").building, folder / "plan.svg")
        write_scan(simulate(rounded_house(), profile="backpack", points=500_000, seed=0), rounded)
        write_plans(indoor_bim.reconstruct(rounded / "scan.laz").building, folder / "rounded.svg")
    draw_slope(indoor_bim.cloud.read.as_cloud(simulate(demo_house(), profile="static", points=300_000, seed=1).points), folder)


def draw_auto(cloud: Cloud, folder: Path) -> None:
    """Stages of the default method."""
    stages = Stages()
    storey = METHODS["auto"](cloud, Params(), stages).storeys[0]
    levelled: LevelledCloud = stages.products["level"]
    sensor = None
    if cloud.gps_time is not None and levelled.trajectory is not None:
        sensor = sensor_positions(levelled.trajectory, cloud.gps_time)
    found = auto_storey(levelled, 0, cloud.gps_time)
    around = window(storey)
    save(folder / "level.png", section(cloud, levelled, around))
    save(folder / "evidence.png", evidence(levelled, sensor, around))
    save(folder / "face_lines.png", lines(found, around))
    save(folder / "cells.png", cells(found, around))
    save(folder / "rooms.png", rooms(found, around))
    save(folder / "walls.png", walls(storey, around))
    views = list(wall_views(storey, levelled.points, trajectory=levelled.trajectory, gps_time=cloud.gps_time))
    best = max(views, key=lambda view: (len({o.kind for o in view.wall.openings}), len(view.wall.openings), view.wall.length))
    save(folder / "wall_picture.png", wall_picture(picture_png(best), best.wall.length, best.wall.height))


def draw_slope(cloud: Cloud, folder: Path) -> None:
    """Stages of the published method."""
    levelled = level_by_pca(cloud)
    found = slope_stages(levelled)
    storey = indoor_bim.reconstruct(cloud, method="slope").building.storeys[0]
    around = window(storey)
    save(folder / "slope_filter.png", slope_filter(levelled, found, around))
    save(folder / "slope_image.png", slope_image(found, around))
    save(folder / "slope_lines.png", slope_lines(found, around))
    save(folder / "slope_walls.png", walls(storey, around))


def window(storey: Storey, *, margin: float = 0.8) -> Window:
    """Left, right, bottom and top of what is drawn, metres."""
    corners = np.concatenate([np.array(wall.footprint) for wall in storey.walls])
    (left, bottom), (right, top) = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    return float(left), float(right), float(bottom), float(top)


def section(cloud: Cloud, levelled: LevelledCloud, around: Window) -> Figure:
    """Slice through the scan as it came and as it was levelled."""
    figure, axes = plt.subplots(2, 1, figsize=(WIDTH * 0.75, 4.0))
    x, y = levelled.points[:, 0], levelled.points[:, 1]
    slab = (np.abs(y - (around[2] + around[3]) / 2) < 0.3) & (x > around[0] - 1) & (x < around[1] + 1)
    storey = levelled.storeys[0]
    along = levelled.frame.rotation @ cloud.frame.rotation.T
    tilted = cloud.points[slab] @ np.column_stack([along[0] * [1, 1, 0] / np.hypot(*along[0, :2]), [0.0, 0.0, 1.0]])
    for axis, points, title in ((axes[0], tilted, "as scanned"), (axes[1], levelled.points[slab][:, [0, 2]], "levelled")):
        axis.scatter(*points.T, s=0.05, color=INK, rasterized=True)
        axis.set(aspect="equal", title=title, ylabel="metres")
    for height, name in ((storey.floor, "floor"), (storey.ceiling, "ceiling")):
        if height is not None:
            axes[1].axhline(height, color=RED, linewidth=0.8)
            axes[1].annotate(f"{name} {height:.3f} m", (around[0] - 1, height), color=RED, va="bottom", fontsize=7)
    return figure


def evidence(levelled: LevelledCloud, sensor: np.ndarray | None, around: Window) -> Figure:
    """All points in plan, the ceiling, and the walls right below it."""
    storey = levelled.storeys[0]
    floor, top = storey.floor or 0.0, (storey.ceiling or 2.5) + 0.15
    overhead = overhead_surface(thin(levelled.points), floor=floor, top=top)
    if overhead is None:
        raise SystemExit("the scan shows no ceiling")
    spots = overhead.centre(np.argwhere(~np.isnan(overhead.image)))
    low, high = spots.min(axis=0) - 1.2, spots.max(axis=0) + 1.2
    near = ((levelled.points[:, :2] > low) & (levelled.points[:, :2] < high)).all(axis=1) & (levelled.points[:, 2] < top)
    points, seen_from = levelled.points[near], None if sensor is None else sensor[near]
    filled = fill_nearest(overhead)
    candidates = ev.wall_points(points, seen_from, filled, floor=floor)
    hits, column = ev.overhead_hits(points, candidates, filled, low=low, high=high, cell=0.025)
    density = ev.local_density(hits.image, ~column, cell=0.025)
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.9), sharex=True, sharey=True)
    count = ev.hit_raster(candidates.xy, low=low, high=high, cell=0.05)
    axes[0].imshow(count.image, extent=extent(count), origin="lower", cmap="gray_r", interpolation="nearest")
    axes[1].imshow(density, extent=extent(hits), origin="lower", cmap="Blues", interpolation="nearest")
    shown = np.zeros((int((high[1] - low[1]) / 0.05) + 1, int((high[0] - low[0]) / 0.05) + 1))
    for angle in (0.0, np.pi / 2):
        swept = sweep(candidates, angle)
        best = swept.evidence.whole().max(axis=0)
        u, v = np.nonzero(best)
        a, b = swept.low[0] + (u + 0.5) * BELOW_CEILING.along, swept.low[1] + (v + 0.5) * BELOW_CEILING.across
        for shift in (-0.025, 0.025):
            spot = np.column_stack([np.cos(angle) * (a + shift) - np.sin(angle) * b, np.sin(angle) * (a + shift) + np.cos(angle) * b])
            rc = np.floor((spot - low) / 0.05).astype(int)[:, ::-1]
            inside = ((rc >= 0) & (rc < shown.shape)).all(axis=1)
            np.maximum.at(shown, tuple(rc[inside].T), best[u, v][inside])
    size = shown.shape[1] * 0.05, shown.shape[0] * 0.05
    axes[2].imshow(
        shown, extent=(low[0], low[0] + size[0], low[1], low[1] + size[1]), origin="lower", cmap="gray_r", interpolation="nearest"
    )
    for axis, title in zip(axes, ("between floor and ceiling", "ceiling", "walls, right below the ceiling"), strict=True):
        axis.set(title=title, aspect="equal", xlim=around[:2], ylim=around[2:])
    return figure


def lines(found: AutoStages, around: Window) -> Figure:
    """Face lines with a tick into the free space."""
    figure, axis = plt.subplots(figsize=(WIDTH * 0.75, 4.2))
    p, q = found.lines.ends()
    axis.add_collection(LineCollection(np.stack([p, q], axis=1), colors=INK, linewidths=1.2))
    middle = (p + q) / 2
    axis.add_collection(LineCollection(np.stack([middle, middle + 0.35 * found.lines.normal], axis=1), colors=RED, linewidths=1))
    return framed(figure, axis, around, f"{len(p)} face lines; the tick points to where the face was seen from")


def cells(found: AutoStages, around: Window) -> Figure:
    """Cells with the evidence for free space, edges with that for walls."""
    figure, axis = plt.subplots(figsize=(WIDTH * 0.75, 4.2))
    area = np.array([polygon.area for polygon in found.cells.polygons])
    share = np.clip(found.inside / area, -1, 1)
    rings = [np.asarray(polygon.exterior.coords) for polygon in found.cells.polygons]
    axis.add_collection(PolyCollection(rings, array=share, cmap="RdBu", clim=(-1, 1), edgecolors="#999999", linewidths=0.2))
    ends = np.stack([found.cells.edge_start, found.cells.edge_end], axis=1)
    strong = found.wall > 0.1
    axis.add_collection(LineCollection(ends[strong], colors="black", linewidths=1.6 * found.wall[strong]))
    return framed(figure, axis, around, f"{len(area)} cells: blue free, red solid; thick edges: wall seen")


def rooms(found: AutoStages, around: Window) -> Figure:
    """Cells called room, and the outlines made of them."""
    figure, axis = plt.subplots(figsize=(WIDTH * 0.75, 4.2))
    rings = [np.asarray(polygon.exterior.coords) for polygon in found.cells.polygons]
    colours = [FREE if room else SOLID for room in found.room]
    axis.add_collection(PolyCollection(rings, facecolors=colours, edgecolors="#bbbbbb", linewidths=0.2))
    for outline in found.outlines:
        for ring in (outline.exterior, *outline.holes):
            axis.plot(*np.array([*ring.corners, ring.corners[0]]).T, color=INK, linewidth=1.2)
    return framed(figure, axis, around, f"{int(found.room.sum())} cells are room; {len(found.outlines)} rooms")


def walls(storey: Storey, around: Window) -> Figure:
    """Walls with resolved joints, openings and rooms."""
    figure, axis = plt.subplots(figsize=(WIDTH * 0.75, 4.2))
    for room in storey.rooms:
        axis.fill(*np.transpose(room.outline.exterior), color=FREE)
        spot = room.outline.polygon.representative_point()
        axis.text(spot.x, spot.y, f"{room.area:.1f} m²", ha="center", va="center", fontsize=7)
    for wall in storey.walls:
        colour = "#555555" if wall.thickness_measured else "#bbbbbb"
        axis.fill(*np.transpose(wall.footprint), facecolor=colour, edgecolor="black", linewidth=0.5)
        (x, y), (x1, y1) = wall.axis
        direction = np.array([x1 - x, y1 - y]) / wall.length
        for opening in wall.openings:
            ends = np.array([x, y]) + np.outer([opening.start, opening.start + opening.width], direction)
            axis.plot(*ends.T, color={"door": RED, "window": "#2e7fc1"}.get(opening.kind, "#e09030"), linewidth=2.5, solid_capstyle="butt")
    measured = sum(wall.thickness_measured for wall in storey.walls)
    return framed(figure, axis, around, f"{len(storey.walls)} walls; dark: both faces seen ({measured}), light: one")


def wall_picture(png: bytes, length: float, height: float) -> Figure:
    """One wall as the scan saw it."""
    figure, axis = plt.subplots(figsize=(WIDTH, 2.0))
    axis.imshow(Image.open(io.BytesIO(png)), extent=(0, length, 0, height), interpolation="nearest", aspect="equal")
    axis.set(xlabel="along the wall, metres", ylabel="up, metres")
    return figure


def slope_filter(levelled: LevelledCloud, found: SlopeStages, around: Window) -> Figure:
    """Projected wall points before and after the outlier removal."""
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.6), sharex=True, sharey=True)
    flat = levelled.points[(levelled.part == FLOOR) | (levelled.part == CEILING)]
    between = levelled.points[levelled.part == WALL]
    for axis, points, title in zip(axes, (flat, between, found.walls), ("floor and ceiling", "the rest", "outliers removed"), strict=True):
        axis.scatter(points[:, 0], points[:, 1], s=0.02, color=INK, rasterized=True)
        axis.set(title=title, aspect="equal", xlim=around[:2], ylim=around[2:])
    return figure


def slope_image(found: SlopeStages, around: Window) -> Figure:
    """Corner of the wall image, its skeleton and the slopes of its pixels."""
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.6), sharex=True, sharey=True)
    slopes = np.where(found.skeleton.image, found.slopes.image, np.nan).astype(float)
    axes[0].imshow(found.image.image, origin="lower", cmap="gray_r", interpolation="nearest")
    axes[1].imshow(found.skeleton.image, origin="lower", cmap="gray_r", interpolation="nearest")
    axes[2].imshow(slopes, origin="lower", cmap=ListedColormap(SLOPES), vmin=-1.5, vmax=2.5, interpolation="nearest")
    for axis, title in zip(axes, ("image", "skeleton", "slopes"), strict=True):
        axis.set(title=title, aspect="equal", xticks=[], yticks=[])
    corner = (np.array([around[1] - 5.0, around[2] + 0.5]) - found.image.origin) / found.image.cell
    size = 4.5 / found.image.cell
    axes[0].set(xlim=(corner[0], corner[0] + size), ylim=(corner[1], corner[1] + size))
    return figure


def slope_lines(found: SlopeStages, around: Window) -> Figure:
    """Lines over the points they were found in."""
    figure, axis = plt.subplots(figsize=(WIDTH * 0.75, 4.2))
    axis.scatter(found.walls[:, 0], found.walls[:, 1], s=0.02, color="#bbbbbb", rasterized=True)
    faces = found.segments
    axis.add_collection(
        LineCollection(np.stack([faces.p, faces.q], axis=1), colors=[f"C{k % 10}" for k in range(len(faces))], linewidths=1.5)
    )
    return framed(figure, axis, around, f"{len(faces)} lines")


def framed(figure: Figure, axis: Axes, around: Window, title: str) -> Figure:
    """Axis in metres at true proportions."""
    axis.set(aspect="equal", xlim=around[:2], ylim=around[2:], title=title, xlabel="x, metres", ylabel="y, metres")
    return figure


def extent(raster: Raster) -> tuple[float, float, float, float]:
    """Borders of a raster for imshow: left, right, bottom, top."""
    rows, columns = raster.image.shape
    return (
        float(raster.origin[0]),
        float(raster.origin[0] + columns * raster.cell),
        float(raster.origin[1]),
        float(raster.origin[1] + rows * raster.cell),
    )


def save(path: Path, figure: Figure, *, dpi: int = 130, colours: int = 64) -> None:
    """Write a figure as a small palette PNG; the same figure gives the same bytes."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi, metadata={"Software": None})
    plt.close(figure)
    image = Image.open(drawn).convert("RGB").quantize(colours, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    part = path.with_suffix(".part")
    image.save(part, format="PNG", optimize=True)
    os.replace(part, path)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
