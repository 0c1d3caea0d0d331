"""Find where the rays of a distorted lens end at a solid, triangle by triangle.

The same as `kernels.body.shadow`, for rays that have no straight rows: for each tile of rays the tree is traversed
front to back, a box is skipped where none of them can pass the ball around it or all end nearer, and a triangle is
tested against the rays between its edges.
"""

from __future__ import annotations

from typing import NamedTuple

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
    AXIS,
    COLUMN,
    COLUMNS,
    COSINE,
    OWN_RAYS,
    ROW,
    ROWS,
    SIDE_BLUR,
    SINE,
    Sides,
    TiledRays,
    cuts_of,
    new_sides,
    rows_of,
    set_spans,
)
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

_AROUND = 0.999
"""Sine of the half angle of a cone around a ball beyond which it may be anywhere."""
_NEARER = 1.0 - 1e-9
"""Far more than the rounding of squared distances."""


class Bar(NamedTuple):
    """Obstacles of rays: triangles in a tree, a selection of them (t,), and the distance from which they count."""

    tree: Tree
    stops: np.ndarray
    start: float


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
def _is_beside(tile: np.ndarray, place: Vector, radius: float) -> bool:
    """Return whether a ball at a place in the sensor's axes lies outside the cone around the rays of a tile."""
    if tile[COSINE] < 0.0:
        return False
    x, y, z = place
    along, square = (
        x * tile[AXIS] + y * tile[AXIS + 1] + z * tile[AXIS + 2],
        tile[COSINE] ** 2 + tile[SINE] ** 2,
    )
    aside = np.sqrt(max((x * x + y * y + z * z) * square - along * along, 0.0))
    return bool(aside * tile[COSINE] - along * tile[SINE] > radius * square)


@lean_inlined
def _offer(
    rays: Cast, lens: TiledRays, number: int, c: np.ndarray, bar: Bar, normals: np.ndarray, sides: Sides,
    ends: np.ndarray,
) -> None:  # fmt: skip
    """Test a triangle of corners (3, 3) against the rays of a tile that may meet it; normals (3, 3): work space."""
    low, high = bounds_of(c)
    middle, radius = ball_around(low, high)
    place, tile = in_sensor_axes(rays, middle), lens.tiles[number]
    if _is_beside(tile, place, radius):
        return
    nearest, count = size_of(place) - radius, 3
    if not _set_edges(view_of(rays, c), normals, sides, nearest + radius, radius):
        count = _set_ball(place, radius, sides)
    cuts = cuts_of(tile, count, sides)
    if cuts < 0:
        return
    o = rays.origin[0], rays.origin[1], rays.origin[2]
    first, column = int(tile[ROW]), int(tile[COLUMN])
    rows, span = rows_of(tile, cuts, sides), sides.span
    set_spans(tile, rows, cuts, sides)
    for row in range(*rows):
        base = (first + row) * lens.columns + column
        for slot in range(base + int(span[0, row]), base + int(span[1, row])):
            ray = slot if lens.numbers.size == 0 else int(lens.numbers[slot])
            if ray < 0 or ends[ray] <= nearest:
                continue
            t, _ = meet(o, ray_direction(rays, ray), c)
            if bar.start < t < ends[ray]:
                ends[ray] = t


@lean_inlined
def _farthest(lens: TiledRays, number: int, ends: np.ndarray) -> float:
    """Return where the last ray of a tile ends, inf where one has no end."""
    tile, most = lens.tiles[number], 0.0
    for row in range(int(tile[ROW]), int(tile[ROW] + tile[ROWS])):
        base = row * lens.columns + int(tile[COLUMN])
        for slot in range(base, base + int(tile[COLUMNS])):
            ray = slot if lens.numbers.size == 0 else int(lens.numbers[slot])
            if ray >= 0:
                most = max(most, ends[ray])
        if most == np.inf:
            break
    return most


@lean
def _end_tile(
    rays: Cast, lens: TiledRays, number: int, bar: Bar, normals: np.ndarray, stack: np.ndarray, sides: Sides,
    ends: np.ndarray,
) -> None:  # fmt: skip
    """Offer the rays of a tile all triangles that may stop them, the nearer boxes first, up to the farthest end;
    normals (3, 3), stack (128,): work space."""
    tree, farthest = bar.tree, np.inf
    stack[0], waiting = 0, min(1, tree.skip.size)
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        b = tree.bounds[node]
        if near2(rays.origin, b) * _NEARER > farthest * farthest:
            continue
        middle, radius = ball_around((b[0], b[1], b[2]), (b[3], b[4], b[5]))
        tile, place = lens.tiles[number], in_sensor_axes(rays, middle)
        if _is_beside(tile, place, radius) or cuts_of(tile, _set_ball(place, radius, sides), sides) < 0:
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
                _offer(rays, lens, number, tree.corners[triangle], bar, normals, sides, ends)
        farthest = _farthest(lens, number, ends)


@kernel
def find_lens_ends(
    rays: Cast, lens: TiledRays, tree: Tree, stops: np.ndarray, start: float, share: int, shares: int, ends: np.ndarray
) -> None:  # fmt: skip
    """Write where listed rays, in metres, first meet a solid beyond `start`, to ends (rays,), infinite before. Shares
    take tiles in turn."""
    normals, stack, sides = np.empty((3, 3)), np.empty(128, np.int64), new_sides()
    bar = Bar(tree, stops, start)
    for number in range(share, lens.tiles.shape[0], shares):
        if lens.tiles[number, OWN_RAYS] > 0.0:
            _end_tile(rays, lens, number, bar, normals, stack, sides, ends)
