"""Options and clouds of the speed benchmarks."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

CACHE = Path(os.environ.get("XDG_CACHE_HOME", tempfile.gettempdir())) / "indoor_bim_benchmarks"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Sizes to measure."""
    parser.addoption("--points", default="200_000,2_000_000", help="numbers of points, comma-separated, e.g. 20_000_000")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Every size asked for."""
    if "count" in metafunc.fixturenames:
        counts = [int(text) for text in metafunc.config.getoption("--points").split(",")]
        metafunc.parametrize("count", counts, ids=[f"{count:,}" for count in counts], scope="session")


@pytest.fixture(params=["shuffled", "wall-by-wall"])
def wall_points(request: pytest.FixtureRequest, count: int) -> np.ndarray:
    """Walls of a floor of rooms, 4 mm rough, 6,400 points a square metre at 2 million; 4 % stray points."""
    rng = np.random.default_rng(1)
    solid, side = count * 24 // 25, 15.0
    wall, along = rng.integers(0, 8, solid), rng.random(solid) * side
    if request.param == "wall-by-wall":
        order = np.lexsort((along, wall))
        wall, along = wall[order], along[order]
    across, height = wall // 2 * 5.0 + rng.normal(0, 0.004, solid), rng.random(solid) * 2.5
    walls = np.column_stack([np.where(wall % 2, across, along), np.where(wall % 2, along, across), height])
    points = np.concatenate([walls, rng.uniform([-1, -1, 0], [side + 1, side + 1, 2.5], (count - solid, 3))])
    return points[rng.permutation(count)] if request.param == "shuffled" else points


@pytest.fixture
def scan(count: int) -> Path:
    """LAZ file of an office floor scanned by a backpack, with times and the path of the scanner; made once and kept."""
    return office_scan(count)


def office_scan(count: int, *, most: int = 2_000_000, floors: int = 1) -> Path:
    """Make the scan of so many points, or find it; more than `most` points are copies of these, each 2 mm rough.

    Several floors lie side by side, 50 m by 40 m each, as one scan of a level map.
    """
    import laspy

    from indoor_bim.simulate import office_floor, profile_params, simulate

    folder = CACHE / (f"office_{count}" if floors == 1 else f"office_{count}_on_{floors}")
    path = folder / "scan.laz"
    if path.exists():
        return path
    folder.mkdir(parents=True, exist_ok=True)
    params = profile_params("backpack") if floors == 1 else profile_params("backpack").model_copy(update={"map_tilt": 0.0})
    made = simulate(office_floor(offices=8, seed=1), points=min(count // floors, most), seed=1, params=params)
    places = [np.array([50.0 * (k % 4), 40.0 * (k // 4), 0.0]) for k in range(floors)]
    pause = float(made.trajectory[-1, 0] - made.trajectory[0, 0]) + 1.0
    paths = [made.trajectory + np.array([k * pause, *place]) for k, place in enumerate(places)]
    np.savetxt(folder / "trajectory.csv", np.vstack(paths), fmt="%.6f", delimiter=",", header="t,x,y,z", comments="")
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales, header.offsets = np.full(3, 0.001), np.floor(made.points.min(axis=0))
    rng = np.random.default_rng(2)
    beside = path.with_suffix(".part.laz")
    with laspy.open(beside, mode="w", header=header) as writer:
        for k in range(max(count // len(made.points), 1)):
            record = laspy.ScaleAwarePointRecord.zeros(len(made.points), header=header)
            points = made.points + places[k % floors] + rng.normal(0, 0.002, made.points.shape)
            steps = np.rint((points - header.offsets) / 0.001).astype(np.int32)
            record["X"], record["Y"], record["Z"], record["gps_time"] = *steps.T, made.gps_time + k % floors * pause
            writer.write_points(record)
    beside.rename(path)
    return path
