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

import numpy as np

from riglens.core.kernels.beams.cones import A_TURN
from riglens.core.kernels.body.face import (
    DOUBT,
    Face,
    ball_around,
    between,
    bounds_of,
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
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined


class Ends(NamedTuple):
    """State of the rays, by row and column: at (rows, columns) metres, the first hit outside of the empty box of a ray
    with one; has_end, is_over uint64 (rows, words): a bit for each ray with a hit, and for each finished ray."""

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
def is_in_whole(bar: Barring, low: Vector, high: Vector) -> bool:
    """Return whether a box of these corners is in the empty box."""
    return is_in(bar.empty_box, low) and is_in(bar.empty_box, high)


@lean_inlined
def verdict_of(products: Vector, doubt: float, is_in_empty_box: bool) -> int:
    """Return -1 where a ray certainly misses a triangle, 1 where it certainly hits it in the empty box, else 0;
    products: u, v and 1 of the barycentric coordinates of the ray, but for a factor."""
    u, v, w = products
    if w < 0.0:
        u, v, w = -u, -v, -w
    if w <= doubt:
        return 0
    room = doubt + 2.0 * EDGE * w
    if min(u, v) < -room or u + v > w + room:
        return -1
    return 1 if is_in_empty_box and min(u, v) > doubt and w - u - v > doubt else 0


@lean_inlined
def end_at(rays: Cast, d: Vector, c: np.ndarray, bar: Barring) -> tuple[float, bool]:
    """Return where a ray of direction d ends at a triangle, by the formula, inf: nowhere; and whether that is in the
    empty box."""
    o = (rays.origin[0], rays.origin[1], rays.origin[2])
    t, _ = meet(o, d, c)
    if not bar.start < t < np.inf:
        return np.inf, False
    return t, is_in(bar.empty_box, (o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]))


@lean_inlined
def _meet_ray(
    rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, column: int, ends: Ends
) -> None:
    """Test a face against one ray, by the formula."""
    d = rotated(rays.rotation, _local(rays, screen, row, column))
    t, is_over = end_at(rays, d, face.corners, bar)
    if is_over:
        set_all(ends.is_over[row], column, column + 1)
    elif t < np.inf and (not has_all(ends.has_end[row], column, column + 1) or t < ends.at[row, column]):
        ends.at[row, column] = t
        set_all(ends.has_end[row], column, column + 1)


@lean_inlined
def _local(rays: Cast, screen: Screen, row: int, column: int) -> Vector:
    """Return the direction of a ray in the frame of the sensor."""
    line, number = screen.row_of[row], screen.column_of[column]
    if rays.kind == LISTED:
        return direction(LISTED, rays.rows[line * screen.column_of.size + number], rays.planes[0])
    return direction(rays.kind, rays.rows[line], rays.planes[number])


@lean_inlined
def _products(rays: Cast, screen: Screen, face: Face, row: int, column: int) -> Vector:
    """Return u, v and 1 of the barycentric coordinates of a ray, up to a factor."""
    if screen.is_camera:  # on the image plane, not a unit vector
        local = 1.0, rays.planes[screen.column_of[column], 0], rays.rows[screen.row_of[row], 0]
        return rotated(face.normals, local)
    return rotated(face.normals, _local(rays, screen, row, column))


@lean_inlined
def _offer_each(
    rays: Cast, screen: Screen, face: Face, bar: Barring, row: int, first: int, end: int, ends: Ends
) -> None:
    """Test a face against the rays of some columns of a row, one by one."""
    for column in range(max(first, bar.first), min(end, bar.end)):
        if has_all(ends.is_over[row], column, column + 1):
            continue
        products = _products(rays, screen, face, row, column)
        verdict = verdict_of(products, face.doubt, face.is_in_empty_box)
        if verdict > 0:
            set_all(ends.is_over[row], column, column + 1)
        elif verdict == 0:
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
    low, high = bounds_of(c)
    middle, radius = ball_around(low, high)
    place = in_sensor_axes(rays, middle)
    view = view_of(rays, c)
    window = window_around(screen, view, (place, radius))
    row = _next_open(screen, window, bar, ends.is_over, window.first)
    if row >= window.end:
        return
    is_in_empty_box = is_in_whole(bar, low, high) and size_of(place) - radius > bar.start
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


@kernel
def find_ends(
    rays: Cast,
    screen: Screen,
    tree: Tree,
    stops: np.ndarray,
    start: float,
    empty_box: np.ndarray,
    share: int,
    shares: int,
    at: np.ndarray,
    has_end: np.ndarray,
    is_over: np.ndarray,
) -> None:
    """Write where the rays of a lattice, in metres, first meet a solid beyond `start` (see `Ends` and `Barring`); no
    bits before. Shares are strips of columns, a whole number of words each."""
    columns = screen.column_of.size
    words = (columns + 63) // 64
    strips = min(words, 1 if shares == 1 else 4 * shares)
    work, stack = np.empty((2, 3, 3)), np.empty(128, np.int64)
    for strip in range(share, strips, shares):
        first, end = 64 * (words * strip // strips), min(64 * (words * (strip + 1) // strips), columns)
        bar = Barring(tree, stops, start, empty_box, first, end)
        _offer_tree(rays, screen, bar, work, stack, Ends(at, has_end, is_over))
