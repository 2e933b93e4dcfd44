"""Lines of wall faces, found where the upper part of the column is filled and placed on the points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.segments import Segments

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LAYERS = 25
BELOW_CEILING = (20, 24)
NEXT_BELOW = (17, 20)
MIDDLE = (8, 20)
WHOLE_COLUMN = (2, 20)
CLEARANCE = 0.06
FINE_LAYER = 0.05
ALONG = 0.10
ACROSS = 0.01
LEAST_EVIDENCE = 0.35


@dataclass(frozen=True, slots=True, eq=False)
class FaceLines:
    """Straight faces, free space to the left of the direction; one row each.

    Parameters
    ----------
    angle : (m,) float64
        Direction of the line, radians.
    offset : (m,) float64
        Signed distance of the line from the origin along its left normal, metres.
    start, end : (m,) float64
        Extent along the direction, metres.
    spread : (m,) float64
        Standard deviation of the points across the line, metres.
    family : (m,) int64
        Number of the sweep that shows the line.
    """

    angle: Floats
    offset: Floats
    start: Floats
    end: Floats
    spread: Floats
    family: Ints

    def __len__(self) -> int:
        return len(self.angle)

    @property
    def direction(self) -> Floats:
        """(m, 2) float64 unit vectors along the lines."""
        return np.column_stack([np.cos(self.angle), np.sin(self.angle)])

    @property
    def normal(self) -> Floats:
        """(m, 2) float64 unit normals to the left: into free space."""
        return np.column_stack([-np.sin(self.angle), np.cos(self.angle)])

    def ends(self, reach: float = 0.0) -> tuple[Floats, Floats]:
        """End points (m, 2) of the lines, prolonged by `reach` metres."""
        foot = self.offset[:, None] * self.normal
        return foot + (self.start - reach)[:, None] * self.direction, foot + (self.end + reach)[:, None] * self.direction

    def take(self, rows: NDArray) -> FaceLines:
        """Lines of the given rows (indices or mask)."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})


