"""How far a reconstructed building is from the known one, in millimetres and shares."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_bim.model import Building, Storey
from indoor_bim.quality import matching
from indoor_bim.quality.placement import place_in_frame_of

Floats = NDArray[np.float64]

_STOREY_GATE, _NEAR, _CUT = 1.0, 0.05, 0.10


@dataclass(frozen=True, slots=True)
class Score:
    """Elements found: `recalled` of `true` ones, `right` of those of the `result`."""

    recalled: int = 0
    true: int = 0
    right: int = 0
    result: int = 0

    def __add__(self, other: Score) -> Score:
        return Score(self.recalled + other.recalled, self.true + other.true, self.right + other.right, self.result + other.result)

    @property
    def recall(self) -> float | None:
        """Share of the true elements that were found; None if there are none."""
        return self.recalled / self.true if self.true else None

    @property
    def precision(self) -> float | None:
        """Share of the result's elements that are true; None if there are none."""
        return self.right / self.result if self.result else None

    @property
    def f1(self) -> float | None:
        """Harmonic mean of precision and recall; None if neither side has an element."""
        if not self.true and not self.result:
            return None
        precision, recall = self.precision or 0.0, self.recall or 0.0
        return 2 * precision * recall / (precision + recall) if precision + recall else 0.0


@dataclass(frozen=True, slots=True)
class FaceScore:
    """Wall faces that bound rooms; None where there is nothing to measure.

    Parameters
    ----------
    completeness : float, optional
        Share of the true faces with a face of the result within 5 cm that looks the same way.
    correctness : float, optional
        Share of the result's faces with a true face within 5 cm that looks the same way.
    median_mm, p95_mm : float, optional
        Median and 95 per cent distance of the true faces from those of the result, of the faces found within 10 cm, millimetres.
    """

    completeness: float | None
    correctness: float | None
    median_mm: float | None
    p95_mm: float | None


@dataclass(frozen=True, slots=True)
class Comparison:
    """A reconstructed building measured against the known one.

    Parameters
    ----------
    storeys : Score
        Storeys, matched by floor level within 1 m.
    walls : Score
        Walls with more than half of their length matched, split or merged in any way.
    missing_walls, extra_walls : tuple of str
        Identifiers of the true walls that were not found, and of the result's walls that are not true.
    faces : FaceScore
        Wall faces that bound rooms; outer faces of a building scanned from inside are not asked for.
    thickness_mm : float, optional
        Mean absolute error of the thickness, of walls with rooms on both sides and both faces measured, millimetres.
    height_mm, floor_mm : float, optional
        Mean absolute error of the clear height of storeys, and of their floor levels, millimetres.
    length_mm, width_mm : float, optional
        Largest absolute error over the storeys of the extent of all rooms along x and y, millimetres.
    rooms_50, rooms_85 : Score
        Rooms with an intersection over union above 0.5 and 0.85.
    corners : Score
        Corners between wall faces in rooms, within 5 cm.
    doors, windows : Score
        Doors with passages, and windows, with an intersection over union above 0.5 along the wall.
    """

    storeys: Score
    walls: Score
    missing_walls: tuple[str, ...]
    extra_walls: tuple[str, ...]
    faces: FaceScore
    thickness_mm: float | None
    height_mm: float | None
    floor_mm: float | None
    length_mm: float | None
    width_mm: float | None
    rooms_50: Score
    rooms_85: Score
    corners: Score
    doors: Score
    windows: Score

    def as_dict(self) -> dict[str, object]:
        """All figures as plain data, for JSON."""
        data: dict[str, object] = asdict(self)
        for name in ("storeys", "walls", "rooms_50", "rooms_85", "corners", "doors", "windows"):
            score: Score = getattr(self, name)
            data[name] = {**asdict(score), "precision": score.precision, "recall": score.recall, "f1": score.f1}
        return data

    def table(self) -> str:
        """All figures as a text table; a dash where there is nothing to measure."""
        scores = [
            ("storeys", self.storeys),
            ("walls", self.walls),
            ("rooms, overlap above 50 %", self.rooms_50),
            ("rooms, overlap above 85 %", self.rooms_85),
            ("corners within 50 mm", self.corners),
            ("doors and passages", self.doors),
            ("windows", self.windows),
        ]
        lines = [f"{'':32}{'true':>6}{'found':>7}{'made':>6}{'right':>7}{'F1':>8}"]
        lines += [f"{name:32}{s.true:6}{s.recalled:7}{s.result:6}{s.right:7}{_text(s.f1, '8.3f')}" for name, s in scores]
        lines += ["", f"{'':32}{'mm':>6}"]
        lengths = [
            ("wall faces, median distance", self.faces.median_mm),
            ("wall faces, 95 % within", self.faces.p95_mm),
            ("wall thickness, mean error", self.thickness_mm),
            ("storey height, mean error", self.height_mm),
            ("floor level, mean error", self.floor_mm),
            ("overall length, error", self.length_mm),
            ("overall width, error", self.width_mm),
        ]
        lines += [f"{name:32}{_text(value, '6.1f')}" for name, value in lengths]
        lines += ["", f"{'':32}{'share':>6}"]
        shares = [("true faces found within 50 mm", self.faces.completeness), ("made faces right within 50 mm", self.faces.correctness)]
        lines += [f"{name:32}{_text(value, '6.3f')}" for name, value in shares]
        lines += [
            f"{name}: {', '.join(ids)}" for name, ids in (("missing walls", self.missing_walls), ("extra walls", self.extra_walls)) if ids
        ]
        return "\n".join(lines)


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
    left, pairs = list(result.storeys), []
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
    return replace(storey, walls=(), joints=(), columns=(), rooms=(), slabs=())


def _measure(result: Storey, truth: Storey) -> _Measured:
    import shapely

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
            longest = max((k for k, overlap in enumerate(row) if overlap), key=lambda k: np.ptp(row[k].on_true))
            if result.walls[longest].thickness_measured:
                thickness.append(result.walls[longest].thickness - wall.thickness)
    extra = []
    for k, wall in enumerate(result.walls):
        covered = [overlap.on_made for row in shared if (overlap := row[k])]
        if matching.covered_share(covered, wall.length) <= matching.OVERLAP:
            extra.append(wall.id)
    made = matching.facing(matching.sample_faces(area, outward=True), true_rooms)
    asked = [matching.sample_faces(room.outline.polygon, outward=False) for room in truth.rooms]
    true_faces = np.concatenate([np.zeros(0), *(matching.face_distances(faces, area, outward=True) for faces in asked)])
    true_corners = np.concatenate([np.zeros((0, 2)), *(matching.corners(room.outline.polygon) for room in truth.rooms)])
    made_corners = matching.corners(area)
    if len(made_corners):
        made_corners = made_corners[shapely.distance(shapely.points(made_corners), true_rooms) < _CUT]
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


def _text(value: float | None, form: str) -> str:
    return format(value, form) if value is not None else "-".rjust(int(form.split(".")[0]))
