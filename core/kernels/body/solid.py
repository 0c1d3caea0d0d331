"""Intersect rays with the triangles of a solid, in a tree of boxes: one formula, whichever path leads to the triangle.

A ray o + t d meets a triangle when it passes the box around it, grown by GROWN on all sides, from t0 to t1, and
when u >= -EDGE, v >= -EDGE and u + v <= 1 + EDGE in the doubles of Möller and Trumbore, "Fast, minimum storage
ray-triangle intersection" (1997); it meets it at their t, held between t0 and t1, so that rounding on a sliver cannot
put it elsewhere. Edges belong to the triangle, so no ray slips through between two of them, and both sides count. As
larger boxes give wider ranges of t, also in doubles, a tree of boxes leaves out nothing that a search over all
triangles finds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.rays.cast import Cast, ray_direction
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.jit import kernel, lean_inlined

GROWN = 1e-6
"""Metres by which boxes are larger than their content: far more than the rounding of a ray's path."""
EDGE = 1e-7
"""Share of its size by which a triangle extends beyond its corners: more than rounding along a shared edge."""
BLOCK = 64
"""Rays that a worker takes in a row."""


class Tree(NamedTuple):
    """Triangles in a tree of boxes, metres: corners (t, 3, 3) in the order of the leaves, and the number (t,) of each
    outside of the tree; nodes in depth-first order: bounds (k, 6) low and high corner, grown; leaf (k, 2) first
    triangle and how many (0 in an inner node); skip (k,) the node to go on with when a ray misses this one."""

    corners: np.ndarray
    number: np.ndarray
    bounds: np.ndarray
    leaf: np.ndarray
    skip: np.ndarray


class Hit(NamedTuple):
    """Hit of a ray: distance along the ray (inf: none), number of the triangle, |cosine| between ray and normal."""

    t: float
    number: int
    square: float


@lean_inlined
def slab(origin: float, along: float, low: float, high: float, t0: float, t1: float) -> tuple[float, float]:
    """Return the part of [t0, t1] inside a slab; empty (t0 > t1) when there is none."""
    if along == 0.0:
        return (t0, t1) if low <= origin <= high else (np.inf, -np.inf)
    a, b = (low - origin) / along, (high - origin) / along
    return max(t0, min(a, b)), min(t1, max(a, b))


@lean_inlined
def _passes(o: Vector, d: Vector, bounds: np.ndarray, t0: float, t1: float) -> tuple[float, float]:
    """Return the part of [t0, t1] in which a ray is inside of bounds (6,)."""
    t0, t1 = slab(o[0], d[0], bounds[0], bounds[3], t0, t1)
    t0, t1 = slab(o[1], d[1], bounds[1], bounds[4], t0, t1)
    return slab(o[2], d[2], bounds[2], bounds[5], t0, t1)


@lean_inlined
def _passes_triangle(o: Vector, d: Vector, c: np.ndarray) -> tuple[float, float]:
    """Return the part of a ray, from its start on, inside of the grown box around corners (3, 3)."""
    t0, t1 = 0.0, np.inf
    for axis in range(3):
        low = min(c[0, axis], min(c[1, axis], c[2, axis])) - GROWN
        high = max(c[0, axis], max(c[1, axis], c[2, axis])) + GROWN
        t0, t1 = slab(o[axis], d[axis], low, high, t0, t1)
    return t0, t1


@lean_inlined
def _is_well_inside(place: Vector, c: np.ndarray) -> bool:
    """Return whether a place lies in the box around corners (3, 3), grown by half of GROWN: a ray that is there at t is
    in the grown box before and after, whatever rounding does."""
    for axis in range(3):
        low, high = min(c[0, axis], min(c[1, axis], c[2, axis])), max(c[0, axis], max(c[1, axis], c[2, axis]))
        if not low - 0.5 * GROWN < place[axis] < high + 0.5 * GROWN:
            return False
    return True


