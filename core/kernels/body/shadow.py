"""Find where the rays of a lattice end at a solid; each triangle is tested against the few rays that can meet it.

The tree of boxes is traversed front to back; a box is skipped where no ray can pass the ball around it, or where every
such ray is finished. A triangle is offered row by row to the columns between its edges, which are linear on the line x
= 1 turned towards it; rounding, and the curve of a LiDAR's row, only make them more. Three products without a division
say of most of these rays for certain that they miss it, or that they meet it; where they cannot tell, or where the
distance counts, the formula of `kernels.body.solid` does. So the ends are the very doubles of a search over all
triangles.

Rays that meet something inside of the *empty box*, a convex place around the sensor in which nothing counts, are over:
it makes no difference where in the empty box they end.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.beams.cones import A_TURN
from riglens.core.kernels.body.face import (
    DOUBT,
    Face,
    ball_around,
    between,
    face_of,
    size_of,
    view_of,
    window_around,
    window_of_box,
)
from riglens.core.kernels.body.screen import (
    BEARING,
    BLUR,
    Screen,
    Window,
    angle_on_line,
    before,
    columns_of,
    has_all,
    in_sensor_axes,
    set_all,
    upto,
)
from riglens.core.kernels.body.solid import EDGE, Tree, meet
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.lattice import direction, rotated
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.codes import LISTED
from riglens.core.kernels.runtime.jit import lean, lean_inlined, parallel_kernel, serial


class Ends(NamedTuple):
    """State of the rays, by row and column: at (rows, columns) metres, the first hit outside of the empty box; has_end,
    is_over uint64 (rows, words): a bit for each ray with a hit, and for each finished ray."""

    at: np.ndarray
    has_end: np.ndarray
    is_over: np.ndarray


class Barring(NamedTuple):
    """Obstacles of rays: triangles in a tree, a selection of them (t,), the distance from which they count, and the
    empty_box (6,): low and high corner in metres, low > high where there is none; first and end of the columns in
    question."""

    tree: Tree
    stops: np.ndarray
    start: float
    empty_box: np.ndarray
    first: int
    end: int


@lean_inlined
def is_in(empty_box: np.ndarray, p: Vector) -> bool:
    """Return whether a place is in the empty box."""
    inside = (empty_box[0] <= p[0] <= empty_box[3]) and (empty_box[1] <= p[1] <= empty_box[4])
    return bool(inside and (empty_box[2] <= p[2] <= empty_box[5]))


@lean_inlined
def _meet_ray(
    rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, column: int, ends: Ends
) -> None:
    """Test a face against one ray, by the formula."""
    line, number = screen.row_of[row], screen.column_of[column]
    if rays.kind == LISTED:
        local = direction(LISTED, rays.rows[line * screen.column_of.size + number], rays.planes[0])
    else:
        local = direction(rays.kind, rays.rows[line], rays.planes[number])
    o, d = (rays.origin[0], rays.origin[1], rays.origin[2]), rotated(rays.rotation, local)
    t, _ = meet(o, d, face.corners)
    if not bar.start < t < np.inf:
        return
    if is_in(bar.empty_box, (o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2])):
        set_all(ends.is_over[row], column, column + 1)
    elif not has_all(ends.has_end[row], column, column + 1) or t < ends.at[row, column]:
        ends.at[row, column] = t
        set_all(ends.has_end[row], column, column + 1)


@lean_inlined
def _products(rays: Cast, screen: Screen, face: Face, row: int, column: int) -> Vector:
    """Return u, v and 1 of the barycentric coordinates of a ray, up to a factor."""
    n, line, number = face.normals, screen.row_of[row], screen.column_of[column]
    if screen.is_camera:
        x, y, z = 1.0, rays.planes[number, 0], rays.rows[line, 0]
    elif rays.kind == LISTED:
        x, y, z = direction(LISTED, rays.rows[line * screen.column_of.size + number], rays.planes[0])
    else:
        x, y, z = direction(rays.kind, rays.rows[line], rays.planes[number])
    return (
        n[0, 0] * x + n[0, 1] * y + n[0, 2] * z,
        n[1, 0] * x + n[1, 1] * y + n[1, 2] * z,
        n[2, 0] * x + n[2, 1] * y + n[2, 2] * z,
    )


@lean_inlined
def _offer_each(
    rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, first: int, end: int, ends: Ends
) -> None:
    """Test a face against the rays of some columns of a row, one by one."""
    for column in range(max(first, bar.first), min(end, bar.end)):
        if has_all(ends.is_over[row], column, column + 1):
            continue
        u, v, w = _products(rays, screen, face, row, column)
        if w < 0.0:
            u, v, w = -u, -v, -w
        if w > face.doubt:
            room = face.doubt + 2.0 * EDGE * w
            if min(u, v) < -room or u + v > w + room:
                continue
            if face.is_in_empty_box and min(u, v) > face.doubt and w - u - v > face.doubt:
                set_all(ends.is_over[row], column, column + 1)
                continue
        _meet_ray(rays, screen, face, bar, row, column, ends)


@lean_inlined
def _offer_columns(
    rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, outer: tuple[int, int], inner: tuple[int, int],
    ends: Ends,
) -> None:  # fmt: skip
    """Test a face against the columns `outer` of a row; the rays of the columns `inner` certainly hit it."""
    first, end = max(inner[0], max(outer[0], bar.first)), min(inner[1], min(outer[1], bar.end))
    if first >= end:
        _offer_each(rays, screen, face, bar, row, outer[0], outer[1], ends)
        return
    set_all(ends.is_over[row], first, end)
    _offer_each(rays, screen, face, bar, row, outer[0], first, ends)
    _offer_each(rays, screen, face, bar, row, end, outer[1], ends)


@lean_inlined
def _azimuth(screen: Screen, face: Face, row: int, y: float) -> float:
    """Return the azimuth of a place on the line x = 1 as the columns of a row count it, within 2 BEARING and up to
    whole turns."""
    return face.azimuth + angle_on_line(y) - (screen.shift[row] if screen.shift.size > 0 else 0.0)


@lean_inlined
def _offer_row(rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, ends: Ends) -> None:
    """Test a face against the rays of a row that may pass between its edges."""
    height = screen.heights[row]
    room = face.doubt * (1.0 if screen.is_camera else np.sqrt(1.0 + height * height) * face.steepest)
    low, high = between(face, height, 3.0 * EDGE / DOUBT * room, True, -face.side, face.side)
    if low > high:
        return
    finder, scale, back = screen.columns, screen.column_scale, 0.0
    if screen.is_camera:
        left, right = -high - BLUR * (1.0 + abs(high)), -low + BLUR * (1.0 + abs(low))
    else:
        left = _azimuth(screen, face, row, low) - 3.0 * BEARING
        right = _azimuth(screen, face, row, high) + 3.0 * BEARING
        back = np.floor(left / A_TURN) * A_TURN
        left, right = left - back, right - back
    outer = (before(finder, scale, left), upto(finder, scale, right))
    is_one = screen.is_camera or right <= A_TURN
    if is_one and has_all(ends.is_over[row], max(outer[0], bar.first), min(outer[1], bar.end)):
        return
    low_in, high_in = 1.0, 0.0
    if face.is_in_empty_box:
        low_in, high_in = between(face, height, 2.0 * room, False, low, high)
    if screen.is_camera:
        inner = (0, 0)
        if low_in < high_in:
            inner = (upto(finder, scale, -high_in), before(finder, scale, -low_in))
        _offer_columns(rays, screen, face, bar, row, outer, inner, ends)
        return
    left_in, right_in = 1.0, 0.0
    if low_in < high_in:
        left_in = _azimuth(screen, face, row, low_in) + 3.0 * BEARING - back
        right_in = _azimuth(screen, face, row, high_in) - 3.0 * BEARING - back
    _offer_turn(rays, screen, face, bar, row, (left, right, left_in, right_in), ends)


@lean_inlined
def _offer_turn(
    rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, turn: tuple[float, float, float, float], ends: Ends
) -> None:  # fmt: skip
    """Offer a face to the azimuths turn[0]..turn[1] of a row, the first within a turn, of which those between turn[2]
    and turn[3] are over."""
    finder, scale, back = screen.columns, screen.column_scale, 0.0
    while turn[1] - back >= 0.0:
        left, right, left_in, right_in = turn[0] - back, turn[1] - back, turn[2] - back, turn[3] - back
        inner = (0, 0)
        if left_in < right_in:
            inner = (upto(finder, scale, left_in), before(finder, scale, right_in))
        outer = (before(finder, scale, left), upto(finder, scale, right))
        _offer_columns(rays, screen, face, bar, row, outer, inner, ends)
        back += A_TURN


@lean_inlined
def _next_open(screen: Screen, window: Window, bar: Barring, is_over: np.ndarray, row: int) -> int:
    """Return the first row of a window from `row` on with a ray in it that is not over, else its last row's next."""
    while row < window.end:
        start, end, again = columns_of(screen, window, row)
        if not has_all(is_over[row], max(start, bar.first), min(end, bar.end)):
            return row
        if not has_all(is_over[row], bar.first, min(again, bar.end)):
            return row
        row += 1
    return row


