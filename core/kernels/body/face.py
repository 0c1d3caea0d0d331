"""A triangle as the rays of a sensor see it: three products that say whether one passes, and where on a row it may.

The products of a direction with three normals are u, v and 1 of the barycentric coordinates of the ray, but for a
factor. Along a row of a camera they are linear in the place on the image. Along a row of a LiDAR, a cone, they are
linear in (x, y, z) = (1, y, h sqrt(1 + y²)) on the line x = 1 turned towards the triangle, but for the root, which is
between 1 and its largest value there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.beams.cones import A_TURN
from riglens.core.kernels.body.screen import (
    BEARING,
    BLUR,
    Screen,
    Window,
    angle_on_line,
    bearing,
    before,
    in_sensor_axes,
    upto,
    window_of,
)
from riglens.core.kernels.body.solid import GROWN
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.lattice import rotated_back
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.jit import lean_inlined

DOUBT = 1e-11
"""Share of the largest possible product of a ray with the edges of a triangle beyond which its sign is certain: a
thousand times its rounding."""
WIDEST = 0.85
"""Sine of the half angle beyond which a ball is too wide in a LiDAR's view to be projected to a line."""

EDGE_ON = 1e-3
"""Below this angle between ray and triangle (about its sine), rounding may move a hit farther sideways."""
BESIDE = 1e-4
"""Share of its size by which a triangle may be hit beyond its corners, far more than EDGE and rounding."""


class View(NamedTuple):
    """A triangle in the frame of the sensor: its first corner, and the ways from there to the others, metres."""

    corner: Vector
    one: Vector
    two: Vector


class Sides(NamedTuple):
    """Bounds of a triangle on the line x = 1: places (1, y, z), y from left to right, z from low to high; left > right
    where they are unknown."""

    left: float
    right: float
    low: float
    high: float


class Face(NamedTuple):
    """A triangle as it is seen from one place: corners (3, 3); normals (3, 3) in the frame of the sensor, whose
    products with a direction are u, v and 1 of its barycentric coordinates, but for a factor; edges (3, 3): of u, v and
    1 - u - v, positive inside, in that frame turned towards it by `azimuth`; doubt: below which products are not
    certain; is_in_empty_box: whether all of it is in the empty box and beyond the start; has_edges: whether the edges
    are known; side, steepest: how far on the line x = 1 it reaches, and the length of the longest (1, y) there."""

    corners: np.ndarray
    normals: np.ndarray
    edges: np.ndarray
    doubt: float
    is_in_empty_box: bool
    has_edges: bool
    azimuth: float
    side: float
    steepest: float


@lean_inlined
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lean_inlined
def size_of(a: Vector) -> float:
    """Return the length of a vector."""
    return float(np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]))


@lean_inlined
def bounds_of(c: np.ndarray) -> tuple[Vector, Vector]:
    """Return the low and the high corner of the box around a triangle of corners (3, 3)."""
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
    return low, high


@lean_inlined
def ball_around(low: Vector, high: Vector) -> tuple[Vector, float]:
    """Return the middle and radius of the ball around a box, a little larger."""
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    across = size_of((high[0] - low[0], high[1] - low[1], high[2] - low[2]))
    return middle, 0.5 * across * (1.0 + BLUR) + 3.0 * GROWN


@lean_inlined
def view_of(rays: Cast, c: np.ndarray) -> View:
    """Return the view of a triangle of corners (3, 3) in the frame of the sensor."""
    r, g = rays.rotation, rays.origin
    return View(
        rotated_back(r, (c[0, 0] - g[0], c[0, 1] - g[1], c[0, 2] - g[2])),
        rotated_back(r, (c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2])),
        rotated_back(r, (c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2])),
    )


@lean_inlined
def _largest(view: View) -> float:
    """Return the largest size that a product of the normals of a triangle with a unit vector may have."""
    one, two = size_of(view.one), size_of(view.two)
    return (size_of(view.corner) + one + two) * (one + two)


