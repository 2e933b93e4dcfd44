"""What a building is called."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import rooms_cloud
from plans import box

from indoor_bim import reconstruct
from indoor_bim.cli import main
from indoor_bim.export.json import read_json
from indoor_bim.title import building_name


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("school/gym.laz", "gym"),
        ("school/scan.laz", "school"),
        ("school/Scan_003.e57", "school"),
        ("school/merged point-cloud.ply", "school"),
        ("school/2024-05-01.laz", "school"),
        ("school/scan of the gym.laz", "scan of the gym"),
        ("data/points.xyz", "points"),
        ("/scan.laz", "scan"),
    ],
)
def test_names(path, name):
    assert building_name(path, source=path.rpartition("/")[2]) == name


def test_a_cloud_in_memory_has_no_folder():
    assert building_name(np.zeros((3, 3)), source="scan") == "scan"
    assert building_name(np.zeros((3, 3)), source="") == "Building"


def test_the_title_can_be_chosen_and_does_not_change_the_identifiers(tmp_path):
    (tmp_path / "Town hall").mkdir()
    scan = tmp_path / "Town hall" / "scan.xyz"
    np.savetxt(scan, rooms_cloud(box(0, 0, 4, 3), spacing=0.05))
    named = reconstruct(scan).building
    assert named.name == "Town hall"
    assert main(["reconstruct", str(scan), "-o", str(tmp_path / "out"), "--title", "1984", "--to", "json,svg", "-q"]) == 0
    chosen = read_json(tmp_path / "out" / "model.json")
    assert chosen.name == "1984"
    assert "1984" in (tmp_path / "out" / "plan.svg").read_text()
    assert [wall.guid for wall in chosen.storeys[0].walls] == [wall.guid for wall in named.storeys[0].walls]
