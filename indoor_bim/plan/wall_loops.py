"""Rays and points at walls, one by one: the compiled inner loops of `wall_rays`, `wall_points` and `wall_picture`."""

from __future__ import annotations

import numpy as np
from numba import types

from indoor_bim.compiled import compiled

BLOCK = 256  # rays that are taken together
SLACK = 1e-3  # metres

_points = types.Array(types.float64, 2, "C", readonly=True)
_wall = types.Array(types.float64, 1, "C", readonly=True)
_rows, _names = types.Array(types.int32, 1, "C"), types.Array(types.int16, 1, "C")
_table = types.Array(types.float32, 2, "C")
_ints = types.Array(types.int64, 1, "C")
_f64, _f32 = types.float64, types.float32
_sides, _float32s = types.Array(types.int8, 1, "A", readonly=True), types.Array(types.float32, 1, "A", readonly=True)
_floats = types.Array(types.float64, 1, "A", readonly=True)
_two_pictures, _one_picture = types.Array(types.int64, 3, "C"), types.Array(types.int64, 2, "C")


@compiled(_points, _points, _points, _f64, _f64, _rows, _names)
def rays_of_walls(points, sensors, walls, front, margin, rows, names):  # type: ignore[no-untyped-def]
    """Write the numbers of rays and walls that came together, as many as there is room for; return how many there are.

    `walls` has a row for each: x, y, dx, dy, half, length, base, height. Blocks of rays that stay on one side of the line of a wall are not
    looked at. Most of the other rays are told from most walls by a loop over a block of them that has no branches, eight answers at a time.
    """
    found = 0
    near = np.zeros(BLOCK, np.uint8)
    eight = near.view(np.uint64)
    px, py, sx, sy = np.zeros(BLOCK), np.zeros(BLOCK), np.zeros(BLOCK), np.zeros(BLOCK)
    for first in range(0, len(points), BLOCK):
        count = min(BLOCK, len(points) - first)
        for k in range(count):
            px[k], py[k], sx[k], sy[k] = points[first + k, 0], points[first + k, 1], sensors[first + k, 0], sensors[first + k, 1]
        x0, x1 = min(px[:count].min(), sx[:count].min()), max(px[:count].max(), sx[:count].max())
        y0, y1 = min(py[:count].min(), sy[:count].min()), max(py[:count].max(), sy[:count].max())
        for w in range(len(walls)):
            x, y, dx, dy, half = walls[w, 0], walls[w, 1], walls[w, 2], walls[w, 3], walls[w, 4]
            apart = abs(((y0 + y1) / 2 - y) * dx - ((x0 + x1) / 2 - x) * dy)
            if apart - ((y1 - y0) * abs(dx) + (x1 - x0) * abs(dy)) / 2 > half + front + SLACK:
                continue
            low, high = -margin - SLACK, walls[w, 5] + margin + SLACK
            for k in range(BLOCK):
                begin, end = (sy[k] - y) * dx - (sx[k] - x) * dy, (py[k] - y) * dx - (px[k] - x) * dy
                end = end if begin >= 0 else -end
                begin = abs(begin)
                u, v = (sx[k] - x) * dx + (sy[k] - y) * dy, (px[k] - x) * dx + (py[k] - y) * dy
                along = u * (begin - end) + (begin - half) * (v - u)  # times the way across
                before, beyond = along <= low * (begin - end), along >= high * (begin - end)
                near[k] = (begin > half) & (end < half + front) & (end < begin) & ~before & ~beyond
            for k in range(count):
                if eight[k // 8] == 0 or not near[k]:
                    continue
                i = first + k
                begin, end = (sy[k] - y) * dx - (sx[k] - x) * dy, (py[k] - y) * dx - (px[k] - x) * dy
                if begin < 0:
                    begin, end = -begin, -end
                share = (begin - half) / (begin - end)
                up = sensors[i, 2] + share * (points[i, 2] - sensors[i, 2]) - walls[w, 6]
                if not (up > -margin and up < walls[w, 7] + margin):
                    continue
                along = (sx[k] + share * (px[k] - sx[k]) - x) * dx + (sy[k] + share * (py[k] - sy[k]) - y) * dy
                if not (along > -margin and along < walls[w, 5] + margin):
                    continue
                if found < len(rows):
                    rows[found], names[found] = i, w
                found += 1
    return found


@compiled(_rows, _names, types.int32, _ints, _rows)
def sort_by_wall(rows, names, offset, first, grouped):  # type: ignore[no-untyped-def]
    """Rows plus an offset, wall by wall; `first` gets where each begins, and the end."""
    for k in range(len(names)):
        first[names[k] + 1] += 1
    for w in range(len(first) - 1):
        first[w + 1] += first[w]
    place = first.copy()
    for k in range(len(rows)):
        grouped[place[names[k]]] = rows[k] + offset
        place[names[k]] += 1


@compiled(_points, _points, _rows, _wall, _table)
def ray_fields(points, sensors, rows, wall, fields):  # type: ignore[no-untyped-def]
    """Side, depth, along, up, far along, far up, end along, end up, slant and length of the rays at one wall, a row of `fields` each."""
    x, y, dx, dy, half, base = wall[0], wall[1], wall[2], wall[3], wall[4], wall[6]
    for k in range(len(rows)):
        i = rows[k]
        begin = (sensors[i, 1] - y) * dx - (sensors[i, 0] - x) * dy
        end = (points[i, 1] - y) * dx - (points[i, 0] - x) * dy
        side = 1.0
        if begin < 0:
            begin, end, side = -begin, -end, -1.0
        u = (sensors[i, 0] - x) * dx + (sensors[i, 1] - y) * dy
        v = (points[i, 0] - x) * dx + (points[i, 1] - y) * dy
        low, rise = sensors[i, 2] - base, points[i, 2] - sensors[i, 2]
        near, far = (begin - half) / (begin - end), (begin + half) / (begin - end)
        length = np.sqrt((begin - end) ** 2 + (v - u) ** 2 + rise**2)
        fields[0, k] = side
        fields[1, k] = half - end
        fields[2, k], fields[3, k] = u + near * (v - u), low + near * rise
        fields[4, k], fields[5, k] = u + far * (v - u), low + far * rise
        fields[6, k], fields[7, k] = v, low + rise
        fields[8, k] = (begin - end) / max(length, 1e-9)
        fields[9, k] = length


@compiled(_sides, *[_float32s] * 6, _f32, _f32, _f32, _f32, _two_pictures, _two_pictures, _two_pictures)
def count_rays(  # type: ignore[no-untyped-def]
    sides, depth, slant, along, up, along_end, up_end, tolerance, through_depth, steep, cell, face, entered, through
):
    """Count the rays from each side (1, -1) that ended on a face, went in, and went through, in the cells where they did so."""
    rows, columns = face.shape[1], face.shape[2]
    for i in range(len(sides)):
        side = 0 if sides[i] == 1 else 1
        if abs(depth[i]) <= tolerance:
            row, column = np.floor(up_end[i] / cell), np.floor(along_end[i] / cell)
            if row >= 0 and row < rows and column >= 0 and column < columns:
                face[side, int(row), int(column)] += 1
        elif depth[i] > tolerance and slant[i] > steep:
            row, column = np.floor(up[i] / cell), np.floor(along[i] / cell)
            if row >= 0 and row < rows and column >= 0 and column < columns:
                entered[side, int(row), int(column)] += 1
                if depth[i] > through_depth:
                    through[side, int(row), int(column)] += 1


@compiled(_floats, _floats, _floats, _f64, _f64, _one_picture)
def count_ahead(along, across, up, half, cell, front):  # type: ignore[no-untyped-def]
    """Count the points farther from the centre line than half a thickness in the cells before which they lie."""
    rows, columns = front.shape
    for i in range(len(along)):
        if abs(across[i]) > half:
            row, column = np.floor(up[i] / cell), np.floor(along[i] / cell)
            if row >= 0 and row < rows and column >= 0 and column < columns:
                front[int(row), int(column)] += 1