@lean_inlined
def _corners_on_line(view: View, cosine: float, sine: float) -> tuple[Sides, float]:
    """Return the span of a triangle's corners on the line x = 1 turned towards it, and the distance ahead of the
    nearest one."""
    left, right, low, high, nearest = np.inf, -np.inf, np.inf, -np.inf, np.inf
    for one, two in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
        x = view.corner[0] + one * view.one[0] + two * view.two[0]
        y = view.corner[1] + one * view.one[1] + two * view.two[1]
        z = view.corner[2] + one * view.one[2] + two * view.two[2]
        ahead = cosine * x + sine * y
        side, height = (cosine * y - sine * x) / ahead, z / ahead
        left, right = min(left, side), max(right, side)
        low, high, nearest = min(low, height), max(high, height), min(nearest, ahead)
    return Sides(left, right, low, high), nearest


@lean_inlined
def sides_of(view: View, radius: float, ahead: float, cosine: float, sine: float) -> Sides:
    """Return the span in which a triangle in a ball at a distance is met on the line x = 1 turned towards it; left >
    right where it is so near, or so nearly edge on, that rounding could move a hit outside of it."""
    normal, corner = _cross(view.two, view.one), view.corner
    over = normal[0] * corner[0] + normal[1] * corner[1] + normal[2] * corner[2]
    if radius >= WIDEST * ahead or abs(over) < EDGE_ON * _largest(view) * (size_of(corner) + radius):
        return Sides(1.0, 0.0, 1.0, 0.0)
    (left, right, low, high), nearest = _corners_on_line(view, cosine, sine)
    room = BESIDE * radius / nearest * (1.0 + max(max(-left, right), max(-low, high)))
    return Sides(left - room, right + room, low - room, high + room)


@lean_inlined
def window_around(screen: Screen, view: View, ball: tuple[Vector, float]) -> Window:
    """Return the rays that can hit a triangle in a ball: those between its corners, or, where these do not bound it,
    those that pass the ball."""
    (x, y, _), radius = ball
    cosine, sine, ahead = 1.0, 0.0, x
    if not screen.is_camera:
        ahead = np.sqrt(x * x + y * y)
        cosine, sine = x / ahead, y / ahead
    sides = sides_of(view, radius, ahead, cosine, sine)
    if sides.left > sides.right:
        return window_of(screen, ball[0], radius)
    return _window_between(screen, sides, (x, y), radius, ahead)


@lean_inlined
def _window_between(
    screen: Screen, sides: Sides, place: tuple[float, float], radius: float, ahead: float
) -> Window:
    """Return the window between some sides on the line x = 1 turned towards a place, of things in a ball at a
    distance."""
    left, right, low, high = sides
    if screen.is_camera:
        first = before(screen.rows, screen.row_scale, -high)
        return Window(first, upto(screen.rows, screen.row_scale, -low), -right, right - left)
    steepest = ahead / np.sqrt(ahead * ahead - radius * radius)
    low, high = min(low, low / steepest), max(high, high / steepest)
    first = before(screen.rows, screen.row_scale, low / np.sqrt(1.0 + low * low) - BLUR)
    end = upto(screen.rows, screen.row_scale, high / np.sqrt(1.0 + high * high) + BLUR)
    azimuth = bearing(place[0], place[1])
    left, right = (
        azimuth + angle_on_line(left) - 3.0 * BEARING,
        azimuth + angle_on_line(right) + 3.0 * BEARING,
    )
    back = np.floor(left / A_TURN) * A_TURN
    return Window(first, end, left - back, right - left)


@lean_inlined
def sides_of_box(rays: Cast, bounds: np.ndarray, middle: Vector, cosine: float, sine: float) -> Sides:
    """Return the bounds of a box of low and high corner (6,) on the line x = 1 turned towards its middle, in the frame
    of the sensor; all its corners are ahead."""
    left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
    for k in range(8):
        dx = (0.5 if k & 1 else -0.5) * (bounds[3] - bounds[0])
        dy = (0.5 if k & 2 else -0.5) * (bounds[4] - bounds[1])
        dz = (0.5 if k & 4 else -0.5) * (bounds[5] - bounds[2])
        x, y, z = rotated_back(rays.rotation, (dx, dy, dz))
        x, y = middle[0] + x, middle[1] + y
        pace = 1.0 / (cosine * x + sine * y)
        side, height = (cosine * y - sine * x) * pace, (middle[2] + z) * pace
        left, right = min(left, side), max(right, side)
        low, high = min(low, height), max(high, height)
    room = BLUR * (1.0 + max(max(-left, right), max(-low, high)))
    return Sides(left - room, right + room, low - room, high + room)


