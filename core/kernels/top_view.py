"""Entropy seen per column of voxels: the sums behind a map from above."""

from __future__ import annotations

import numba
import numpy as np

from core.kernels.bits import lowest_bit, popcount
from core.kernels.jit import parallel_kernel


@parallel_kernel
def update_columns(
    before: np.ndarray,
    now: np.ndarray,
    keep: np.ndarray,
    first: np.ndarray,
    codes: np.ndarray,
    values_q: np.ndarray,
    shape: tuple[int, int, int],
    block: int,
    sums_q: np.ndarray,
) -> None:
    """Have the sums of the columns follow a change of the chosen voxels (words, a part of `keep`), exactly.

    shape: voxels along x and y, words per column; values_q int64 by code; sums_q int64 (bx, by): blocks of
    `block` x `block` columns. A row of blocks is one thread's own.
    """
    nx, ny, depth = shape
    for bx in numba.prange(sums_q.shape[0]):
        for column in range(bx * block * ny, min((bx + 1) * block, nx) * ny):
            change = np.int64(0)
            for w in range(column * depth, (column + 1) * depth):
                bits = before[w] ^ now[w]
                while bits != 0:
                    bit = lowest_bit(bits)
                    below = (np.uint64(1) << bit) - np.uint64(1)
                    value = values_q[codes[np.int64(first[w]) + np.int64(popcount(keep[w] & below))]]
                    change += value if (now[w] >> bit) & np.uint64(1) != 0 else -value
                    bits &= bits - np.uint64(1)
            sums_q[bx, (column % ny) // block] += change