def height_layers(points: WallPoints) -> Ints:
    """Height layer of each point: 5 cm layers right below the overhead surface, even ones from the floor up to these."""
    first, last = BELOW_CEILING
    below_top = last - 1 - np.floor((points.depth - CLEARANCE) / FINE_LAYER).astype(np.int64)
    from_floor = np.clip((points.rise * first).astype(np.int64), 0, first - 1)
    return np.where(below_top >= first, np.minimum(below_top, last - 1), from_floor)


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Wall points sorted into thin strips along one direction, for both sides they can be seen from."""

    angle: float
    low: Floats
    band: tuple[int, int]
    masks: NDArray[np.uint32]
    crest: NDArray[np.bool_]
    evidence: Floats


def sweep(points: WallPoints, angle: float, *, band: tuple[int, int] = BELOW_CEILING) -> Sweep:
    """Heights hit in every strip `ALONG` x `ACROSS` of the plan.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    angle : float
        Direction of the strips, radians.
    band : (int, int)
        Height layers that tell walls from furniture: first, and one past the last.

    Returns
    -------
    Sweep
        Bit k of ``masks[side, u, v]`` is set where height layer k was hit from that side (0: from the left of the direction).
    """
    along = np.array([np.cos(angle), np.sin(angle)])
    left = np.array([-along[1], along[0]])
    u, v = points.xy @ along, points.xy @ left
    low = np.array([np.floor(u.min() / ALONG) * ALONG - 5 * ALONG, np.floor(v.min() / ACROSS) * ACROSS - 10 * ACROSS])
    iu = ((u - low[0]) / ALONG).astype(np.int64)
    iv = ((v - low[1]) / ACROSS).astype(np.int64)
    shape = (2, int(iu.max()) + 6, int(iv.max()) + 11)
    layer = height_layers(points)
    masks = np.zeros(shape[0] * shape[1] * shape[2], dtype=np.uint32)
    cell = iu * shape[2] + iv
    sides = [np.arange(len(u))] * 2
    if points.sensor is not None:
        from_left = (points.sensor - points.xy) @ left > 0
        sides = [np.flatnonzero(from_left), np.flatnonzero(~from_left)]
    for side, rows in enumerate(sides):
        keys = np.unique((cell[rows] + side * shape[1] * shape[2]) * LAYERS + layer[rows])
        np.bitwise_or.at(masks, keys // LAYERS, np.uint32(1) << (keys % LAYERS).astype(np.uint32))
    masks = masks.reshape(shape)
    evidence = _wall_evidence(masks, band)
    crest = _crests(masks, band) & (evidence >= LEAST_EVIDENCE)
    return Sweep(angle, low, band, masks, crest, np.where(_widen(crest, 1), evidence, 0))


def _wall_evidence(masks: NDArray[np.uint32], band: tuple[int, int], *, reach: int = 2) -> Floats:
    """Share of the band of height layers that is hit, per strip; what only crosses the direction is left out."""
    from scipy import ndimage

    joined = masks.copy()
    for k in range(1, reach + 1):
        joined[:, :, k:] |= masks[:, :, :-k]
        joined[:, :, :-k] |= masks[:, :, k:]
    best = _filled(joined, band)
    along = ndimage.uniform_filter1d(best, 7, axis=1)
    across = ndimage.uniform_filter1d(best, round(7 * ALONG / ACROSS), axis=2)
    near = joined.copy()
    near[:, 1:] |= joined[:, :-1]
    near[:, :-1] |= joined[:, 1:]
    tall = np.bitwise_count(near & _bits(MIDDLE)).astype(np.float32) / (MIDDLE[1] - MIDDLE[0])
    thinly = np.where(tall >= 0.6, _filled(near, band), 0)
    thinly[ndimage.uniform_filter1d(thinly, 15, axis=1) < 0.5] = 0
    best[across > np.maximum(along, 0.3)] = 0
    thinly[ndimage.uniform_filter1d(thinly, round(7 * ALONG / ACROSS), axis=2) > 0.5] = 0
    best = np.maximum(best, thinly)
    smooth: Floats = ndimage.median_filter(best, size=(1, 5, 1))
    return smooth


def _crests(masks: NDArray[np.uint32], band: tuple[int, int], *, apart: float = 0.04) -> NDArray[np.bool_]:
    """Strips where more of the column is hit than in any other within `apart` metres across."""
    from scipy import ndimage

    layers = 0.1 * np.bitwise_count(masks).astype(np.float32) + np.bitwise_count(masks & _bits(band))
    density = ndimage.uniform_filter1d(ndimage.gaussian_filter1d(layers, 0.015 / ACROSS, axis=2, truncate=3), 5, axis=1)
    crest: NDArray[np.bool_] = density >= ndimage.maximum_filter1d(density, 2 * round(apart / ACROSS) + 1, axis=2)
    return crest


def _filled(masks: NDArray[np.uint32], band: tuple[int, int]) -> Floats:
    """Share of a band of height layers that is hit; right below the ceiling, the layers next below count as well."""
    share = np.bitwise_count(masks & _bits(band)).astype(np.float32) / (band[1] - band[0])
    if band == BELOW_CEILING:
        share *= 0.5 + np.bitwise_count(masks & _bits(NEXT_BELOW)).astype(np.float32) / (2 * (NEXT_BELOW[1] - NEXT_BELOW[0]))
    filled: Floats = share
    return filled


def _bits(band: tuple[int, int]) -> np.uint32:
    return np.uint32((1 << band[1]) - (1 << band[0]))


def _widen(mask: NDArray[np.bool_], strips: int) -> NDArray[np.bool_]:
    wide = mask.copy()
    for k in range(1, strips + 1):
        wide[:, :, k:] |= mask[:, :, :-k]
        wide[:, :, :-k] |= mask[:, :, k:]
    return wide


def ridges(swept: Sweep, *, shortest: float = 0.4) -> list[tuple[int, Ints, Ints]]:
    """Crests of the wall evidence: side and strip indices (u, v) of each, ordered along u."""
    from scipy import ndimage

    found = []
    for side in (0, 1):
        thick = ndimage.binary_dilation(swept.crest[side], np.ones((1, 3)))
        labels, number = ndimage.label(thick, np.ones((3, 3)))
        labels[~swept.crest[side]] = 0
        u, v = np.nonzero(labels)
        label = labels[u, v]
        order = np.argsort(label, kind="stable")
        u, v, label = u[order], v[order], label[order]
        bounds = np.searchsorted(label, np.arange(1, number + 2))
        for k in range(number):
            part = slice(bounds[k], bounds[k + 1])
            if part.stop > part.start and (u[part].max() - u[part].min() + 1) * ALONG >= shortest:
                found.append((side, u[part], v[part]))
    return found


def face_lines(swept: Sweep, *, family: int, steepest: float = 12.0) -> FaceLines:
    """Lines of all faces along one direction.

    Parameters
    ----------
    swept : Sweep
        Wall points in strips along the direction.
    family : int
        Number of the sweep.
    steepest : float
        Largest angle between a face and the direction, degrees.
    """
    rows: list[tuple[float, ...]] = []
    for side, u, v in ridges(swept):
        line = _fit(swept, side, u, v)
        if line is None or abs(line[0]) > np.tan(np.radians(steepest)):
            continue
        rows.append(_row(swept, side, *line, int(u.min()), int(u.max())))
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return FaceLines(table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4], np.full(len(table), family, dtype=np.int64))


def prolong(lines: FaceLines, *, least: float = 1.5, most: float = 8.0, slack: float = 0.3) -> tuple[Floats, Floats]:
    """Ends of lines that run on to the next line beyond `least` metres.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    least, most : float
        Shortest and longest prolongation, metres.
    slack : float
        How far the line that is met may itself be prolonged, metres.

    Returns
    -------
    start, end : (m,) float64
        New extents along the lines, metres.
    """
    p, q = lines.ends(slack)
    direction, normal = lines.direction, lines.normal
    start, end = lines.start - least, lines.end + least
    for k in range(len(lines)):
        a = p @ normal[k] - lines.offset[k]
        b = q @ normal[k] - lines.offset[k]
        crossing = (a * b < 0) & (np.abs(a - b) > 1e-9)
        share = a[crossing] / (a - b)[crossing]
        along = (p[crossing] + share[:, None] * (q - p)[crossing]) @ direction[k]
        after = along[(along > end[k]) & (along < lines.end[k] + most)]
        before = along[(along < start[k]) & (along > lines.start[k] - most)]
        if len(after):
            end[k] = after.min() + 0.01
        if len(before):
            start[k] = before.max() - 0.01
    return start, end


def end_cuts(
    lines: FaceLines, *, depth: float = 1.0, near: float = 0.20, shortest: float = 0.6, thickest: float = 0.6
) -> tuple[Floats, Floats]:
    """Cuts across what lies behind a face, where the face ends and no other line runs on from there.

    Walls are not cut: what lies between a face and one that looks the other way.

    Parameters
    ----------
    lines : FaceLines
        Lines.
    depth : float
        Length of a cut, metres.
    near : float
        Lines across the face this close to its end make a cut superfluous, metres.
    shortest : float
        Shortest face, metres.
    thickest : float
        Thickest wall, metres.

    Returns
    -------
    p, q : (m, 2) float64
        Ends of the cuts, metres.
    """
    tails, heads = lines.ends()
    p, q = lines.ends(near)
    direction, normal = lines.direction, lines.normal
    cuts = []
    for k in np.flatnonzero(lines.end - lines.start >= shortest):
        opposite = direction @ direction[k] < -0.99
        for end in (tails[k], heads[k]):
            along_p, along_q = (p - end) @ direction[k], (q - end) @ direction[k]
            across_p, across_q = (p - end) @ normal[k], (q - end) @ normal[k]
            beside = np.minimum(np.abs(along_p), np.abs(along_q)) < near
            steep = np.abs(across_q - across_p) > np.abs(along_q - along_p)
            behind = np.minimum(across_p, across_q) < -0.1
            reaches = np.maximum(across_p, across_q) > -near
            spans = (np.minimum(along_p, along_q) < near) & (np.maximum(along_p, along_q) > -near)
            back = opposite & spans & (across_p < -0.02) & (across_p > -thickest)
            if not (back | (beside & steep & behind & reaches)).any():
                cuts.append((end + 0.02 * normal[k], end - depth * normal[k]))
    return np.array([a for a, _ in cuts]).reshape(-1, 2), np.array([b for _, b in cuts]).reshape(-1, 2)


def join_lines(parts: Sequence[FaceLines]) -> FaceLines:
    """All lines in one table."""
    return FaceLines(*(np.concatenate([getattr(part, name) for part in parts]) for name in FaceLines.__slots__))


def merge_lines(lines: FaceLines, *, gap: float = 4.0, apart: float = 0.035, turn: float = 1.5) -> FaceLines:
    """Lines that continue one another, in the same direction and seen from the same side, become one.

    Parameters
    ----------
    lines : FaceLines
        Lines of all sweeps.
    gap : float
        Longest gap between two pieces of one line, metres.
    apart : float
        Largest distance across between the pieces where they come closest, metres.
    turn : float
        Largest angle between long pieces, degrees; short ones may turn by what `apart` allows over their length.
    """
    order = np.lexsort((lines.start, lines.offset, -np.round(lines.end - lines.start, 6)))
    groups = [[int(row)] for row in order]
    fitted = [(float(lines.angle[g[0]]), float(lines.offset[g[0]]), float(lines.start[g[0]]), float(lines.end[g[0]])) for g in groups]
    first = 0
    while first < len(groups):
        for second in range(first + 1, len(groups)):
            if _continues(fitted[first], fitted[second], gap=gap, apart=apart, turn=np.radians(turn)):
                groups[first] += groups.pop(second)
                fitted.pop(second)
                fitted[first] = _common_line(lines, groups[first])
                first = -1
                break
        first += 1
    table = np.array(fitted).reshape(-1, 4)
    spread = np.array([np.average(lines.spread[g], weights=(lines.end - lines.start)[g]) for g in groups])
    family = np.array([lines.family[g[0]] for g in groups], dtype=np.int64)
    return FaceLines(table[:, 0], table[:, 1], table[:, 2], table[:, 3], spread, family)


def evidence_along(swept: Sweep, angle: float, offset: float, start: float, end: float) -> Floats:
    """Wall evidence every `ALONG` metres of a line seen from its left.

    Parameters
    ----------
    swept : Sweep
        Sweep in about the direction of the line, or against it.
    angle, offset : float
        Line as in `FaceLines`.
    start, end : float
        Extent, metres.
    """
    count = max(round((end - start) / ALONG), 1)
    t = start + (np.arange(count) + 0.5) * (end - start) / count
    xy = t[:, None] * np.array([np.cos(angle), np.sin(angle)]) + offset * np.array([-np.sin(angle), np.cos(angle)])
    along = np.array([np.cos(swept.angle), np.sin(swept.angle)])
    side = 0 if np.cos(angle - swept.angle) > 0 else 1
    iu = np.floor((xy @ along - swept.low[0]) / ALONG).astype(np.int64)
    iv = np.floor((xy @ np.array([-along[1], along[0]]) - swept.low[1]) / ACROSS).astype(np.int64)
    inside = (iu >= 0) & (iu < swept.evidence.shape[1]) & (iv >= 3) & (iv < swept.evidence.shape[2] - 3)
    near = np.clip(iv, 3, swept.evidence.shape[2] - 4)[:, None] + np.arange(-3, 4)
    value = swept.evidence[side, np.clip(iu, 0, swept.evidence.shape[1] - 1)[:, None], near].max(axis=1)
    return np.where(inside, value, 0.0).astype(np.float64)


Line = tuple[float, float, float, float]


def _continues(first: Line, second: Line, *, gap: float, apart: float, turn: float) -> bool:
    """Whether the shorter line continues the longer one."""
    if second[3] - second[2] > first[3] - first[2]:
        first, second = second, first
    difference = abs(np.mod(second[0] - first[0] + np.pi, 2 * np.pi) - np.pi)
    if difference > max(turn, min(apart / (second[3] - second[2]), np.radians(8.0))):
        return False
    p, q = _ends_on(second, first[0])
    if max(p[0], first[2]) - min(q[0], first[3]) > gap:
        return False
    return abs(p[1] - first[1]) <= apart and abs(q[1] - first[1]) <= apart


def _ends_on(line: Line, angle: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Both ends of a line in the frame (along, across) of an angle."""
    turn = line[0] - angle
    cos, sin = float(np.cos(turn)), float(np.sin(turn))
    _, offset, start, end = line
    return (start * cos - offset * sin, start * sin + offset * cos), (end * cos - offset * sin, end * sin + offset * cos)


