"""Speed of every stage that sees points, beside what else does the same work.

Usage: ``python -m pytest benchmarks/speed.py --benchmark-columns=min,median,rounds [--points 200_000,2_000_000,20_000_000]``.
The figures in brackets are the ratios within a group. ``-k "not open3d and not tree"`` leaves out the slow ones.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

RADIUS, NEIGHBOURS, VOXEL = 0.03, 10, 0.02


def measure(benchmark: Any, group: str, work: Callable[[], Any], *, rounds: int = 5, warm: bool = True) -> Any:
    """Time some rounds of the work, after one that does not count."""
    benchmark.group = group
    return benchmark.pedantic(work, rounds=rounds, warmup_rounds=int(warm))


def open3d_cloud(points: np.ndarray) -> Any:
    """Legacy cloud of Open3D."""
    open3d = pytest.importorskip("open3d")
    return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))


def name_of(request: pytest.FixtureRequest, stage: str) -> str:
    """Stage and data of a test."""
    return f"{stage} {request.node.callspec.id}"


def test_radius_filter(benchmark: Any, wall_points: np.ndarray, request: pytest.FixtureRequest) -> None:
    """Grid radius outlier removal."""
    from indoor_bim.filters import grid_radius_outlier_removal

    measure(benchmark, name_of(request, "radius filter"), lambda: grid_radius_outlier_removal(wall_points, NEIGHBOURS, RADIUS))


def test_radius_filter_by_tree(benchmark: Any, wall_points: np.ndarray, request: pytest.FixtureRequest) -> None:
    """Its twin by scipy's tree."""
    from indoor_bim.cloud.filters import radius_inliers_by_tree

    work = lambda: radius_inliers_by_tree(wall_points, nb_points=NEIGHBOURS, radius=RADIUS)  # noqa: E731
    measure(benchmark, name_of(request, "radius filter"), work, rounds=1, warm=False)


def test_radius_filter_of_open3d(benchmark: Any, wall_points: np.ndarray, request: pytest.FixtureRequest) -> None:
    """Open3D's legacy filter, which has to keep the same points."""
    from indoor_bim.filters import grid_radius_outlier_removal

    cloud = open3d_cloud(wall_points)
    work = lambda: cloud.remove_radius_outlier(NEIGHBOURS, RADIUS)  # noqa: E731
    kept = measure(benchmark, name_of(request, "radius filter"), work, rounds=1, warm=False)[1]
    assert np.array_equal(kept, grid_radius_outlier_removal(wall_points, NEIGHBOURS, RADIUS)[1])


def test_voxels(benchmark: Any, wall_points: np.ndarray, request: pytest.FixtureRequest) -> None:
    """Voxel down-sampling."""
    from indoor_bim.filters import voxel_down_sample

    measure(benchmark, name_of(request, "voxels"), lambda: voxel_down_sample(wall_points, VOXEL))


def test_voxels_of_open3d(benchmark: Any, wall_points: np.ndarray, request: pytest.FixtureRequest) -> None:
    """Open3D's legacy down-sampling."""
    from indoor_bim.filters import voxel_down_sample

    cloud = open3d_cloud(wall_points)
    thin = measure(benchmark, name_of(request, "voxels"), lambda: cloud.voxel_down_sample(VOXEL))
    assert len(thin.points) == len(voxel_down_sample(wall_points, VOXEL))


def test_read(benchmark: Any, scan: Path, request: pytest.FixtureRequest) -> None:
    """Reading a LAZ file."""
    from indoor_bim import read

    measure(benchmark, name_of(request, "read"), lambda: read(scan))


def test_read_of_laspy(benchmark: Any, scan: Path, request: pytest.FixtureRequest) -> None:
    """Reading the same file with laspy alone."""
    import laspy

    measure(benchmark, name_of(request, "read"), lambda: laspy.read(scan))


def test_level(benchmark: Any, scan: Path, request: pytest.FixtureRequest) -> None:
    """Floor, ceiling and main direction of the slope method."""
    from indoor_bim import read
    from indoor_bim.cloud.pca_levelling import level_by_pca

    cloud = read(scan)
    measure(benchmark, name_of(request, "level"), lambda: level_by_pca(cloud))


def test_level_of_open3d(benchmark: Any, scan: Path, request: pytest.FixtureRequest) -> None:
    """One plane by Open3D's RANSAC, for comparison."""
    from indoor_bim import read

    cloud = open3d_cloud(read(scan).points)
    measure(benchmark, name_of(request, "level"), lambda: cloud.segment_plane(0.03, 3, 1000), rounds=1, warm=False)


def test_slope_lines(benchmark: Any, scan: Path, request: pytest.FixtureRequest) -> None:
    """From the levelled cloud to wall faces."""
    from indoor_bim import read
    from indoor_bim.cloud.pca_levelling import level_by_pca
    from indoor_bim.slope import slope_stages

    levelled = level_by_pca(read(scan))
    measure(benchmark, name_of(request, "slope lines"), lambda: slope_stages(levelled), rounds=3)


@pytest.mark.parametrize("method", ["auto", "slope"])
def test_reconstruct(benchmark: Any, scan: Path, method: str, request: pytest.FixtureRequest) -> None:
    """The whole way, nothing written; a process of its own tells its peak memory."""
    from indoor_bim import reconstruct

    measure(benchmark, name_of(request, "reconstruct").replace(f"-{method}", ""), lambda: reconstruct(scan, method=method), rounds=3)
    program = (
        "import re, sys, indoor_bim\n"
        "indoor_bim.reconstruct(sys.argv[1], method=sys.argv[2])\n"
        "print(re.search(r'VmHWM:\\s*(\\d+)', open('/proc/self/status').read())[1])"
    )
    done = subprocess.run([sys.executable, "-c", program, str(scan), method], capture_output=True, text=True, check=True)
    benchmark.extra_info["peak_memory_mb"] = int(done.stdout.split()[-1]) / 1024
    print(f"\npeak memory of {method}: {benchmark.extra_info['peak_memory_mb']:.0f} MB")


def test_reconstruct_beside_laspy(benchmark: Any, scan: Path, request: pytest.FixtureRequest) -> None:
    """Reading the same file with laspy alone."""
    import laspy

    measure(benchmark, name_of(request, "reconstruct"), lambda: laspy.read(scan), rounds=3)
