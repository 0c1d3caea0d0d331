"""Where rays first hit something: oriented boxes, the ground z = 0, and triangles in a tree of boxes.

For pictures of what a sensor sees; the metric has no occlusion. Serial kernels, so that any thread may call them.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.codes import BODY, GROUND
from riglens.core.kernels.jit import inlined, kernel


@inlined
def _slab(origin: float, along: float, low: float, high: float, t0: float, t1: float) -> tuple[float, float]:
    """The part of [t0, t1] inside a slab; empty (t0 > t1) when there is none."""
    if along == 0.0:
        return (t0, t1) if low <= origin <= high else (np.inf, -np.inf)
    a, b = (low - origin) / along, (high - origin) / along
    return max(t0, min(a, b)), min(t1, max(a, b))


@kernel
def hit_boxes(
    origin: np.ndarray,
    directions: np.ndarray,
    centres: np.ndarray,
    halves: np.ndarray,
    rotations: np.ndarray,
    distance: np.ndarray,
    what: np.ndarray,
) -> None:
    """Shorten distance (n,) to the nearest box and note its number in what (n,).

    directions (n, 3) unit; rotations (m, 3, 3) box to vehicle frame. A box around the origin hides nothing.
    """
    for box in range(centres.shape[0]):
        turn, half = rotations[box], halves[box]
        to = centres[box] - origin
        reach2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
        far2 = to[0] * to[0] + to[1] * to[1] + to[2] * to[2]
        start = np.empty(3)
        for axis in range(3):
            start[axis] = -(turn[0, axis] * to[0] + turn[1, axis] * to[1] + turn[2, axis] * to[2])
        for ray in range(directions.shape[0]):
            d = directions[ray]
            nearest = d[0] * to[0] + d[1] * to[1] + d[2] * to[2]
            if far2 - nearest * nearest > reach2 or nearest + np.sqrt(reach2) < 0.0:
                continue
            t0, t1 = -np.inf, distance[ray]
            for axis in range(3):
                along = turn[0, axis] * d[0] + turn[1, axis] * d[1] + turn[2, axis] * d[2]
                t0, t1 = _slab(start[axis], along, -half[axis], half[axis], t0, t1)
            if 0.0 <= t0 <= t1 and t0 < distance[ray]:
                distance[ray], what[ray] = t0, box


@kernel
def hit_ground(height: float, directions: np.ndarray, distance: np.ndarray, what: np.ndarray) -> None:
    """Shorten distance (n,) to the plane z = 0 for rays that start `height` above it and look down."""
    for ray in range(directions.shape[0]):
        down = -directions[ray, 2]
        if height > 0.0 and down * distance[ray] > height:
            distance[ray], what[ray] = height / down, GROUND


@kernel
def hit_triangles(
    origin: np.ndarray,
    directions: np.ndarray,
    corners: np.ndarray,
    bounds: np.ndarray,
    leaf: np.ndarray,
    skip: np.ndarray,
    distance: np.ndarray,
    what: np.ndarray,
    facing: np.ndarray,
) -> None:
    """Shorten distance (n,) to the nearest triangle, seen from either side (Möller and Trumbore, 1997).

    corners (t, 3, 3); nodes in depth-first order: bounds (k, 6) low and high corner, leaf (k, 2) first triangle
    and number of them (0 in an inner node), skip (k,) the node to go on with when a ray misses this one.
    facing (n,): how squarely the ray meets the surface, 0 to 1.
    """
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
