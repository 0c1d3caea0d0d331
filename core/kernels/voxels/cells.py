"""Sums of entropies for pictures: over the cells of the display, which are blocks of voxels, and over columns."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel
from riglens.core.kernels.voxels.bits import first_run, lowest_bit, mask_of, popcount
from riglens.core.kernels.voxels.entropy_codes import Runs


class CellMap(NamedTuple):
    """Voxels of a grid and the display cells, blocks of voxels, that hold them: keep uint64 (words,), the voxels;
    numbers int32 (bx, by, bz): the cell of each block; ny columns of `depth` words make a slice along x."""

    keep: np.ndarray
    numbers: np.ndarray
    ny: int
    depth: int
    block: int


class Columns(NamedTuple):
    """Columns of a grid, put together in squares: nx, ny columns of `depth` words; `block` columns make an edge."""

    nx: int
    ny: int
    depth: int
    block: int


@inlined
def _block_of(bits: np.uint64, low: int, block: int) -> tuple[int, np.uint64]:
    """Return the number, counted upwards, of the block that holds the lowest of some bits of a word, whose first level
    is `low`, and the bits of that block."""
    number = int((low + np.int64(lowest_bit(bits))) // block)
    return number, mask_of(number * block - low, (number + 1) * block - 1 - low, 0)


@kernel
def flag_blocks(voxels: CellMap, flags: np.ndarray) -> None:
    """Flag the blocks, flags uint8 (bx, by, bz), that hold at least one of the voxels; there are no numbers yet."""
    slice_words, depth, block = voxels.ny * voxels.depth, voxels.depth, voxels.block
    for w in range(voxels.keep.size):
        bits = voxels.keep[w]
        column = flags[w // slice_words // block, w % slice_words // depth // block]
        while bits != 0:
            number, within = _block_of(bits, w % depth * 64, block)
            column[number] = 1
            bits &= ~within


@kernel
def largest_per_cell(voxels: CellMap, runs: Runs, values: np.ndarray, largest: np.ndarray) -> None:
    """Raise the number of each cell, largest (m,), to the largest value of its voxels, values (rows,) by code."""
    slice_words, depth, block = voxels.ny * voxels.depth, voxels.depth, voxels.block
    for w in range(voxels.keep.size):
        bits = voxels.keep[w]
        column = voxels.numbers[w // slice_words // block, w % slice_words // depth // block]
        while bits != 0:
            number, of_block = _block_of(bits, w % depth * 64, block)
            run, of_run = first_run(bits, runs.starts[w])
            cell = column[number]
            largest[cell] = max(largest[cell], values[runs.codes[np.int64(runs.first[w]) + run]])
            bits &= ~(of_run & of_block)


@parallel_kernel
def levels_per_cell(
    levels: np.ndarray, voxels: CellMap, runs: Runs, values_q: np.ndarray, sums_q: np.ndarray
) -> None:
    """Add what every voxel adds to its cell, in the column of the number of nested sets that hold it.

    levels uint64 (n, words): each a part of the one before; values_q int64 (m,): what a voxel adds, by code; sums_q
    int64 (m, n + 1). Blocks with the same bx are one thread's own.
    """
    count, words = levels.shape
    depth, block = voxels.depth, voxels.block
    slab_words = block * voxels.ny * depth
    for slab in numba.prange(voxels.numbers.shape[0]):
        for w in range(slab * slab_words, min((slab + 1) * slab_words, words)):
            bits = voxels.keep[w]
            column = voxels.numbers[slab, w // depth % voxels.ny // block]
            while bits != 0:
                number, of_block = _block_of(bits, w % depth * 64, block)
                run, of_run = first_run(bits, runs.starts[w])
                value_q = values_q[runs.codes[np.int64(runs.first[w]) + run]]
                held, sums = of_run & of_block, sums_q[column[number]]
                bits &= ~held
                for level in range(count):
                    within = held & levels[level, w]
                    sums[level] += np.int64(popcount(held ^ within)) * value_q
                    held = within
                sums[count] += np.int64(popcount(held)) * value_q


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
