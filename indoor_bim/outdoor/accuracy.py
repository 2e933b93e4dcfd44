"""How far footprints are from surveyed corners, and wall points from the model."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from indoor_bim.errors import ReadError
from indoor_bim.frame import Frame
from indoor_bim.outdoor.footprint import WallPoints
from indoor_bim.outdoor.model import Village

Floats = NDArray[np.float64]

GATE = 0.5
BAND = 0.3


@dataclass(frozen=True, slots=True)
class CornerDifference:
    """A surveyed corner and the corner of a footprint next to it, scan coordinates; None where there is none within the gate."""

    id: str
    surveyed: tuple[float, float]
    found: tuple[float, float] | None
    distance: float | None


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Accuracy of a village.

    Parameters
    ----------
    corners : tuple of CornerDifference
        One for each surveyed corner.
    wall_points : int
        Number of wall points compared with the model.
    wall_mean, wall_sd : float
        Mean and standard deviation of their signed distance from it, outside positive, metres.
    wall_within : float
        Share of them within 0.1 m, as in Sensors 2024, 24, 5723, figure 24.
    """

    corners: tuple[CornerDifference, ...]
    wall_points: int
    wall_mean: float
    wall_sd: float
    wall_within: float

    @property
    def distances(self) -> Floats:
        """Planar distances of the corners that were found, metres."""
        return np.array([corner.distance for corner in self.corners if corner.distance is not None])

    def table(self) -> str:
        """Table of differences like that of Sensors 2024, 24, 5723 (table 3), as Markdown."""
        lines = ["| corner | surveyed x | surveyed y | found x | found y | dx | dy | distance m |", "|---|---|---|---|---|---|---|---|"]
        for corner in self.corners:
            x, y = corner.surveyed
            if corner.found is None or corner.distance is None:
                lines.append(f"| {corner.id} | {x:.3f} | {y:.3f} | — | — | — | — | none within {GATE} m |")
                continue
            u, v = corner.found
            lines.append(f"| {corner.id} | {x:.3f} | {y:.3f} | {u:.3f} | {v:.3f} | {u - x:.3f} | {v - y:.3f} | {corner.distance:.3f} |")
        d = self.distances
        if len(d):
            sd = float(d.std(ddof=1)) if len(d) > 1 else 0.0
            spread = f"mean {d.mean():.3f} m, s.d. {sd:.3f}, max {d.max():.3f}, min {d.min():.3f}"
            lines += ["", f"{len(d)} of {len(self.corners)} corners: {spread}"]
        lines += [
            "",
            f"{self.wall_points} wall points: mean {self.wall_mean:.3f} m from the model, s.d. {self.wall_sd:.3f}, "
            f"{100 * self.wall_within:.1f} % within 0.1 m",
        ]
        return "\n".join(lines) + "\n"


def read_corners(path: str | Path) -> tuple[tuple[str, float, float], ...]:
    """Read surveyed corners.

    Parameters
    ----------
    path : path
        CSV with the columns ``x`` and ``y`` in scan coordinates, and ``id`` if there is one.

    Raises
    ------
    ReadError
        If the file is missing or has no such numbers.
    """
    file = Path(path)
    try:
        rows = list(csv.DictReader(file.read_text(encoding="utf-8-sig").splitlines()))
        found = [{name.strip().lower(): value for name, value in row.items() if name} for row in rows]
        corners = tuple((row.get("id") or str(i), float(row["x"]), float(row["y"])) for i, row in enumerate(found, start=1))
    except FileNotFoundError:
        raise ReadError(f"{file}: no such file; expected surveyed corners as CSV") from None
    except (OSError, UnicodeDecodeError, KeyError, TypeError, ValueError) as error:
        raise ReadError(f"{file}: cannot read the corners ({error}); expected CSV with x, y, and id if there is one") from None
    if not corners:
        raise ReadError(f"{file}: holds no corner; expected CSV with the columns x and y, and id if there is one")
    return corners


def measure(village: Village, walls: WallPoints, frame: Frame, surveyed: tuple[tuple[str, float, float], ...] = ()) -> Accuracy:
    """Compare a village with surveyed corners and with the wall points of the scan.

    Parameters
    ----------
    village : Village
        Houses, model coordinates.
    walls : WallPoints
        Points that may be of walls, model coordinates.
    frame : Frame
        Takes scan coordinates to model coordinates.
    surveyed : tuple of (str, float, float)
        Name and scan coordinates of surveyed corners.

    Notes
    -----
    Each surveyed corner is compared with one corner of a footprint: as many pairs within the gate as possible, then the least sum of
    distances. Wall points are those within 0.3 m of a facade that was seen, between base and eave.
    """
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    made = [(x, y, house.base) for house in village.houses for x, y in house.footprint]
    corners = frame.to_scan(np.array(made).reshape(-1, 3))[:, :2]
    asked = np.array([(x, y) for _, x, y in surveyed]).reshape(-1, 2)
    distance = cdist(asked, corners) * frame.scale
    rows, columns = linear_sum_assignment(np.where(distance <= GATE, distance, 1e6)) if distance.size else ((), ())
    partner = {int(i): int(j) for i, j in zip(rows, columns, strict=True) if distance[i, j] <= GATE}
    differences = []
    for i, (name, x, y) in enumerate(surveyed):
        j = partner.get(i)
        found = None if j is None else (float(corners[j, 0]), float(corners[j, 1]))
        differences.append(CornerDifference(name, (x, y), found, None if j is None else float(distance[i, j])))
    away = wall_distances(village, walls)
    if not len(away):
        return Accuracy(tuple(differences), 0, 0.0, 0.0, 0.0)
    within = float((np.abs(away) <= 0.1).mean())
    return Accuracy(tuple(differences), len(away), float(away.mean()), float(away.std()), within)


def wall_distances(village: Village, walls: WallPoints) -> Floats:
    """Signed distance (n,) of wall points from the facade next to them, outside positive, metres.

    Parameters
    ----------
    village : Village
        Houses, model coordinates.
    walls : WallPoints
        Points that may be of walls.
    """
    from indoor_bim.outdoor.edges import near_segment

    parts = []
    for house in village.houses:
        near = walls.about(np.array(house.footprint))
        near = near[(near[:, 2] > house.base + 0.3) & (near[:, 2] < house.eave - 0.1)]
        best = np.full(len(near), np.inf)
        for facade in house.facades:
            if facade.seen:
                _, across, rows = near_segment(near[:, :2], np.array(facade.start), np.array(facade.end), band=BAND)
                closer = np.abs(across) < np.abs(best[rows])
                best[rows[closer]] = -across[closer]
        parts.append(best[np.isfinite(best)])
    return np.concatenate(parts) if parts else np.zeros(0)
