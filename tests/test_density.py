"""Pictures of the scan for plans."""

from __future__ import annotations

import io

import buildings
import numpy as np
from PIL import Image

from indoor_bim.cloud.cloud import Cloud
from indoor_bim.export.plan_style import Underlay
from indoor_bim.frame import Frame
from indoor_bim.quality.density import CELL, scan_underlays, storey_density


def pixels(picture: Underlay) -> np.ndarray:
    with Image.open(io.BytesIO(picture.png)) as image:
        return np.asarray(image)


def post(x: float, y: float) -> np.ndarray:
    z = np.arange(0.05, 2.5, 0.02)
    return np.column_stack([np.full_like(z, x), np.full_like(z, y), z])


def test_a_post_is_dark_at_its_place_and_the_rest_is_clear() -> None:
    storey = buildings.one_room().storeys[0]
    picture = storey_density(storey, post(1.01, 2.03))
    assert picture is not None
    image = pixels(picture)
    ((row, column),) = np.argwhere(image[..., 3] > 0)
    left, _, _, top = picture.bounds
    assert image[row, column, 3] == 255
    assert abs(left + (column + 0.5) * CELL - 1.01) <= CELL
    assert abs(top - (row + 0.5) * CELL - 2.03) <= CELL


def test_low_things_are_pale() -> None:
    storey = buildings.one_room().storeys[0]
    low = post(3.0, 2.0)
    picture = storey_density(storey, np.concatenate([post(1.0, 2.0), low[low[:, 2] < 0.6]]))
    assert picture is not None
    dark, pale = sorted(pixels(picture)[..., 3][pixels(picture)[..., 3] > 0].tolist(), reverse=True)
    assert dark == 255
    assert pale < 180


def test_every_storey_with_points_gets_its_own() -> None:
    building = buildings.moved(buildings.two_storeys(), yaw=20.0, shift=(5.0, 6.0, 7.0))
    to_scan = np.linalg.inv(np.array(building.transform_cloud_to_model))
    points = np.concatenate([post(1.0, 1.0), post(2.0, 2.0)]) @ to_scan[:3, :3].T + to_scan[:3, 3]
    assert list(scan_underlays(building, Cloud(points, Frame.identity()))) == ["0.ST"]


def test_same_bytes_in_any_order() -> None:
    storey = buildings.one_room().storeys[0]
    points = np.random.default_rng(5).uniform(0, 4, (5000, 3))
    one, two = storey_density(storey, points), storey_density(storey, points[::-1])
    assert one == two
