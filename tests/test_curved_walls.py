"""Curved walls: arcs through points, chains that keep to them, walls that join, and what the model says."""

from __future__ import annotations

import json
from dataclasses import replace

import buildings
import ifcopenshell
import ifcopenshell.util.element
import numpy as np
import pytest
import shapely

from indoor_bim.cloud.read import read
from indoor_bim.errors import ReadError
from indoor_bim.export.ifc import to_ifc
from indoor_bim.export.json import from_json, to_json
from indoor_bim.model import Building
from indoor_bim.model import Curve as ModelCurve
from indoor_bim.pipeline import reconstruct
from indoor_bim.plan.arc_chains import with_curved_walls
from indoor_bim.plan.arc_fit import FINE, circle_through, longest_run
from indoor_bim.plan.arc_loops import TUKEY, mark_on_circles
from indoor_bim.plan.arcs import UPPER, find_arcs, wall_spots
from indoor_bim.plan.curve import Curve
from indoor_bim.plan.curved_walls import pieces_of_curves, with_common_curves
from indoor_bim.plan.evidence import FEW_POINTS, WallPoints
from indoor_bim.plan.face_lines import FaceLines
from indoor_bim.plan.joints import join_without_overlaps
from indoor_bim.plan.line_search import line_evidence
from indoor_bim.plan.segments import Segments
from indoor_bim.plan.walls import walls_from_faces
from indoor_bim.simulate import simulate, write_scan
from indoor_bim.simulate.layout import arc, lay_out_storey

NOISE = 0.003


def scanned_path(xy, towards, *, noise=NOISE, per_metre=60, layers=50, seed=0):
    """Points of a wall along a path (n, 2), seen from the side that `towards` (n, 2) points to."""
    rng = np.random.default_rng(seed)
    xy, towards = np.asarray(xy, float), np.asarray(towards, float)
    step = np.hypot(*np.diff(xy, axis=0).T)
    at = np.concatenate([[0.0], np.cumsum(step)])
    along = np.linspace(0.0, at[-1], max(int(at[-1] * per_metre), 2))
    place = np.column_stack([np.interp(along, at, xy[:, k]) for k in (0, 1)])
    side = np.column_stack([np.interp(along, at, towards[:, k]) for k in (0, 1)])
    place, side = np.repeat(place, layers, axis=0), np.repeat(side, layers, axis=0)
    rise = np.tile((np.arange(layers) + 0.5) / layers, len(along))
    scattered = place + rng.normal(0, noise, len(place))[:, None] * side
    return WallPoints(scattered, rise, 2.5 * (1 - rise) + 0.06, place + 1.5 * side)


def scanned_arc(centre, radius, start, end, *, within=True, **how):
    angle = np.radians(np.linspace(start, end, 400))
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    return scanned_path(np.asarray(centre) + radius * unit, -unit if within else unit, **how)


def scanned_line(p, q, **how):
    p, q = np.asarray(p, float), np.asarray(q, float)
    d = (q - p) / np.hypot(*(q - p))
    return scanned_path([p, q], [[-d[1], d[0]]] * 2, **how)


def together(*parts):
    return WallPoints(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("xy", "rise", "depth", "sensor")))


def test_spots_are_the_same_whether_cells_are_counted_or_sorted():
    points = scanned_arc((3, -2), 4.0, 10, 80, per_metre=600)
    assert np.count_nonzero(points.rise > UPPER) > FEW_POINTS
    far = WallPoints(np.vstack([points.xy, [9e3, 9e3]]), np.append(points.rise, 1.0), np.append(points.depth, 0.1), None)
    counted, sorted_ = wall_spots(points), wall_spots(far)
    assert len(counted) > 100
    assert np.array_equal(counted.xy, sorted_.xy)
    assert np.array_equal(counted.tangent, sorted_.tangent)


def test_the_covariance_of_a_radius_is_honest():
    errors = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        angle = np.linspace(0, 1.2, 60)
        on = (4 + rng.normal(0, 0.01, 60))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        _, radius, covariance = circle_through(on, np.array([0.1, -0.1]), 3.9)
        errors.append((radius - 4) / np.sqrt(covariance[2, 2]))
    assert 0.8 < np.std(errors) < 1.3
    assert abs(np.mean(errors)) < 0.3


