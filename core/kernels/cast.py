"""All rays of one sensor through the grid, in parallel: the set of voxels covered, or the sum over all hits."""

from __future__ import annotations

import numba
import numpy as np

from core.kernels.bits import popcount
from core.kernels.jit import atomic_or, inlined, parallel_kernel
from core.kernels.walk import walk_bresenham, walk_exact

BLOCK = 64
FULL_WORD = np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def level_mask(low: int, high: int) -> np.uint64:
    """Bits low..high (both 0..63, both included) of a word."""
    return (FULL_WORD << np.uint64(low)) & (FULL_WORD >> np.uint64(63 - high))


@inlined
def _direction(rotation: np.ndarray, lattice: np.ndarray, i: int) -> tuple[float, float, float]:
    x, y, z = lattice[i, 0], lattice[i, 1], lattice[i, 2]
    return (
        (rotation[0, 0] * x + rotation[0, 1] * y) + rotation[0, 2] * z,
        (rotation[1, 0] * x + rotation[1, 1] * y) + rotation[1, 2] * z,
        (rotation[2, 0] * x + rotation[2, 1] * y) + rotation[2, 2] * z,
    )


@inlined
def _mark_runs(runs: np.ndarray, count: int, depth: int, keep: np.ndarray, marks: np.ndarray) -> None:
    """Set the bits of the runs that are also in `keep`; `depth` words make a column."""
    for r in range(count):
        low, high = runs[r, 1], runs[r, 2]
        for part in range(low >> 6, (high >> 6) + 1):
            word = runs[r, 0] * depth + part
            bits = level_mask(max(low - 64 * part, 0), min(high - 64 * part, 63)) & keep[word]
            if marks[word] & bits != bits:
                atomic_or(marks, word, bits)


@parallel_kernel
def mark_rays(
    origin: np.ndarray,
    rotation: np.ndarray,
    lattice: np.ndarray,
    reach: np.ndarray,
    box: np.ndarray,
    shape: np.ndarray,
    bresenham: bool,
    workers: int,
    keep: np.ndarray,
    marks: np.ndarray,
    irregular: np.ndarray,
) -> None:
    """Mark in `marks` the voxels of `keep` that some ray of the lattice traverses; any number of threads.

    origin (3,) grid units; rotation (3, 3); lattice (n, 3) sensor frame; reach (2,) grid units; box (6,) cells;
    shape (3,); keep, marks uint64 (columns * depth,); irregular bool (n,): rays left to the rational walk.
    """
    rays = lattice.shape[0]
    blocks = (rays + BLOCK - 1) // BLOCK
    depth = (shape[2] + 63) // 64
    g = (origin[0], origin[1], origin[2])
    for worker in numba.prange(workers):
        runs = np.empty((shape[0] + shape[1] + shape[2] + 3, 3), np.int32)
        for block in range(worker, blocks, workers):
            for i in range(block * BLOCK, min((block + 1) * BLOCK, rays)):
                d = _direction(rotation, lattice, i)
                if bresenham:
                    count = walk_bresenham(g, d, reach[0], reach[1], box, shape[1], runs)
                else:
                    count = walk_exact(g, d, reach[0], reach[1], box, shape[1], runs)
                irregular[i] = count < 0
                _mark_runs(runs, count, depth, keep, marks)


@inlined
def _sum_runs(
    runs: np.ndarray, count: int, depth: int, keep: np.ndarray, first: np.ndarray, h_q: np.ndarray, sums: np.ndarray
) -> None:
    """Add the entropies of all voxels of the runs, as often as they are met."""
    for r in range(count):
        for level in range(runs[r, 1], runs[r, 2] + 1):
            word = runs[r, 0] * depth + (level >> 6)
            bit = np.uint64(1) << np.uint64(level & 63)
            if keep[word] & bit != 0:
                voxel = first[word] + popcount(keep[word] & (bit - np.uint64(1)))
                for c in range(3):
                    sums[c] += np.int64(h_q[voxel, c])


@parallel_kernel
def sum_hits(
    origin: np.ndarray,
    rotation: np.ndarray,
    lattice: np.ndarray,
    reach: np.ndarray,
    box: np.ndarray,
    shape: np.ndarray,
    bresenham: bool,
    workers: int,
    keep: np.ndarray,
    first: np.ndarray,
    h_q: np.ndarray,
    irregular: np.ndarray,
) -> np.ndarray:
    """Sum over rays over their voxels of h in fixed point, (3,) int64; at most 2^15 rays a call (no overflow)."""
    rays = lattice.shape[0]
    blocks = (rays + BLOCK - 1) // BLOCK
    depth = (shape[2] + 63) // 64
    g = (origin[0], origin[1], origin[2])
    partial = np.zeros((workers, 3), np.int64)
    for worker in numba.prange(workers):
        runs = np.empty((shape[0] + shape[1] + shape[2] + 3, 3), np.int32)
        for block in range(worker, blocks, workers):
            for i in range(block * BLOCK, min((block + 1) * BLOCK, rays)):
                d = _direction(rotation, lattice, i)
                if bresenham:
                    count = walk_bresenham(g, d, reach[0], reach[1], box, shape[1], runs)
                else:
                    count = walk_exact(g, d, reach[0], reach[1], box, shape[1], runs)
                irregular[i] = count < 0
                _sum_runs(runs, count, depth, keep, first, h_q, partial[worker])
    return partial.sum(axis=0)