@lean
def _offer(rays: Cast, screen: Screen, c: np.ndarray, bar: Barring, work: np.ndarray, ends: Ends) -> None:
    """Test a triangle against all rays that can hit it."""
    low = (
        min(c[0, 0], min(c[1, 0], c[2, 0])),
        min(c[0, 1], min(c[1, 1], c[2, 1])),
        min(c[0, 2], min(c[1, 2], c[2, 2])),
    )
    high = (
        max(c[0, 0], max(c[1, 0], c[2, 0])),
        max(c[0, 1], max(c[1, 1], c[2, 1])),
        max(c[0, 2], max(c[1, 2], c[2, 2])),
    )
    middle, radius = ball_around(low, high)
    place = in_sensor_axes(rays, middle)
    view = view_of(rays, c)
    window = window_around(screen, view, (place, radius))
    row = _next_open(screen, window, bar, ends.is_over, window.first)
    if row >= window.end:
        return
    is_in_empty_box = (
        is_in(bar.empty_box, low) and is_in(bar.empty_box, high) and size_of(place) - radius > bar.start
    )
    face = face_of(screen, view, c, (place, radius), is_in_empty_box, work)
    while row < window.end:
        if face.has_edges:
            _offer_row(rays, screen, face, bar, row, ends)
        else:
            start, end, again = columns_of(screen, window, row)
            _offer_each(rays, screen, face, bar, row, start, end, ends)
            _offer_each(rays, screen, face, bar, row, 0, again, ends)
        row = _next_open(screen, window, bar, ends.is_over, row + 1)


