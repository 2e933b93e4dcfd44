"""A wall goes on behind cupboards, and does not run on past its end."""

from __future__ import annotations

import numpy as np
import pytest

from indoor_bim.plan import passing_rays
from indoor_bim.plan.cells import cut_into_cells, hidden_wall
from indoor_bim.plan.passing_rays import Rays


@pytest.mark.parametrize(
    ("seen", "empty_inside", "found"),
    [
        ([(0, 2), (4, 6)], True, [(2, 4)]),  # hidden between two seen parts: the wall goes on
        ([(0, 2)], True, []),  # seen on one side only: it may end there
        ([(0, 2), (4, 6)], False, []),  # floor or ceiling was seen between the faces: a passage
    ],
)
def test_a_wall_is_hidden_only_between_two_seen_parts(seen, empty_inside, found):
    p = np.array([[0, 0.2], [6, 0], [0, -2], [2, -2], [4, -2], [6, -2], [0, -2], [0, 2]], dtype=float)
    q = np.array([[6, 0.2], [0, 0], [0, 2], [2, 2], [4, 2], [6, 2], [6, -2], [6, 2]], dtype=float)
    cells = cut_into_cells(p, q)
    direction = (q - p)[:2] / 6  # the two faces of the wall; the other lines only cut
    middle = (cells.edge_start + cells.edge_end) / 2
    face = cells.edge_line < 2
    wall = np.array([float(face[k] and any(a < middle[k, 0] < b for a, b in seen)) for k in range(len(middle))])
    inside = np.array([0 < polygon.centroid.y < 0.2 for polygon in cells.polygons])
    hidden = hidden_wall(cells, wall, direction, empty=inside if empty_inside else np.zeros(len(inside), dtype=bool))
    assert sorted(set(np.round(middle[hidden, 0], 3).tolist())) == [(a + b) / 2 for a, b in found]
    assert hidden.sum() == 2 * len(found)


@pytest.mark.parametrize(("across", "found"), [(0.3, 2), (0.2, 0), (0.0, 0)])
def test_a_wall_is_hidden_up_to_the_face_of_a_wall_across(across, found):
    p = np.array([[0, 0.2], [6, 0], [4, 2], [0, -2], [2, -2], [0, 2], [0, -2], [6, -2]], dtype=float)
    q = np.array([[6, 0.2], [0, 0], [4, -2], [0, 2], [2, 2], [6, 2], [6, -2], [6, 2]], dtype=float)
    cells = cut_into_cells(p, q)
    direction = (q - p)[:3] / np.hypot(*(q - p)[:3].T)[:, None]  # two faces of the wall and one across it at x = 4
    middle = (cells.edge_start + cells.edge_end) / 2
    wall = np.where(cells.edge_line < 2, middle[:, 0] < 2, across * (cells.edge_line == 2)).astype(float)
    empty = np.array([0 < polygon.centroid.y < 0.2 for polygon in cells.polygons])
    hidden = hidden_wall(cells, wall, direction, empty=empty)
    assert hidden.sum() == found
    np.testing.assert_allclose(middle[hidden, 0], 3.0)


@pytest.mark.parametrize(("between_is_hidden", "found"), [(True, 2), (False, 0)])
def test_a_wall_is_hidden_all_the_way_to_the_wall_across(between_is_hidden, found):
    """The cells between the hidden part, x from 2 to 3, and the wall across at x = 4 show no floor and no ceiling either, or they do."""
    p = np.array([[0, 0.2], [6, 0], [4, 2], [0, -2], [2, -2], [3, -2], [0, 2], [0, -2], [6, -2]], dtype=float)
    q = np.array([[6, 0.2], [0, 0], [4, -2], [0, 2], [2, 2], [3, 2], [6, 2], [6, -2], [6, 2]], dtype=float)
    cells = cut_into_cells(p, q)
    direction = (q - p)[:3] / np.hypot(*(q - p)[:3].T)[:, None]
    middle = (cells.edge_start + cells.edge_end) / 2
    wall = np.where(cells.edge_line < 2, middle[:, 0] < 2, cells.edge_line == 2).astype(float)
    empty = np.array([0 < c.centroid.y < 0.2 and (between_is_hidden or c.centroid.x < 3) for c in cells.polygons])
    hidden = hidden_wall(cells, wall, direction, empty=empty)
    assert np.count_nonzero(hidden & (np.abs(middle[:, 0] - 2.5) < 0.1)) == found


