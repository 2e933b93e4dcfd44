"""Walls of one curve: a common axis and thickness, and ends on the corners of its chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.curve import THICKEST, Curve
from indoor_bim.plan.walls import Walls

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALONG_COS = np.cos(np.radians(2.0))
"""A piece of a curved wall differs less than this from its chain in direction."""


def pieces_of_curves(walls: Walls, curves: Sequence[Curve]) -> tuple[Ints, Ints]:
    """Curve (m,) and piece of its chain (m,) that each wall is; -1 for straight walls.

    Parameters
    ----------
    walls : Walls
        Walls, metres.
    curves : sequence of Curve
        Curves.
    """
    of_curve, of_piece = np.full(len(walls), -1, dtype=np.int64), np.full(len(walls), -1, dtype=np.int64)
    middle, direction = (walls.p + walls.q) / 2, walls.direction
    for number, curve in enumerate(curves):
        away = middle - curve.centre
        step = (curve.end - curve.start) / curve.pieces
        slack = 0.0 if curve.closed else step / 2
        angle = np.mod(np.arctan2(away[:, 1], away[:, 0]) - curve.start + slack, 2 * np.pi) - slack
        piece = np.clip(np.floor(angle / step), 0, curve.pieces - 1).astype(np.int64)
        angle_end = curve.pieces * step + slack
        at = curve.start + (piece + 0.5) * step
        tangent = np.column_stack([-np.sin(at), np.cos(at)])
        distance = (away * np.column_stack([np.cos(at), np.sin(at)])).sum(axis=1)
        near = (distance > min(curve.radii) - THICKEST) & (distance < max(curve.radii) + THICKEST)
        faces = distance[:, None] + np.array([-0.5, 0.5]) * walls.thickness[:, None]
        near &= np.abs(faces[:, :, None] - np.array([curve.chord_distance(radius) for radius in curve.radii])).min(axis=(1, 2)) < 0.03
        near &= (angle < angle_end) & (np.abs((direction * tangent).sum(axis=1)) > ALONG_COS)
        near &= walls.length < 2.5 * step * (max(curve.radii) + THICKEST)
        rows = near & (of_curve < 0)
        of_curve[rows], of_piece[rows] = number, piece[rows]
    return of_curve, of_piece


def with_common_curves(walls: Walls, curves: Sequence[Curve]) -> Walls:
    """Walls of each curve about one axis and with one thickness: one for each piece, ending on the corners of the chain.

    Parameters
    ----------
    walls : Walls
        Walls, metres.
    curves : sequence of Curve
        Curves.

    Returns
    -------
    Walls
        Sorted by position; the same where there are no curves.
    """
    if not curves:
        return walls
    of_curve, of_piece = pieces_of_curves(walls, curves)
    tables = [walls.take(of_curve < 0)]
    for number, curve in enumerate(curves):
        mine = of_curve == number
        if mine.any():
            tables.append(_chain_of_walls(walls.take(mine), of_piece[mine], curve))
    table = replace(walls, **{name: np.concatenate([getattr(part, name) for part in tables]) for name in Walls.__slots__})
    d = np.round(table.q - table.p, 6)
    backwards = (d[:, 0] < 0) | ((d[:, 0] == 0) & (d[:, 1] < 0))
    flip = backwards[:, None]
    table = replace(table, p=np.where(flip, table.q, table.p), q=np.where(flip, table.p, table.q), seen_left=table.seen_left ^ backwards)
    return table.take(np.lexsort(np.round(np.column_stack([table.q, table.p]).T, 6)))


def _chain_of_walls(walls: Walls, piece: Ints, curve: Curve) -> Walls:
    """One wall for each piece of a curve, counter-clockwise."""
    middle = (walls.p + walls.q) / 2 - curve.centre
    if len(curve.radii) > 1 and walls.measured.any():
        inner, outer = min(curve.radii), max(curve.radii)
        thickness, axis = outer - inner, (outer + inner) / 2
    else:
        thickness = float(np.median(walls.thickness))
        axis = float(np.median(np.hypot(*middle.T)))
        face = min(curve.radii, key=lambda radius: abs(abs(axis - radius) - thickness / 2))
        axis = face + np.sign(axis - face) * thickness / 2
    step = (curve.end - curve.start) / curve.pieces
    corner = curve.chord_distance(axis) / np.cos(step / 2)
    counter_clockwise = middle[:, 0] * walls.direction[:, 1] - middle[:, 1] * walls.direction[:, 0] > 0
    rows = []
    for number in np.unique(piece):
        group = np.flatnonzero(piece == number)
        angles = curve.start + np.array([number, number + 1]) * step
        ends = curve.centre + corner * np.column_stack([np.cos(angles), np.sin(angles)])
        ends = _to_its_own_ends(ends, np.vstack([walls.p[group], walls.q[group]]), number=int(number), pieces=piece, curve=curve)
        length = walls.length[group]
        support = walls.support[group]
        best = group[np.argmax(np.round(length, 6))]
        squares = float((support * np.nan_to_num(walls.rmse[group]) ** 2).sum())
        tops = walls.top[group]
        rows.append(
            Walls(
                p=ends[:1],
                q=ends[1:],
                thickness=np.array([thickness]),
                measured=np.array([bool(walls.measured[group].any())]),
                seen_left=np.array([bool(walls.seen_left[best] == counter_clockwise[best])]),
                support=np.array([support.sum()]),
                coverage=np.array([np.average(walls.coverage[group], weights=length)]),
                rmse=np.array([np.sqrt(squares / support.sum()) if support.sum() else np.nan]),
                top=np.array([np.nanmax(tops) if np.isfinite(tops).any() else np.nan]),
            )
        )
    return Walls(**{name: np.concatenate([getattr(row, name) for row in rows]) for name in Walls.__slots__})


def _to_its_own_ends(corners: Floats, ends: Floats, *, number: int, pieces: Ints, curve: Curve) -> Floats:
    """Ends of a piece: the corners of the chain where the next piece is a wall too, else as far as its own walls go."""
    d = (corners[1] - corners[0]) / np.hypot(*(corners[1] - corners[0]))
    along = (ends - corners[0]) @ d
    out = corners.copy()
    if (number - 1 if number or not curve.closed else curve.pieces - 1) not in pieces:
        out[0] = corners[0] + d * along.min()
    if (number + 1 if number + 1 < curve.pieces or not curve.closed else 0) not in pieces:
        out[1] = corners[0] + d * along.max()
    return out
