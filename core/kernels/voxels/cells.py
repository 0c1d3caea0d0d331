"""Sums of entropies for pictures: over the cells of the display, which are blocks of voxels, and over columns."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import kernel, parallel_kernel
from riglens.core.kernels.voxels.bits import first_run, lowest_bit, popcount
from riglens.core.kernels.voxels.entropy_codes import Runs


class CellMap(NamedTuple):
    """Informative voxels and the display cells that hold them: keep uint64 (words,), the voxels; first uint32
    (words + 1,): how many come before each word; cells int32 (n,): the cell of each; slab_words: words of
    the columns that may share a cell; slabs of that size have no cell in common."""

    keep: np.ndarray
    first: np.ndarray
    cells: np.ndarray
    slab_words: int


class Columns(NamedTuple):
    """Columns of a grid, put together in squares: nx, ny columns of `depth` words; `block` columns make an edge."""

    nx: int
    ny: int
    depth: int
    block: int


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
    """Return the largest count of the voxels of each cell."""
    largest = np.zeros(count_of_cells, np.uint32)
    for row in range(cells.size):
        largest[cells[row]] = max(largest[cells[row]], counts[row])
    return largest


@parallel_kernel
def levels_per_cell(
    levels: np.ndarray, voxels: CellMap, runs: Runs, values_q: np.ndarray, sums_q: np.ndarray
) -> None:
    """Add what every voxel adds to its cell, in the column of the number of nested sets that hold it.

    levels uint64 (n, words): each a part of the one before; values_q int64 (m,): what a voxel adds, by code; sums_q
    int64 (m, n + 1).
    """
    count, words = levels.shape
    slab_words = voxels.slab_words
    slabs = (words + slab_words - 1) // slab_words
    for slab in numba.prange(slabs):
        for w in range(slab * slab_words, min((slab + 1) * slab_words, words)):
            bits, row = voxels.keep[w], np.int64(voxels.first[w])
            run, value_q = np.int64(runs.first[w]), np.int64(0)
            while bits != 0:
                bit, level = lowest_bit(bits), 0
                if (runs.starts[w] >> bit) & np.uint64(1) != 0:
                    value_q = values_q[runs.codes[run]]
                    run += 1
                while level < count and (levels[level, w] >> bit) & np.uint64(1) != 0:
                    level += 1
                sums_q[voxels.cells[row], level] += value_q
                row += 1
                bits &= bits - np.uint64(1)


@parallel_kernel
def update_columns(
    before: np.ndarray,
    now: np.ndarray,
    runs: Runs,
    values_q: np.ndarray,
    columns: Columns,
    sums_q: np.ndarray,
) -> None:
    """Update the sums of the columns after a change of the chosen voxels, uint64 (words,), exactly.

    values_q int64 (m,): what a voxel adds, by code; sums_q int64 (bx, by): sums of the squares of columns. A row of
    squares is one thread's own.
    """
    nx, ny, depth, block = columns.nx, columns.ny, columns.depth, columns.block
    for bx in numba.prange(sums_q.shape[0]):
        for column in range(bx * block * ny, min((bx + 1) * block, nx) * ny):
            change = np.int64(0)
            for w in range(column * depth, (column + 1) * depth):
                bits = before[w] ^ now[w]
                while bits != 0:
                    run, within = first_run(bits, runs.starts[w])
                    gained = np.int64(popcount(now[w] & within)) - np.int64(popcount(before[w] & within))
                    change += gained * values_q[runs.codes[np.int64(runs.first[w]) + run]]
                    bits ^= within
            sums_q[bx, (column % ny) // block] += change
