"""Count the voxels that sensors share, for safety reviews, by bits that count in parallel.

Sums are integers, so neither the order of the sensors nor the number of workers matters.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import kernel, parallel_kernel
from riglens.core.kernels.voxels.bits import first_run, popcount
from riglens.core.kernels.voxels.entropy_codes import Entropies

COLUMNS = 4
"""Columns of all sums: the entropies of three classes in units of 2^-32 nat, and one that stays 0, because four numbers
are added at once."""


@parallel_kernel
def covered_levels(
    stack: np.ndarray, slots: np.ndarray, keep: np.ndarray, workers: int, levels: np.ndarray
) -> None:
    """Write the voxels within keep (words,) that at least 1, 2, 3 of the sets of slots (n,) hold: levels uint64
    (3, words). stack uint64 (rows, words): sets of voxels."""
    size = keep.size
    for worker in numba.prange(workers):
        for word in range(size * worker // workers, size * (worker + 1) // workers):
            once, twice, thrice, within = np.uint64(0), np.uint64(0), np.uint64(0), keep[word]
            if within != 0:
                for i in range(slots.size):
                    bits = stack[slots[i], word] & within
                    thrice |= twice & bits
                    twice |= once & bits
                    once |= bits
            levels[0, word], levels[1, word], levels[2, word] = once, twice, thrice


@kernel
def sum_by_sector(
    words: np.ndarray, sectors: np.ndarray, depth: int, entropies: Entropies, sums: np.ndarray
) -> None:
    """Add up the entropies of a set of voxels that count, run by run, by the sector of their column: words uint64
    (words,), depth of them for each column; sectors uint8 (columns,); sums int64 (s, 4)."""
    for word in range(words.size):
        left, starts, first = words[word], entropies.starts[word], np.int64(entropies.first[word])
        row = sums[sectors[word // depth]]
        while left != 0:
            run, within = first_run(left, starts)
            count, code = np.int64(popcount(within)), np.int64(entropies.codes[first + run])
            for column in range(COLUMNS):
                row[column] += count * np.int64(entropies.entropies_q[code, column])
            left ^= within
