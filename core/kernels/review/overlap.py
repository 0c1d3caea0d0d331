"""Count the voxels that sensors share, for safety reviews.

What how many sensors traverse, and the entropy of what one sensor alone, exactly two, and three or more of some of
them see, by bits that count in parallel, from scratch and after a move. Sums are integers, so neither the order of
the sensors and of their moves nor the number of workers matters.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.voxels.bits import FULL_WORD, first_run, popcount
from riglens.core.kernels.voxels.entropy_codes import Entropies

COLUMNS = 4
"""Columns of all sums: the entropies of three classes in units of 2^-32 nat, and one that stays 0, because four numbers
are added at once."""
BLOCK = 1000
"""Columns that a worker takes at a time, in turn with the others: a camera changes one side only."""
NOBODY = -1
"""In the place of a sensor."""


class Views(NamedTuple):
    """Voxels that some of n sensors see.

    stack uint64 (rows, words): sets of voxels, of which slots (k,) are those of the sensors at places (k,) of the rig;
    crowds bool (g, n): sets of sensors, for the voxels that three or more of them and no others see; sectors
    uint8 (columns,); depth: words of a column.
    """

    stack: np.ndarray
    slots: np.ndarray
    places: np.ndarray
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
    """Add to sums int64 (4,) the entropies of some voxels of one code; count: less than none is modulo 2^64."""
    h0, h1 = np.uint64(entropies_q[code, 0]), np.uint64(entropies_q[code, 1])
    h2, h3 = np.uint64(entropies_q[code, 2]), np.uint64(entropies_q[code, 3])
    sums[0] += np.int64(count * h0)
    sums[1] += np.int64(count * h1)
    sums[2] += np.int64(count * h2)
    sums[3] += np.int64(count * h3)


class Signed(NamedTuple):
    """Sign of a word's voxels: those of plus are added, the others subtracted."""

    word: int
    plus: np.uint64
    entropies: Entropies


@lean_inlined
def _add(voxels: np.uint64, signed: Signed, sums: np.ndarray) -> None:
    """Add to sums (4,) the entropies of some voxels, run by run."""
    entropies = signed.entropies
    starts, first = entropies.starts[signed.word], np.int64(entropies.first[signed.word])
    left = voxels
    while left != 0:
        run, within = first_run(left, starts)
        count = popcount(within & signed.plus) - popcount(within & ~signed.plus)
        if count != 0:
            code = np.uint64(entropies.codes[np.uint64(first + run)])
            _weigh(count, entropies.entropies_q, code, sums)
        left ^= within


