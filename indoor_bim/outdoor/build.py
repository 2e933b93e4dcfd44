"""Houses of the model from the sides of footprints and the points about them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Evidence, Point2, Ring
from indoor_bim.outdoor.edges import FittedEdge, near_segment
from indoor_bim.outdoor.footprint import WallPoints
from indoor_bim.outdoor.heights import base_height, common_top, count_storeys, eave_height, wall_top
from indoor_bim.outdoor.model import Facade, House, shoelace
from indoor_bim.outdoor.terrain import Terrain
from indoor_bim.outdoor.topology import whole_storeys

Floats = NDArray[np.float64]

LEAST_HEIGHT = 1.8
AGREEING, LEAST_AGREEING = 0.15, 0.6
OTHER_HOUSE = 1.0
BESIDE = 0.3


def make_houses(footprints: list[list[FittedEdge]], walls: WallPoints, terrain: Terrain, *, storey_height: float) -> tuple[House, ...]:
    """Give footprints their heights, storeys and evidence.

    Parameters
    ----------
    footprints : list of list of FittedEdge
        Sides of each house, counter-clockwise.
    walls : WallPoints
        Points that may be of walls.
    terrain : Terrain
        Ground heights.
    storey_height : float
        Usual height of a storey, metres.

    Returns
    -------
    tuple of House
        Sorted by place; footprints without walls of a man's height are left out.
    """
    houses = []
    for edges in footprints:
        corners = np.array([edge.start for edge in edges])
        near = walls.about(corners)
        base = base_height(terrain, corners)
        tops = [wall_top(edge, near, foot=base) if edge.fitted else None for edge in edges]
        eave = _eave(edges, tops, near, base)
        if eave is None or eave - base < LEAST_HEIGHT:
            continue
        facades = tuple(_facade(edge, top) for edge, top in zip(edges, tops, strict=True))
        houses.append(_house(corners, base, eave, count_storeys(eave - base, storey_height), facades))
    return _numbered(houses)


def make_published_houses(rings: list[Floats], walls: Floats, *, storey_height: float) -> tuple[House, ...]:
    """Give outlines the heights of the highest and the lowest wall point about them (Sensors 2024, 24, 5723, section 2.2).

    Parameters
    ----------
    rings : list of (m, 2) float64
        Corners of each footprint, counter-clockwise, metres.
    walls : (n, 3) float64
        Wall points, metres.
    storey_height : float
        Height of a storey, metres.

    Returns
    -------
    tuple of House
        Sorted by place.
    """
    houses = []
    sorted_walls = WallPoints(walls[np.lexsort((walls[:, 2], walls[:, 1], walls[:, 0]))])
    for ring in rings:
        near = sorted_walls.about(ring)
        beside = np.zeros(len(near), dtype=np.bool_)
        facades = []
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            _, across, rows = near_segment(near[:, :2], a, b, band=BESIDE)
            beside[rows] = True
            rmse = float(np.sqrt(np.mean(across**2))) if len(rows) else None
            facades.append(Facade(_point(a), _point(b), len(rows) > 0, evidence=Evidence(len(rows), float(len(rows) > 0), rmse, 1)))
        z = near[beside, 2]
        if len(z):
            storeys = whole_storeys(float(z.max()), float(z.min()), storey_height=storey_height)
            houses.append(_house(ring, float(z.min()), float(z.max()), storeys, tuple(facades)))
    return _numbered(houses)


def _eave(edges: list[FittedEdge], tops: list[float | None], points: Floats, base: float) -> float | None:
    """Eave that most walls have; where they do not agree, because few points reach so high, that of all walls together.

    Party walls end where the other house does: a common end far from that of most walls is none.
    """
    known = [(top, edge.length) for top, edge in zip(tops, edges, strict=True) if top is not None]
    levels, lengths = (np.array(column) for column in zip(*known, strict=True)) if known else (np.zeros(0), np.zeros(0))
    eave = eave_height(levels, lengths)
    if eave is not None and lengths[np.abs(levels - eave) < AGREEING].sum() >= LEAST_AGREEING * sum(
        edge.length for edge in edges if edge.fitted
    ):
        return eave
    together = common_top([edge for edge in edges if edge.fitted], points, foot=base)
    if together is None or (eave is not None and abs(together - eave) > OTHER_HOUSE):
        return eave
    return together


def _facade(edge: FittedEdge, top: float | None) -> Facade:
    evidence = Evidence(edge.points, float(edge.coverage), float(edge.rmse) if edge.fitted else None, int(edge.fitted))
    return Facade(_point(edge.start), _point(edge.end), edge.fitted, None if top is None else float(top), evidence)


def _house(corners: Floats, base: float, eave: float, storeys: int, facades: tuple[Facade, ...]) -> House:
    ring: Ring = tuple(_point(corner) for corner in corners)
    length = sum(facade.length for facade in facades)
    support = sum(facade.evidence.support for facade in facades)
    squares = sum(facade.evidence.rmse**2 * facade.evidence.support for facade in facades if facade.evidence.rmse is not None)
    seen = sum(facade.evidence.support for facade in facades if facade.evidence.rmse is not None)
    evidence = Evidence(
        support=support,
        coverage=min(1.0, sum(facade.evidence.coverage * facade.length for facade in facades) / length),
        rmse=float((squares / seen) ** 0.5) if seen else None,
        sides=1,
    )
    return House("H", ring, base, eave, storeys, facades, evidence=evidence)


def _numbered(houses: list[House]) -> tuple[House, ...]:
    from dataclasses import replace

    houses = sorted(houses, key=lambda house: shoelace(house.footprint)[1])
    return tuple(replace(house, id=f"H{number}") for number, house in enumerate(houses, start=1))


def _point(xy: Floats) -> Point2:
    return float(xy[0]), float(xy[1])
