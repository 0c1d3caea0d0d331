"""Sets of voxels as bits: columns of 64-bit words along z, the numbering of the voxels in a set, and runs of
neighbouring ones that share their counts: far fewer than voxels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.voxels import bits, entropy_codes
from riglens.core.kernels.voxels.entropy_codes import Runs
from riglens.core.scene.grid import VoxelGrid

Words = NDArray[np.uint64]
Counts = NDArray[np.uint16] | NDArray[np.uint32]
"""Counts of frames by voxel and class, (n, 3)."""


def words_per_column(grid: VoxelGrid) -> int:
    """Return the number of 64-bit words that hold one column of voxels."""
    return (grid.shape[2] + 63) // 64


def words_in(grid: VoxelGrid) -> int:
    """Return the number of words of a set of voxels of a grid."""
    return grid.shape[0] * grid.shape[1] * words_per_column(grid)


def empty_words(grid: VoxelGrid) -> Words:
    """Return the empty set of voxels, (nx * ny * words per column,)."""
    return np.zeros(words_in(grid), np.uint64)


def require_words_of(grid: VoxelGrid, words: Words) -> None:
    """Raise ValueError unless the words are a set of voxels of this grid: kernels index by every bit that is set."""
    if words.dtype != np.uint64 or words.shape != (words_in(grid),):
        raise ValueError(f"words must fit the grid (got {words.dtype} {words.shape})")
    levels, depth = grid.shape[2], words_per_column(grid)
    if levels % 64:
        top = int(np.bitwise_or.reduce(words.reshape(-1, depth)[:, -1], initial=np.uint64(0)))
        if top >> (levels % 64):
            raise ValueError(f"words: found voxels above the grid's height of {levels} levels")


def pack(grid: VoxelGrid, mask: NDArray[np.bool_]) -> Words:
    """Return the words of a dense mask (nx, ny, nz)."""
    words = empty_words(grid)
    levels = np.packbits(mask.reshape(-1, grid.shape[2]), axis=1, bitorder="little")
    _bytes_by_column(grid, words)[:, : levels.shape[1]] = levels
    return words


def _bytes_by_column(grid: VoxelGrid, words: Words) -> NDArray[np.uint8]:
    """Return the words as bytes (columns, n), the lowest levels first: on the processors that Numba compiles for."""
    return words.view(np.uint8).reshape(-1, 8 * words_per_column(grid))


def unpack(grid: VoxelGrid, words: Words) -> NDArray[np.bool_]:
    """Return the dense mask (nx, ny, nz) of a set of voxels."""
    require_words_of(grid, words)
    levels = np.unpackbits(_bytes_by_column(grid, words), axis=1, count=grid.shape[2], bitorder="little")
    return levels.view(np.bool_).reshape(grid.shape)


@dataclass(frozen=True)
class VoxelIndex:
    """A set of voxels and their compact ids, in the order of word and bit.

    words uint64 (nx * ny * depth,): word (ix * ny + iy) * depth + iz // 64, bit iz % 64;
    first uint32 (words + 1,): id of the first voxel of each word.
    """

    grid: VoxelGrid
    words: Words
    first: NDArray[np.uint32]

    @classmethod
    def of(cls, grid: VoxelGrid, words: Words) -> VoxelIndex:
        """Number the voxels of a set; raise ValueError for words of another grid, or too many voxels."""
        require_words_of(grid, words)
        first = bits.first_ids(words)
        if words.size >= 1 << 26 and bool((first[1:] < first[:-1]).any()):  # ids have 32 bits
            raise ValueError("words: more than 4,294,967,295 voxels")
        return cls(grid, words, first)

    @property
    def count(self) -> int:
        """Number of voxels in the set."""
        return int(self.first[-1])

    def ijk(self) -> NDArray[np.int32]:
        """Return the indices along x, y, z of all voxels, (count, 3)."""
        return bits.list_voxels(self.words, self.first, self.grid.shape[1], words_per_column(self.grid))

    @cached_property
    def bounds(self) -> NDArray[np.int64]:
        """Smallest box of cells around the set: [x from, x to, y from, y to, z from, z to), int64 (6,)."""
        nx, ny, nz = self.grid.shape
        depth = words_per_column(self.grid)
        used = self.words.reshape(nx, ny, depth)
        levels = np.bitwise_or.reduce(used.reshape(-1, depth), axis=0)
        on = [bool((int(levels[z >> 6]) >> (z & 63)) & 1) for z in range(nz)]
        columns = np.asarray(used.any(axis=2))
        limits: list[int] = []
        for flags in (np.any(columns, axis=1), np.any(columns, axis=0), np.array(on)):
            where = np.flatnonzero(flags)
            limits += [int(where[0]), int(where[-1]) + 1] if where.size else [0, 0]
        return np.array(limits, np.int64)


def runs_of(words: Words, counts: Counts) -> tuple[Runs, Counts, NDArray[np.int64]]:
    """Return runs of equal counts (n, 3) of the voxels of a set, the distinct rows (m, 3), most frequent first, and the
    number of voxels of each (m,)."""
    starts, first = np.empty(len(words), np.uint64), np.empty(len(words) + 1, np.uint32)
    numbers = np.empty(entropy_codes.find_runs(words, counts, starts, first), np.uint32)
    most = 1 << 16
    while True:
        firsts, uses = np.zeros(most, np.int64), np.zeros(most, np.int64)
        slots = np.full(2 * most, entropy_codes.EMPTY, np.int64)
        found = entropy_codes.number_runs(
            words, starts, counts, entropy_codes.Numbering(numbers, firsts, uses, slots)
        )
        if found >= 0:
            break
        most *= 4
    order = np.argsort(-uses[:found], kind="stable")
    ranks = np.empty(found, np.uint32)
    ranks[order] = np.arange(found, dtype=np.uint32)
    codes = np.empty(len(numbers), np.uint16) if found <= 1 << 16 else numbers
    entropy_codes.renumber(numbers, ranks, codes)
    return Runs(starts, first, codes), counts[firsts[:found][order]], uses[order]


def codes_of(index: VoxelIndex, runs: Runs) -> NDArray[np.unsignedinteger[Any]]:
    """Return the number of the row of every voxel, (n,); a new array each time."""
    codes = np.empty(index.count, runs.codes.dtype)
    entropy_codes.voxel_codes(index.words, runs.starts, runs.codes, codes)
    return codes