@lean_inlined
def window_of_box(rays: Cast, screen: Screen, bounds: np.ndarray) -> Window:
    """Return the rays that can pass a box of low and high corner (6,): those between its corners, or, where it is too
    near for these to bound it, those that pass the ball around it."""
    middle, radius = ball_around((bounds[0], bounds[1], bounds[2]), (bounds[3], bounds[4], bounds[5]))
    x, y, z = in_sensor_axes(rays, middle)
    cosine, sine, ahead = 1.0, 0.0, x
    if not screen.is_camera:
        ahead = np.sqrt(x * x + y * y)
        cosine, sine = x / ahead, y / ahead
    if radius >= WIDEST * ahead:
        return window_of(screen, (x, y, z), radius)
    sides = sides_of_box(rays, bounds, (x, y, z), cosine, sine)
    return _window_between(screen, sides, (x, y), radius, ahead)


@lean_inlined
def set_normals(view: View, normals: np.ndarray) -> float:
    """Write the normals of a triangle; returns the largest size that their products with a unit vector may have."""
    corner, one, two = view.corner, view.one, view.two
    back = (-corner[0], -corner[1], -corner[2])
    for number, n in enumerate((_cross(two, back), _cross(back, one), _cross(two, one))):
        for axis in range(3):
            normals[number, axis] = n[axis]
    return _largest(view)


@lean_inlined
def _set_edges(normals: np.ndarray, sign: float, cosine: float, sine: float, edges: np.ndarray) -> None:
    """Write the edges of a triangle that belong to its normals, in axes turned about z."""
    for axis in range(3):
        edges[0, axis], edges[1, axis] = sign * normals[0, axis], sign * normals[1, axis]
        edges[2, axis] = sign * (normals[2, axis] - normals[0, axis] - normals[1, axis])
    for k in range(3):
        x, y = edges[k, 0], edges[k, 1]
        edges[k, 0], edges[k, 1] = cosine * x + sine * y, cosine * y - sine * x


@lean_inlined
def face_of(
    screen: Screen,
    view: View,
    c: np.ndarray,
    ball: tuple[Vector, float],
    is_in_empty_box: bool,
    work: np.ndarray,
) -> Face:
    """Return the face of a triangle of corners (3, 3) in the ball around it, in the frame of the sensor; work (2, 3,
    3)."""
    (x, y, z), radius = ball
    normals, edges = work[0], work[1]
    doubt = DOUBT * screen.longest * set_normals(view, normals)
    corner = view.corner
    over = normals[2, 0] * corner[0] + normals[2, 1] * corner[1] + normals[2, 2] * corner[2]
    distance = size_of((x, y, z))
    has_edges = distance > radius and abs(over) > doubt * (distance + radius)
    azimuth, side, steepest, cosine, sine = 0.0, 1e9, 1.0, 1.0, 0.0
    if not screen.is_camera:
        flat = np.sqrt(x * x + y * y)
        if radius >= WIDEST * flat:
            return Face(c, normals, edges, doubt, is_in_empty_box, False, 0.0, 0.0, 0.0)
        cosine, sine = x / flat, y / flat
        steepest = flat / np.sqrt(flat * flat - radius * radius)
        azimuth, side = bearing(x, y), radius / flat * steepest
    _set_edges(normals, 1.0 if over > 0.0 else -1.0, cosine, sine, edges)
    return Face(c, normals, edges, doubt, is_in_empty_box, has_edges, azimuth, side, steepest)


@lean_inlined
def between(
    face: Face, height: float, room: float, is_outer: bool, low: float, high: float
) -> tuple[float, float]:
    """Return the part of low..high on the line x = 1 in which rays of a row may be between the edges of a face, or
    where not `is_outer` the part in which they are for certain; room: of the edges (empty: from > to)."""
    for k in range(3):
        a = face.edges[k, 2] * height
        b = a * face.steepest
        rest = face.edges[k, 0] + (max(a, b) + room if is_outer else min(a, b) - room)
        slope = face.edges[k, 1]
        if slope > 0.0:
            low = max(low, -rest / slope)
        elif slope < 0.0:
            high = min(high, -rest / slope)
        elif rest < 0.0:
            low, high = 1.0, 0.0
    return low, high
