"""Known buildings, made in code: the truth that a virtual scan is compared with."""

from __future__ import annotations

import itertools
from typing import Literal

import numpy as np

from indoor_bim.model import Building, Opening, Point2, Ring
from indoor_bim.simulate.layout import CurvedPartition, Partition, arc, door, lay_out_storey, passage, window


def demo_house() -> Building:
    """One-storey house, 11.9 x 9.0 m outside: seven rooms, a corner cut at 45 degrees, open and closed doors, windows."""
    ring = [(0.0, 0.0), (11.6, 0.0), (11.6, 6.7), (9.6, 8.7), (0.0, 8.7)]
    ring_openings = [
        [window(2.3, width=1.6), window(6.2, width=1.2), window(9.8)],
        [window(5.2, width=1.6, sill=0.1, height=2.1)],
        [window(1.41, width=1.2)],
        [window(3.9, width=1.6), window(7.6, width=0.8, sill=1.3, height=0.9)],
        [door(4.35, width=1.0)],
    ]
    partitions = [
        Partition(
            (0.0, 3.6),
            (11.6, 3.6),
            0.20,
            (door(2.2, hinge="start", swing="right"), door(6.4, hinge="end", swing="right"), door(9.0, hinge="start")),
        ),
        Partition((7.6, 3.6), (7.6, 8.7), 0.20, (passage(0.76),)),
        Partition((0.0, 5.1), (7.6, 5.1), 0.12, (door(1.5, width=0.8, hinge="end"), door(6.3, hinge="start"))),
        Partition((3.9, 5.1), (3.9, 8.7), 0.12, (door(1.2, width=0.8),)),
        Partition((4.6, 0.0), (4.6, 3.6), 0.12),
        Partition((7.9, 0.0), (7.9, 3.6), 0.12),
    ]
    rooms = [
        ("Corridor", (3.0, 4.3)),
        ("Bathroom", (2.0, 7.0)),
        ("Bedroom", (6.0, 7.0)),
        ("Living room", (9.5, 5.5)),
        ("Kitchen", (2.0, 1.8)),
        ("Study", (6.0, 1.8)),
        ("Guest room", (9.5, 1.8)),
    ]
    return Building("Demo house", (lay_out_storey(1, ring, 0.30, ring_openings, partitions, rooms),))


def single_room(*, width: float = 7.0, depth: float = 5.0, height: float = 3.0, cut_corner: float = 0.0) -> Building:
    """One room with a door and a window.

    Parameters
    ----------
    width, depth, height : float
        Clear size, metres.
    cut_corner : float
        Length that a 45 degree cut takes off both sides of a corner on the centre lines, metres; 0 for none.
    """
    w, d, t = width + 0.3, depth + 0.3, 0.3
    corner = [(w, d - cut_corner), (w - cut_corner, d)] if cut_corner > 0 else [(w, d)]
    ring = [(0.0, 0.0), (w, 0.0), *corner, (0.0, d)]
    openings: list[list[Opening]] = [[] for _ in ring]
    openings[0] = [door(1.2, hinge="start")]
    openings[-1] = [window(d / 2, width=1.6)]
    return Building("Single room", (lay_out_storey(1, ring, t, openings, [], [("Room", (w / 2, d / 2))], height=height),))


