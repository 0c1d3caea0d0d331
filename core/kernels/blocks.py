"""Blocks of voxels for display: numbering the blocks in use and summing entropies per block."""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.bits import lowest_bit
from riglens.core.kernels.jit import kernel, parallel_kernel


@kernel
def flag_blocks(ijk: np.ndarray, block: int, flags: np.ndarray) -> None:
    """Flag the blocks, flags uint8 (bx, by, bz), that hold at least one of the voxels ijk (n, 3)."""
    for row in range(ijk.shape[0]):
        flags[ijk[row, 0] // block, ijk[row, 1] // block, ijk[row, 2] // block] = 1


@kernel
def cells_of(ijk: np.ndarray, block: int, numbers: np.ndarray) -> np.ndarray:
    """Cell number of each voxel, int32 (n,), from the numbers (bx, by, bz) of the blocks."""
    cells = np.empty(ijk.shape[0], np.int32)
    for row in range(ijk.shape[0]):
        cells[row] = numbers[ijk[row, 0] // block, ijk[row, 1] // block, ijk[row, 2] // block]
    return cells


@kernel
def largest_per_cell(cells: np.ndarray, counts: np.ndarray, count_of_cells: int) -> np.ndarray:
    """Largest count of the voxels of each cell."""
    largest = np.zeros(count_of_cells, np.uint32)
    for row in range(cells.size):
        largest[cells[row]] = max(largest[cells[row]], counts[row])
    return largest


@parallel_kernel
def seen_per_cell(
    seen: np.ndarray,
    keep: np.ndarray,
    first: np.ndarray,
    h_q: np.ndarray,
    cells: np.ndarray,
    words_per_slab: int,
    sums: np.ndarray,
) -> None:
    """Add h (fixed point) of the seen voxels to their cells; a slab of columns never shares a cell with another."""
    slabs = (seen.size + words_per_slab - 1) // words_per_slab
    for slab in numba.prange(slabs):
        for w in range(slab * words_per_slab, min((slab + 1) * words_per_slab, seen.size)):
            bits, row = keep[w], np.int64(first[w])
            while bits != 0:
                if (seen[w] >> lowest_bit(bits)) & np.uint64(1) != 0:
                    sums[cells[row]] += np.int64(h_q[row])
                row += 1
                bits &= bits - np.uint64(1)
