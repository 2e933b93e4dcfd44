"""A virtual laser scanner: rays from a spinning multi-line sensor, cast into a known building, with the errors of real scans."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from indoor_bim.errors import ConfigError
from indoor_bim.frame import Frame
from indoor_bim.model import Building
from indoor_bim.params import SimulateParams
from indoor_bim.simulate.drift import Drift, best_rigid_fit
from indoor_bim.simulate.furnish import furnish, stair_steps, surroundings
from indoor_bim.simulate.mesh import Triangles, box_triangles, door_leaves, glass_triangles, shell_triangles, window_frames
from indoor_bim.simulate.walk import stations, walk_path

Points = NDArray[np.float64]
Profile = Literal["backpack", "static", "clean"]

_SKIP, _PERSON_RADIUS, _PERSON_HEIGHT, _PERSON_AHEAD, _STATION_TIME, _TRIPOD_SHADE = 1e-4, 0.22, 1.75, 1.6, 180.0, np.radians(30)


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedScan:
    """A scan of a known building.

    Parameters
    ----------
    points : (n, 3) float64
        Scan coordinates, metres, in order of time.
    gps_time : (n,) float64
        Time of each point, seconds.
    trajectory : (m, 4) float64
        Time in seconds and estimated position of the sensor in scan coordinates, metres.
    truth : Building
        The building, with the transform from scan coordinates to its own.
    """

    points: Points
    gps_time: NDArray[np.float64]
    trajectory: Points
    truth: Building


@dataclass(frozen=True, slots=True, eq=False)
class _Rays:
    time: Points
    origin: Points
    direction: Points


def profile_params(profile: Profile) -> SimulateParams:
    """Parameters of a named kind of scan: ``backpack``, ``static`` (tripods, millimetres) or ``clean`` (no errors, no furniture).

    Raises
    ------
    ConfigError
        If there is no such profile.
    """
    if profile == "backpack":
        return SimulateParams()
    static = SimulateParams(
        movement="stations", range_noise=0.001, dropout=0.01, mixed_pixels=0.003, drift=0.0, drift_yaw=0.0, sensor_height=1.5, map_tilt=0.0
    )
    if profile == "static":
        return static
    if profile == "clean":
        return static.model_copy(
            update={
                "range_noise": 0.0,
                "dropout": 0.0,
                "mixed_pixels": 0.0,
                "glass_return": 0.0,
                "glass_reflection": 0.0,
                "furniture": False,
                "map_yaw": 0.0,
            }
        )
    raise ConfigError(f"there is no scan profile {profile!r}: expected backpack, static or clean")


def simulate(
    building: Building, *, profile: Profile = "backpack", points: int = 500_000, seed: int = 0, params: SimulateParams | None = None
) -> SimulatedScan:
    """Scan a known building with a virtual laser scanner.

    The truth's transform is the nominal frame of the map corrected by the mean drift: the turn about the vertical and
    the shift that fit the drifted points to the true ones best in the least squares sense. What is left of the
    drift bends the map; its mean only places it, and no method could know it.

    Parameters
    ----------
    building : Building
        Doors with a hinge stand open, doors without one are closed.
    profile : {"backpack", "static", "clean"}
        Kind of scan, see `profile_params`.
    points : int
        Number of points.
    seed : int
        Draws everything that is random; the same seed gives the same bytes.
    params : SimulateParams, optional
        In place of those of the profile.

    Raises
    ------
    ConfigError
        If the number of points is not positive, or nearly all rays miss the building.
    """
    if points < 1:
        raise ConfigError(f"a scan of {points} points was asked for: expected at least 1")
    settings = profile_params(profile) if params is None else params
    rng = np.random.Generator(np.random.PCG64(seed))
    walked = settings.movement == "walk"
    feet = walk_path(building) if walked else stations(building)
    leaves = door_leaves(building, rng=rng)
    boxes = [*leaves, *window_frames(building), *stair_steps(building)]
    if settings.furniture:
        boxes += [*furnish(building, feet, leaves, rng=rng), *surroundings(building)]
    scene = _Scene(np.concatenate([shell_triangles(building), box_triangles(boxes)]), glass_triangles(building))
    sensor = feet + np.array([0.0, 0.0, settings.sensor_height])
    duration = (len(feet) - 1) * _step(feet) / settings.speed if walked else len(feet) * _STATION_TIME
    batches: list[tuple[Points, Points, Points]] = []
    found = 0
    while found < points:
        count = int((points - found) * 1.25) + 1000
        rays = _walk_rays(sensor, duration, count, settings, rng) if walked else _station_rays(sensor, count, rng)
        distance = _measure(scene, rays, settings, rng)
        if walked and settings.people:
            distance = np.minimum(distance, _people(rays, feet, duration, settings))
        hit = np.isfinite(distance) & (distance < settings.max_range) & (rng.random(count) >= settings.dropout)
        if hit.mean() < 0.01:
            raise ConfigError(f"only {hit.sum()} of {count} rays hit building {building.name!r}: it is open on all sides or out of range")
        batches.append((rays.time[hit], rays.origin[hit], rays.direction[hit] * distance[hit][:, None]))
        found += int(hit.sum())
    time, origin, ray = (np.concatenate(part) for part in zip(*batches, strict=True))
    chosen = np.sort(rng.permutation(found)[:points])
    chosen = chosen[np.argsort(time[chosen], kind="stable")]
    time, origin, ray = time[chosen], origin[chosen], ray[chosen]
    noise = settings.range_noise * rng.standard_normal(points)
    drift = Drift.draw(duration, position=settings.drift, yaw=settings.drift_yaw, rng=rng)
    true, drifted = origin + ray, drift.apply(time, origin, ray)
    length = np.linalg.norm(ray, axis=1)
    noisy = drift.apply(time, origin, ray * (1 + noise / np.maximum(length, 0.1))[:, None])
    nominal = _map_frame(sensor[0], settings, rng)
    turn, shift = best_rigid_fit(drifted, true)
    times: Points = np.arange(0.0, duration, 0.1) if walked else (np.arange(len(feet), dtype=np.float64) + 0.5) * _STATION_TIME
    path = _positions(sensor, duration, times) if walked else sensor
    stops = drift.apply(times, path, np.zeros((len(times), 3)))
    return SimulatedScan(
        points=nominal.to_scan(noisy),
        gps_time=time,
        trajectory=np.column_stack([times, nominal.to_scan(stops)]),
        truth=replace(building, transform_cloud_to_model=nominal.then(turn, shift).rows(), source="scan.laz", method="truth"),
    )


class _Scene:
    """Opaque surfaces and panes of glass, ready for ray casting."""

    def __init__(self, solid: Triangles, glass: Triangles) -> None:
        self._solid, self._glass = _raycasting_scene(solid), _raycasting_scene(glass)

    def solid(self, origin: Points, direction: Points) -> Points:
        return _cast(self._solid, origin, direction)[0]

    def glass(self, origin: Points, direction: Points) -> tuple[Points, Points]:
        return _cast(self._glass, origin, direction)


def _raycasting_scene(triangles: Triangles) -> Any:
    import open3d as o3d

    scene: Any = o3d.t.geometry.RaycastingScene()
    if len(triangles):
        vertices = o3d.core.Tensor.from_numpy(triangles.reshape(-1, 3).astype(np.float32))
        scene.add_triangles(vertices, o3d.core.Tensor.from_numpy(np.arange(3 * len(triangles), dtype=np.uint32).reshape(-1, 3)))
    return scene if len(triangles) else None


def _cast(scene: Any, origin: Points, direction: Points) -> tuple[Points, Points]:
    """Distances (n,), infinite where nothing is hit, and surface normals (n, 3)."""
    import open3d as o3d

    if scene is None:
        return np.full(len(origin), np.inf), np.zeros_like(origin)
    rays = o3d.core.Tensor.from_numpy(np.hstack([origin, direction]).astype(np.float32))
    answer = scene.cast_rays(rays)
    return answer["t_hit"].numpy().astype(np.float64), answer["primitive_normals"].numpy().astype(np.float64)


def _measure(scene: _Scene, rays: _Rays, settings: SimulateParams, rng: np.random.Generator) -> Points:
    """Distance (n,) of the first return: through glass, from it, mirrored by it, or averaged over an edge."""
    distance = scene.solid(rays.origin, rays.direction)
    pane, normal = scene.glass(rays.origin, rays.direction)
    fate = rng.random(len(distance))
    behind = pane < distance
    returned = behind & (fate < settings.glass_return)
    mirrored = behind & ~returned & (fate < settings.glass_return + settings.glass_reflection)
    direction = rays.direction[mirrored]
    bounced = direction - 2 * np.sum(direction * normal[mirrored], axis=1)[:, None] * normal[mirrored]
    at_pane = rays.origin[mirrored] + direction * pane[mirrored][:, None] + bounced * _SKIP
    distance[mirrored] = pane[mirrored] + scene.solid(at_pane, bounced)
    distance[returned] = pane[returned]
    wide = np.flatnonzero(rng.random(len(distance)) < settings.mixed_pixels)
    beside = rays.direction[wide] + rng.normal(scale=0.004, size=(len(wide), 3))
    beside /= np.linalg.norm(beside, axis=1)[:, None]
    other, share = scene.solid(rays.origin[wide], beside), rng.random(len(wide))
    both = np.isfinite(other) & np.isfinite(distance[wide]) & ~behind[wide]
    wide, other, share = wide[both], other[both], share[both]
    distance[wide] += share * (other - distance[wide])
    return distance


def _walk_rays(sensor: Points, duration: float, count: int, settings: SimulateParams, rng: np.random.Generator) -> _Rays:
    """Rays of heads that spin while they are carried along the path; a random share of all that a real one would send."""
    time = np.sort(rng.uniform(0.0, duration, count))
    head, line = rng.integers(len(settings.head_tilts), size=count), rng.integers(settings.lines, size=count)
    elevation = (
        np.radians(np.linspace(-settings.line_fov / 2, settings.line_fov / 2, settings.lines))[line]
        if settings.lines > 1
        else np.zeros(count)
    )
    azimuth = 2 * np.pi * np.modf(settings.spin_rate * time + head / len(settings.head_tilts))[0]
    forward, left, up = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    tilt = np.radians(np.asarray(settings.head_tilts))[head]
    forward, up = np.cos(tilt) * forward - np.sin(tilt) * up, np.sin(tilt) * forward + np.cos(tilt) * up
    ahead = _positions(sensor, duration, time + 0.4) - _positions(sensor, duration, time - 0.4)
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    direction = np.column_stack(
        [np.cos(heading) * forward - np.sin(heading) * left, np.sin(heading) * forward + np.cos(heading) * left, up]
    )
    bob = np.column_stack([np.zeros((count, 2)), 0.02 * np.sin(2 * np.pi * 1.8 * time)])
    return _Rays(time, _positions(sensor, duration, time) + bob, direction)


def _station_rays(sensor: Points, count: int, rng: np.random.Generator) -> _Rays:
    """Rays in all directions but straight down, from each tripod in turn."""
    time = np.sort(rng.uniform(0.0, len(sensor) * _STATION_TIME, count))
    up = rng.uniform(-np.cos(_TRIPOD_SHADE), 1.0, count)
    azimuth = rng.uniform(0.0, 2 * np.pi, count)
    level = np.sqrt(1 - up**2)
    station = np.minimum((time // _STATION_TIME).astype(np.int64), len(sensor) - 1)
    return _Rays(time, sensor[station], np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), up]))


def _positions(path: Points, duration: float, time: Points) -> Points:
    """Position (n, 3) on an evenly walked path at the given times."""
    place = np.clip(time / duration, 0.0, 1.0) * (len(path) - 1)
    return np.column_stack([np.interp(place, np.arange(len(path)), path[:, axis]) for axis in range(3)])


def _step(path: Points) -> float:
    return float(np.median(np.linalg.norm(np.diff(path, axis=0), axis=1)))


def _people(rays: _Rays, feet: Points, duration: float, settings: SimulateParams) -> Points:
    """Distance (n,) to people (upright cylinders) who walk before and behind the scanner."""
    distance = np.full(len(rays.time), np.inf)
    for k in range(settings.people):
        delay = (1 if k % 2 == 0 else -1) * (_PERSON_AHEAD + 0.7 * (k // 2)) / settings.speed
        person = _positions(feet, duration, rays.time + delay)
        offset = (rays.origin - person)[:, :2]
        a = np.maximum(np.sum(rays.direction[:, :2] ** 2, axis=1), 1e-12)
        b, c = np.sum(rays.direction[:, :2] * offset, axis=1), np.sum(offset**2, axis=1) - _PERSON_RADIUS**2
        root = b**2 - a * c
        t = (-b - np.sqrt(np.maximum(root, 0))) / a
        z = rays.origin[:, 2] + t * rays.direction[:, 2] - person[:, 2]
        distance = np.where((root > 0) & (c > 0) & (t > 0) & (z > 0) & (z < _PERSON_HEIGHT), np.minimum(distance, t), distance)
    return distance


def _map_frame(first: Points, settings: SimulateParams, rng: np.random.Generator) -> Frame:
    """Frame from scan coordinates, which start at the first sensor position, to model coordinates."""
    drawn = rng.uniform([2.0, 0.0, -180.0], [15.0, 360.0, 180.0])
    tilt = np.radians(drawn[0] if settings.map_tilt is None else settings.map_tilt)
    yaw = np.radians(drawn[2] if settings.map_yaw is None else settings.map_yaw)
    axis = np.radians(drawn[1])
    x, y = np.cos(axis), np.sin(axis)
    cross = np.array([[0, 0, y], [0, 0, -x], [-y, x, 0]])
    lean = np.eye(3) + np.sin(tilt) * cross + (1 - np.cos(tilt)) * cross @ cross
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    return Frame(np.asarray(settings.map_origin, dtype=np.float64), (lean @ turn).T, 1.0, np.asarray(first, dtype=np.float64))
