"""How far a reconstructed building is from the known one, in millimetres and shares."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Building, Storey
from indoor_bim.quality import matching
from indoor_bim.quality.comparison import Comparison, FaceScore, Score
from indoor_bim.quality.placement import place_in_frame_of

Floats = NDArray[np.float64]

_STOREY_GATE, _NEAR, _CUT = 1.0, 0.05, 0.10


@dataclass(frozen=True, slots=True, eq=False)
class _Measured:
    """One storey against its truth."""

    walls: Score
    missing: tuple[str, ...]
    extra: tuple[str, ...]
    true_faces: Floats
    result_faces: Floats
    thickness: tuple[float, ...]
    size: tuple[float, float] | None
    rooms_50: Score
    rooms_85: Score
    corners: Score
    doors: Score
    windows: Score


def compare(result: Building, truth: Building) -> Comparison:
    """Compare a reconstructed building with the known one.

    Both are placed in the scan by their transforms. Only what a scan from inside can know is asked for: faces that bound a
    room of the truth; of a wall with a room on one side only, that face places it.

    Parameters
    ----------
    result, truth : Building
        Models of the same scan.

    Raises
    ------
    ValueError
        If a transform is not a similarity.
    """
    placed = place_in_frame_of(result, truth)
    pairs = _storey_pairs(placed, truth)
    both = [(a, b) for a, b in pairs if a is not None and b is not None]
    measured = [_measure(a or _emptied(b), b or _emptied(a)) for a, b in pairs]
    true_faces = np.concatenate([np.zeros(0), *(m.true_faces for m in measured)])
    result_faces = np.concatenate([np.zeros(0), *(m.result_faces for m in measured)])
    found = true_faces[true_faces <= _CUT]
    sizes = [m.size for m in measured if m.size is not None]
    return Comparison(
        storeys=Score(len(both), len(truth.storeys), len(both), len(placed.storeys)),
        walls=sum((m.walls for m in measured), Score()),
        missing_walls=tuple(wall for m in measured for wall in m.missing),
        extra_walls=tuple(wall for m in measured for wall in m.extra),
        faces=FaceScore(
            completeness=float(np.mean(true_faces <= _NEAR)) if len(true_faces) else None,
            correctness=float(np.mean(result_faces <= _NEAR)) if len(result_faces) else None,
            median_mm=float(np.median(found)) * 1000 if len(found) else None,
            p95_mm=float(np.percentile(found, 95)) * 1000 if len(found) else None,
        ),
        thickness_mm=_mean_mm([error for m in measured for error in m.thickness]),
        height_mm=_mean_mm([a.height - b.height for a, b in both]),
        floor_mm=_mean_mm([a.elevation - b.elevation for a, b in both]),
        length_mm=max(size[0] for size in sizes) * 1000 if sizes else None,
        width_mm=max(size[1] for size in sizes) * 1000 if sizes else None,
        rooms_50=sum((m.rooms_50 for m in measured), Score()),
        rooms_85=sum((m.rooms_85 for m in measured), Score()),
        corners=sum((m.corners for m in measured), Score()),
        doors=sum((m.doors for m in measured), Score()),
        windows=sum((m.windows for m in measured), Score()),
    )


def _storey_pairs(result: Building, truth: Building) -> list[tuple[Storey | None, Storey | None]]:
    """Storeys paired by floor level; None beside a storey without a partner."""
    left = list(result.storeys)
    pairs: list[tuple[Storey | None, Storey | None]] = []
    for storey in truth.storeys:
        nearest = min(left, key=lambda other: abs(other.elevation - storey.elevation), default=None)
        if nearest is not None and abs(nearest.elevation - storey.elevation) < _STOREY_GATE:
            left.remove(nearest)
            pairs.append((nearest, storey))
        else:
            pairs.append((None, storey))
    return [*pairs, *((storey, None) for storey in left)]


def _emptied(storey: Storey | None) -> Storey:
    assert storey is not None
    return replace(storey, walls=(), joints=(), curves=(), columns=(), rooms=(), slabs=())


def _measure(result: Storey, truth: Storey) -> _Measured:

    rooms, true_rooms = matching.rooms_area(result), matching.rooms_area(truth)
    area = matching.walls_area(result)
    sides = [matching.sides_on_rooms(wall, true_rooms) for wall in truth.walls]
    shared = [[matching.wall_overlap(wall, made, side) for made in result.walls] for wall, side in zip(truth.walls, sides, strict=True)]
    missing, thickness = [], []
    for wall, side, row in zip(truth.walls, sides, shared, strict=True):
        covered = [overlap.on_true for overlap in row if overlap]
        if matching.covered_share(covered, wall.length) <= matching.OVERLAP:
            missing.append(wall.id)
        elif all(side):
            lengths = [overlap.on_true[1] - overlap.on_true[0] if overlap else 0.0 for overlap in row]
            nearest = result.walls[int(np.argmax(lengths))]
            if nearest.thickness_measured:
                thickness.append(nearest.thickness - wall.thickness)
    extra = []
    for k, wall in enumerate(result.walls):
        covered = [overlap.on_made for row in shared if (overlap := row[k])]
        if matching.covered_share(covered, wall.length) <= matching.OVERLAP:
            extra.append(wall.id)
    made = matching.facing(matching.sample_faces(area, outward=True), true_rooms)
    asked = [matching.sample_faces(room.outline.polygon, outward=False) for room in truth.rooms]
    true_faces = np.concatenate([np.zeros(0), *(matching.face_distances(faces, area, outward=True) for faces in asked)])
    true_corners = np.concatenate(
        [np.zeros((0, 2)), *(matching.corners(room.outline.polygon, outward=False).points for room in truth.rooms)]
    )
    made_corners = matching.facing(matching.corners(area, outward=True), true_rooms).points
    closeness = _NEAR - np.linalg.norm(true_corners[:, None] - made_corners[None], axis=2)
    openings = [
        [[(w, o) for w in s.walls for o in w.openings if (o.kind == "window") == glazed] for s in (result, truth)]
        for glazed in (False, True)
    ]
    likeness = matching.room_overlaps(result, truth)
    return _Measured(
        walls=Score(len(truth.walls) - len(missing), len(truth.walls), len(result.walls) - len(extra), len(result.walls)),
        missing=tuple(missing),
        extra=tuple(extra),
        true_faces=true_faces,
        result_faces=matching.face_distances(made, true_rooms, outward=False),
        thickness=tuple(thickness),
        size=_size_error(rooms.bounds, true_rooms.bounds) if result.rooms and truth.rooms else None,
        rooms_50=_paired(likeness, above=0.5),
        rooms_85=_paired(likeness, above=0.85),
        corners=_paired(closeness, above=0.0),
        doors=_paired(matching.opening_overlaps(*openings[0]), above=0.5),
        windows=_paired(matching.opening_overlaps(*openings[1]), above=0.5),
    )


def _paired(gain: Floats, *, above: float) -> Score:
    pairs = matching.count_pairs(gain, above=above)
    return Score(pairs, gain.shape[0], pairs, gain.shape[1])


def _size_error(result: tuple[float, ...], truth: tuple[float, ...]) -> tuple[float, float]:
    length, width = (abs((result[k + 2] - result[k]) - (truth[k + 2] - truth[k])) for k in (0, 1))
    return length, width


def _mean_mm(errors: list[float]) -> float | None:
    return float(np.mean(np.abs(errors))) * 1000 if errors else None