@pytest.mark.parametrize("back_is_seen", [True, False])
def test_a_face_behind_a_cupboard_goes_on_where_the_other_face_was_seen(back_is_seen):
    p = np.array([[0, 0.2], [6, 0], [0, -2], [2, -2], [4, -2], [6, -2], [0, -2], [0, 2]], dtype=float)
    q = np.array([[6, 0.2], [0, 0], [0, 2], [2, 2], [4, 2], [6, 2], [6, -2], [6, 2]], dtype=float)
    cells = cut_into_cells(p, q)
    direction = (q - p)[:2] / 6
    middle = (cells.edge_start + cells.edge_end) / 2
    hides = np.abs(middle[:, 0] - 3) < 1
    wall = np.where(cells.edge_line == 0, ~hides, cells.edge_line == 1).astype(float)
    if not back_is_seen:
        wall[(cells.edge_line == 1)] = 0.0
    inside = np.array([0 < polygon.centroid.y < 0.2 for polygon in cells.polygons])
    hidden = hidden_wall(cells, wall, direction, empty=inside)
    assert hidden[hides & (cells.edge_line == 0)].all() == back_is_seen
    assert not hidden_wall(cells, wall, direction, empty=inside, sided=False).any()
    assert not hidden[~hides].any()


@pytest.mark.parametrize(("cut", "passing", "without_rays", "found"), [(5, 0, 0, 4), (5, 300, 0, 0), (2, 0, 2, 2), (2, 300, 2, 0)])
def test_a_wall_is_hidden_for_long_where_no_ray_passes(cut, passing, without_rays, found):
    """Both faces were seen up to x = 2, and from there to the wall across at x = 8 nothing was; another line may cut what is hidden."""
    p = np.array([[0, 0.2], [9, 0], [8, 2], [0, -2], [2, -2], [cut, -2], [0, 2], [0, -2], [9, -2]], dtype=float)
    q = np.array([[9, 0.2], [0, 0], [8, -2], [0, 2], [2, 2], [cut, 2], [9, 2], [9, -2], [9, 2]], dtype=float)
    cells = cut_into_cells(p, q)
    direction = (q - p)[:3] / np.hypot(*(q - p)[:3].T)[:, None]
    middle = (cells.edge_start + cells.edge_end) / 2
    wall = np.where(cells.edge_line < 2, middle[:, 0] < 2, cells.edge_line == 2).astype(float)
    empty = np.array([0 < polygon.centroid.y < 0.2 for polygon in cells.polygons])
    along = np.linspace(2.5, 7.5, passing)
    origins, hits = (np.column_stack([along, np.full(passing, y), np.ones(passing)]) for y in (-1.0, 1.0))
    rays = Rays(hits, origins, 0.0, 2.5)
    assert hidden_wall(cells, wall, direction, empty=empty, rays=rays).sum() == found
    assert hidden_wall(cells, wall, direction, empty=empty).sum() == without_rays


@pytest.mark.parametrize("both_sides", [True, False])
@pytest.mark.parametrize("in_turn", [True, False])
@pytest.mark.parametrize(
    ("p", "q"), [((0.0, 1.0), (4.0, 1.0)), ((3.0, 4.0), (1.0, -2.0)), ((2.0, 1.0), (1.4, 1.0)), ((2.0, 2.0), (2.0, 2.0))]
)
def test_many_rays_are_counted_as_few_are(p, q, in_turn, both_sides, monkeypatch):
    """Those of a scanner that moves keep together, and most blocks of them are far from a wall."""
    rng = np.random.default_rng(1)
    hits, origins = rng.uniform([-1, -2, 0], [5, 5, 3], (2, 30_000, 3))
    hits[::3, 1] = 1 + rng.normal(0, 0.04, 10_000)
    if in_turn:
        origins = origins[np.argsort(origins[:, 0])]
        hits[:, 0] = origins[:, 0] + rng.normal(0, 0.1, len(hits))
    rays = Rays(hits, origins, 0.1, 2.4)
    many = rays.met(np.array(p), np.array(q), both_sides=both_sides)
    through = [rays.seen_through(np.array(p), np.array(q), stopped=stopped) for stopped in np.geomspace(1, 1e6, 50)]
    monkeypatch.setattr(passing_rays, "FEW_RAYS", len(hits))
    assert many == rays.met(np.array(p), np.array(q), both_sides=both_sides)
    assert through == [rays.seen_through(np.array(p), np.array(q), stopped=stopped) for stopped in np.geomspace(1, 1e6, 50)]
    assert many[1] > 100 or p == q