def _common_line(lines: FaceLines, group: list[int]) -> tuple[float, float, float, float]:
    """Length-weighted line through the pieces of a group."""
    base = float(lines.angle[group[0]])
    a = weight = 0.0
    points = []
    for row in group:
        p, q = _ends_on((lines.angle[row], lines.offset[row], lines.start[row], lines.end[row]), base)
        points.append((p, q))
    length = np.array([q[0] - p[0] for p, q in points])
    mx = float(np.average([(p[0] + q[0]) / 2 for p, q in points], weights=length))
    my = float(np.average([(p[1] + q[1]) / 2 for p, q in points], weights=length))
    for (p, q), n in zip(points, length, strict=True):
        dx, dy = q[0] - p[0], q[1] - p[1]
        cx, cy = (p[0] + q[0]) / 2 - mx, (p[1] + q[1]) / 2 - my
        a += n * (dx * dy / 12 + cx * cy)
        weight += n * (dx * dx / 12 + cx * cx)
    turn = float(np.arctan2(a, weight))
    cos, sin = np.cos(turn), np.sin(turn)
    along = [cos * x + sin * y for ends in points for x, y in ends]
    return base + turn, float(-sin * mx + cos * my), float(min(along)), float(max(along))


def _fit(swept: Sweep, side: int, u: Ints, v: Ints, *, window: int = 6) -> tuple[float, float, float, float] | None:
    """Robust line v = level + slope (u - middle) through the strips around a crest, in metres."""
    columns, first = np.unique(u, return_index=True)
    path = np.interp(np.arange(columns[0], columns[-1] + 1), columns, v[first])
    span = np.arange(columns[0], columns[-1] + 1)
    offsets = np.arange(-window, window + 1)
    strips = np.clip(np.rint(path)[:, None].astype(np.int64) + offsets, 0, swept.masks.shape[2] - 1)
    bits = swept.masks[side, span[:, None], strips]
    whole = np.bitwise_count(bits).astype(np.float64)
    weight = np.bitwise_count(bits & _bits(swept.band)).astype(np.float64)
    x = np.broadcast_to((span + 0.5)[:, None] * ALONG, weight.shape)
    y = (strips + 0.5) * ACROSS
    if weight.sum() < 5:
        return None
    slope, level, width = 0.0, 0.0, 0.06
    middle = float((weight * x).sum() / weight.sum())
    start = (
        np.polyfit(span * ALONG + 0.5 * ALONG - middle, (path + 0.5) * ACROSS, 1)
        if len(span) > 6
        else np.array([0.0, float(np.median(path) + 0.5) * ACROSS])
    )
    slope, level = float(start[0]), float(start[1])
    spread = 0.02
    for step in range(8):
        if step == 4:
            weight, width = whole, float(np.clip(3 * spread, 0.02, 0.05))
        residual = y - level - slope * (x - middle)
        w = weight * np.maximum(1 - (residual / width) ** 2, 0) ** 2
        total = w.sum()
        if total < 1e-9:
            return None
        mx, my = (w * x).sum() / total, (w * y).sum() / total
        sxx, sxy = (w * (x - mx) ** 2).sum(), (w * (x - mx) * (y - my)).sum()
        slope = float(sxy / max(sxx, 1e-9)) if len(span) > 6 else 0.0
        level = float(my + slope * (middle - mx))
        inner = np.abs(residual) < width
        spread = float(np.sqrt((w * residual**2).sum() / total))
        if step < 4:
            width = float(
                np.clip(4 * 1.4826 * np.sqrt((weight * inner * residual**2).sum() / max((weight * inner).sum(), 1e-9)) / 1.2, 0.015, 0.06)
            )
    return slope, middle + swept.low[0], level + swept.low[1], spread


