"""Exchange the contribution of one sensor and account for exactly the voxels whose cover changed."""

from __future__ import annotations

import numba
import numpy as np

from core.kernels.bits import lowest_bit, popcount
from core.kernels.jit import inlined, parallel_kernel

COLUMNS = 4
"""Sums are kept side by side: three classes in fixed point, then the number of voxels."""


@inlined
def _add_voxels(bits: np.uint64, sign: int, keep: np.uint64, first: int, h_q: np.ndarray, sums: np.ndarray) -> None:
    """Add (or take away) the entropies of the voxels `bits` of one word of the index."""
    one = np.uint64(1)
    sums[3] += sign * np.int64(popcount(bits))
    while bits != 0:
        below = (one << lowest_bit(bits)) - one
        voxel = first + np.int64(popcount(keep & below))
        for c in range(3):
            sums[c] += sign * np.int64(h_q[voxel, c])
        bits &= bits - one


@parallel_kernel
def exchange(
    stack: np.ndarray,
    slot: int,
    marks: np.ndarray,
    same_kind: np.ndarray,
    union: np.ndarray,
    kind: int,
    keep: np.ndarray,
    first: np.ndarray,
    h_q: np.ndarray,
    workers: int,
) -> np.ndarray:
    """Put `marks` in the place of stack[slot], clear marks, update union[kind]; returns the change of the sums.

    stack (slots, words) contributions; same_kind: the other slots of this kind; union (2, words) covered by all
    cameras and by all LiDARs; result int64 (2, 4): this kind, and any sensor; rows as in COLUMNS. Integers, so
    the order of the edits and the number of threads cannot matter.
    """
    words = keep.size
    partial = np.zeros((workers, 16), np.int64)  # a cache line of its own for every worker
    for worker in numba.prange(workers):
        sums = np.zeros((2, COLUMNS), np.int64)
        for w in range(words * worker // workers, words * (worker + 1) // workers):
            old, new = stack[slot, w], marks[w]
            if old == new:
                if new != 0:
                    marks[w] = 0
                continue
            marks[w] = 0
            stack[slot, w] = new
            others = np.uint64(0)
            for other in same_kind:
                others |= stack[other, w]
            union[kind, w] = others | new
            elsewhere = ~union[1 - kind, w]
            gained, lost = new & ~old & ~others, old & ~new & ~others
            _add_voxels(gained, 1, keep[w], first[w], h_q, sums[0])
            _add_voxels(lost, -1, keep[w], first[w], h_q, sums[0])
            _add_voxels(gained & elsewhere, 1, keep[w], first[w], h_q, sums[1])
            _add_voxels(lost & elsewhere, -1, keep[w], first[w], h_q, sums[1])
        for column in range(2 * COLUMNS):
            partial[worker, column] = sums[column // COLUMNS, column % COLUMNS]
    return partial.sum(axis=0)[: 2 * COLUMNS].reshape(2, COLUMNS)
