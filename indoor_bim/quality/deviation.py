"""How far the walls of a model are from a scan, or from another model: signed distances, wall by wall."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from indoor_bim.quality.extra_surfaces import ExtraSurface, extra_surfaces
from indoor_bim.quality.nearest_face import index_faces, surface_distances
from indoor_bim.quality.path_drift import path_drift
from indoor_bim.quality.unique_rows import unique_rows
from indoor_bim.quality.wall_bodies import Body, Faces, WallModel, face_cells, upright_faces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Status = Literal["seen", "not seen", "missing"]

CELL = 0.10  # metres: distances are medians of cells of this size, so that dense parts of a scan do not outvote sparse ones
GATE = 0.10  # metres: points farther from every face belong to something else
DRIFT_TAKEN_OUT = " Its map is bent by up to {:.0f} mm along the path of the scanner; this was taken out (column drift)."
LEAST_POINTS = 3  # in a cell
LEAST_SEEN = 0.10  # share of a wall's better face
_LEAST_CELLS, _LEAST_FACE_CELLS = 20, 50
_FLOOR = (-0.10, 0.15)  # metres about the foot of a wall: where its floor would be if it did not stand
_FREE = 0.5  # share of a footprint with floor points: nothing stands there


@dataclass(frozen=True, slots=True)
class WallDeviation:
    """Distances of a scan from one wall; positive: the scan lies in front of the face, outside the wall.

    Parameters
    ----------
    id, name, guid, storey : str
        The wall.
    status : {"seen", "not seen", "missing"}
        Missing: the scan shows floor where it should stand, or the other model has no wall there.
    covered : float
        Share of the long faces with points.
    points : int
        Number of points.
    bias, median, p95 : float, optional
        Median of the signed distance, median and 95 per cent of its amount over the cells with points, metres.
    shift, thicker : float, optional
        How far the scan shows the wall beside its place, and thicker than modelled, metres; where both faces were seen.
    drift : float, optional
        What the bend of the map along the path of the scanner added to the bias before it was taken out, metres; where that is known.
    """

    id: str
    name: str
    guid: str
    storey: str
    status: Status
    covered: float
    points: int
    bias: float | None = None
    median: float | None = None
    p95: float | None = None
    shift: float | None = None
    thicker: float | None = None
    drift: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Deviations:
    """A model held against a scan.

    Parameters
    ----------
    walls : tuple of WallDeviation
        Every wall that the comparison is about, in the order of the model.
    extra : tuple of ExtraSurface
        Upright surfaces of the scan that the model does not have.
    points : (n, 3) float64
        Points in model coordinates, metres.
    distance : (n,) float64
        Signed distance of each point from its wall face, metres; NaN for points of no wall.
    message : str
        How model and scan were brought together.
    """

    walls: tuple[WallDeviation, ...]
    extra: tuple[ExtraSurface, ...]
    points: Floats
    distance: Floats
    message: str = ""


def wall_deviations(
    model: WallModel,
    points: Floats,
    *,
    bands: Sequence[tuple[float, float]],
    is_scan: bool = True,
    message: str = "",
    time: Floats | None = None,
    scanner: Floats | None = None,
) -> Deviations:
    """Measure how far points are from the walls of a model.

    Parameters
    ----------
    model : WallModel
        Walls and other elements, metres.
    points : (n, 3) float64
        Scan, or samples of another model, in model coordinates, metres.
    bands : sequence of (float, float)
        Floor and ceiling of each storey that the points show, metres; walls outside are left out.
    is_scan : bool
        True when the points may show floors; else every wall without points is missing.
    message : str
        How the points came to their place.
    time : (n,) float64, optional
        Time of each point, seconds: then the bend of the map along the path of the scanner is estimated and taken out of all distances.
    scanner : (n, 3) float64, optional
        Where the scanner was when each point was taken, metres.

    Returns
    -------
    Deviations
        Statistics of each wall, extra surfaces and the distance of each point.
    """
    model = model.detailed({body.storey for body in model.walls if _reaches(body, bands)})
    walls = tuple(body for body in model.walls if _reaches(body, bands))
    faces = upright_faces(walls)
    cells, _, cell_wall = face_cells(faces, cell=CELL)
    within = _in_bands(cells[:, 2], bands)
    inside = _in_bands(points[:, 2], bands)
    rigid, triangle, on_face = _distances(points, faces)
    on_face &= inside
    rows = np.flatnonzero(on_face)
    distance, bend = rigid, None
    if time is not None:
        distance, bend = _without_drift(points, rigid, faces, triangle, rows, time, scanner)
        message += "" if bend is None else DRIFT_TAKEN_OUT.format(1000 * bend)
    found = _cell_medians(points[rows], distance[rows], triangle[rows], faces.normal, faces.plane)
    bent = found if bend is None else _cell_medians(points[rows], rigid[rows], triangle[rows], faces.normal, faces.plane)
    wall_of_plane = np.zeros(faces.plane.max(initial=-1) + 1, dtype=np.int64)
    wall_of_plane[faces.plane] = faces.wall
    totals = np.bincount(cell_wall[within], minlength=len(walls))
    results = []
    for k, body in enumerate(walls):
        own = wall_of_plane[found.plane] == k
        result = _wall_deviation(body, found.take(own), faces.normal, faces.plane, int(totals[k]), points if is_scan else None)
        if bend is not None and result.bias is not None:
            before = float(np.median(bent.distance[wall_of_plane[bent.plane] == k]))
            result = replace(result, drift=before - result.bias)
        results.append(result)
    corners = [body.vertices[body.triangles].reshape(-1, 3) for body in (*walls, *model.others) if _reaches(body, bands)]
    other = points[inside & ~on_face]
    loose = other[surface_distances(other, np.concatenate([np.zeros((0, 3)), *corners])) > GATE]
    extra = tuple(surface for floor, ceiling in bands for surface in extra_surfaces(loose, floor=floor, ceiling=ceiling))
    return Deviations(tuple(results), extra, points, np.where(on_face, distance, np.nan), message)


def _distances(points: Floats, faces: Faces) -> tuple[Floats, Ints, NDArray[np.bool_]]:
    """Signed distance (n,) of each point from its nearest face, that triangle (n,), and whether it belongs to the face (n,)."""
    if not len(faces.wall) or not len(points):
        return np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64), np.zeros(len(points), dtype=bool)
    near = index_faces(faces).nearest(points)
    return near.distance, near.triangle, near.square & (np.abs(near.distance) < GATE)


def _without_drift(
    points: Floats, distance: Floats, faces: Faces, triangle: Ints, rows: Ints, time: Floats, scanner: Floats | None
) -> tuple[Floats, float | None]:
    """Distances (n,) once the bend of the map is taken out, and its largest amount; the same and None where it cannot be told."""
    xy, normal = points[rows, :2], faces.normal[triangle[rows]]
    place = None if scanner is None else scanner[rows, :2]
    bend = path_drift(xy, normal, distance[rows], faces.plane[triangle[rows]], time[rows], place)
    if bend is None:
        return distance, None
    straight = distance.copy()
    straight[rows] += np.einsum("ij,ij->i", bend.displacement(xy, time[rows], place), normal)
    return straight, bend.largest


@dataclass(frozen=True, slots=True, eq=False)
class _Cells:
    """Median distance (k,), number of points (k,) and plane (k,) of the cells with points."""

    distance: Floats
    count: Ints
    plane: Ints

    def take(self, rows: NDArray[np.bool_]) -> _Cells:
        return _Cells(self.distance[rows], self.count[rows], self.plane[rows])


def _cell_medians(points: Floats, distance: Floats, triangle: Ints, normal: Floats, plane: Ints) -> _Cells:
    if not len(points):
        return _Cells(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    across = normal[triangle]
    along = points[:, 1] * across[:, 0] - points[:, 0] * across[:, 1]
    cell = np.floor(np.column_stack([along, points[:, 2]]) / CELL).astype(np.int64)
    _, _, group, count = unique_rows(np.column_stack([plane[triangle], cell]))
    order = np.lexsort((distance, group))
    start = np.cumsum(count) - count
    middle = 0.5 * (distance[order[start + (count - 1) // 2]] + distance[order[start + count // 2]])
    enough = count >= LEAST_POINTS
    return _Cells(middle[enough], count[enough], plane[triangle][order[start]][enough])


def _wall_deviation(body: Body, cells: _Cells, normal: Floats, plane: Ints, total: int, scan: Floats | None) -> WallDeviation:
    covered = min(1.0, len(cells.distance) / total) if total else 0.0
    named = (body.id, body.name, body.guid, body.storey)
    if covered < LEAST_SEEN / 2 or len(cells.distance) < _LEAST_CELLS:
        gone = scan is None or _stands_on_free_floor(body, scan)
        return WallDeviation(*named, "missing" if gone else "not seen", round(covered, 3), int(cells.count.sum()))
    amount = np.abs(cells.distance)
    shift, thicker = _both_faces(cells, normal, plane)
    return WallDeviation(
        *named,
        "seen",
        round(covered, 3),
        int(cells.count.sum()),
        bias=float(np.median(cells.distance)),
        median=float(np.median(amount)),
        p95=float(np.percentile(amount, 95)),
        shift=shift,
        thicker=thicker,
    )


def _both_faces(cells: _Cells, normal: Floats, plane: Ints) -> tuple[float | None, float | None]:
    """Shift along the normal of the first face, and excess thickness; None where one face only was seen."""
    first_of = np.unique(plane, return_index=True)[1]
    across = normal[first_of[cells.plane]]
    front = across @ across[0] > 0
    if min(front.sum(), (~front).sum()) < _LEAST_FACE_CELLS:
        return None, None
    ahead, behind = float(np.median(cells.distance[front])), float(np.median(cells.distance[~front]))
    return abs(ahead - behind) / 2, ahead + behind


def _stands_on_free_floor(body: Body, scan: Floats) -> bool:
    """Whether the scan shows floor over most of the footprint of a wall."""
    import shapely

    triangles = body.vertices[body.triangles][:, :, :2]
    flat = shapely.polygons(np.concatenate([triangles, triangles[:, :1]], axis=1))
    footprint = shapely.union_all(flat[shapely.area(flat) > 1e-6]).buffer(-0.03)
    if footprint.is_empty:
        return False
    above = scan[:, 2] - body.vertices[:, 2].min()
    x0, y0, x1, y1 = footprint.bounds
    floor = scan[(above > _FLOOR[0]) & (above < _FLOOR[1]) & (scan[:, :2] > (x0, y0)).all(axis=1) & (scan[:, :2] < (x1, y1)).all(axis=1)]
    inside = shapely.contains_xy(footprint, floor[:, 0], floor[:, 1])
    hit = len(unique_rows(np.floor(floor[inside, :2] / CELL).astype(np.int64)).rows)
    return bool(hit * CELL**2 > _FREE * footprint.area)


def _reaches(body: Body, bands: Sequence[tuple[float, float]]) -> bool:
    """Whether a body reaches through at least a fifth of one of the bands of heights."""
    bottom, top = body.vertices[:, 2].min(), body.vertices[:, 2].max()
    return any(min(top, high) - max(bottom, low) > 0.2 * (high - low) for low, high in bands)


def _in_bands(height: Floats, bands: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Whether heights (n,) lie in one of the bands."""
    inside = np.zeros(len(height), dtype=bool)
    for low, high in bands:
        inside |= (height > low) & (height < high)
    return inside