def _row(swept: Sweep, side: int, slope: float, middle: float, level: float, spread: float, first: int, last: int) -> tuple[float, ...]:
    """Line in model coordinates: angle, offset, start, end, spread."""
    turn = float(np.arctan(slope))
    cos, sin = np.cos(turn), np.sin(turn)
    offset = -sin * middle + cos * level
    along = cos * middle + sin * level
    start = along + (swept.low[0] + first * ALONG - middle) / cos
    end = along + (swept.low[0] + (last + 1) * ALONG - middle) / cos
    if side == 1:
        return swept.angle + turn + np.pi, -offset, -end, -start, spread
    return swept.angle + turn, offset, start, end, spread


def unexplained(points: WallPoints, lines: FaceLines, *, near: float = 0.08, upper: float = 0.8) -> WallPoints:
    """Points high on the walls that lie on none of the lines.

    Parameters
    ----------
    points : WallPoints
        Candidates.
    lines : FaceLines
        Lines found so far.
    near : float
        Points this close to a line lie on it, metres.
    upper : float
        Share of the height above which points count.
    """
    high = points.rise > upper
    xy = points.xy[high]
    sensor = None if points.sensor is None else points.sensor[high]
    cell = np.floor(xy / 0.05).astype(np.int64)
    cell -= cell.min(axis=0)
    _, first, group = np.unique(cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1], return_index=True, return_inverse=True)
    spots = xy[first]
    free = np.ones(len(spots), dtype=bool)
    for direction, normal, offset, start, end in zip(lines.direction, lines.normal, lines.offset, lines.start, lines.end, strict=True):
        along = spots @ direction
        free &= (np.abs(spots @ normal - offset) > near) | (along < start - 0.1) | (along > end + 0.1)
    keep = free[group]
    return WallPoints(xy[keep], points.rise[high][keep], points.depth[high][keep], None if sensor is None else sensor[keep])


