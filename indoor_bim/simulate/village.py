"""A known village and the points that a scanner would take of it: walls with windows, eaves, ground, trees and cars.

Points lie on the surfaces at even density; what stands before what is not worked out, sides and stretches that were hidden are
named instead. That makes a scan in a fraction of a second, for demonstrations and tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.frame import Frame
from indoor_bim.model import Point2, Ring
from indoor_bim.outdoor.model import Facade, House, Village

Floats = NDArray[np.float64]

CLUTTER, GROUND, VEGETATION, BUILDING = 1, 2, 5, 6
WINDOW_WIDTH, WINDOW_SILL, WINDOW_HEIGHT, WINDOW_DEPTH = 1.2, 0.9, 1.4, 0.12


@dataclass(frozen=True, slots=True)
class Plot:
    """A house as it stands.

    Parameters
    ----------
    footprint : ring
        Corners of its outer walls, counter-clockwise, metres.
    storeys : int
        Storeys.
    storey_height : float
        Height of each, metres.
    overhang : float
        Width of the eaves, metres.
    hidden : tuple of (int, float, float)
        Stretches without points: number of the side, from, to, metres along it.
    """

    footprint: Ring
    storeys: int = 1
    storey_height: float = 3.0
    overhang: float = 0.4
    hidden: tuple[tuple[int, float, float], ...] = ()

    @property
    def height(self) -> float:
        """Height of the eave above the ground, metres."""
        return self.storeys * self.storey_height


def sample_village() -> tuple[Plot, ...]:
    """Six houses: L, T, U, with a bay, oblique, and a small one."""
    return (
        Plot(placed(((0, 0), (12, 0), (12, 8), (6, 8), (6, 12), (0, 12)), at=(0, 0), turn=17), storeys=2),
        Plot(placed(((0, 0), (10, 0), (10, 7), (7, 7), (7, 11), (3, 11), (3, 7), (0, 7)), at=(24, 0), turn=-8), storeys=1),
        Plot(placed(((0, 0), (14, 0), (14, 9), (9, 9), (9, 5), (5, 5), (5, 9), (0, 9)), at=(50, 2), turn=33), storeys=2),
        Plot(placed(((0, 0), (4, 0), (5, -1.2), (7, -1.2), (8, 0), (12, 0), (12, 8), (0, 8)), at=(0, 26), turn=60), storeys=3),
        Plot(placed(((0, 0), (11, 1), (10, 9), (-1, 8)), at=(25, 24), turn=5), storeys=2),
        Plot(placed(((0, 0), (7, 0), (7, 6), (0, 6)), at=(50, 27), turn=80), storeys=1),
    )


def placed(ring: Sequence[Point2], *, at: Point2, turn: float) -> Ring:
    """Turn a ring by `turn` degrees about its origin and move that to `at`."""
    c, s = cos(turn * pi / 180), sin(turn * pi / 180)
    return tuple((at[0] + c * x - s * y, at[1] + s * x + c * y) for x, y in ring)


def ground_height(xy: Floats) -> Floats:
    """Height (n,) of the rolling ground at points (n, 2), metres."""
    x, y = np.asarray(xy, dtype=np.float64).T
    height: Floats = 0.01 * x + 0.25 * np.sin(0.06 * x + 0.04 * y) + 0.15 * np.cos(0.09 * y)
    return height


def true_village(plots: Sequence[Plot], *, name: str = "village") -> Village:
    """Return the village as a perfect scan would give it.

    Parameters
    ----------
    plots : sequence of Plot
        Houses.
    name : str
        Name of the village.
    """
    houses = []
    for number, plot in enumerate(plots, start=1):
        base = _base(plot)
        sides = zip(plot.footprint, (*plot.footprint[1:], plot.footprint[0]), strict=True)
        facades = tuple(Facade(a, b, True, base + plot.height) for a, b in sides)
        houses.append(House(f"H{number}", plot.footprint, base, base + plot.height, plot.storeys, facades))
    return Village(name, tuple(houses))


def scan_village(
    plots: Sequence[Plot], *, density: float = 120.0, noise: float = 0.015, trees: int = 8, cars: int = 4, seed: int = 1
) -> Cloud:
    """Take points of a village.

    Parameters
    ----------
    plots : sequence of Plot
        Houses.
    density : float
        Points for each square metre of wall; the ground gets a quarter of it.
    noise : float
        Standard deviation of a coordinate, metres.
    trees, cars : int
        How many stand about.
    seed : int
        Seed of all random numbers.

    Returns
    -------
    Cloud
        Points with their ASPRS classes.
    """
    rng = np.random.default_rng(seed)
    parts = [(_ground(plots, rng, density / 4), GROUND)]
    for plot in plots:
        parts.append((_walls(plot, rng, density), BUILDING))
        if plot.overhang > 0:
            parts.append((_soffit(plot, rng, density / 2), BUILDING))
    for place in _free_places(plots, rng, trees, clearance=2.5):
        parts.append((_tree(place, rng), VEGETATION))
    for place in _free_places(plots, rng, cars, clearance=3.0):
        parts.append((_car(place, rng), CLUTTER))
    points = np.concatenate([part for part, _ in parts])
    classes = np.concatenate([np.full(len(part), code, dtype=np.uint8) for part, code in parts])
    points += rng.normal(0.0, noise, points.shape)
    return Cloud(points, Frame.identity(), classification=classes, source="village.laz")


def _base(plot: Plot) -> float:
    corners = np.asarray(plot.footprint)
    ends = np.roll(corners, -1, axis=0)
    steps = np.linspace(0, 1, 21)[:-1]
    along = (corners[:, None] + (ends - corners)[:, None] * steps[:, None]).reshape(-1, 2)
    weight = np.repeat(np.hypot(*(ends - corners).T), len(steps))
    return float(np.average(ground_height(along), weights=weight))


def _walls(plot: Plot, rng: np.random.Generator, density: float) -> Floats:
    base = _base(plot)
    parts = []
    for number, (a, b) in enumerate(zip(plot.footprint, (*plot.footprint[1:], plot.footprint[0]), strict=True)):
        start, end = np.asarray(a), np.asarray(b)
        length = float(np.hypot(*(end - start)))
        d = (end - start) / length
        foot = -0.5
        count = int(density * length * (plot.height - foot))
        along, z = rng.uniform(0, length, count), rng.uniform(foot, plot.height, count)
        depth = np.zeros(count)
        in_pane = (np.abs((along + 0.4) % 3.0 - 1.7) < WINDOW_WIDTH / 2) & (along > 1.0) & (along < length - 1.0)
        in_pane &= (z > 0) & (np.abs(z % plot.storey_height - WINDOW_SILL - WINDOW_HEIGHT / 2) < WINDOW_HEIGHT / 2)
        depth[in_pane] = WINDOW_DEPTH
        keep = ~in_pane | (rng.random(count) < 0.15)
        for side, low, high in plot.hidden:
            if side == number:
                keep &= (along < low) | (along > high)
        xy = start + along[:, None] * d + depth[:, None] * np.array([-d[1], d[0]])
        points = np.column_stack([xy, base + z])[keep]
        parts.append(points[points[:, 2] > ground_height(points[:, :2])])
    return np.concatenate(parts)


def _soffit(plot: Plot, rng: np.random.Generator, density: float) -> Floats:
    import shapely

    house = shapely.Polygon(plot.footprint)
    eaves = house.buffer(plot.overhang, join_style="mitre")
    for number, low, high in plot.hidden:
        a, b = np.asarray(plot.footprint[number]), np.asarray(plot.footprint[(number + 1) % len(plot.footprint)])
        d = (b - a) / np.hypot(*(b - a))
        eaves = eaves.difference(shapely.LineString([a + low * d, a + high * d]).buffer(2 * plot.overhang, cap_style="flat"))
    x, y = _scatter(eaves.bounds, rng, density)
    inside = shapely.contains_xy(eaves, x, y) & ~shapely.contains_xy(house, x, y)
    return np.column_stack([x[inside], y[inside], np.full(inside.sum(), _base(plot) + plot.height)])


def _ground(plots: Sequence[Plot], rng: np.random.Generator, density: float) -> Floats:
    import shapely

    houses = shapely.union_all([shapely.Polygon(plot.footprint) for plot in plots])
    x, y = _scatter(houses.buffer(12.0).bounds, rng, density)
    outside = ~shapely.contains_xy(houses, x, y)
    xy = np.column_stack([x[outside], y[outside]])
    return np.column_stack([xy, ground_height(xy)])


def _scatter(bounds: tuple[float, float, float, float], rng: np.random.Generator, density: float) -> tuple[Floats, Floats]:
    x0, y0, x1, y1 = bounds
    count = ceil(density * (x1 - x0) * (y1 - y0))
    return rng.uniform(x0, x1, count), rng.uniform(y0, y1, count)


def _free_places(plots: Sequence[Plot], rng: np.random.Generator, count: int, *, clearance: float) -> list[Floats]:
    import shapely

    houses = shapely.union_all([shapely.Polygon(plot.footprint) for plot in plots])
    x, y = _scatter(houses.buffer(8.0).bounds, rng, 1.0)
    free = shapely.distance(houses, shapely.points(x, y)) > clearance
    return list(np.column_stack([x[free], y[free]])[:count])


def _tree(place: Floats, rng: np.random.Generator) -> Floats:
    height, radius = rng.uniform(3.0, 8.0), rng.uniform(1.0, 2.0)
    turn, z = rng.uniform(0, 2 * pi, 400), rng.uniform(0, height, 400)
    trunk = np.column_stack([0.12 * np.cos(turn), 0.12 * np.sin(turn), z])
    crown = rng.normal(0, 1, (3000, 3))
    crown *= (radius * rng.random(3000) ** 0.4 / np.linalg.norm(crown, axis=1))[:, None]
    points = np.concatenate([trunk, crown + np.array([0.0, 0.0, height])])
    return np.column_stack([points[:, :2] + place, points[:, 2] + ground_height(place[None])[0]])


def _car(place: Floats, rng: np.random.Generator) -> Floats:
    size = np.array([4.3, 1.8, 1.4])
    points = rng.uniform(0, 1, (2500, 3))
    face = rng.integers(0, 5, 2500)
    points[face == 0, 0], points[face == 1, 0] = 0.0, 1.0
    points[face == 2, 1], points[face == 3, 1] = 0.0, 1.0
    points[face == 4, 2] = 1.0
    points = (points - [0.5, 0.5, 0.0]) * size
    turn = rng.uniform(0, pi)
    xy = points[:, :2] @ np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]]) + place
    return np.column_stack([xy, points[:, 2] + ground_height(place[None])[0]])
