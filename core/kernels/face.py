"""A triangle as the rays of a sensor see it: three products that say whether one passes, and where on a row it may.

The products of a direction with three normals are u, v and 1 of the barycentric coordinates of the ray, but for a
factor. Along a row of a camera they are linear in the place on the image. Along a row of a LiDAR, a cone, they are
linear in (x, y, z) = (1, y, h sqrt(1 + y²)) on the line x = 1 turned towards the triangle, but for the root, which is
between 1 and its largest value there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.cast import Cast
from riglens.core.kernels.jit import lean_inlined
from riglens.core.kernels.predicates import Vector
from riglens.core.kernels.screen import BLUR, Screen, bearing, in_sensor_axes
from riglens.core.kernels.solid import GROWN

DOUBT = 1e-11
"""Products of a ray with the edges of a triangle are certain beyond this share of their largest possible size, which
is a thousand times more than their rounding."""
WIDEST = 0.85
"""Balls that take more than this (a sine) of a LiDAR's view have no line that they could be laid on."""


class Face(NamedTuple):
    """A triangle as it is seen from one place: corners (3, 3); normals (3, 3) in the frame of the sensor, whose
    products with a direction are u, v and 1 of its barycentric coordinates, but for a factor; edges (3, 3): of u, v and
    1 - u - v, positive inside, in that frame turned towards it by `azimuth`; doubt: below which products are not
    certain; is_void: whether all of it is in the void and beyond the start; has_edges: whether the edges are known;
    side, steepest: how far on the line x = 1 it reaches, and the length of the longest (1, y) there."""

    corners: np.ndarray
    normals: np.ndarray
    edges: np.ndarray
    doubt: float
    is_void: bool
    has_edges: bool
    azimuth: float
    side: float
    steepest: float


@lean_inlined
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lean_inlined
def size_of(a: Vector) -> float:
    """Length of a vector."""
    return float(np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]))


@lean_inlined
def ball_around(low: Vector, high: Vector) -> tuple[Vector, float]:
    """Middle and radius of the ball around a box, a little larger."""
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    across = size_of((high[0] - low[0], high[1] - low[1], high[2] - low[2]))
    return middle, 0.5 * across * (1.0 + BLUR) + 3.0 * GROWN


@lean_inlined
def _corner(c: np.ndarray, number: int) -> Vector:
    return c[number, 0], c[number, 1], c[number, 2]


@lean_inlined
def _set_normals(rays: Cast, c: np.ndarray, normals: np.ndarray) -> float:
    """Write the normals of a triangle; returns the largest size that their products with a unit vector may have."""
    one = (c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2])
    two = (c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2])
    back = (rays.origin[0] - c[0, 0], rays.origin[1] - c[0, 1], rays.origin[2] - c[0, 2])
    r = rays.rotation
    for number, n in enumerate((_cross(two, back), _cross(back, one), _cross(two, one))):
        for axis in range(3):
            normals[number, axis] = r[0, axis] * n[0] + r[1, axis] * n[1] + r[2, axis] * n[2]
    return (size_of(back) + size_of(one) + size_of(two)) * (size_of(one) + size_of(two))


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
    rays: Cast, screen: Screen, c: np.ndarray, ball: tuple[Vector, float], is_void: bool, work: np.ndarray
) -> Face:
    """A triangle in the ball around it, place and radius in the frame of the sensor; work (2, 3, 3)."""
    (x, y, z), radius = ball
    normals, edges = work[0], work[1]
    doubt = DOUBT * screen.longest * _set_normals(rays, c, normals)
    corner = in_sensor_axes(rays, _corner(c, 0))
    over = normals[2, 0] * corner[0] + normals[2, 1] * corner[1] + normals[2, 2] * corner[2]
    distance = size_of((x, y, z))
    has_edges = distance > radius and abs(over) > doubt * (distance + radius)
    azimuth, side, steepest, cosine, sine = 0.0, 1e9, 1.0, 1.0, 0.0
    if not screen.is_camera:
        flat = np.sqrt(x * x + y * y)
        if radius >= WIDEST * flat:
            return Face(c, normals, edges, doubt, is_void, False, 0.0, 0.0, 0.0)
        cosine, sine = x / flat, y / flat
        steepest = flat / np.sqrt(flat * flat - radius * radius)
        azimuth, side = bearing(x, y), radius / flat * steepest
    _set_edges(normals, 1.0 if over > 0.0 else -1.0, cosine, sine, edges)
    return Face(c, normals, edges, doubt, is_void, has_edges, azimuth, side, steepest)


@lean_inlined
def between(
    face: Face, height: float, room: float, is_outer: bool, low: float, high: float
) -> tuple[float, float]:
    """The part of low..high on the line x = 1 in which rays of a row may be between the edges of a face, or where not
    `is_outer` the part in which they are for certain; room: of the edges (empty: from > to)."""
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
