"""Find where the rays of a distorted lens end at a solid, triangle by triangle.

The same as `kernels.body.shadow`, for rays that have no straight rows: the tree is traversed front to back, a box is
skipped where no ray can pass the ball around it, and a triangle is tested against the rays of tiles between its
edges.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.body.face import (
    DOUBT,
    View,
    ball_around,
    bounds_of,
    set_normals,
    size_of,
    view_of,
)
from riglens.core.kernels.body.screen import in_sensor_axes
from riglens.core.kernels.body.shadow import near2
from riglens.core.kernels.body.solid import EDGE, Tree, meet
from riglens.core.kernels.rays.cast import Cast, ray_direction
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.rays.tiles import (
    AFTER,
    COLUMN,
    OWN_RAYS,
    ROW,
    ROWS,
    SIDE_BLUR,
    Sides,
    TiledRays,
    cuts_of,
    new_sides,
    rows_of,
    span_of,
)
from riglens.core.kernels.runtime.jit import lean, lean_inlined, parallel_kernel, serial

_AROUND = 0.999
"""Sine of the half angle of a cone around a ball beyond which it may be anywhere."""


class Rows(NamedTuple):
    """Obstacles of rays: triangles in a tree, a selection of them (t,), the distance from which they count; first and
    end of the rows in question."""

    tree: Tree
    stops: np.ndarray
    start: float
    first: int
    end: int


@lean_inlined
def _set_edges(view: View, normals: np.ndarray, sides: Sides, distance: float, radius: float) -> bool:
    """Write the edges of a triangle in a ball at a distance as sides; return whether they are known: not where it is
    seen edge on."""
    largest, corner = set_normals(view, normals), view.corner
    over = normals[2, 0] * corner[0] + normals[2, 1] * corner[1] + normals[2, 2] * corner[2]
    if not abs(over) > 3.0 * DOUBT * largest * (distance + radius):
        return False
    sign = 1.0 if over > 0.0 else -1.0
    room = 3.0 * EDGE * size_of((normals[2, 0], normals[2, 1], normals[2, 2])) + 3.0 * DOUBT * largest
    for edge in range(3):
        plane = sides.plane[edge]
        for axis in range(3):
            plane[axis] = sign * normals[edge, axis]
            if edge == 2:
                plane[axis] -= sign * (normals[0, axis] + normals[1, axis])
        size = max(size_of((plane[0], plane[1], plane[2])), room)
        for axis in range(3):
            plane[axis] /= size
        plane[3], plane[4] = 0.0, SIDE_BLUR + room / size
    return True


@lean_inlined
def _set_ball(place: Vector, radius: float, sides: Sides) -> int:
    """Write planes that touch a ball at a place in the sensor's axes as sides; return how many."""
    distance = size_of(place)
    if radius >= _AROUND * distance:
        return 0
    x, y, z = place[0] / distance, place[1] / distance, place[2] / distance
    flat, sine = np.sqrt(x * x + y * y), radius / distance
    cosine = np.sqrt(1.0 - sine * sine)
    a, b = (-y / flat, x / flat) if flat > 1e-6 else (1.0, 0.0)
    for side in range(4):
        plane, to = sides.plane[side], cosine if side & 1 else -cosine
        u, v, w = (a, b, 0.0) if side & 2 else (-z * b, z * a, x * b - y * a)
        plane[0], plane[1], plane[2] = sine * x + to * u, sine * y + to * v, sine * z + to * w
        plane[3], plane[4] = 0.0, SIDE_BLUR
    return 4


@lean_inlined
def _is_left_out(tile: np.ndarray, bar: Rows) -> bool:
    """Return whether a tile has none of the rows in question."""
    return bool(tile[ROW] >= bar.end or tile[ROW] + tile[ROWS] <= bar.first)


@lean_inlined
def _may_pass(lens: TiledRays, place: Vector, radius: float, bar: Rows, sides: Sides) -> bool:
    """Return whether some ray of the rows in question may pass a ball."""
    count, number = _set_ball(place, radius, sides), 0
    while number < lens.tiles.shape[0]:
        tile = lens.tiles[number]
        if _is_left_out(tile, bar) or cuts_of(tile, count, sides) < 0:
            number = int(tile[AFTER])
            continue
        if tile[OWN_RAYS] > 0.0:
            return True
        number += 1
    return False