@lean_inlined
def near2(o: np.ndarray, bounds: np.ndarray) -> float:
    """Return the squared distance of a box from a place."""
    total = 0.0
    for axis in range(3):
        beside = max(max(bounds[axis] - o[axis], o[axis] - bounds[3 + axis]), 0.0)
        total += beside * beside
    return total


@lean
def _offer_tree(
    rays: Cast, screen: Screen, bar: Barring, work: np.ndarray, stack: np.ndarray, ends: Ends
) -> None:
    """Offer all triangles that stop rays, the nearer boxes first; work (2, 3, 3), stack (128,)."""
    tree = bar.tree
    stack[0], waiting = 0, min(1, tree.skip.size)
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        window = window_of_box(rays, screen, tree.bounds[node])
        if _next_open(screen, window, bar, ends.is_over, window.first) >= window.end:
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
                _offer(rays, screen, tree.corners[triangle], bar, work, ends)


@parallel_kernel
def find_ends(
    rays: Cast,
    screen: Screen,
    tree: Tree,
    stops: np.ndarray,
    start: float,
    empty_box: np.ndarray,
    workers: int,
    at: np.ndarray,
    has_end: np.ndarray,
    is_over: np.ndarray,
) -> None:
    """Write where the rays of a lattice, in metres, first meet a solid beyond `start` (see `Ends` and `Barring`); all
    zeros before. Workers share strips of columns, a whole number of words each."""
    columns = screen.column_of.size
    words = (columns + 63) // 64
    strips = min(words, 1 if workers == 1 else 4 * workers)
    for worker in numba.prange(workers):
        for strip in range(worker, strips, workers):
            first, end = 64 * (words * strip // strips), min(64 * (words * (strip + 1) // strips), columns)
            bar = Barring(tree, stops, start, empty_box, first, end)
            work, stack = np.empty((2, 3, 3)), np.empty(128, np.int64)
            _offer_tree(rays, screen, bar, work, stack, Ends(at, has_end, is_over))


find_ends_serial = serial(find_ends)