def circle_in_numpy(xy, centre, radius, *, rounds=12, finest=0.001):
    """Twin of `circle_through`, from the paper."""
    circle = np.array([*centre, radius])
    for _ in range(rounds):
        away = xy - circle[:2]
        distance = np.hypot(*away.T)
        residual = distance - circle[2]
        sigma = max(1.4826 * np.median(np.abs(residual)), finest)
        weight = np.maximum(1 - (residual / (TUKEY * sigma)) ** 2, 0.0) ** 2
        gradient = np.column_stack([away / distance[:, None], np.ones(len(xy))])
        normal = gradient.T @ (gradient * weight[:, None]) + 1e-9 * np.eye(3)
        step = np.linalg.solve(normal, gradient.T @ (weight * residual))
        circle += step
        if np.abs(step).max() < 1e-7:
            break
    return circle[:2], circle[2], sigma**2 * np.linalg.inv(normal)


@pytest.mark.parametrize("strays", [0, 40])
def test_a_circle_is_fitted_as_numpy_fits_it(strays):
    rng = np.random.default_rng(strays)
    angle = rng.uniform(1.0, 2.5, 300)
    on = (3 + rng.normal(0, 0.01, 300))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) + [700.0, -20.0]
    on[:strays] += rng.uniform(-0.5, 0.5, (strays, 2))
    ours, twin = circle_through(on, np.array([700.2, -20.1]), 3.2), circle_in_numpy(on, np.array([700.2, -20.1]), 3.2)
    assert ours[0] == pytest.approx(twin[0], abs=1e-8)
    assert ours[1] == pytest.approx(twin[1], abs=1e-8)
    assert ours[2] == pytest.approx(twin[2], rel=1e-5)


def test_spots_on_circles_are_near_them_and_run_along():
    rng = np.random.default_rng(3)
    xy, angle, circles = (
        rng.uniform(-3, 3, (500, 2)),
        rng.uniform(0, np.pi, 500),
        np.column_stack([rng.uniform(-2, 2, (40, 2)), np.ones(40)]),
    )
    tangent = np.column_stack([np.cos(angle), np.sin(angle)])
    on = np.zeros((40, 500), dtype=bool)
    mark_on_circles(xy, tangent, circles, 0.2, 0.4, on)
    for circle, marked in zip(circles, on, strict=True):
        away = xy - circle[:2]
        distance = np.hypot(*away.T)
        assert np.array_equal(marked, (np.abs(distance - 1) < 0.2) & (np.abs((away * tangent).sum(axis=1)) < 0.4 * distance))
    assert 0.01 < on.mean() < 0.2


def test_a_run_goes_on_over_the_seam_and_stops_at_gaps():
    angle = np.radians(np.concatenate([np.arange(-60, 80, 1.0), np.arange(150, 180, 1.0)]))
    start, end, covered = longest_run(2 * np.column_stack([np.cos(angle), np.sin(angle)]), np.zeros(2), 2.0, gap=1.3)
    assert np.degrees([start, end]) % 360 == pytest.approx([300, 79], abs=3)
    assert covered == pytest.approx(2 * np.radians(139), abs=0.2)


@pytest.mark.parametrize("noise", [0.0005, 0.012])
@pytest.mark.parametrize(
    ("radius", "start", "end", "within"),
    [(2.4, 20, 340, True), (2.6, 20, 340, False), (11.85, 60, 105, True), (1.35, 10, 100, True), (6.0, 200, 240, False)],
)
def test_an_arc_is_found_where_it_is(radius, start, end, within, noise):
    points = scanned_arc((3, -2), radius, start, end, within=within, noise=noise)
    (arc,) = find_arcs(points, FaceLines.none(), wall_spots(points))
    assert arc.from_within == within
    assert arc.radius == pytest.approx(radius, abs=4 * np.sqrt(arc.covariance[2, 2]) + 0.001)
    assert arc.centre == pytest.approx([3, -2], abs=4 * np.sqrt(arc.covariance[:2, :2].max()) + 0.001)
    assert np.degrees(arc.turn) == pytest.approx(end - start, abs=np.degrees(0.35 / radius))
    assert arc.noise == pytest.approx(max(noise, 0.001), rel=0.3)
    assert arc.deviation < FINE