@lean_inlined
def _offer_tile(
    rays: Cast, lens: TiledRays, tile: np.ndarray, cuts: int, c: np.ndarray, bar: Rows, nearest: float, sides: Sides,
    ends: np.ndarray,
) -> None:  # fmt: skip
    """Test a triangle, at least `nearest` away, against the rays of a tile that may meet it."""
    span, o = sides.span, (rays.origin[0], rays.origin[1], rays.origin[2])
    first, column = int(tile[ROW]), int(tile[COLUMN])
    for row in range(*rows_of(tile, cuts, sides)):
        span_of(tile, row, cuts, sides)
        base = (first + row) * lens.columns + column
        for slot in range(base + span[0], base + span[1]):
            ray = slot if lens.numbers.size == 0 else int(lens.numbers[slot])
            if ray >= 0 and ends[ray] > nearest:
                t, _ = meet(o, ray_direction(rays, ray), c)
                if bar.start < t < ends[ray]:
                    ends[ray] = t


@lean
def _offer(
    rays: Cast, lens: TiledRays, c: np.ndarray, bar: Rows, normals: np.ndarray, sides: Sides, ends: np.ndarray
) -> None:  # fmt: skip
    """Test a triangle of corners (3, 3) against all rays that can hit it; normals (3, 3): work space."""
    middle, radius = ball_around(*bounds_of(c))
    place, number, count = in_sensor_axes(rays, middle), 0, 3
    distance = size_of(place)
    if not _set_edges(view_of(rays, c), normals, sides, distance, radius):
        count = _set_ball(place, radius, sides)
    while number < lens.tiles.shape[0]:
        tile = lens.tiles[number]
        cuts = -1 if _is_left_out(tile, bar) else cuts_of(tile, count, sides)
        if cuts < 0:
            number = int(tile[AFTER])
            continue
        if tile[OWN_RAYS] > 0.0:
            _offer_tile(rays, lens, tile, cuts, c, bar, distance - radius, sides, ends)
        number += 1


@lean
def _offer_tree(
    rays: Cast, lens: TiledRays, bar: Rows, normals: np.ndarray, stack: np.ndarray, sides: Sides, ends: np.ndarray
) -> None:  # fmt: skip
    """Offer all triangles that stop rays, the nearer boxes first; normals (3, 3), stack (128,): work space."""
    tree = bar.tree
    stack[0], waiting = 0, min(1, tree.skip.size)
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        b = tree.bounds[node]
        middle, radius = ball_around((b[0], b[1], b[2]), (b[3], b[4], b[5]))
        if not _may_pass(lens, in_sensor_axes(rays, middle), radius, bar, sides):
            continue
        if tree.leaf[node, 1] == 0:
            near, far = node + 1, tree.skip[node + 1]
            if near2(rays.origin, tree.bounds[far]) < near2(rays.origin, tree.bounds[near]):
                near, far = far, near
            stack[waiting], stack[waiting + 1] = far, near
            waiting += 2
            continue
        for triangle in range(tree.leaf[node, 0], tree.leaf[node, 0] + tree.leaf[node, 1]):
            if bar.stops[tree.number[triangle]]:
                _offer(rays, lens, tree.corners[triangle], bar, normals, sides, ends)


@parallel_kernel
def find_lens_ends(
    rays: Cast,
    lens: TiledRays,
    strip_rows: int,
    tree: Tree,
    stops: np.ndarray,
    start: float,
    workers: int,
    ends: np.ndarray,
) -> None:
    """Write where listed rays, in metres, first meet a solid beyond `start`, to ends (rays,), infinite before. Workers
    take strips of rows, whole tiles, in turn."""
    rows = int(np.max(lens.tiles[:, ROW] + lens.tiles[:, ROWS])) if lens.tiles.shape[0] > 0 else 0
    strip_rows = max(rows, 1) if workers == 1 else strip_rows
    for worker in numba.prange(workers):
        normals, stack, sides = np.empty((3, 3)), np.empty(128, np.int64), new_sides()
        for first in range(worker * strip_rows, rows, workers * strip_rows):
            bar = Rows(tree, stops, start, first, first + strip_rows)
            _offer_tree(rays, lens, bar, normals, stack, sides, ends)


find_lens_ends_serial = serial(find_lens_ends)