def other_directions(points: WallPoints, *, cell: float = 0.40, least: float = 0.4, most: int = 6) -> list[float]:
    """Directions that the remaining points line up in, radians.

    Parameters
    ----------
    points : WallPoints
        What the main directions do not explain.
    cell : float
        Side of the cells whose direction is looked at, metres; four grids half a cell apart are used.
    least : float
        Length of wall that a direction needs, metres.
    most : int
        Largest number of directions.
    """
    if not len(points):
        return []
    layer = height_layers(points)
    hits = np.unique(np.column_stack([np.floor(points.xy / 0.03).astype(np.int64), layer]), axis=0)
    spots, layers = np.unique(hits[:, :2], axis=0, return_counts=True)
    filled = layers >= 2
    fine, weight = spots[filled] * 0.03 + 0.015, layers[filled].astype(np.float64)
    angles, lengths = [], []
    for shift in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)):
        index = np.floor(fine / cell + np.array(shift)).astype(np.int64)
        index -= index.min(axis=0)
        _, group, count = np.unique(index[:, 0] * (index[:, 1].max() + 1) + index[:, 1], return_inverse=True, return_counts=True)
        total = np.bincount(group, weights=weight)
        mean = np.column_stack([np.bincount(group, weights=weight * fine[:, k]) / total for k in range(2)])
        x, y = (fine - mean[group]).T
        xx, yy, xy = (np.bincount(group, weights=weight * w) / total for w in (x * x, y * y, x * y))
        half = np.sqrt(((xx - yy) / 2) ** 2 + xy**2)
        minor, major = (xx + yy) / 2 - half, (xx + yy) / 2 + half
        straight = (count >= 6) & (minor < 0.15 * major) & (major > (0.2 * cell) ** 2)
        angles.append(np.mod(0.5 * np.arctan2(2 * xy, xx - yy)[straight], np.pi))
        lengths.append(np.sqrt(12 * major[straight]) / 4)
    angle, length = np.concatenate(angles), np.concatenate(lengths)
    grid = np.radians(np.arange(0, 180, 2.0))
    found: list[float] = []
    while len(found) < most and len(angle):
        apart = np.abs(np.mod(angle[None] - grid[:, None] + np.pi / 2, np.pi) - np.pi / 2)
        votes = ((apart < np.radians(6)) * length).sum(axis=1)
        best = int(np.argmax(votes))
        if votes[best] < least:
            break
        mine = apart[best] < np.radians(6)
        delta = np.mod(angle[mine] - grid[best] + np.pi / 2, np.pi) - np.pi / 2
        found.append(float(grid[best] + np.median(delta)))
        angle, length = angle[~mine], length[~mine]
    return found