@pytest.mark.parametrize(
    "straight",
    [
        pytest.param(lambda: scanned_line((0, 0), (6, 0)), id="straight"),
        pytest.param(lambda: together(scanned_line((0, 0), (3, 0)), scanned_line((3, 0), (6, 0.6))), id="bend"),
        pytest.param(
            lambda: together(*(scanned_line(p, q) for p, q in [((0, 0), (3, 0)), ((3, 0), (4, 1)), ((4, 1), (4, 4))])), id="chamfer"
        ),
        pytest.param(lambda: scanned_arc((0, 0), 0.25, 0, 360, within=False), id="column"),
        pytest.param(lambda: scanned_arc((0, 0), 200, 80, 82.2), id="drift"),
        pytest.param(
            lambda: together(
                *(
                    scanned_line(*(2.5 * np.array([np.cos(np.radians(a)), np.sin(np.radians(a))]) for a in (45 * k, 45 * k + 45)))
                    for k in range(8)
                )
            ),
            id="octagon",
        ),
    ],
)
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_what_is_not_curved_is_no_arc(straight, noise):
    points = straight()
    rng = np.random.default_rng(1)
    points = replace(points, xy=points.xy + rng.normal(0, noise, points.xy.shape))
    lines, sweeps, curves = with_curved_walls(none := FaceLines.none(), some := [], points, wall_spots(points))
    assert curves == ()
    assert lines is none
    assert sweeps is some


def test_arcs_do_not_depend_on_the_order_of_the_points():
    points = together(scanned_arc((0, 0), 2.4, 0, 250), scanned_arc((9, 1), 6.0, 240, 300))
    shuffled = np.random.default_rng(3).permutation(len(points))
    found = [find_arcs(given, FaceLines.none(), wall_spots(given)) for given in (points, points.take(shuffled))]
    for first, again in zip(*found, strict=True):
        assert [first.radius, first.start, first.end, *first.centre] == [again.radius, again.start, again.end, *again.centre]


@pytest.fixture(scope="module")
def drum():
    """Chain of the two faces of a wall 0.2 m thick that goes three quarters round."""
    points = together(scanned_arc((1, 2), 2.4, 0, 270), scanned_arc((1, 2), 2.6, 0, 270, within=False))
    return points, *with_curved_walls(FaceLines.none(), [], points, wall_spots(points))


def test_both_faces_are_one_curve_whose_pieces_keep_to_it(drum):
    _, lines, sweeps, curves = drum
    (curve,) = curves
    assert curve.radii == pytest.approx((2.4, 2.6), abs=0.003)
    assert len(lines) == 2 * curve.pieces == len(sweeps)
    p, q = lines.ends()
    middle = np.hypot(*((p + q) / 2 - curve.centre).T)
    corner = np.hypot(*(p - curve.centre).T)
    for face in (slice(0, curve.pieces), slice(curve.pieces, None)):
        radius = curve.radii[0] if middle[face][0] < 2.5 else curve.radii[1]
        assert np.abs(middle[face] - radius).max() <= FINE
        assert np.abs(corner[face] - radius).max() <= 1.01 * FINE
        follows = np.hypot(*(p[face][:, None] - q[face][None]).transpose(2, 0, 1)).min(axis=1)
        assert np.sort(follows)[:-1] == pytest.approx(0, abs=1e-9)
    shown = [line_evidence(lines, k, sweeps, float(lines.start[k]), float(lines.end[k])).mean() for k in range(len(lines))]
    assert np.min(shown) > 0.5


def test_straight_lines_along_a_curve_make_room_for_the_chain(drum):
    points, *_ = drum
    tangents = FaceLines(np.array([np.pi / 2, 0.0]), np.array([-3.39, 9.0]), np.array([1.6, 0.0]), np.array([2.4, 3.0]), *[np.zeros(2)] * 2)
    tangents = replace(tangents, family=np.zeros(2, dtype=np.int64))
    lines, _, curves = with_curved_walls(tangents, [], points, wall_spots(points))
    assert len(lines) == 2 * curves[0].pieces + 1
    assert lines.offset[0] == 9.0


def chain_faces(curve, *, faces):
    """Faces of a curve as the outline of rooms gives them: p, q with free space to the left."""
    p, q = [], []
    for radius, within in faces:
        corner = curve.chord_distance(radius) / np.cos((curve.end - curve.start) / curve.pieces / 2)
        at = curve.centre + corner * np.column_stack([np.cos(curve.breaks), np.sin(curve.breaks)])
        p += list(at[:-1] if within else at[1:])
        q += list(at[1:] if within else at[:-1])
    segments = Segments.from_ends(np.array(p), np.array(q))
    return replace(segments, sided=np.full(len(segments), True), support=np.full(len(segments), 100), rmse=np.full(len(segments), 0.01))


def curve_of(radii, start, end, pieces):
    return Curve(np.array([2.0, 1.0]), tuple(radii), np.radians(start), np.radians(end), 0.001, 0.002, pieces)


