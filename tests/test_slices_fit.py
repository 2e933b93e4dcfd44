"""Weighted polar line fits: exact lines, covariance by Monte Carlo, better than total least squares."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan.noise import scanner_noise
from indoor_bim.plan.polar_fit import PolarLines, fit_lines, point_covariance, project_ends

FITS, POINTS = 2000, 60
RANGE_NOISE, BEARING_NOISE = 0.02, 0.004


def measured(seed: int, *, fits: int = FITS):
    """Points of one wall measured many times, in turn from nearby and from far along the wall, with range and bearing noise."""
    rng = np.random.default_rng(seed)
    alpha, radius = np.radians(70.0), 4.0
    along = np.linspace(-6.0, 3.0, POINTS)
    normal, tangent = np.array([np.cos(alpha), np.sin(alpha)]), np.array([-np.sin(alpha), np.cos(alpha)])
    true = radius * normal + along[:, None] * tangent
    scanner = np.where(np.arange(POINTS)[:, None] % 2 == 0, [1.0, 0.5], radius * normal - 3.0 * normal + 18.0 * tangent)
    scanner = np.tile(scanner, (fits, 1))
    ray = np.tile(true, (fits, 1)) - scanner
    distance, bearing = np.hypot(*ray.T), np.arctan2(ray[:, 1], ray[:, 0])
    distance = distance + RANGE_NOISE * rng.standard_normal(len(ray))
    bearing = bearing + BEARING_NOISE * rng.standard_normal(len(ray))
    points = scanner + distance[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])
    return points, scanner, np.repeat(np.arange(fits), POINTS), alpha, radius


@pytest.fixture(scope="module")
def fits():
    points, scanner, group, alpha, radius = measured(1)
    covariance = point_covariance(points, scanner, range_noise=RANGE_NOISE, bearing_noise=BEARING_NOISE)
    return fit_lines(points, group, covariance), alpha, radius


def test_95_percent_ellipses_hold_the_true_line_in_95_percent_of_fits(fits):
    lines, alpha, radius = fits
    error = np.column_stack([lines.alpha - alpha, lines.radius - radius])
    distance = np.einsum("mi,mij,mj->m", error, np.linalg.inv(lines.covariance), error)
    assert 0.93 <= (distance <= -2 * np.log(0.05)).mean() <= 0.97


def test_estimates_scatter_as_their_covariance_says_and_are_not_biased(fits):
    lines, alpha, radius = fits
    error = np.column_stack([lines.alpha - alpha, lines.radius - radius])
    stated = lines.covariance.mean(axis=0)
    white = np.linalg.solve(np.linalg.cholesky(stated), error.T)
    assert np.cov(white) == pytest.approx(np.eye(2), abs=0.1)
    assert np.all(np.abs(error.mean(axis=0)) < 4 * np.sqrt(np.diag(stated) / FITS))


def test_weights_beat_total_least_squares_where_the_noise_is_unequal(fits):
    lines, alpha, radius = fits
    points, _, group, _, _ = measured(1)
    plain = fit_lines(points, group, np.broadcast_to(np.eye(2), (len(points), 2, 2)))
    for name, true in (("alpha", alpha), ("radius", radius)):
        weighted, unweighted = (np.sqrt(np.mean((getattr(fit, name) - true) ** 2)) for fit in (lines, plain))
        assert weighted < 0.75 * unweighted


def test_an_exact_line_comes_back_far_from_the_origin():
    along = np.linspace(0, 3, 20)
    for degrees in (0.0, 30.0, 90.0, 179.0):
        a = np.radians(degrees)
        points = np.array([5000.0, -3000.0]) + along[:, None] * [-np.sin(a), np.cos(a)]
        line = fit_lines(points, np.zeros(20, dtype=np.int64), np.broadcast_to(1e-4 * np.eye(2), (20, 2, 2)))
        assert np.abs(points @ line.normal[0] - line.radius[0]).max() < 1e-8
        p, q = project_ends(points, np.zeros(20, dtype=np.int64), line)
        assert sorted([p[0].round(6).tolist(), q[0].round(6).tolist()]) == sorted(
            [points[0].round(6).tolist(), points[-1].round(6).tolist()]
        )


def test_groups_are_fitted_as_if_they_were_alone():
    rng = np.random.default_rng(3)
    points = rng.normal(0, 1, (300, 2)) * [1, 0.01]
    group = rng.integers(-1, 4, 300)
    covariance = np.broadcast_to(1e-4 * np.eye(2), (300, 2, 2))
    together = fit_lines(points, group, covariance)
    for k in range(4):
        alone = fit_lines(points[group == k], np.zeros((group == k).sum(), dtype=np.int64), covariance[group == k])
        assert together.alpha[k] == pytest.approx(alone.alpha[0], abs=1e-9)
        assert together.covariance[k] == pytest.approx(alone.covariance[0], rel=1e-9)


def test_moving_the_origin_there_and_back_changes_nothing(fits):
    lines, _, _ = fits
    origin = np.array([3.0, -8.0])
    back = lines.moved(origin).moved(-origin)
    assert back.radius == pytest.approx(lines.radius)
    assert back.covariance == pytest.approx(lines.covariance)


def test_turned_lines_are_the_same_lines():
    lines = PolarLines(np.array([0.3]), np.array([2.0]), np.array([[[1e-4, 2e-5], [2e-5, 1e-4]]]))
    turned = lines.facing(np.zeros((1, 2)))  # the origin lies below a line at distance 2
    assert turned.normal[0] == pytest.approx(-lines.normal[0])
    assert turned.radius[0] == -2.0
    assert turned.covariance[0].tolist() == [[1e-4, -2e-5], [-2e-5, 1e-4]]


def test_a_group_of_one_place_has_no_line():
    line = fit_lines(np.ones((5, 2)), np.zeros(5, dtype=np.int64), np.broadcast_to(np.eye(2), (5, 2, 2)))
    assert np.isnan(line.alpha[0])
    assert np.isnan(line.covariance).all()


def test_noise_of_the_scanner_is_found_from_the_distances():
    rng = np.random.default_rng(5)
    scanner = np.tile([[0.0, 0.0]], (60_000, 1))
    angle = rng.uniform(-1.4, 1.4, 60_000)
    distance = 3.0 / np.cos(angle) + 0.015 * rng.standard_normal(60_000)
    bearing = angle + 0.003 * rng.standard_normal(60_000)
    points = distance[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])
    wall = PolarLines(np.zeros(1), np.array([3.0]), np.zeros((1, 2, 2)))
    found = scanner_noise(points, scanner, np.zeros(60_000, dtype=np.int64), wall)
    assert found == pytest.approx((0.015, 0.003), rel=0.08)