def measure(faces: Segments, points: WallPoints, *, reach: float = 0.05) -> Segments:
    """Support, spread and coverage of faces.

    Parameters
    ----------
    faces : Segments
        Faces, free space to the left of p -> q.
    points : WallPoints
        Candidates.
    reach : float
        Points this close to a face lie on it, metres.
    """
    order = np.argsort(points.xy[:, 0], kind="stable")
    xy, rise = points.xy[order], points.rise[order]
    sensor = None if points.sensor is None else points.sensor[order]
    support, rmse, coverage = np.zeros(len(faces), dtype=np.int64), np.full(len(faces), np.nan), np.zeros(len(faces))
    for k, (p, d, n, length) in enumerate(zip(faces.p, faces.direction, faces.normal, faces.length, strict=True)):
        ends = np.sort([p[0], p[0] + length * d[0]])
        rows = slice(*np.searchsorted(xy[:, 0], [ends[0] - reach, ends[1] + reach]))
        along, across = (xy[rows] - p) @ d, (xy[rows] - p) @ n
        on = (np.abs(across) < reach) & (along > 0) & (along < length)
        if sensor is not None:
            on &= (sensor[rows] - p) @ n > 0
        if not on.any():
            continue
        support[k] = int(on.sum())
        rmse[k] = float(np.sqrt(np.mean(across[on] ** 2)))
        columns, layers = max(int(np.ceil(length / ALONG)), 1), 10
        cells = np.minimum((along[on] / ALONG).astype(np.int64), columns - 1) * layers + np.minimum(
            (rise[rows][on] * layers).astype(np.int64), layers - 1
        )
        coverage[k] = len(np.unique(cells)) / (columns * layers)
    return replace(faces, sided=np.ones(len(faces), dtype=bool), support=support, rmse=rmse, coverage=np.minimum(coverage, 1.0))
