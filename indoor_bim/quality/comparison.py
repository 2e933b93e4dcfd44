"""The figures of a comparison between a reconstructed building and the known one."""

from __future__ import annotations

from dataclasses import asdict, dataclass


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


def _text(value: float | None, form: str) -> str:
    return format(value, form) if value is not None else "-".rjust(int(form.split(".")[0]))
