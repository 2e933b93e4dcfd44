from __future__ import annotations

import json

import numpy as np
import pytest
import shapely
from clouds import rooms_cloud, tilted
from plans import FLAT, box

from indoor_bim.errors import ConfigError, NothingToReconstructError, WriteError
from indoor_bim.frame import Frame
from indoor_bim.pipeline import reconstruct

ROOMS = (box(0, 0, 4, 3), box(4.2, 0, 9, 3), box(0, 3.2, 9, 5.4))


@pytest.fixture(params=["auto", "slices", "slope"])
def method(request):
    return request.param


@pytest.fixture(scope="module")
def scan():
    return rooms_cloud(*ROOMS, noise=0.003)


def room_areas(building) -> list[float]:
    return sorted(room.area for storey in building.storeys for room in storey.rooms)


TRUE_AREAS = sorted(shapely.Polygon(room).area for room in ROOMS)


def test_known_rooms_come_back(scan, method):
    result = reconstruct(scan, method=method)
    storey = result.building.storeys[0]
    assert storey.height == pytest.approx(2.5, abs=0.005)
    assert room_areas(result.building) == pytest.approx(TRUE_AREAS, rel=0.02)
    measured = [wall.thickness for wall in storey.walls if wall.thickness_measured]
    assert measured == pytest.approx([0.2] * len(measured), abs=0.015)
    assert len(measured) == 2
    assert {"read", "level", "walls"} <= result.timings.keys() & result.stages.keys()


@pytest.mark.parametrize(("tilt", "yaw", "shift"), [(12.0, 33.0, (0, 0, 0)), (0.0, 5.0, (691_000.0, 5_334_000.0, 520.0))])
def test_attitude_and_place_do_not_matter(scan, tilt, yaw, shift, method):
    moved = reconstruct(tilted(scan, tilt=tilt, yaw=yaw, shift=shift), method=method).building
    assert room_areas(moved) == pytest.approx(TRUE_AREAS, rel=0.02)
    frame = Frame.from_matrix(moved.transform_cloud_to_model)
    corner = tilted(np.array([[0.0, 0.0, 0.0]]), tilt=tilt, yaw=yaw, shift=shift)
    corners = np.array([c for room in moved.storeys[0].rooms for c in room.outline.exterior])
    local = frame.to_local(corner)[0]
    assert abs(local[2]) < 0.01
    assert np.hypot(*(corners - local[:2]).T).min() < 0.03


def test_the_order_of_points_does_not_matter(scan, method):
    shuffled = scan[np.random.default_rng(3).permutation(len(scan))]
    a, b = reconstruct(scan, method=method).building, reconstruct(shuffled, method=method).building
    np.testing.assert_allclose([wall.axis for wall in a.storeys[0].walls], [wall.axis for wall in b.storeys[0].walls], atol=1e-6)


def test_outputs_are_complete_and_repeat_to_the_byte(scan, tmp_path, method):
    for folder in ("a", "b"):
        reconstruct(scan, tmp_path / folder, method=method)
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == ["model.ifc", "model.json", "model.mtl", "model.obj", "params.toml", "plan.svg"]
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name


def test_a_scan_without_walls_leaves_files_that_say_why(tmp_path, method):
    points = rooms_cloud(FLAT[0])
    flat = points[(points[:, 2] == 0) | (points[:, 2] == 2.5)]
    with pytest.raises(NothingToReconstructError, match="expected walls"):
        reconstruct(flat, tmp_path / "out", method=method)
    model = json.loads((tmp_path / "out" / "model.json").read_text())
    assert model["storeys"] == []
    assert "expected walls" in model["warnings"][0]
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"model.ifc", "model.obj", "plan.svg", "params.toml"}


@pytest.mark.parametrize("missing", ["floor", "ceiling"])
def test_a_scan_without_floor_or_ceiling_is_modelled_with_a_warning(missing, method):
    points = rooms_cloud(*ROOMS, noise=0.003, **{missing: False})
    building = reconstruct(points, method=method).building
    assert any(missing in warning for warning in building.warnings)
    assert building.storeys[0].height == pytest.approx(2.5, abs=0.1)
    assert len(building.storeys[0].walls) == 6


def test_progress_is_reported(scan, method):
    calls: list[tuple[str, float]] = []
    reconstruct(scan, method=method, progress=lambda stage, share: calls.append((stage, share)))
    assert [stage for stage, share in calls if share == 0.0] == {
        "auto": ["read", "level", "plan", "walls", "openings"],
        "slices": ["read", "level", "lines", "walls", "openings"],
        "slope": ["read", "level", "lines", "walls"],
    }[method]


def test_an_unknown_method_is_named(scan):
    with pytest.raises(ConfigError, match="magic"):
        reconstruct(scan, method="magic")


def test_an_unwritable_folder_fails_before_anything_is_computed(scan, tmp_path, method):
    (tmp_path / "file").write_text("")
    with pytest.raises(WriteError, match="file"):
        reconstruct(scan, tmp_path / "file" / "out", method=method)


def test_pictures_of_walls_are_written_on_request(scan, tmp_path):
    result = reconstruct(scan, debug=tmp_path / "walls")
    names = {path.stem for path in (tmp_path / "walls").iterdir()}
    assert names == {wall.id for wall in result.building.storeys[0].walls}
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in (tmp_path / "walls").iterdir())


def test_walls_without_a_closed_room_are_delivered_with_a_warning():
    points = rooms_cloud(box(0, 0, 12, 4), noise=0.003)
    building = reconstruct(points[points[:, 0] < 6], method="slope").building
    assert building.storeys[0].walls
    assert not building.storeys[0].rooms
    assert any("close a room" in warning for warning in building.warnings)


def test_a_scan_too_sparse_for_the_default_method_goes_to_the_published_one_and_says_so():
    result = reconstruct(rooms_cloud(*ROOMS, spacing=0.08, noise=0.003))
    assert "too sparse" in result.warnings[0]
    assert "lines" in result.stages
    assert room_areas(result.building) == pytest.approx(TRUE_AREAS, rel=0.05)