@lean_inlined
def meet(o: Vector, d: Vector, c: np.ndarray) -> tuple[float, float]:
    """Return the distance at which a ray meets a triangle of corners (3, 3), inf if it does not, and |cosine| between
    ray and normal."""
    ax, ay, az = c[0, 0], c[0, 1], c[0, 2]
    ux, uy, uz = c[1, 0] - ax, c[1, 1] - ay, c[1, 2] - az
    vx, vy, vz = c[2, 0] - ax, c[2, 1] - ay, c[2, 2] - az
    px, py, pz = d[1] * vz - d[2] * vy, d[2] * vx - d[0] * vz, d[0] * vy - d[1] * vx
    volume = ux * px + uy * py + uz * pz
    if volume == 0.0:
        return np.inf, 0.0
    sx, sy, sz = o[0] - ax, o[1] - ay, o[2] - az
    u = (sx * px + sy * py + sz * pz) / volume
    qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    v = (d[0] * qx + d[1] * qy + d[2] * qz) / volume
    if not (u >= -EDGE and v >= -EDGE and u + v <= 1.0 + EDGE):
        return np.inf, 0.0
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    t = (vx * qx + vy * qy + vz * qz) / volume
    if not (t > 0.0 and _is_well_inside((o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]), c)):
        t0, t1 = _passes_triangle(o, d, c)
        if t0 > t1:
            return np.inf, 0.0
        t = min(max(t, t0), t1)
    return t, abs(volume) / np.sqrt(nx * nx + ny * ny + nz * nz)


@lean_inlined
def first_hit(
    o: Vector, d: Vector, tree: Tree, stops: np.ndarray, nodes: tuple[int, int], start: float, best: Hit
) -> Hit:
    """Return the nearest hit beyond `start` and nearer than `best`; of two at the same place the one with the lower
    number.

    nodes: from which node of the tree to which; stops bool (t,): which triangles stop the ray.
    """
    node = nodes[0]
    while node < nodes[1]:
        t0, t1 = _passes(o, d, tree.bounds[node], 0.0, best.t)
        if t0 > t1 or t1 <= start:
            node = tree.skip[node]
            continue
        for triangle in range(tree.leaf[node, 0], tree.leaf[node, 0] + tree.leaf[node, 1]):
            number = tree.number[triangle]
            if stops[number]:
                t, square = meet(o, d, tree.corners[triangle])
                if t > start and (t < best.t or (t == best.t and number < best.number)):
                    best = Hit(t, number, square)
        node += 1
    return best


@kernel
def meet_listed(
    origin: np.ndarray, directions: np.ndarray, tree: Tree, stops: np.ndarray, most: np.ndarray, start: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the first hits of rays of directions (n, 3) nearer than `most` (n,): distance (n,), inf without one,
    number of the triangle (n,), -1 without one, and |cosine| (n,)."""
    count = directions.shape[0]
    distance, number, square = np.full(count, np.inf), np.full(count, -1), np.zeros(count)
    o = (origin[0], origin[1], origin[2])
    for ray in range(count):
        d = (directions[ray, 0], directions[ray, 1], directions[ray, 2])
        none = Hit(most[ray], -1, 0.0)
        hit = first_hit(o, d, tree, stops, (0, tree.skip.size), start, none)
        if hit.number >= 0:
            distance[ray], number[ray], square[ray] = hit.t, hit.number, hit.square
    return distance, number, square


@kernel
def ends_by_tree(
    rays: Cast, tree: Tree, stops: np.ndarray, start: float, share: int, shares: int, ends: np.ndarray
) -> None:
    """Write where each ray of a lattice first meets the solid, (n,), inf where it does not; shares take blocks of rays
    in turn. `rays` is in metres."""
    blocks = (ends.size + BLOCK - 1) // BLOCK
    o, none = (rays.origin[0], rays.origin[1], rays.origin[2]), Hit(np.inf, -1, 0.0)
    for block in range(share, blocks, shares):
        for ray in range(block * BLOCK, min((block + 1) * BLOCK, ends.size)):
            d = ray_direction(rays, ray)
            ends[ray] = first_hit(o, d, tree, stops, (0, tree.skip.size), start, none).t
