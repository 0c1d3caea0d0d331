"""Count the voxels that sensors share, for safety reviews.

What how many sensors traverse, and the entropy of what one sensor alone, exactly two, and three or more of some of
them see, by bits that count in parallel. Sums are integers, so neither the order of the sensors nor the number of
workers matters.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.voxels.bits import first_run, popcount
from riglens.core.kernels.voxels.entropy_codes import Entropies

COLUMNS = 4
"""Columns of all sums: the entropies of three classes in units of 2^-32 nat, and one that stays 0, because four numbers
are added at once."""
BLOCK = 1000
"""Columns that a worker takes at a time, in turn with the others: sensors see some sides only."""


class Views(NamedTuple):
    """Voxels that n sensors see.

    stack uint64 (rows, words): sets of voxels, of which slots (n,) are those of the sensors; crowds bool (g, n): sets
    of sensors, for the voxels that three or more of them and no others see; sectors uint8 (columns,); depth: words of a
    column.
    """

    stack: np.ndarray
    slots: np.ndarray
    crowds: np.ndarray
    sectors: np.ndarray
    depth: int


def rows_of_sums(sensors: int, crowds: int) -> int:
    """Return the number of rows of sums: voxels of each sensor alone, i; of exactly two, n + n i + j for i < j, the
    rest stays 0; of three or more of each crowd and no others, n + n² + g."""
    return sensors + sensors * sensors + crowds


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


@lean_inlined
def _weigh(count: np.uint64, entropies_q: np.ndarray, code: np.uint64, sums: np.ndarray) -> None:
    """Add to sums int64 (4,) the entropies of some voxels of one code."""
    h0, h1 = np.uint64(entropies_q[code, 0]), np.uint64(entropies_q[code, 1])
    h2, h3 = np.uint64(entropies_q[code, 2]), np.uint64(entropies_q[code, 3])
    sums[0] += np.int64(count * h0)
    sums[1] += np.int64(count * h1)
    sums[2] += np.int64(count * h2)
    sums[3] += np.int64(count * h3)


@lean_inlined
def _add(voxels: np.uint64, word: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add to sums (4,) the entropies of some voxels of a word, run by run."""
    starts, first = entropies.starts[word], np.int64(entropies.first[word])
    left = voxels
    while left != 0:
        run, within = first_run(left, starts)
        code = np.uint64(entropies.codes[np.uint64(first + run)])
        _weigh(popcount(within), entropies.entropies_q, code, sums)
        left ^= within


@kernel
def total_by_sector(sectors: np.ndarray, depth: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add up all entropies by the sector of their column: sums int64 (s, 4)."""
    for word in range(sectors.size * depth):
        _add(entropies.keep[word], word, entropies, sums[sectors[word // depth]])


@lean_inlined
def _gather(views: Views, word: int, bits: np.uint64, room: np.ndarray) -> int:
    """Write to room (2, n + 1) which of some voxels each sensor sees that sees any, and its number; return how many
    these are."""
    count = 0
    for i in range(views.slots.size):
        seen = views.stack[views.slots[i], word] & bits
        room[0, count], room[1, count] = seen, np.uint64(i)
        count += int(seen != 0)
    return count


@lean_inlined
def _overlaps(own: np.ndarray) -> tuple[np.uint64, np.uint64, np.uint64]:
    """Return the voxels that exactly one sensor, exactly two, and three or more see, of words own (k,)."""
    once, twice, thrice = np.uint64(0), np.uint64(0), np.uint64(0)
    for i in range(own.size):
        thrice |= twice & own[i]
        twice |= once & own[i]
        once |= own[i]
    return once & ~twice, twice & ~thrice, thrice


@lean_inlined
def _add_twos(
    own: np.ndarray,
    who: np.ndarray,
    n: int,
    two: np.uint64,
    word: int,
    entropies: Entropies,
    sums: np.ndarray,
) -> None:
    """Add to sums (rows, 4) voxels that exactly two sensors see."""
    for i in range(own.size):
        first = own[i] & two
        if first != 0:
            for j in range(i + 1, own.size):
                if first & own[j] != 0:
                    row = n * (1 + np.int64(who[i])) + np.int64(who[j])
                    _add(first & own[j], word, entropies, sums[row])


@lean_inlined
def _add_crowds(
    own: np.ndarray,
    who: np.ndarray,
    crowds: np.ndarray,
    many: np.uint64,
    word: int,
    entropies: Entropies,
    sums: np.ndarray,
) -> None:
    """Add to sums (rows, 4) the voxels of `many`, seen by three sensors or more, that no sensor outside of each crowd
    sees."""
    n = crowds.shape[1]
    for g in range(crowds.shape[0]):
        left = many
        for i in range(own.size):
            if not crowds[g, who[i]]:
                left &= ~own[i]
        _add(left, word, entropies, sums[n * (1 + n) + g])


@lean
def _tally_columns(
    columns: tuple[int, int],
    views: Views,
    entropies: Entropies,
    room: np.ndarray,
    sums: np.ndarray,
) -> None:
    """As `tally_views`, of some columns, first to second number: sums (s, rows, 4), room (2, n + 1) to work in."""
    n = views.crowds.shape[1]
    for column in range(columns[0], columns[1]):
        rows = sums[views.sectors[column]]
        for word in range(column * views.depth, (column + 1) * views.depth):
            k = _gather(views, word, entropies.keep[word], room)
            own, who = room[0, :k], room[1, :k]
            one, two, many = _overlaps(own)
            if one != 0:
                for i in range(k):
                    _add(own[i] & one, word, entropies, rows[who[i]])
            if two != 0:
                _add_twos(own, who, n, two, word, entropies, rows)
            if many != 0:
                _add_crowds(own, who, views.crowds, many, word, entropies, rows)


@parallel_kernel
def tally_views(views: Views, entropies: Entropies, sums: np.ndarray) -> None:
    """Add to sums int64 (workers, s, rows, 4) what sensors see of each sector, by who does: rows as `rows_of_sums`."""
    workers, columns, n = sums.shape[0], views.sectors.size, views.crowds.shape[1]
    for worker in numba.prange(workers):
        room = np.zeros((2, n + 1), np.uint64)
        for begin in range(worker * BLOCK, columns, workers * BLOCK):
            block = (begin, min(begin + BLOCK, columns))
            _tally_columns(block, views, entropies, room, sums[worker])
