"""Height of the ground everywhere, from the ground points of a scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_bim.outdoor.model import Ground

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """Ground heights on the corners of a square grid.

    Parameters
    ----------
    heights : (rows, columns) float64
        Height of the ground at each grid point, metres; rows run along y, columns along x.
    seen : (rows, columns) bool
        Where there were ground points; elsewhere the height is interpolated.
    origin : (2,) float64
        Place of grid point [0, 0], metres.
    spacing : float
        Distance between grid points, metres.
    """

    heights: Floats
    seen: NDArray[np.bool_]
    origin: Floats
    spacing: float

    def at(self, xy: Floats) -> Floats:
        """Ground height (n,) under points (n, 2), bilinear; beyond the grid that of its border.

        Parameters
        ----------
        xy : (n, 2) float64
            Points, metres.
        """
        rows, columns = self.heights.shape
        place = np.clip((np.asarray(xy, dtype=np.float64) - self.origin) / self.spacing, 0.0, [columns - 1.0, rows - 1.0])
        low = np.minimum(place.astype(np.int64), [max(columns - 2, 0), max(rows - 2, 0)])
        j, i = low.T
        u, v = (place - low).T
        next_j, next_i = np.minimum(j + 1, columns - 1), np.minimum(i + 1, rows - 1)
        z = self.heights
        lower = z[i, j] * (1 - u) + z[i, next_j] * u
        upper = z[next_i, j] * (1 - u) + z[next_i, next_j] * u
        height: Floats = lower * (1 - v) + upper * v
        return height


def ground_terrain(ground: Floats, *, spacing: float = 1.0) -> Terrain:
    """Ground heights on a grid: the median of the ground points about each grid point, smoothly filled where there are none.

    Parameters
    ----------
    ground : (n, 3) float64
        Ground points, metres.
    spacing : float
        Distance between grid points, metres.

    Raises
    ------
    ValueError
        If there is no point.

    Notes
    -----
    Gaps, such as the places of houses, hold the mean of the seen heights about them, weighted by a Gaussian that widens until it
    reaches some (normalised convolution; H. Knutsson and C.-F. Westin, CVPR 1993).

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(9.0), np.arange(9.0))
    >>> slope = np.column_stack([x.ravel(), y.ravel(), 0.1 * x.ravel()])
    >>> ground_terrain(slope).at(np.array([[4.5, 4.0]])).round(3).tolist()
    [0.45]
    """
    if not len(ground):
        raise ValueError("expected at least one ground point")
    index = np.floor(ground[:, :2] / spacing + 0.5).astype(np.int64)
    low = index.min(axis=0)
    columns, rows = (index.max(axis=0) - low + 1).tolist()
    key = (index[:, 1] - low[1]) * columns + index[:, 0] - low[0]
    heights, seen = _medians(key, ground[:, 2], rows * columns)
    filled = _fill(heights.reshape(rows, columns), seen.reshape(rows, columns))
    return Terrain(filled, seen.reshape(rows, columns), low * spacing, spacing)


def ground_mesh(terrain: Terrain, *, most: int = 40_000) -> Ground:
    """Triangles between the grid points of a terrain.

    Parameters
    ----------
    terrain : Terrain
        Ground heights.
    most : int
        Largest number of vertices; a finer terrain is thinned to every second, third, ... grid point.

    Returns
    -------
    Ground
        Squares with a corner that was seen, two triangles each.
    """
    rows, columns = terrain.heights.shape
    step = max(1, int(np.ceil(np.sqrt(rows * columns / most))))
    z = terrain.heights[::step, ::step]
    near = _any_seen(terrain.seen, step)
    i, j = np.nonzero(near[: z.shape[0] - 1, : z.shape[1] - 1])
    width = z.shape[1]
    a = i * width + j
    corners = np.concatenate([np.column_stack([a, a + 1, a + width + 1]), np.column_stack([a, a + width + 1, a + width])])
    used, index = np.unique(corners, return_inverse=True)
    y, x = np.divmod(used, width)
    vertices = np.column_stack([terrain.origin + np.column_stack([x, y]) * step * terrain.spacing, z.ravel()[used]])
    return Ground(
        tuple((float(x), float(y), float(z)) for x, y, z in vertices.tolist()),
        tuple((int(a), int(b), int(c)) for a, b, c in index.reshape(-1, 3).tolist()),
    )


def _any_seen(seen: NDArray[np.bool_], step: int) -> NDArray[np.bool_]:
    """Whether any grid point of each square of that many steps was seen."""
    rows, columns = (np.arange(0, count, step) for count in seen.shape)
    squares: NDArray[np.bool_] = np.logical_or.reduceat(np.logical_or.reduceat(seen, rows, axis=0), columns, axis=1)
    return squares


def spot_heights(ground: Floats, *, spacing: float, radius: float) -> Floats:
    """Heights to write on a map: means of the ground points about sampled ground points.

    Parameters
    ----------
    ground : (n, 3) float64
        Ground points, metres.
    spacing : float
        Distance between sampled points, metres: in each square of that side, the ground point next to the middle.
    radius : float
        Radius about the sampled point within which ground points are averaged in x, y and z, metres.

    Returns
    -------
    (m, 3) float64
        Place and height, sorted by x, then y.

    Notes
    -----
    Sensors 2024, 24, 5723, equation 7; the paper draws the points at random.
    """
    from scipy.spatial import cKDTree

    if not len(ground):
        return np.zeros((0, 3))
    xy = ground[:, :2]
    cell = np.floor(xy / spacing)
    from_middle = ((xy - (cell + 0.5) * spacing) ** 2).sum(axis=1)
    order = np.lexsort((ground[:, 2], ground[:, 1], ground[:, 0], from_middle, cell[:, 1], cell[:, 0]))
    ordered = cell[order]
    first = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    samples = xy[order[first]]
    close = ground[_close_to(xy, samples, radius)]
    close = close[np.lexsort((close[:, 2], close[:, 1], close[:, 0]))]
    around = cKDTree(close[:, :2]).query_ball_point(samples, radius, return_sorted=True)
    means = np.array([close[near].mean(axis=0) for near in around])
    return means[np.lexsort((means[:, 1], means[:, 0]))]


def _close_to(xy: Floats, samples: Floats, radius: float) -> NDArray[np.bool_]:
    """Points in the squares of side `radius` of the samples, or in the squares beside them."""
    stride = 1 << 31
    steps = (np.array([-1, 0, 1])[:, None] * stride + np.array([-1, 0, 1])).ravel()

    def squares(points: Floats) -> NDArray[np.int64]:
        index = np.floor(points / radius).astype(np.int64)
        return np.asarray(index[:, 0] * stride + index[:, 1])

    wanted = np.unique(squares(samples)[:, None] + steps)
    asked = squares(xy)
    near: NDArray[np.bool_] = wanted[np.minimum(np.searchsorted(wanted, asked), len(wanted) - 1)] == asked
    return near


def _medians(key: NDArray[np.int64], values: Floats, count: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Median of the values of each key, and which keys have any."""
    order = np.lexsort((values, key))
    key, values = key[order], values[order]
    starts = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    counts = np.diff(np.append(starts, len(key)))
    medians = np.zeros(count)
    medians[key[starts]] = (values[starts + (counts - 1) // 2] + values[starts + counts // 2]) / 2
    seen = np.zeros(count, dtype=np.bool_)
    seen[key[starts]] = True
    return medians, seen


def _fill(heights: Floats, seen: NDArray[np.bool_]) -> Floats:
    from scipy.ndimage import gaussian_filter

    filled, known = heights.copy(), seen.copy()
    sigma = 1.0
    while not known.all():
        weight = gaussian_filter(seen.astype(np.float64), sigma, mode="constant", truncate=3.0)
        mean = gaussian_filter(np.where(seen, heights, 0.0), sigma, mode="constant", truncate=3.0)
        reached = ~known & (weight > 1e-3)
        filled[reached] = mean[reached] / weight[reached]
        known |= reached
        sigma *= 1.5
    return filled
