"""Find where the rays of a distorted lens end at a solid, triangle by triangle.

The same as `kernels.body.shadow`, for rays that have no straight rows: the tree is traversed front to back, a box is
skipped where all rays of the tiles that its ball touches are finished, and a triangle is tested against the rays of
tiles between its edges. Rays that hit something inside the empty box are finished.
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
from riglens.core.kernels.body.shadow import Barring, end_at, is_in_whole, near2
from riglens.core.kernels.body.solid import EDGE, Tree
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


class LensEnds(NamedTuple):
    """State of the rays: at (rays,) metres, the first hit outside of the empty box; has_end, is_over (rays,): rays with
    a hit, and finished rays; still (tiles,): unfinished rays of each tile."""

    at: np.ndarray
    has_end: np.ndarray
    is_over: np.ndarray
    still: np.ndarray


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
def _may_be_open(
    lens: TiledRays, place: Vector, radius: float, bar: Barring, sides: Sides, still: np.ndarray
) -> bool:
    """Return whether some ray that may pass a ball is not finished, of the rows in question."""
    count, number = _set_ball(place, radius, sides), 0
    while number < lens.tiles.shape[0]:
        tile = lens.tiles[number]
        if tile[ROW] >= bar.end or tile[ROW] + tile[ROWS] <= bar.first or cuts_of(tile, count, sides) < 0:
            number = int(tile[AFTER])
            continue
        if tile[OWN_RAYS] > 0.0 and still[number] > 0:
            return True
        number += 1
    return False


@lean_inlined
def _meet_ray(rays: Cast, ray: int, c: np.ndarray, bar: Barring, ends: LensEnds) -> bool:
    """Test a triangle against one ray, by the formula; return whether the ray is finished now."""
    t, is_over = end_at(rays, ray_direction(rays, ray), c, bar)
    if not is_over and t < np.inf and (not ends.has_end[ray] or t < ends.at[ray]):
        ends.at[ray], ends.has_end[ray] = t, True
    return is_over


@lean_inlined
def _offer_tile(
    rays: Cast, lens: TiledRays, number: int, cuts: int, c: np.ndarray, bar: Barring, is_in_empty_box: bool,
    nearest: float, sides: Sides, ends: LensEnds,
) -> None:  # fmt: skip
    """Test a triangle, at least `nearest` away, against the rays of a tile that may meet it."""
    tile, span = lens.tiles[number], sides.span
    first, column = int(tile[ROW]), int(tile[COLUMN])
    for row in range(*rows_of(tile, cuts, sides)):
        span_of(tile, row, cuts, sides)
        base = (first + row) * lens.columns + column
        for place in range(span[0], span[1]):
            ray = base + place if lens.numbers.size == 0 else int(lens.numbers[base + place])
            if ray < 0 or ends.is_over[ray] or (ends.has_end[ray] and ends.at[ray] <= nearest):
                continue
            does = is_in_empty_box and span[2] <= place < span[3]
            if does or _meet_ray(rays, ray, c, bar, ends):
                ends.is_over[ray] = True
                ends.still[number] -= 1


@lean
def _offer(
    rays: Cast, lens: TiledRays, c: np.ndarray, bar: Barring, normals: np.ndarray, sides: Sides, ends: LensEnds
) -> None:  # fmt: skip
    """Test a triangle of corners (3, 3) against all rays that can hit it; normals (3, 3): work space."""
    low, high = bounds_of(c)
    middle, radius = ball_around(low, high)
    place = in_sensor_axes(rays, middle)
    nearest, number, count = size_of(place) - radius, 0, 3
    is_in_empty_box = is_in_whole(bar, low, high) and nearest > bar.start
    if not _set_edges(view_of(rays, c), normals, sides, size_of(place), radius):
        count, is_in_empty_box = _set_ball(place, radius, sides), False
    while number < lens.tiles.shape[0]:
        tile = lens.tiles[number]
        if tile[ROW] >= bar.end or tile[ROW] + tile[ROWS] <= bar.first:
            number = int(tile[AFTER])
            continue
        cuts = cuts_of(tile, count, sides)
        if cuts < 0:
            number = int(tile[AFTER])
            continue
        if tile[OWN_RAYS] > 0.0 and ends.still[number] > 0:
            _offer_tile(rays, lens, number, cuts, c, bar, is_in_empty_box, nearest, sides, ends)
        number += 1


@lean
def _offer_tree(
    rays: Cast, lens: TiledRays, bar: Barring, normals: np.ndarray, stack: np.ndarray, sides: Sides, ends: LensEnds
) -> None:  # fmt: skip
    """Offer all triangles that stop rays, the nearer boxes first; normals (3, 3), stack (128,): work space."""
    tree = bar.tree
    stack[0], waiting = 0, min(1, tree.skip.size)
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        b = tree.bounds[node]
        middle, radius = ball_around((b[0], b[1], b[2]), (b[3], b[4], b[5]))
        if not _may_be_open(lens, in_sensor_axes(rays, middle), radius, bar, sides, ends.still):
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
    empty_box: np.ndarray,
    workers: int,
    at: np.ndarray,
    has_end: np.ndarray,
    is_over: np.ndarray,
    still: np.ndarray,
) -> None:
    """Write where listed rays, in metres, first meet a solid beyond `start` (see `LensEnds` and `Barring`); none
    has an end before, and `still` has all rays of each tile. Workers take strips of rows, whole tiles, in turn."""
    rows = int(np.max(lens.tiles[:, ROW] + lens.tiles[:, ROWS])) if lens.tiles.shape[0] > 0 else 0
    strip_rows = rows if workers == 1 else strip_rows
    for worker in numba.prange(workers):
        normals, stack, sides = np.empty((3, 3)), np.empty(128, np.int64), new_sides()
        for first in range(worker * strip_rows, rows, workers * strip_rows):
            bar = Barring(tree, stops, start, empty_box, first, first + strip_rows)
            _offer_tree(rays, lens, bar, normals, stack, sides, LensEnds(at, has_end, is_over, still))


find_lens_ends_serial = serial(find_lens_ends)