@pytest.mark.parametrize(
    ("radii", "turn", "pieces"), [((2.4, 2.6), (0, 360), 28), ((2.4, 2.6), (20, 200), 15), ((11.9, 12.1), (60, 100), 8)]
)
def test_walls_of_a_curve_meet_without_gap_or_overlap(radii, turn, pieces):
    curve = curve_of(radii, *turn, pieces)
    walls = walls_from_faces(chain_faces(curve, faces=[(radii[0], True), (radii[1], False)]))
    walls = with_common_curves(walls, (curve,))
    assert len(walls) == pieces
    joined, meetings, outlines = join_without_overlaps(walls, snap=0.3, far_snap=0.0, curves=(curve,))
    assert len(meetings) == pieces - (0 if curve.closed else 1)
    angle = np.linspace(curve.start, curve.end, 2000)
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    ring = shapely.Polygon(np.vstack([curve.centre + radii[1] * unit, curve.centre + radii[0] * unit[::-1]])).buffer(0)
    union = shapely.union_all(outlines)
    assert sum(outline.area for outline in outlines) == pytest.approx(union.area, abs=1e-6)
    assert union.buffer(1e-6).geom_type == "Polygon"
    assert union.area == pytest.approx(ring.area, rel=0.01)
    assert union.hausdorff_distance(ring) < 2.5 * FINE  # the ends are cut square to the last piece
    assert np.ptp(joined.thickness) == 0


def test_one_thickness_where_half_of_a_face_was_hidden():
    curve = curve_of((2.4, 2.6), 0, 180, 14)
    faces = chain_faces(curve, faces=[(2.4, True), (2.6, False)])
    walls = with_common_curves(walls_from_faces(faces.take(np.arange(20)), shortest_single=0.05), (curve,))
    assert len(walls) == 14
    assert walls.measured.sum() == 6
    assert walls.thickness == pytest.approx(np.full(14, 0.2))
    assert (pieces_of_curves(walls, (curve,))[0] == 0).all()


def test_straight_walls_beside_a_curve_stay_as_they_are():
    curve = curve_of((2.4, 2.6), 0, 180, 14)
    straight = walls_from_faces(replace(Segments.from_ends([[0, -3]], [[6, -3]]), sided=np.array([True])))
    kept = with_common_curves(straight, (curve,))
    assert np.array_equal(kept.p, straight.p)
    assert np.array_equal(kept.thickness, straight.thickness)
    assert with_common_curves(straight, ()) is straight


def curved_model():
    building = buildings.one_room()
    storey = building.storeys[0]
    curve = ModelCurve("A1", (1.0, 2.0), 2.5, ((3.5, 2.0), (1.0, 4.5)), (storey.walls[0].id, storey.walls[1].id), 0.01, 0.002, 0.004)
    return replace(building, storeys=(replace(storey, curves=(curve,)),))


def test_curves_go_there_and_back():
    assert from_json(to_json(curved_model())) == curved_model()
    document = json.loads(to_json(curved_model()))
    document["storeys"][0]["curves"][0]["walls"][0] = "nowhere"
    with pytest.raises(ReadError, match=r'storeys\[0\].curves\[0\].walls: there is no wall "nowhere"'):
        from_json(json.dumps(document))


def test_walls_of_a_curve_say_so_in_ifc():
    file = ifcopenshell.file.from_string(to_ifc(curved_model()))
    told = [ifcopenshell.util.element.get_pset(wall, "IndoorBim_Curve") for wall in file.by_type("IfcWall")]
    assert [pset["Radius"] for pset in told if pset] == [2.5, 2.5]
    assert [pset["ChainDeviation"] for pset in told if pset] == [0.01, 0.01]


def test_a_round_tower_is_one_room_within_one_curve(tmp_path):
    ring = [*arc((0.0, -2.5), (0.0, 2.5), 2.5)[:-1], (0.0, 2.5), (-3.0, 2.5), (-3.0, -2.5)]
    tower = Building("Tower", (lay_out_storey(1, ring, 0.3, [[]] * len(ring), [], [("Room", (0.0, 0.0))]),))
    scan = simulate(tower, profile="static", points=80_000, seed=1)
    write_scan(scan, tmp_path)
    (storey,) = reconstruct(read(tmp_path / "scan.laz")).building.storeys
    (curve,) = storey.curves
    assert curve.radius == pytest.approx(2.5, abs=0.01)
    assert curve.chain_deviation < 1.2 * FINE
    assert len(storey.walls) == len(curve.walls) + 3
    (room,) = storey.rooms
    assert room.area == pytest.approx(tower.storeys[0].rooms[0].area, rel=0.005)
