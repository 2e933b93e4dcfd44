"""Walls of one build have one thickness: measured ones that differ by less than the scan's accuracy share it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_bim.plan.walls import Walls

WIDEST_SPAN = 4.0  # of the accuracy: thicknesses of one build differ by no more than this from thinnest to thickest


def share_thickness(walls: Walls, *, accuracy: float | None = None) -> Walls:
    """Give walls whose measured thicknesses cannot be told apart their common thickness, about unchanged centre lines.

    Sorted thicknesses are one build as long as neighbours differ by no more than `accuracy` and the whole spans no more than four
    times that; the common one is the mean weighted by length.

    Parameters
    ----------
    walls : Walls
        Walls, metres.
    accuracy : float, optional
        Difference that the scan cannot tell, metres; default: the median distance of the points from their faces.

    Examples
    --------
    >>> none = np.zeros(3)
    >>> ends = np.zeros((3, 2)), np.array([[4.0, 0], [4, 0], [2, 0]])
    >>> walls = Walls(*ends, np.array([0.11, 0.12, 0.24]), none < 1, none < 1, none, none, none + 0.02, none)
    >>> share_thickness(walls).thickness.round(4).tolist()
    [0.115, 0.115, 0.24]
    """
    measured = np.flatnonzero(walls.measured)
    known = walls.rmse[measured]
    if accuracy is None:
        accuracy = float(np.median(known[np.isfinite(known)])) if np.isfinite(known).any() else 0.0
    thickness = walls.thickness.copy()
    group: list[int] = []
    for k in measured[np.lexsort((measured, np.round(walls.thickness[measured], 6)))]:
        t = walls.thickness[k]
        if group and (t - walls.thickness[group[-1]] > accuracy or t - walls.thickness[group[0]] > WIDEST_SPAN * accuracy):
            thickness[group] = np.average(walls.thickness[group], weights=walls.length[group])
            group = []
        group.append(int(k))
    if group:
        thickness[group] = np.average(walls.thickness[group], weights=walls.length[group])
    return replace(walls, thickness=thickness)
