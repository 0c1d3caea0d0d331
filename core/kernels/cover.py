"""How often the entropy of display cells is covered: sums per cell and per number of sensors."""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.bits import lowest_bit
from riglens.core.kernels.jit import parallel_kernel


@parallel_kernel
def levels_per_cell(
    levels: np.ndarray,
    keep: np.ndarray,
    first: np.ndarray,
    h_q: np.ndarray,
    cells: np.ndarray,
    words_per_slab: int,
    sums: np.ndarray,
) -> None:
    """Add h (fixed point) of every voxel to its cell, in the column of how many of the nested sets hold it.

    levels uint64 (n, words): each a part of the one before; sums int64 (m, n + 1). A slab of columns never shares
    a cell with another.
    """
    count, words = levels.shape
    slabs = (words + words_per_slab - 1) // words_per_slab
    for slab in numba.prange(slabs):
        for w in range(slab * words_per_slab, min((slab + 1) * words_per_slab, words)):
            bits, row = keep[w], np.int64(first[w])
            while bits != 0:
                bit, level = lowest_bit(bits), 0
                while level < count and (levels[level, w] >> bit) & np.uint64(1) != 0:
                    level += 1
                sums[cells[row], level] += np.int64(h_q[row])
                row += 1
                bits &= bits - np.uint64(1)
