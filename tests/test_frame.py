from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoor_bim.frame import Frame

ANGLES = st.floats(-3.1, 3.1)


def rotation(yaw: float, tilt: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    d, t = np.cos(tilt), np.sin(tilt)
    return np.array([[1, 0, 0], [0, d, -t], [0, t, d]]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@given(yaw=ANGLES, tilt=ANGLES, scale=st.sampled_from([1.0, 0.001, 0.3048]))
def test_there_and_back(yaw, tilt, scale):
    frame = Frame(np.array([691_000.0, 5_334_000.0, 500.0]), rotation(yaw, tilt), scale, np.array([1.0, 2.0, 3.0]))
    points = np.array([[691_001.234567, 5_334_009.876543, 499.5], [691_000.0, 5_334_000.0, 500.0]])
    np.testing.assert_allclose(frame.to_scan(frame.to_local(points)), points, rtol=0, atol=2e-9 / scale)


@given(yaw=ANGLES, tilt=ANGLES)
def test_the_matrix_says_the_same(yaw, tilt):
    frame = Frame(np.array([10.0, -4.0, 2.0]), rotation(yaw, tilt), 0.001, np.array([1.0, 2.0, 3.0]))
    points = np.array([[1.0, 2.0, 3.0], [-500.0, 20.0, 1.0]])
    by_matrix = points @ frame.matrix[:3, :3].T + frame.matrix[:3, 3]
    np.testing.assert_allclose(by_matrix, frame.to_local(points), atol=1e-12)
    again = Frame.from_matrix(frame.matrix)
    np.testing.assert_allclose(again.to_local(points), frame.to_local(points), atol=1e-9)


def test_then_turns_and_moves_local_coordinates():
    frame = Frame(np.array([5.0, 0.0, 0.0]), np.eye(3), 2.0, np.array([0.0, 1.0, 0.0]))
    quarter = rotation(np.pi / 2, 0)
    np.testing.assert_allclose(frame.then(quarter, (0, 0, 7)).to_local([[6.0, 0.0, 0.0]]), [[-1.0, 2.0, 7.0]], atol=1e-12)


@pytest.mark.parametrize("matrix", [np.diag([1.0, 2.0, 1.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0]), np.zeros((4, 4)), np.eye(3)])
def test_only_similarities_are_frames(matrix):
    with pytest.raises(ValueError, match="expected"):
        Frame.from_matrix(matrix)
