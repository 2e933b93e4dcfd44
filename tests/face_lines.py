"""Lines of faces for tests."""

from __future__ import annotations

import numpy as np

from indoor_bim.plan.face_lines import FaceLines


def lines_between(*ends, spread=0.005, family=0):
    """Lines from p to q, free space to their left, of ((px, py), (qx, qy))."""
    p, q = np.array([a for a, _ in ends], dtype=float), np.array([b for _, b in ends], dtype=float)
    d = (q - p) / np.hypot(*(q - p).T)[:, None]
    normal = np.column_stack([-d[:, 1], d[:, 0]])
    angle, offset = np.arctan2(d[:, 1], d[:, 0]), (p * normal).sum(axis=1)
    count = len(ends)
    return FaceLines(
        angle, offset, (p * d).sum(axis=1), (q * d).sum(axis=1), np.full(count, spread), np.full(count, family, dtype=np.int64)
    )
