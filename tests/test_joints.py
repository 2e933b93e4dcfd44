"""Joints of random wall graphs: bodies do not overlap, profiles are simple."""

from __future__ import annotations

import itertools

import ifcopenshell
import ifcopenshell.geom
import numpy as np
import pytest
import shapely
from test_graph import wall_table

from indoor_bim.assemble import build_storey
from indoor_bim.export.ifc import to_ifc
from indoor_bim.model import Building
from indoor_bim.plan.joints import footprints, join_without_overlaps, swallowed

HEIGHT = 3.0
CUBIC_CENTIMETRE = 1e-6
Rows = list[tuple[tuple[float, float], tuple[float, float], float]]


def direction(angle: float) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])


def row(rng: np.random.Generator, p: np.ndarray, q: np.ndarray, scatter: float = 0.02) -> tuple:
    usual = (0.05, 0.10, 0.115, 0.175, 0.24, 0.30, 0.36, 0.60)
    thickness = float(rng.choice([*usual, rng.uniform(0.05, 0.6)]))
    return tuple(p + rng.normal(0, scatter, 2)), tuple(q + rng.normal(0, scatter, 2)), thickness


def star(rng: np.random.Generator) -> Rows:
    """L, Y and more: walls that end in one corner."""
    corner = rng.uniform(-5, 5, 2)
    return [row(rng, corner, corner + rng.uniform(1, 8) * direction(a)) for a in rng.uniform(0, 2 * np.pi, rng.integers(2, 7))]


def comb(rng: np.random.Generator) -> Rows:
    """T: walls that end on a long one, at any angle, close to each other."""
    angle = rng.uniform(0, 2 * np.pi)
    feet = rng.uniform(-5.5, 5.5, rng.integers(1, 7))[:, None] * direction(angle)
    turns = angle + rng.choice([-1, 1], len(feet)) * rng.uniform(0.3, np.pi - 0.3, len(feet))
    teeth = [row(rng, foot, foot + rng.uniform(1, 4) * direction(a)) for foot, a in zip(feet, turns, strict=True)]
    return [row(rng, -6 * direction(angle), 6 * direction(angle)), *teeth]


def polygon(rng: np.random.Generator) -> Rows:
    """X and L: a wall right through a ring of others."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 8)))
    corners = [rng.uniform(2, 6) * direction(a) for a in angles]
    through = 5 * direction(rng.uniform(0, np.pi))
    return [row(rng, a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)] + [row(rng, -through, through)]


def crossing(rng: np.random.Generator) -> Rows:
    """Anything: walls thrown down."""
    starts = rng.uniform(-4, 4, (rng.integers(2, 10), 2))
    return [row(rng, p, p + rng.uniform(0.5, 7) * direction(rng.uniform(0, 2 * np.pi))) for p in starts]


def side_by_side(rng: np.random.Generator) -> Rows:
    """Nearly parallel walls that lie partly in each other, and one across."""
    angle = rng.uniform(0, 2 * np.pi)
    rows = []
    for turn in angle + rng.normal(0, 0.02, rng.integers(2, 5)):
        p = rng.normal(0, 0.2, 2) + rng.uniform(-3, 3) * direction(turn)
        rows.append(row(rng, p, p + rng.uniform(0.6, 8) * direction(turn), scatter=0.0))
    across = 3 * direction(angle + rng.uniform(0.3, 2.8))
    return [*rows, row(rng, -across, across)]


def joined(rows: Rows):
    walls = wall_table(*(r for r in rows if np.hypot(*np.subtract(r[1], r[0])) > 0.3))
    return join_without_overlaps(walls, snap=0.3, far_snap=1.5 if len(rows) % 2 else 0.0)


@pytest.mark.parametrize("make", [star, comb, polygon, crossing, side_by_side])
def test_profiles_are_simple_and_bodies_do_not_overlap(make):
    for seed in range(150):
        walls, meetings, outlines = joined(make(np.random.default_rng(seed)))
        storey = build_storey(walls, meetings, outlines, [], floor=0.0, ceiling=HEIGHT)
        profiles = [shapely.Polygon(wall.footprint) for wall in storey.walls]
        assert len(profiles) == len(walls) > 0
        assert all(profile.is_valid and profile.area > 1e-3 for profile in profiles), seed
        for a, b in itertools.combinations(profiles, 2):
            assert a.intersection(b).area * HEIGHT < CUBIC_CENTIMETRE, seed
        assert not swallowed(outlines).any()


@pytest.mark.parametrize("make", [star, comb, polygon, crossing, side_by_side])
def test_no_two_bodies_of_the_ifc_share_a_cubic_centimetre(make):
    settings = ifcopenshell.geom.settings()
    settings.set("use-world-coords", True)
    for seed in range(3):
        walls, meetings, outlines = joined(make(np.random.default_rng(1000 + seed)))
        building = Building("Test", (build_storey(walls, meetings, outlines, [], floor=0.0, ceiling=HEIGHT),))
        file = ifcopenshell.file.from_string(to_ifc(building))
        sections = []
        for wall in file.by_type("IfcWall"):
            shape = ifcopenshell.geom.create_shape(settings, wall).geometry
            corners = np.array(shape.verts).reshape(-1, 3)[np.array(shape.faces).reshape(-1, 3)]
            foot = [shapely.Polygon(t[:, :2]) for t in corners if np.ptp(t[:, 2]) < 1e-6 and t[0, 2] < HEIGHT / 2]
            sections.append(shapely.union_all(foot))
        assert [s.area for s in sections] == pytest.approx([o.area for o in outlines], rel=1e-5)
        for a, b in itertools.combinations(sections, 2):
            assert a.intersection(b).area * HEIGHT < CUBIC_CENTIMETRE, seed


def test_a_wall_that_several_others_cover_is_left_out():
    rows = [((0, 0), (4, 0), 0.3), ((4, 0.01), (8, 0.01), 0.3), ((3, 0), (5, 0), 0.1)]
    walls, _, outlines = joined(rows)
    assert len(walls) == 2
    assert shapely.union_all(outlines).area == pytest.approx(8 * 0.3, abs=1e-3)


def test_a_thick_stub_in_the_midst_of_a_wall_is_left_out():
    rows = ((0, 0), (4, 0), 0.3), ((2, -0.1), (2, 0.1), 0.36)
    outlines = footprints(wall_table(*rows), ())
    assert [outline.area for outline in outlines] == pytest.approx([4 * 0.3, 0.2 * 0.36])
    assert swallowed(outlines).tolist() == [False, True]
    assert len(join_without_overlaps(wall_table(*rows), snap=0.3, far_snap=0.0)[0]) == 1
