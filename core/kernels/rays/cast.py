"""All rays of one sensor, one by one and in parallel: the set of voxels covered, or the sum over all hits."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.rays.lattice import direction, rotated
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.rays.walk import Ray, walk_bresenham, walk_exact
from riglens.core.kernels.runtime.jit import inlined, lean_inlined, parallel_kernel
from riglens.core.kernels.runtime.work_stealing import new_counter, take
from riglens.core.kernels.voxels.bits import level_mask, mark_levels, popcount
from riglens.core.kernels.voxels.entropy_codes import Entropies

NONE_STOPPED = np.zeros(0, np.bool_)
BLOCK = 64
"""Rays that a worker walks in a row."""
WORDS_AT_ONCE = 1 << 13
"""Words that a worker adds up in a row."""


class Cast(NamedTuple):
    """Rays to walk: lattice tables of any kind (see `kernels.rays.lattice`), origin (3,) in grid units,
    rotation (3, 3), reach (2,) in grid units, box (6,) cells to stay in, shape (3,) of the grid, the method, ends
    (rays,), where each ray is cut off, in grid units, and is_stopped (rays,): rays that are not cast at all; both
    empty where there are none; in_row: how many listed rays make a row of the lattice, 0 where this is not known."""

    kind: int
    rows: np.ndarray
    planes: np.ndarray
    origin: np.ndarray
    rotation: np.ndarray
    reach: np.ndarray
    box: np.ndarray
    shape: np.ndarray
    bresenham: bool
    ends: np.ndarray
    is_stopped: np.ndarray = NONE_STOPPED
    in_row: int = 0


@inlined
def _passes(g: float, d: float, low: float, high: float, t_in: float, t_out: float) -> tuple[float, float]:
    """Return the span of t in which a ray may be between two faces of an axis, a little too long rather than too
    short."""
    if d == 0.0:
        return t_in, t_out
    a, b = (low - g) / d, (high - g) / d
    blur = 1e-14 * (abs(g) + abs(high) + abs(low)) / abs(d)
    return max(t_in, min(a, b) - blur), min(t_out, max(a, b) + blur)


@inlined
def _misses(rays: Cast, g: Vector, d: Vector, far: float) -> bool:
    """Return whether a ray certainly misses the box: much faster than to clip it exactly."""
    t_in, t_out = rays.reach[0], far
    for axis in range(3):
        low, high = float(rays.box[2 * axis]), float(rays.box[2 * axis + 1])
        t_in, t_out = _passes(g[axis], d[axis], low, high, t_in, t_out)
    return bool(t_out < t_in)


@lean_inlined
def direction_at(rays: Cast, row: int, plane: int) -> Vector:
    """Return the direction of the ray of a row and a plane in the frame of the grid."""
    return rotated(rays.rotation, direction(rays.kind, rays.rows[row], rays.planes[plane]))


@lean_inlined
def ray_direction(rays: Cast, ray: int) -> Vector:
    """Return the direction of a ray, by its number, in the frame of the grid."""
    planes = rays.planes.shape[0]
    return direction_at(rays, ray // planes, ray % planes)


@inlined
def walk_ray(rays: Cast, ray: int, runs: np.ndarray) -> int:
    """Write the runs of one ray and return their number, 0 if it is stopped; negative when it is left to the rational
    walk."""
    if rays.is_stopped.size > 0 and rays.is_stopped[ray]:
        return 0
    d = ray_direction(rays, ray)
    g = (rays.origin[0], rays.origin[1], rays.origin[2])
    far = min(rays.reach[1], rays.ends[ray]) if rays.ends.size > 0 else rays.reach[1]
    if far <= rays.reach[0] or _misses(rays, g, d, far):
        return 0
    whole = Ray(g, d, rays.reach[0], far)
    if rays.bresenham:
        return walk_bresenham(whole, rays.box, rays.shape[1], runs)
    return walk_exact(whole, rays.box, rays.shape[1], runs)


@inlined
def _mark_runs(runs: np.ndarray, count: int, depth: int, marks: np.ndarray) -> None:
    """Set the bits of the runs; `depth` words make a column."""
    if depth == 1:
        for r in range(count):
            marks[runs[r, 0]] |= level_mask(runs[r, 1], runs[r, 2])
        return
    for r in range(count):
        mark_levels(marks, np.int64(runs[r, 0]) * depth, np.int64(runs[r, 1]), np.int64(runs[r, 2]))


@parallel_kernel
def mark_rays(
    rays: Cast, first: int, end: int, marks: np.ndarray, spare: np.ndarray, left: np.ndarray
) -> None:
    """Mark what some of the rays first..end-1 traverse in marks uint64 (words,) and spare (workers - 1, words), one set
    for each worker. left bool (end - first,): the rays to walk; remains set for those left to the rational walk.
    """
    workers = spare.shape[0] + 1
    blocks = (end - first + BLOCK - 1) // BLOCK
    depth, counter = (rays.shape[2] + 63) // 64, new_counter()
    for worker in numba.prange(workers):
        own = spare[worker - 1] if worker > 0 else marks
        runs = np.empty((rays.shape[0] + rays.shape[1] + rays.shape[2] + 3, 3), np.int32)
        block = take(counter)
        while block < blocks:
            for ray in range(first + block * BLOCK, min(first + (block + 1) * BLOCK, end)):
                if left[ray - first]:
                    count = walk_ray(rays, ray, runs)
                    left[ray - first] = count < 0
                    _mark_runs(runs, count, depth, own)
            block = take(counter)


@parallel_kernel
def add_marks(spare: np.ndarray, marks: np.ndarray, workers: int) -> None:
    """Add the bits of spare (n, words) to marks (words,), and clear them."""
    words, counter = marks.size, new_counter()
    for _ in numba.prange(workers):
        start = take(counter) * WORDS_AT_ONCE
        while start < words:
            part = marks[start : start + WORDS_AT_ONCE]
            for row in range(spare.shape[0]):
                more = spare[row, start : start + WORDS_AT_ONCE]
                for w in range(part.size):
                    part[w] |= more[w]
                    more[w] = 0
            start = take(counter) * WORDS_AT_ONCE


@inlined
def _sum_runs(runs: np.ndarray, count: int, depth: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add the entropies of all voxels of the runs, as often as they are met."""
    for r in range(count):
        for level in range(runs[r, 1], runs[r, 2] + 1):
            word = runs[r, 0] * depth + (level >> 6)
            bit = np.uint64(1) << np.uint64(level & 63)
            if entropies.keep[word] & bit != 0:
                upto = entropies.starts[word] & (bit | (bit - np.uint64(1)))
                code = entropies.codes[entropies.first[word] + popcount(upto) - np.uint64(1)]
                for c in range(3):
                    sums[c] += np.int64(entropies.entropies_q[code, c])


@parallel_kernel
def sum_hits(
    rays: Cast, first: int, end: int, workers: int, entropies: Entropies, irregular: np.ndarray
) -> np.ndarray:
    """Return the sum of h over the rays first..end-1 and the voxels of each (the reading `hits`), int64 (3,) in units
    of 2^-32 nat; at most 2^15 rays a call, or it could overflow. irregular bool (end - first,): rays left to the
    rational walk, which are not in the sum.
    """
    blocks = (end - first + BLOCK - 1) // BLOCK
    depth = (rays.shape[2] + 63) // 64
    partial = np.zeros((workers, 3), np.int64)
    for worker in numba.prange(workers):
        runs = np.empty((rays.shape[0] + rays.shape[1] + rays.shape[2] + 3, 3), np.int32)
        for block in range(worker, blocks, workers):
            for ray in range(first + block * BLOCK, min(first + (block + 1) * BLOCK, end)):
                count = walk_ray(rays, ray, runs)
                irregular[ray - first] = count < 0
                _sum_runs(runs, count, depth, entropies, partial[worker])
    total: np.ndarray = partial.sum(axis=0)
    return total
