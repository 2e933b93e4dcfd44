"""Lines of faces placed on the points themselves, by weighted robust least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_bim.plan.evidence import WallPoints
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.threads import in_threads, threads_for


def fit_to_points(lines: FaceLines, points: WallPoints, *, reach: float = 0.05, finest: float = 0.001, shortest: float = 0.7) -> FaceLines:
    """Lines fitted to the points along them that were seen from their left.

    Every bit of surface counts about alike, however often it was hit. Weights are Tukey's, their scale the median distance of
    the points from the line.

    Parameters
    ----------
    lines : FaceLines
        Lines within a strip or two of the points.
    points : WallPoints
        Candidates.
    reach : float
        Points this close to a line take part, metres.
    finest : float
        Least standard deviation that is assumed, metres.
    shortest : float
        Shorter lines keep their direction, metres.

    Returns
    -------
    FaceLines
        The same rows; lines that would leave what they were found on stay.

    References
    ----------
    Beaton, Tukey, The fitting of power series, meaning polynomials, illustrated on band-spectroscopic data, Technometrics 16, 1974.
    """
    from indoor_bim.plan.line_fit_loops import fit_line

    sensor = np.zeros((0, 2)) if points.sensor is None else np.ascontiguousarray(points.sensor)
    table = (np.ascontiguousarray(points.xy), np.ascontiguousarray(points.rise), sensor)
    tails, heads = lines.ends()
    length = lines.end - lines.start

    def fit(k: int) -> tuple[float, float, bool]:
        place = (lines.direction[k].copy(), float(lines.start[k]), float(lines.offset[k]), float(length[k]))
        level, slope, found = fit_line(*table, points.along(tails[k], heads[k], reach), *place, reach, finest, bool(length[k] >= shortest))
        return level, slope, found

    fits = in_threads(fit, range(len(lines)), threads=threads_for(len(points)))
    level, slope, found = (np.array(column) for column in zip(*fits, strict=True)) if fits else np.zeros((3, 0))
    found = (found > 0) & (np.maximum(np.abs(level), np.abs(level + slope * length)) <= 0.6 * reach)
    turn = np.where(found, np.arctan(slope), 0.0)
    cos, sin, across = np.cos(turn), np.sin(turn), lines.offset + level
    return replace(
        lines,
        angle=lines.angle + turn,
        offset=np.where(found, cos * across - sin * lines.start, lines.offset),
        start=np.where(found, cos * lines.start + sin * across, lines.start),
        end=np.where(found, cos * lines.start + sin * across + length / cos, lines.end),
    )
