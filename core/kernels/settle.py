"""Bring the union of one kind of sensor up to date and account for exactly the voxels whose cover changed.

Arrays that a parallel kernel writes are arguments of their own: Numba takes a write to a member of a tuple for dead
code and leaves it out.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.bits import first_run, popcount
from riglens.core.kernels.codes import CLASS_COUNT, VOXELS
from riglens.core.kernels.jit import inlined, kernel, parallel_kernel
from riglens.core.kernels.palette import Entropies
from riglens.core.kernels.turns import new_turns, take

COLUMNS = VOXELS + 1
"""Columns of the sums: three classes in fixed point, then the number of voxels."""
ROWS_AT_ONCE = 8
"""Rows of the grid that a worker takes."""


@inlined
def _gain(new: np.uint64, old: np.uint64) -> np.int64:
    """How many more bits are set in one word than in the other."""
    return np.int64(popcount(new)) - np.int64(popcount(old))


@inlined
def _unite(stack: np.ndarray, slots: np.ndarray, start: int, seen: np.ndarray) -> None:
    """Write the voxels that any of the slots holds, for as many words as `seen` has."""
    seen[:] = 0
    for slot in slots:
        part = stack[slot, start : start + seen.size]
        for i in range(seen.size):
            seen[i] |= part[i]


@inlined
def _changing(come: np.ndarray, gone: np.ndarray, free: np.ndarray, where: np.ndarray) -> int:
    """List the words in which the union changes. Without a branch: it cannot be foreseen."""
    count = 0
    for w in range(come.size):
        where[count] = w
        count += int((come[w] ^ gone[w]) & free[w] != 0)
    return count


class _Row(NamedTuple):
    """A row of the grid: what only those who come or go may see, the unions of this kind and of the other, and the
    runs of equal entropies."""

    free: np.ndarray
    own: np.ndarray
    other: np.ndarray
    starts: np.ndarray
    first: np.ndarray


@kernel
def _tally(
    row: _Row, come: np.ndarray, gone: np.ndarray, where: np.ndarray, codes: np.ndarray, tallies: np.ndarray
) -> None:
    """Store the new union in the words listed, and count, by code of their entropies, the voxels that this kind (low
    32 bits) and any sensor (high bits) gain; run by run, as all voxels of a run have the same code."""
    for word in where:
        w = np.uint64(word)
        changed, alone = (come[w] ^ gone[w]) & row.free[w], ~row.other[w]
        gained, lost = changed & come[w], changed & gone[w]
        starts, first = row.starts[w], np.int64(row.first[w])
        row.own[w] ^= changed
        while changed != 0:
            run, within = first_run(changed, starts)
            code = np.uint64(codes[np.uint64(first + run)])
            more_any = _gain(gained & within & alone, lost & within & alone)
            tallies[code] += _gain(gained & within, lost & within) + (more_any << np.int64(32))
            changed ^= within


@inlined
def _weigh(tallies: np.ndarray, palette_q: np.ndarray, sums: np.ndarray) -> None:
    """Add to sums (8,) the entropies of the voxels tallied, and their number: fewer than 2^31 of each code, so none
    spills over."""
    for code in range(tallies.size):
        if tallies[code] == 0:
            continue
        own = np.int64(np.int32(tallies[code]))
        any_sensor = (tallies[code] - own) >> np.int64(32)
        for c in range(CLASS_COUNT):
            h_q = np.int64(palette_q[code, c])
            sums[c] += own * h_q
            sums[COLUMNS + c] += any_sensor * h_q
        sums[VOXELS] += own
        sums[COLUMNS + VOXELS] += any_sensor


class Slots(NamedTuple):
    """Rows of the stack, by what becomes of them: int64 (k,) each."""

    arrived: np.ndarray
    leaving: np.ndarray


class Region(NamedTuple):
    """Words outside of which nothing changes: rows of the grid along x, first and end, and of each row of `row_words`
    words the `words` from `first_word` on."""

    first_row: int
    end_row: int
    first_word: int
    words: int
    row_words: int


@inlined
def _take_rows(region: Region, turns: np.ndarray) -> tuple[int, int]:
    """The next rows of a region that nobody has taken, first and end; first >= end when all are taken."""
    first = region.first_row + take(turns) * ROWS_AT_ONCE
    return first, min(first + ROWS_AT_ONCE, region.end_row)


@kernel
def _room(workers: int) -> np.ndarray:
    """Sums of each worker, on cache lines of their own. A function of its own: see `new_turns`."""
    return np.zeros((workers, 16), np.int64)


@parallel_kernel
def find_free(
    stack: np.ndarray,
    staying: np.ndarray,
    region: Region,
    keep: np.ndarray,
    workers: int,
    free: np.ndarray,
) -> None:
    """Write, in a region of free uint64 (words,), the voxels of keep that none of the slots staying (k,) holds."""
    turns = new_turns()
    for _ in numba.prange(workers):
        first, end = _take_rows(region, turns)
        while first < end:
            for ix in range(first, end):
                start = ix * region.row_words + region.first_word
                part = free[start : start + region.words]
                part[:] = keep[start : start + region.words]
                for slot in staying:
                    other = stack[slot, start : start + region.words]
                    for w in range(part.size):
                        part[w] &= ~other[w]
            first, end = _take_rows(region, turns)


@parallel_kernel
def settle(
    stack: np.ndarray,
    union: np.ndarray,
    free: np.ndarray,
    slots: Slots,
    kind: int,
    region: Region,
    entropies: Entropies,
    workers: int,
) -> np.ndarray:
    """Take what the slots hold that leave out of union[kind], and what those hold that arrive into it; those leaving
    are cleared. Returns the change of the sums.

    stack uint64 (slots, words): what the sensor of each slot traverses, of which only informative voxels count; union
    uint64 (2, words): informative voxels covered by all cameras and by all LiDARs; free uint64 (words,): see
    `find_free`, with the other slots of this kind staying; kind: CAMERAS or LIDARS of `riglens.core.kernels.codes`.
    Result int64 (2, 4): change of the sums of this kind, and of any sensor; columns as in COLUMNS. Integers, so neither
    the order of the edits nor the number of threads can matter.
    """
    words, partial, turns = region.words, _room(workers), new_turns()
    for worker in numba.prange(workers):
        come, gone, where = (
            np.empty(words, np.uint64),
            np.empty(words, np.uint64),
            np.empty(words + 1, np.int32),
        )
        tallies = np.zeros(entropies.palette_q.shape[0], np.int64)
        first, end = _take_rows(region, turns)
        while first < end:
            for ix in range(first, end):
                a = ix * region.row_words + region.first_word
                b = a + words
                row = _Row(
                    free[a:b],
                    union[kind, a:b],
                    union[1 - kind, a:b],
                    entropies.starts[a:b],
                    entropies.first[a:b],
                )
                _unite(stack, slots.arrived, a, come)
                _unite(stack, slots.leaving, a, gone)
                count = _changing(come, gone, row.free, where)
                _tally(row, come, gone, where[:count], entropies.codes, tallies)
                for slot in slots.leaving:
                    stack[slot, a:b] = 0
            first, end = _take_rows(region, turns)
        _weigh(tallies, entropies.palette_q, partial[worker])
    change = np.zeros((2, COLUMNS), np.int64)
    for worker in range(workers):  # numpy's own sum takes seconds to compile
        for c in range(2 * COLUMNS):
            change[c // COLUMNS, c % COLUMNS] += partial[worker, c]
    return change
