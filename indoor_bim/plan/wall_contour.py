"""Which lines of slices are walls, and the contour that they make."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.boxes import without_boxes
from indoor_bim.plan.contour_completion import CLOSED, GAP, STEP, Contour, complete_contour, interrupted
from indoor_bim.plan.curtains import draw_curtains
from indoor_bim.plan.doubles import without_doubles
from indoor_bim.plan.full_height import ends_lower, share_at_ceiling
from indoor_bim.plan.layer_image import SAMPLING, LayerImage
from indoor_bim.plan.segments import Segments

Points = NDArray[np.float64]

SLACK = 0.05  # metres below the ceiling that are its own
SHORT = 0.60  # metres: shorter faces are walls only as parts of a contour
FOLD, COLUMN_SIDES = 0.25, 8  # metres, and number: longer sides are no folds, and columns have no more sides
FOLDED = 1.4  # times the usual scatter of a wall: curtains
TELLING = 0.008  # metres: in scans that scatter more, folds do not tell curtains from walls
BELOW_CEILING = (0.025, 0.08)  # metres, and of the height: depth of the band that every wall is in and no door, window or wardrobe
HITS_PER_STEP = 2.0  # of a wall in that band, on average
AT_CEILING = 0.35  # share of a face right below the ceiling that makes it a wall; less where all of it is hit less often
LEAST_COVERAGE = 0.12  # of a face from floor to ceiling: emptier are beams and what hangs from the ceiling


def up_to_ceiling(
    segments: Segments, points: Points, image: LayerImage, *, height: float, reach: float, density: float
) -> NDArray[np.bool_]:
    """Tell walls from everything lower: they are hit right below the ceiling.

    Parameters
    ----------
    segments : Segments
        Faces with coverage, metres.
    points : (n, 3) float64
        Points, metres, z above the floor.
    image : LayerImage
        Layers hit in plan.
    height : float
        From floor to ceiling, metres.
    reach : float
        Points within this distance of a face lie on it, metres.
    density : float
        Points on a metre of wall in plan per metre of height.

    Returns
    -------
    (m,) bool
    """
    enough = max(4 * reach - SLACK, HITS_PER_STEP / SAMPLING / max(density, 1e-9))
    depth = SLACK + float(np.clip(enough, BELOW_CEILING[0], BELOW_CEILING[1] * height))
    expected = 1 - (1 - segments.coverage) ** max((depth - SLACK) / image.layer, 1.0)
    wall = share_at_ceiling(segments, points, height=height, reach=reach, depth=depth) >= np.minimum(AT_CEILING, expected / 2)
    wall |= (segments.length < SHORT) & ~ends_lower(segments, image, height=height, reach=reach)
    return wall & (segments.coverage >= LEAST_COVERAGE)


def wall_contour(walls: Segments, *, shortest: float, gap: float) -> Contour:
    """Completed contour of faces that are walls, without doubles, curtains and loose ends (section 1.4.2).

    Parameters
    ----------
    walls : Segments
        Faces that go up to the ceiling, metres.
    shortest : float
        Shorter faces cannot be told from noise, metres.
    gap : float
        Shorter gaps are closed, metres.
    """
    faces = without_boxes(without_doubles(walls, shortest=shortest))
    if not len(faces):
        return complete_contour(faces)
    usual = float(np.average(faces.rmse, weights=faces.length))
    faces = draw_curtains(faces, soft=(faces.rmse > FOLDED * usual) | (usual > TELLING))
    while True:
        contour = complete_contour(faces, gap=gap)
        goes_on = (contour.follows >= 0).all(axis=1) | np.isin(contour.kind, (CLOSED, GAP)).any(axis=1)
        goes_on |= np.isin(np.arange(len(faces)), interrupted(contour, gap=gap) // 2)
        stub = (contour.segments.length < SHORT) & ~goes_on | folds(contour)
        if not stub.any() or stub.all():
            return contour
        faces = faces.take(~stub)


def folds(contour: Contour) -> NDArray[np.bool_]:
    """Segments (m,) between short ones that are short themselves: folds of a curtain, unless they close a ring around a column."""
    short = np.append(contour.segments.length < FOLD, False)
    around = short[contour.follows // 2].all(axis=1) & (contour.follows >= 0).all(axis=1)
    fold: NDArray[np.bool_] = short[:-1] & around
    fold[[row for ring in contour.rings() if len(ring) <= COLUMN_SIDES for row in ring]] = False
    return fold


def with_bridges(contour: Contour, *, gap: float) -> Segments:
    """Segments of a contour, and faces without support across its gaps and steps: the wall goes on over a door and below a window.

    Parameters
    ----------
    contour : Contour
        Completed contour.
    gap : float
        Where a face is interrupted for less than this, the face without support is as long as all of it, metres.
    """
    pairs = np.concatenate([contour.pairs(GAP), contour.pairs(STEP)])
    ends = contour.place(pairs.ravel()).reshape(-1, 2, 2)
    on = interrupted(contour, gap=gap)
    short = np.hypot(*(contour.place(on[:, 0]) - contour.place(on[:, 1])).T) < gap
    whole = np.where(short[:, None], on ^ 1, on)  # the far ends
    ends = np.concatenate([ends, contour.place(whole.ravel()).reshape(-1, 2, 2)])
    pairs = np.concatenate([pairs, on])
    from_end = (pairs[:, 0] % 2 == 1)[:, None]
    p, q = np.where(from_end, ends[:, 0], ends[:, 1]), np.where(from_end, ends[:, 1], ends[:, 0])
    bridges = replace(Segments.from_ends(p, q), sided=contour.segments.sided[pairs // 2].all(axis=1))
    return Segments(**{name: np.concatenate([getattr(part, name) for part in (contour.segments, bridges)]) for name in Segments.__slots__})
