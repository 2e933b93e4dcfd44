"""Where the scanner was when each point was measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_bim.threads import in_parts

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STANDING = 5.0  # seconds between rows of a path: a scanner that walks is recorded more often, so here it stood
DRIFT_PERIOD = 2.0  # seconds: the error of a walking scanner's position changes more slowly


def sensor_positions(trajectory: Floats, gps_time: Floats) -> Floats:
    """Position of the scanner for each point.

    A path whose rows are far apart in time is a list of standpoints: the scanner stood there from that time on, or around that time
    where points were taken before the first row. On a walked path it stood still between two rows that are more than a few seconds
    apart.

    Parameters
    ----------
    trajectory : (m, 4) float64
        Time in seconds, sorted, and x, y, z in metres.
    gps_time : (n,) float64
        Time of each point, seconds.

    Returns
    -------
    (n, 3) float64
        Positions, metres.

    Examples
    --------
    >>> walked = np.array([[0.0, 0, 0, 1], [0.5, 1, 0, 1], [1.0, 2, 0, 1], [60, 9, 0, 1]])
    >>> sensor_positions(walked, np.array([0.25, 30.0, 61.0]))[:, 0].tolist()
    [0.5, 2.0, 9.0]
    """
    from indoor_bim.plan.path_loops import positions_at

    time, gps_time = trajectory[:, 0], np.asarray(gps_time, dtype=np.float64)
    if _stands(time):
        return np.asarray(trajectory[_standpoint(time, gps_time), 1:4], dtype=np.float64)
    stood = np.flatnonzero(np.diff(time) > STANDING)
    time = np.insert(time, stood + 1, np.nextafter(time[stood + 1], -np.inf))
    path = np.insert(trajectory[:, 1:], stood + 1, trajectory[stood, 1:], axis=0)
    time, path = np.ascontiguousarray(time, dtype=np.float64), np.ascontiguousarray(path[:, :3], dtype=np.float64)
    positions = np.zeros((len(gps_time), 3))
    in_parts(lambda part: positions_at(gps_time[part], time, path, positions[part]), len(gps_time))
    return positions


def known_positions(trajectory: Floats | None, gps_time: Floats | None, rows: Ints | None = None) -> Floats | None:
    """Position of the scanner for each point, or for some, None where times of points or path are not known; as `sensor_positions`.

    Parameters
    ----------
    trajectory : (m, 4) float64, optional
        Time in seconds and x, y, z in metres.
    gps_time : (n,) float64, optional
        Time of each point, seconds.
    rows : (k,) int64, optional
        Points that are asked for; default: all.
    """
    if trajectory is None or gps_time is None or not np.isfinite(trajectory[:, 0]).all():
        return None
    if rows is None or len(rows) == len(gps_time):
        return sensor_positions(trajectory, gps_time)
    if _stands(trajectory[:, 0]):
        return np.asarray(trajectory[_standpoint(trajectory[:, 0], np.asarray(gps_time)).take(rows), 1:4], dtype=np.float64)
    return sensor_positions(trajectory, gps_time.take(rows))


def path_periods(trajectory: Floats, gps_time: Floats) -> Ints:
    """Stretch of the path that each point was measured on: as long as a walking scanner's position has about the same error.

    Parameters
    ----------
    trajectory : (m, 4) float64
        Time in seconds, sorted, and x, y, z in metres.
    gps_time : (n,) float64
        Time of each point, seconds.

    Returns
    -------
    (n,) int64
        Number of the stretch; all points of one standpoint share it.

    Examples
    --------
    >>> walked = np.array([[0.0, 0, 0, 1], [0.5, 1, 0, 1], [1.0, 2, 0, 1], [60, 9, 0, 1]])
    >>> path_periods(walked, np.array([0.5, 30.0, 50.0, 61.0])).tolist()
    [0, 0, 0, 30]
    """
    from indoor_bim.plan.path_loops import periods_at

    time, gps_time = np.ascontiguousarray(trajectory[:, 0], dtype=np.float64), np.asarray(gps_time, dtype=np.float64)
    if _stands(time):
        return _standpoint(time, gps_time)
    stood = np.append(np.diff(time) > STANDING, False)
    periods = np.zeros(len(gps_time), dtype=np.int64)
    in_parts(lambda part: periods_at(gps_time[part], time, stood, DRIFT_PERIOD, periods[part]), len(gps_time))
    return periods


def _stands(time: Floats) -> bool:
    """True where the rows of a path are standpoints."""
    return len(time) == 1 or float(np.median(np.diff(time))) > STANDING


def _standpoint(time: Floats, gps_time: Floats) -> Ints:
    """Row of the standpoint of each point."""
    before = len(gps_time) > 0 and gps_time.min() < time[0] - 0.1 * (time[-1] - time[0]) / max(len(time) - 1, 1)
    change = (time[1:] + time[:-1]) / 2 if before else time[1:]
    rows: Ints = np.searchsorted(change, gps_time, side="right").astype(np.int64)
    return rows
