"""Where rays first hit something: oriented boxes, the ground z = 0, and triangles in a tree of boxes.

For pictures of what a sensor sees; the metric has no occlusion. Serial kernels, so that any thread may call them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.codes import BODY, GROUND
from riglens.core.kernels.jit import inlined, kernel


class Boxes(NamedTuple):
    """Oriented boxes in metres, vehicle frame: centres (m, 3), half sizes (m, 3), rotations (m, 3, 3) from the frame of
    the box."""

    centres: np.ndarray
    halves: np.ndarray
    rotations: np.ndarray


class Triangles(NamedTuple):
    """Triangles in a tree of boxes, metres: corners (t, 3, 3); nodes in depth-first order: bounds (k, 6) low and high
    corner, leaf (k, 2) first triangle and number of them (0 in an inner node), skip (k,) the node to go on with when a
    ray misses this one."""

    corners: np.ndarray
    bounds: np.ndarray
    leaf: np.ndarray
    skip: np.ndarray


class Nearest(NamedTuple):
    """What each ray has met first so far: distance (n,) in metres; what (n,): the number of a box or one of the codes
    of `riglens.core.kernels.codes`; facing (n,): how squarely it meets the car's body, 0 to 1."""

    distance: np.ndarray
    what: np.ndarray
    facing: np.ndarray


@inlined
def _slab(origin: float, along: float, low: float, high: float, t0: float, t1: float) -> tuple[float, float]:
    """The part of [t0, t1] inside a slab; empty (t0 > t1) when there is none."""
    if along == 0.0:
        return (t0, t1) if low <= origin <= high else (np.inf, -np.inf)
    a, b = (low - origin) / along, (high - origin) / along
    return max(t0, min(a, b)), min(t1, max(a, b))


@kernel
def hit_boxes(origin: np.ndarray, directions: np.ndarray, boxes: Boxes, nearest: Nearest) -> None:
    """Note the boxes that are nearer than what was met so far. origin (3,); directions (n, 3) unit vectors.

    A box around the origin hides nothing.
    """
    distance, what = nearest.distance, nearest.what
    for box in range(boxes.centres.shape[0]):
        turn, half = boxes.rotations[box], boxes.halves[box]
        to = boxes.centres[box] - origin
        reach2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
        far2 = to[0] * to[0] + to[1] * to[1] + to[2] * to[2]
        start = np.empty(3)
        for axis in range(3):
            start[axis] = -(turn[0, axis] * to[0] + turn[1, axis] * to[1] + turn[2, axis] * to[2])
        for ray in range(directions.shape[0]):
            d = directions[ray]
            ahead = d[0] * to[0] + d[1] * to[1] + d[2] * to[2]
            if far2 - ahead * ahead > reach2 or ahead + np.sqrt(reach2) < 0.0:
                continue
            t0, t1 = -np.inf, distance[ray]
            for axis in range(3):
                along = turn[0, axis] * d[0] + turn[1, axis] * d[1] + turn[2, axis] * d[2]
                t0, t1 = _slab(start[axis], along, -half[axis], half[axis], t0, t1)
            if 0.0 <= t0 <= t1 and t0 < distance[ray]:
                distance[ray], what[ray] = t0, box


@kernel
def hit_ground(height_m: float, directions: np.ndarray, nearest: Nearest) -> None:
    """Note the plane z = 0 where it is nearer than what was met so far, for rays that start above it and look down."""
    distance, what, height = nearest.distance, nearest.what, height_m
    for ray in range(directions.shape[0]):
        down = -directions[ray, 2]
        if height > 0.0 and down * distance[ray] > height:
            distance[ray], what[ray] = height / down, GROUND


@kernel
def hit_triangles(origin: np.ndarray, directions: np.ndarray, tree: Triangles, nearest: Nearest) -> None:
    """Note the triangles, seen from either side, that are nearer than what was met so far (Möller, Trumbore 1997)."""
    distance, what, facing = nearest.distance, nearest.what, nearest.facing
    corners, bounds, leaf, skip = tree
    for ray in range(directions.shape[0]):
        d = directions[ray]
        node = 0
        while node < bounds.shape[0]:
            t0, t1 = 0.0, distance[ray]
            for axis in range(3):
                t0, t1 = _slab(origin[axis], d[axis], bounds[node, axis], bounds[node, 3 + axis], t0, t1)
            if t0 > t1:
                node = skip[node]
                continue
            for triangle in range(leaf[node, 0], leaf[node, 0] + leaf[node, 1]):
                t, square = _meet(origin, d, corners[triangle])
                if 0.0 < t < distance[ray]:
                    distance[ray], what[ray], facing[ray] = t, BODY, square
            node += 1


@inlined
def _meet(origin: np.ndarray, d: np.ndarray, corners: np.ndarray) -> tuple[float, float]:
    """Distance to a triangle, inf when the ray misses it, and |cosine| between ray and normal."""
    ax, ay, az = corners[0, 0], corners[0, 1], corners[0, 2]
    ux, uy, uz = corners[1, 0] - ax, corners[1, 1] - ay, corners[1, 2] - az
    vx, vy, vz = corners[2, 0] - ax, corners[2, 1] - ay, corners[2, 2] - az
    px, py, pz = d[1] * vz - d[2] * vy, d[2] * vx - d[0] * vz, d[0] * vy - d[1] * vx
    volume = ux * px + uy * py + uz * pz
    if volume == 0.0:
        return np.inf, 0.0
    sx, sy, sz = origin[0] - ax, origin[1] - ay, origin[2] - az
    u = (sx * px + sy * py + sz * pz) / volume
    qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    v = (d[0] * qx + d[1] * qy + d[2] * qz) / volume
    if u < 0.0 or v < 0.0 or u + v > 1.0:
        return np.inf, 0.0
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return (vx * qx + vy * qy + vz * qz) / volume, abs(volume) / np.sqrt(nx * nx + ny * ny + nz * nz)
