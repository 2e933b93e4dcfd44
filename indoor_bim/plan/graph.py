"""Corners: wall ends moved to where axes meet, as a planar graph of corners and walls."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.curve import Curve
from indoor_bim.plan.curved_walls import pieces_of_curves
from indoor_bim.plan.walls import Walls

if TYPE_CHECKING:
    import networkx as nx

Floats = NDArray[np.float64]
End = Literal["start", "end", "path"]

STEP_COS = np.cos(np.radians(5.0))  # walls that go on after a step differ less than this in direction
CRACK = 0.10  # metres between walls beside each other that does not open a room
MEETING_SINE = np.sin(np.radians(12.0))  # axes that differ less than this in direction do not meet
CURVED_SINE = np.sin(np.radians(2.0))  # the same for pieces of curved walls


@dataclass(frozen=True, slots=True)
class Meeting:
    """A corner: the walls that meet in a point, each at an end or along its path."""

    point: tuple[float, float]
    walls: tuple[int, ...]
    ends: tuple[End, ...]


def join_walls(
    walls: Walls, *, snap: float = 0.30, far_snap: float = 0.0, curves: Sequence[Curve] = ()
) -> tuple[Walls, tuple[Meeting, ...]]:
    """Move wall ends to the axes of the walls they meet.

    An end meets another wall when the intersection of the axes is no farther from it than half that wall's thickness plus
    `snap`, and beyond the other wall's ends by no more than half its own thickness plus `snap`. Two ends that choose each
    other make an L; an end that meets a wall between its ends makes a T and leaves that wall in one piece; several ends
    in one point make a Y. An end that meets nothing is moved up to a parallel wall that goes on behind a narrow gap, with a step.

    Parameters
    ----------
    walls : Walls
        Walls in metres.
    snap : float
        Slack for what the scan did not see of the corner, metres.
    far_snap : float
        Slack for ends that meet nothing within `snap`, such as corners behind cupboards, metres. No wall is prolonged by more
        than its own length to a corner; a step is closed over as much.
    curves : sequence of Curve
        Curves that walls are pieces of: these meet at small angles as well.

    Returns
    -------
    walls : Walls
        The same walls with moved ends; walls that would turn round are left as they were.
    meetings : tuple of Meeting
        Corners, sorted by position.
    """
    walls = split_crossings(walls, snap=snap)
    ends = [(a, e) for a in range(len(walls)) for e in (0, 1)]
    curved = pieces_of_curves(walls, curves)[0] >= 0
    choice = {(a, e): _choose(walls, a, e, snap=snap, curved=curved) for a, e in ends}
    if far_snap > snap:
        choice |= {(a, e): _choose(walls, a, e, snap=far_snap, curved=curved, outwards=True) for a, e in ends if choice[a, e] is None}
    p, q = walls.p.copy(), walls.q.copy()
    for (a, e), found in choice.items():
        if found is not None:
            (p if e == 0 else q)[a] = found[1]
        else:
            (p if e == 0 else q)[a] = _closed_step(walls, a, e, widest=max(2 * snap, far_snap), crack=CRACK if far_snap > snap else 0.0)
    turned = ((q - p) * walls.direction).sum(axis=1) <= 0.02
    p[turned], q[turned] = walls.p[turned], walls.q[turned]
    moved = replace(walls, p=p, q=q)
    incidences: list[tuple[Floats, int, int, int]] = []  # point, wall, end, other wall
    for (a, e), found in sorted(choice.items()):
        if found is not None and not turned[a]:
            incidences.append((found[1], a, e, found[0]))
    return moved, _meetings(moved, incidences)


def split_crossings(walls: Walls, *, snap: float = 0.30) -> Walls:
    """Cut the shorter of two walls that cross, so that it meets the longer one from both sides.

    Parameters
    ----------
    walls : Walls
        Walls in metres.
    snap : float
        Stubs no longer than this beyond the other wall's face are left to be trimmed, metres.
    """
    while True:
        cut = _first_crossing(walls, snap=snap)
        if cut is None:
            return walls
        k, point = cut
        rest = walls.take(np.arange(len(walls)) != k)
        share = float(np.hypot(*(point - walls.p[k])) / walls.length[k])
        row = walls.take([k])
        halves = []
        for p, q, part in ((row.p, point[None], share), (point[None], row.q, 1 - share)):
            halves.append(replace(row, p=p, q=q, support=np.round(row.support * part).astype(np.int64)))
        table = {name: np.concatenate([getattr(x, name) for x in (rest, *halves)]) for name in Walls.__slots__}
        walls = replace(walls, **table)
        walls = walls.take(np.lexsort(np.round(np.column_stack([walls.q, walls.p]).T, 6)))


def _first_crossing(walls: Walls, *, snap: float) -> tuple[int, Floats] | None:
    """The first wall, and the place, where a longer one runs through it."""
    d, length = walls.direction, walls.length
    for k in range(len(walls)):
        cross = d[k, 0] * d[:, 1] - d[k, 1] * d[:, 0]
        rows = np.flatnonzero((np.abs(cross) > MEETING_SINE) & (np.arange(len(walls)) != k))
        gap = walls.p[rows] - walls.p[k]
        mine = (gap[:, 0] * d[rows, 1] - gap[:, 1] * d[rows, 0]) / cross[rows]
        theirs = (gap[:, 0] * d[k, 1] - gap[:, 1] * d[k, 0]) / cross[rows]
        stub = walls.thickness[rows] / 2 / np.abs(cross[rows]) + snap
        other_stub = walls.thickness[k] / 2 / np.abs(cross[rows]) + snap
        crossing = (mine > stub) & (mine < length[k] - stub) & (theirs > other_stub) & (theirs < length[rows] - other_stub)
        crossing &= (length[rows] > length[k]) | ((length[rows] == length[k]) & (rows < k))
        if crossing.any():
            best = np.flatnonzero(crossing)[np.argmin(mine[crossing])]
            return k, walls.p[k] + mine[best] * d[k]
    return None


def without_stubs(walls: Walls, *, shortest: float = 1.2, snap: float = 0.30) -> Walls:
    """Leave out short walls with a free end: door leaves and the sides of cupboards.

    Parameters
    ----------
    walls : Walls
        Walls before they are joined, metres.
    shortest : float
        Shorter walls need to meet others at both ends, unless both their faces were seen, metres.
    snap : float
        Slack of corners, metres.

    Examples
    --------
    >>> none = np.zeros(2)
    >>> ends = np.array([[0.0, 0.0], [2.0, 0.1]]), np.array([[4.0, 0.0], [2.0, 0.9]])
    >>> walls = Walls(*ends, none + 0.1, none > 0, none > 0, none, none, none, none)
    >>> without_stubs(walls).length.tolist()
    [4.0]
    """
    while True:
        joined, meetings = join_walls(walls, snap=snap)
        ends = {(w, e) for meeting in meetings for w, e in zip(meeting.walls, meeting.ends, strict=True)}
        free = np.array([(k, "start") not in ends or (k, "end") not in ends for k in range(len(joined))], dtype=bool)
        if len(joined) != len(walls):  # walls that cross were cut: rows no longer correspond
            walls = joined
            continue
        stub = free & (walls.length < shortest) & ~walls.measured
        if not stub.any():
            return walls
        walls = walls.take(~stub)


def wall_graph(walls: Walls, meetings: tuple[Meeting, ...]) -> nx.Graph:
    """Planar graph of corners and wall stretches.

    Nodes are corners ``(x, y)`` rounded to 0.1 mm; edges carry ``wall`` (row of the table) and ``length`` in metres. A wall with
    corners along its path is a chain of edges with the same ``wall``.

    Parameters
    ----------
    walls : Walls
        Joined walls.
    meetings : tuple of Meeting
        Their corners.
    """
    import networkx as nx

    graph = nx.Graph()
    for k in range(len(walls)):
        stops = [tuple(walls.p[k]), tuple(walls.q[k])]
        stops += [m.point for m in meetings for w, e in zip(m.walls, m.ends, strict=True) if w == k and e == "path"]
        d = walls.direction[k]
        stops.sort(key=lambda s: (float(np.dot(s, d)), s))
        nodes = [(round(float(x), 4), round(float(y), 4)) for x, y in stops]
        for a, b in itertools.pairwise(nodes):
            if a != b:
                graph.add_edge(a, b, wall=k, length=float(np.hypot(a[0] - b[0], a[1] - b[1])))
    return graph


def _choose(walls: Walls, a: int, end: int, *, snap: float, curved: NDArray[np.bool_], outwards: bool = False) -> tuple[int, Floats] | None:
    """The wall that an end meets, and where: the least movement wins, then the thicker wall."""
    d = walls.direction
    tip = walls.q[a] if end else walls.p[a]
    out = d[a] if end else -d[a]
    cross = out[0] * d[:, 1] - out[1] * d[:, 0]
    usable = np.abs(cross) > np.where(curved | curved[a], CURVED_SINE, MEETING_SINE)
    usable[a] = False
    rows = np.flatnonzero(usable)
    if not len(rows):
        return None
    sine = cross[rows]
    gap = walls.p[rows] - tip
    move = (gap[:, 0] * d[rows, 1] - gap[:, 1] * d[rows, 0]) / sine
    place = (gap[:, 0] * out[1] - gap[:, 1] * out[0]) / sine
    beyond = np.maximum(np.maximum(-place, place - walls.length[rows]), 0.0)
    reach = walls.thickness[rows] / 2 / np.abs(sine) + snap
    slack = walls.thickness[a] / 2 / np.abs(sine) + snap
    near = (np.abs(move) <= reach) & (beyond <= slack)
    if outwards:
        near &= (move > 0) & (move <= walls.length[a])
    if not near.any():
        return None
    rows, move, beyond = rows[near], move[near], beyond[near]
    cost = np.round(np.abs(move) + beyond, 4)
    best = np.lexsort((rows, -np.round(walls.thickness[rows], 4), cost))[0]
    return int(rows[best]), tip + move[best] * out


def _closed_step(walls: Walls, a: int, end: int, *, widest: float, crack: float) -> Floats:
    """End of a wall, moved up to a wall that goes on beside its line: the two overlap across, so they touch."""
    d, n = walls.direction, walls.normal[a]
    tip = walls.q[a] if end else walls.p[a]
    out = d[a] if end else -d[a]
    ends = np.stack([walls.p - tip, walls.q - tip])
    gap = (ends @ out).min(axis=0)
    aside = np.abs(ends @ n).min(axis=0)
    goes_on = (np.abs(d @ d[a]) > STEP_COS) & (gap > 0) & (gap <= widest) & (aside < (walls.thickness + walls.thickness[a]) / 2 + crack)
    goes_on[a] = False
    moved: Floats = tip + (gap[goes_on].min() if goes_on.any() else 0.0) * out
    return moved


def _meetings(walls: Walls, incidences: list[tuple[Floats, int, int, int]]) -> tuple[Meeting, ...]:
    """Cluster incidences to corners and find out how every wall takes part."""
    tolerance = 0.02
    clusters: list[tuple[Floats, set[int]]] = []
    in_square: dict[tuple[int, int], list[int]] = {}
    for point, a, _, b in incidences:
        column, row = (int(place) for place in np.floor(point / tolerance))
        around = sorted(k for i in (-1, 0, 1) for j in (-1, 0, 1) for k in in_square.get((column + i, row + j), ()))
        same = next((k for k in around if np.hypot(*(clusters[k][0] - point)) < tolerance), None)
        if same is None:
            in_square.setdefault((column, row), []).append(len(clusters))
            clusters.append((point, {a, b}))
        else:
            clusters[same][1].update((a, b))
    out = []
    for point, members in clusters:
        rows = sorted(members)
        ends: list[End] = []
        for k in rows:
            to_p, to_q = np.hypot(*(walls.p[k] - point)), np.hypot(*(walls.q[k] - point))
            ends.append("start" if to_p < tolerance else "end" if to_q < tolerance else "path")
        out.append(Meeting((float(point[0]), float(point[1])), tuple(rows), tuple(ends)))
    return tuple(sorted(out, key=lambda m: m.point))