def office_floor(*, offices: int = 5, seed: int = 0) -> Building:
    """Office floor: a corridor with offices of varied width on both sides; an office with a closed door opens to its neighbour.

    Parameters
    ----------
    offices : int
        Number of offices on each side, at least 2.
    seed : int
        Draws widths, doors and which doors are closed.
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    widths = [np.round(rng.uniform(2.8, 4.6, offices), 2) for _ in range(2)]
    widths[1] = np.round(widths[1] * widths[0].sum() / widths[1].sum(), 2)
    widths[1][-1] += widths[0].sum() - widths[1].sum()
    length, south, north, depth = round(float(widths[0].sum()), 2), 5.0, 7.2, 11.9
    corridor_walls, cross_walls, rooms = [], [], [("Corridor", (length / 2, (south + north) / 2))]
    ring_openings: list[list[Opening]] = [
        [],
        [window((south + north) / 2, width=1.2)],
        [],
        [door((depth - (south + north) / 2), width=1.2)],
    ]
    for side, (y, y_facade) in enumerate(((south, 0.0), (north, depth))):
        edges = np.round(np.concatenate([[0.0], np.cumsum(widths[side])]), 2)
        doors = []
        for k, (x0, x1) in enumerate(itertools.pairwise(edges.tolist())):
            closed = k > 0 and rng.random() < 0.2
            hinge: Literal["start", "end"] = "start" if rng.random() < 0.5 else "end"
            place = round(float(rng.uniform(x0 + 0.9, x1 - 0.9)), 2)
            doors.append(door(place, hinge=None if closed else hinge, swing="right" if side == 0 else "left"))
            centre = (x0 + x1) / 2
            ring_openings[2 * side].append(
                window(round(centre if side == 0 else length - centre, 3), width=round(min(2.0, x1 - x0 - 1.0), 2))
            )
            rooms.append((f"Office {len(rooms)}", (centre, (y + y_facade) / 2)))
            if k > 0:
                connecting = (door(round(abs(y - y_facade) - 1.4, 2), hinge="start", swing="left"),) if closed else ()
                cross_walls.append(Partition((x0, y_facade), (x0, y), 0.12, connecting))
        corridor_walls.append(Partition((0.0, y), (length, y), 0.20, tuple(doors)))
    ring = [(0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth)]
    return Building("Office floor", (lay_out_storey(1, ring, 0.36, ring_openings, corridor_walls + cross_walls, rooms, height=2.75),))


def two_storeys() -> Building:
    """House of two storeys with a straight stair, 9.3 x 7.3 m outside."""
    ring = [(0.0, 0.0), (9.0, 0.0), (9.0, 7.0), (0.0, 7.0)]
    stairwell: Ring = ((1.2, 0.25), (4.2, 0.25), (4.2, 1.25), (1.2, 1.25))
    ground = lay_out_storey(
        1,
        ring,
        0.30,
        [[window(7.2)], [window(1.8), window(5.3)], [window(2.0), window(6.5)], [door(1.6, width=1.0)]],
        [
            Partition((0.0, 3.8), (9.0, 3.8), 0.20, (passage(1.2), door(7.0, hinge="start"))),
            Partition((5.5, 0.0), (5.5, 3.8), 0.12, (door(2.6, hinge="end"),)),
            Partition((4.2, 3.8), (4.2, 7.0), 0.12, (door(1.4, hinge="start", swing="right"),)),
        ],
        [("Hall", (2.5, 2.5)), ("Kitchen", (7.0, 2.0)), ("Entrance", (2.0, 5.5)), ("Living room", (7.0, 5.5))],
        height=2.5,
        stairwells=(None, stairwell),
    )
    upper = lay_out_storey(
        2,
        ring,
        0.30,
        [[window(7.2)], [window(1.8), window(5.3)], [window(2.0), window(6.5)], [window(2.0)]],
        [
            Partition((0.0, 3.8), (9.0, 3.8), 0.20, (door(2.0, hinge="end"), door(4.9, hinge="start"))),
            Partition((5.7, 0.0), (5.7, 3.8), 0.12, (door(2.4, hinge="start", swing="right"),)),
            Partition((3.6, 3.8), (3.6, 7.0), 0.12),
        ],
        [("Landing", (2.5, 2.5)), ("Bedroom", (7.2, 2.0)), ("Bathroom", (1.8, 5.5)), ("Child's room", (6.5, 5.5))],
        elevation=2.8,
        height=2.4,
        stairwells=(stairwell, None),
    )
    return Building("House of two storeys", (ground, upper))


def rounded_house() -> Building:
    """One-storey house with curved walls: 15 x 11 m, an apse, a corner rounded by 1.5 m, an outer wall of 12 m radius.

    Inside, a round room of 2.5 m radius stands in the hall, a partition of 6 m radius parts two rooms, and there are two round columns.
    """
    bow, apse, corner = arc((0.0, 0.0), (9.2, 0.0), 12.0), arc((15.0, 2.0), (15.0, 6.0), 2.5), arc((1.5, 10.0), (0.0, 8.5), 1.5)
    ring = [*bow, (15.0, 0.0), *apse, (15.0, 10.0), *corner]
    ring_openings: list[list[Opening]] = [[] for _ in ring]
    ring_openings[ring.index((15.0, 10.0))] = [window(2.6), window(9.0, width=1.6)]
    ring_openings[ring.index((0.0, 8.5))] = [door(3.0, width=1.0), window(6.4)]
    ring_openings[ring.index((9.2, 0.0))] = [window(2.8, width=1.6)]
    middle, radius, jamb = (4.6, 4.6), 2.5, float(np.arcsin(0.6 / 2.5))
    jambs: list[Point2] = [(middle[0] + radius * float(np.cos(a)), middle[1] + radius * float(np.sin(a))) for a in (-jamb, jamb)]
    opposite: Point2 = (middle[0] - radius, middle[1])
    rotunda = [jambs[0], *arc(jambs[1], opposite, radius), *arc(opposite, jambs[0], radius)[1:]]
    partitions: list[Partition | CurvedPartition] = [
        Partition((9.2, 0.0), (9.2, 10.0), 0.20, (door(3.8, hinge="start", swing="right"), door(8.8, hinge="end", swing="right"))),
        CurvedPartition(tuple(arc((9.2, 7.2), (15.0, 7.2), 6.0)), 0.12),
        CurvedPartition(tuple(rotunda), 0.20, {0: (door(0.6, hinge="start", swing="left"),)}),
    ]
    rooms = [("Hall", (1.0, 4.0)), ("Round room", middle), ("Salon", (13.0, 3.0)), ("Study", (12.0, 9.0))]
    columns = [_round_column((8.2, 9.0), 0.25), _round_column((11.4, 2.2), 0.20)]
    return Building("Rounded house", (lay_out_storey(1, ring, 0.30, ring_openings, partitions, rooms, columns=columns),))


def _round_column(centre: Point2, radius: float, *, sides: int = 48) -> Ring:
    angle = 2 * np.pi * np.arange(sides) / sides
    return tuple(
        (float(x), float(y)) for x, y in np.round(np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)]), 9)
    )
