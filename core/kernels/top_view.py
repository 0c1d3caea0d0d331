"""Entropy seen per column of voxels: the sums behind a map from above."""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.bits import first_run, popcount
from riglens.core.kernels.jit import parallel_kernel


@parallel_kernel
def update_columns(
    before: np.ndarray,
    now: np.ndarray,
    starts: np.ndarray,
    first: np.ndarray,
    codes: np.ndarray,
    values_q: np.ndarray,
    shape: tuple[int, int, int],
    block: int,
    sums_q: np.ndarray,
) -> None:
    """Have the sums of the columns follow a change of the chosen voxels (words), exactly.

    shape: voxels along x and y, words per column; starts, first, codes: runs of equal voxels; values_q
    int64 by code; sums_q int64 (bx, by): blocks of `block` x `block` columns. A row of blocks is one thread's own.
    """
    nx, ny, depth = shape
    for bx in numba.prange(sums_q.shape[0]):
        for column in range(bx * block * ny, min((bx + 1) * block, nx) * ny):
            change = np.int64(0)
            for w in range(column * depth, (column + 1) * depth):
                bits = before[w] ^ now[w]
                while bits != 0:
                    run, within = first_run(bits, starts[w])
                    gained = np.int64(popcount(now[w] & within)) - np.int64(popcount(before[w] & within))
                    change += gained * values_q[codes[np.int64(first[w]) + run]]
                    bits ^= within
            sums_q[bx, (column % ny) // block] += change