@kernel
def total_by_sector(sectors: np.ndarray, depth: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add up all entropies by the sector of their column: sums int64 (s, 4)."""
    for word in range(sectors.size * depth):
        _add(entropies.keep[word], Signed(word, FULL_WORD, entropies), sums[sectors[word // depth]])


@lean_inlined
def _gather(views: Views, word: int, bits: np.uint64, room: np.ndarray) -> int:
    """Write to room (2, n + 1) which of some voxels each sensor sees that sees any, and its place; return their
    number."""
    count = 0
    for i in range(views.slots.size):
        seen = views.stack[views.slots[i], word] & bits
        room[0, count], room[1, count] = seen, views.places[i]
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
    signed: Signed,
    sums: np.ndarray,
) -> None:
    """Add to sums (rows, 4) voxels that exactly two sensors see."""
    for i in range(own.size):
        first = own[i] & two
        if first != 0:
            for j in range(i + 1, own.size):
                if first & own[j] != 0:
                    a, b = np.int64(who[i]), np.int64(who[j])
                    row = n * (1 + min(a, b)) + max(a, b)
                    _add(first & own[j], signed, sums[row])


@lean_inlined
def _add_crowds(
    own: np.ndarray,
    who: np.ndarray,
    crowds: np.ndarray,
    without: int,
    many: np.uint64,
    signed: Signed,
    sums: np.ndarray,
) -> None:
    """Add to sums (rows, 4) the voxels of `many`, seen by three sensors or more, that no sensor outside of each crowd
    sees; crowds that hold the sensor `without` are skipped."""
    n = crowds.shape[1]
    for g in range(crowds.shape[0]):
        left = many
        if without == NOBODY or not crowds[g, without]:
            for i in range(own.size):
                if not crowds[g, who[i]]:
                    left &= ~own[i]
            row = n * (1 + n) + g
            _add(left, signed, sums[row])


@lean_inlined
def _share(
    own: np.ndarray,
    who: np.ndarray,
    crowds: np.ndarray,
    without: int,
    bits: np.uint64,
    signed: Signed,
    sums: np.ndarray,
) -> None:
    """Add to sums (rows, 4) some voxels of a word by the sensors that see them, who (k,) seeing own (k,) of them;
    unseen ones belong to the sensor `without`, if any."""
    one, two, many = _overlaps(own)
    if without != NOBODY:
        _add(bits & ~(one | two | many), signed, sums[without])
    if one != 0:
        for i in range(own.size):
            _add(own[i] & one, signed, sums[who[i]])
    if two != 0:
        _add_twos(own, who, crowds.shape[1], two, signed, sums)
    if many != 0:
        _add_crowds(own, who, crowds, without, many, signed, sums)


@lean
def _tally_columns(
    columns: tuple[int, int],
    views: Views,
    entropies: Entropies,
    room: np.ndarray,
    sums: np.ndarray,
) -> None:
    """As `tally_views`, of some columns, first to second number: sums (s, rows, 4), room (2, n + 1) to work in."""
    for column in range(columns[0], columns[1]):
        rows = sums[views.sectors[column]]
        for word in range(column * views.depth, (column + 1) * views.depth):
            keep = entropies.keep[word]
            k = _gather(views, word, keep, room)
            if k != 0:
                signed = Signed(word, FULL_WORD, entropies)
                _share(room[0, :k], room[1, :k], views.crowds, NOBODY, keep, signed, rows)


@parallel_kernel
def tally_views(views: Views, entropies: Entropies, sums: np.ndarray) -> None:
    """Add to sums int64 (workers, s, rows, 4) what sensors see of each sector, by who does: rows as `rows_of_sums`."""
    workers, columns, n = sums.shape[0], views.sectors.size, views.crowds.shape[1]
    for worker in numba.prange(workers):
        room = np.zeros((2, n + 1), np.uint64)
        for begin in range(worker * BLOCK, columns, workers * BLOCK):
            block = (begin, min(begin + BLOCK, columns))
            _tally_columns(block, views, entropies, room, sums[worker])


@lean_inlined
def _change_word(
    word: int,
    m: int,
    moved: np.ndarray,
    views: Views,
    entropies: Entropies,
    before: np.ndarray,
    room: np.ndarray,
    rows: np.ndarray,
) -> None:
    """As `change_views`, of one word and one of the sensors that moved: rows (rows, 4) of its sector."""
    now = views.stack[moved[m, 1], word] & entropies.keep[word]
    bits = now ^ before[m, word]
    if bits != 0:
        k = _gather(views, word, bits, room)
        for other in range(moved.shape[0]):
            if other != m and before[other, word] & bits != 0:
                room[0, k], room[1, k] = before[other, word] & bits, moved[other, 0]
                k += 1
        signed = Signed(word, now, entropies)
        _share(room[0, :k], room[1, :k], views.crowds, moved[m, 0], bits, signed, rows)
        before[m, word] = now


@lean
def _change_columns(
    columns: tuple[int, int],
    moved: np.ndarray,
    views: Views,
    entropies: Entropies,
    before: np.ndarray,
    room: np.ndarray,
    sums: np.ndarray,
) -> None:
    """As `change_views`, of some columns, first to second number: sums (m, s, rows, 4), room (2, n + 1) to work in."""
    for column in range(columns[0], columns[1]):
        sector = views.sectors[column]
        for word in range(column * views.depth, (column + 1) * views.depth):
            for m in range(moved.shape[0]):
                _change_word(word, m, moved, views, entropies, before, room, sums[m, sector])


@parallel_kernel
def change_views(
    moved: np.ndarray, views: Views, entropies: Entropies, before: np.ndarray, sums: np.ndarray
) -> None:
    """Add up the current voxels of moved sensors, one after the other, less their previous ones, by the other sensors
    that see them.

    moved int64 (m, 2): their places and their rows of the stack; views: of all others; before uint64 (m, words): their
    sets until now, of what counts, which become those of now; sums int64 (workers, m, s, rows, 4): rows as
    `rows_of_sums`, voxels of one sensor alone in its own row, and crowds that hold it stay unchanged.
    """
    workers, columns, n = sums.shape[0], views.sectors.size, views.crowds.shape[1]
    for worker in numba.prange(workers):
        room = np.zeros((2, n + 1), np.uint64)
        for begin in range(worker * BLOCK, columns, workers * BLOCK):
            block = (begin, min(begin + BLOCK, columns))
            _change_columns(block, moved, views, entropies, before, room, sums[worker])
