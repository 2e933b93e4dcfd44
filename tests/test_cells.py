"""Hidden ends of faces are closed up to the next wall."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from indoor_bim.plan.cells import close_corners, cut_into_cells


@pytest.fixture
def time_limit():
    """Ten seconds: a walk along a line that never ends is a failure, not a hang."""

    def stop(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(10)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def close_face_before_wall(*, crossings=(), mirror=1, backward=False):
    """Middles of the edges that are closed where a face along x is seen up to x = 0 and a wall runs across at x = 0.3."""
    verticals = [-3, 0, 1, *crossings]
    p = np.array([[-3, 0], [0.3, -1], [-3, 1], [-3, -1], *([x, -1] for x in verticals)], dtype=float)
    q = np.array([[1, 0], [0.3, 1], [1, 1], [1, -1], *([x, 1] for x in verticals)], dtype=float)
    p[:, 0] *= mirror
    q[:, 0] *= mirror
    if backward:
        p[0], q[0] = q[0].copy(), p[0].copy()
    cells = cut_into_cells(p, q)
    middle = (cells.edge_start + cells.edge_end) / 2 * [mirror, 1]
    wall = ((cells.edge_line == 0) & (middle[:, 0] < 0) | (cells.edge_line == 1)).astype(float)
    return middle[close_corners(cells, wall) > wall]


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize("backward", [False, True])
def test_hidden_end_is_taken_from_the_face(mirror, backward):
    np.testing.assert_allclose(close_face_before_wall(mirror=mirror, backward=backward), [[0.15, 0.0]], atol=1e-9)


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="needs an alarm clock")
@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize("backward", [False, True])
def test_edges_shorter_than_the_grid_of_corners_end_no_walk(time_limit, mirror, backward):
    closed = close_face_before_wall(crossings=(0.15, 0.15003), mirror=mirror, backward=backward)
    np.testing.assert_allclose(np.sort(closed[:, 0]), [0.075, 0.225], atol=1e-4)
