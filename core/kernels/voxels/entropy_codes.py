"""Entropies of the voxels, run by run: neighbours in a column often share one combination of counts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.runtime.jit import inlined, kernel
from riglens.core.kernels.voxels.bits import lowest_bit

EMPTY = -1


class Runs(NamedTuple):
    """Runs of neighbouring voxels of a word that share one combination of counts.

    starts uint64 (words,): the first voxel of each run; first uint32 (words + 1,): number of runs before each word;
    codes uint16 or uint32 (runs,): the row of the palette of each run.
    """

    starts: np.ndarray
    first: np.ndarray
    codes: np.ndarray


class Entropies(NamedTuple):
    """Entropies of the informative voxels: keep uint64 (words,), the voxels that have any; their runs, as in `Runs`;
    entropies_q uint32 (m, >= 3): h of the three classes in units of 2^-32 nat, by code."""

    keep: np.ndarray
    starts: np.ndarray
    first: np.ndarray
    codes: np.ndarray
    entropies_q: np.ndarray


class Numbering(NamedTuple):
    """Output of `number_runs`: numbers uint32 (runs,), the number of each run's combination; firsts, uses int64
    (most,): first row and number of voxels of each combination; slots int64 (power of two,), filled with EMPTY: the
    open-addressing table."""

    numbers: np.ndarray
    firsts: np.ndarray
    uses: np.ndarray
    slots: np.ndarray


@inlined
def _same(rows: np.ndarray, a: int, b: int) -> bool:
    return bool(rows[a, 0] == rows[b, 0] and rows[a, 1] == rows[b, 1] and rows[a, 2] == rows[b, 2])


@kernel
def find_runs(words: np.ndarray, rows: np.ndarray, starts: np.ndarray, first: np.ndarray) -> int:
    """Mark where runs of equal rows begin; return the number of runs.

    words uint64 (n,): voxels in use; rows (voxels, 3) in their order; starts uint64 (n,): the voxels whose row
    differs from that of the voxel before in the same word; first uint32 (n + 1,): runs before each word.
    """
    row, runs = 0, 0
    for w in range(words.size):
        first[w] = runs
        bits, begun = words[w], np.uint64(0)
        while bits != 0:
            lowest = bits & (~bits + np.uint64(1))
            if begun == 0 or not _same(rows, row - 1, row):
                begun |= lowest
                runs += 1
            row += 1
            bits ^= lowest
        starts[w] = begun
    first[words.size] = runs
    return runs


@inlined
def _number_of(rows: np.ndarray, row: int, found: int, table: Numbering) -> int:
    """Return the number of a row among the `found` distinct ones, or `found` for one not met before; it is then
    entered."""
    firsts, slots = table.firsts, table.slots
    last = slots.size - 1
    a, b, c = np.uint64(rows[row, 0]), np.uint64(rows[row, 1]), np.uint64(rows[row, 2])
    mixed = (a * np.uint64(73856093)) ^ (b * np.uint64(19349663)) ^ (c * np.uint64(83492791))
    slot = np.int64((mixed ^ (mixed >> np.uint64(15))) & np.uint64(last))
    while slots[slot] != EMPTY and not _same(rows, firsts[slots[slot]], row):
        slot = (slot + 1) & last
    if slots[slot] == EMPTY and found < firsts.size:
        slots[slot], firsts[found] = found, row
        return found
    return int(slots[slot])


@kernel
def number_runs(words: np.ndarray, starts: np.ndarray, rows: np.ndarray, table: Numbering) -> int:
    """Number runs with equal rows equally, in the order of their first appearance; return the number of different rows.

    words, starts, rows as in `find_runs`. Returns -1 when there are more than table.firsts can hold.
    """
    row, run, found = 0, -1, 0
    for w in range(words.size):
        bits = words[w]
        while bits != 0:
            if (starts[w] >> lowest_bit(bits)) & np.uint64(1) != 0:
                number = _number_of(rows, row, found, table)
                if number == EMPTY:
                    return -1
                found = max(found, number + 1)
                run += 1
                table.numbers[run] = number
            table.uses[table.numbers[run]] += 1
            row += 1
            bits &= bits - np.uint64(1)
    return found


@kernel
def renumber(numbers: np.ndarray, ranks: np.ndarray, codes: np.ndarray) -> None:
    """Write codes (n,) = ranks[numbers], without a temporary array."""
    for row in range(numbers.size):
        codes[row] = ranks[numbers[row]]


@kernel
def voxel_codes(words: np.ndarray, starts: np.ndarray, codes: np.ndarray, voxels: np.ndarray) -> None:
    """The code of every voxel, voxels (n,), from those of the runs."""
    row, run = 0, -1
    for w in range(words.size):
        bits = words[w]
        while bits != 0:
            if (starts[w] >> lowest_bit(bits)) & np.uint64(1) != 0:
                run += 1
            voxels[row] = codes[run]
            row += 1
            bits &= bits - np.uint64(1)
