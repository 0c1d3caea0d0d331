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

COLUMNS = VOXELS + 1
"""Columns of the sums: three classes in fixed point, then the number of voxels."""
MANY = 0.2
"""Where more of the words of a row may change, going through all of them is faster than picking them out."""


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
def _differing(come: np.ndarray, gone: np.ndarray, where: np.ndarray) -> int:
    """List the words that differ; only there can the union change. Without a branch: it cannot be foreseen."""
    count = 0
    for w in range(come.size):
        where[count] = w
        count += int(come[w] != gone[w])
    return count


class _Row(NamedTuple):
    """A row of the grid: the stack and its word that the row starts with, what counts, the unions of this kind and
    of the other, and the runs of equal entropies."""

    stack: np.ndarray
    start: int
    keep: np.ndarray
    own: np.ndarray
    other: np.ndarray
    starts: np.ndarray
    first: np.ndarray


@inlined
def _renew_all(row: _Row, staying: np.ndarray, new: np.ndarray, where: np.ndarray) -> int:
    """Make the voxels that arrive, in `new`, the new union in all words; lists those that change."""
    for slot in staying:
        part = row.stack[slot, row.start : row.start + new.size]
        for i in range(new.size):
            new[i] |= part[i]
    for i in range(new.size):
        new[i] &= row.keep[i]
    return _differing(new, row.own, where)


@inlined
def _renew_some(row: _Row, staying: np.ndarray, new: np.ndarray, where: np.ndarray, count: int) -> int:
    """The same in the first `count` words that are listed; the others cannot change."""
    changed = 0
    for i in range(np.uint64(count)):
        word = where[i]
        w = np.uint64(word)
        seen = new[w]
        for slot in staying:
            seen |= row.stack[slot, np.uint64(row.start) + w]
        seen &= row.keep[w]
        new[w], where[changed] = seen, word
        changed += int(seen != row.own[w])
    return changed


@kernel
def _tally(row: _Row, new: np.ndarray, where: np.ndarray, codes: np.ndarray, tallies: np.ndarray) -> None:
    """Store the new union in the words listed, and count, by code of their entropies, the voxels that this kind (low
    32 bits) and any sensor (high bits) gain; run by run, as all voxels of a run have the same code."""
    for word in where:
        w = np.uint64(word)
        gained, lost, alone = new[w] & ~row.own[w], row.own[w] & ~new[w], ~row.other[w]
        starts, first = row.starts[w], np.int64(row.first[w])
        row.own[w] = new[w]
        changed = gained | lost
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
    staying: np.ndarray
    leaving: np.ndarray


class Region(NamedTuple):
    """Words outside of which nothing changes: rows int64 (n,) of the grid along x, in the order in which the workers
    take turns with them; of each row of `row_words` words the `words` from `first_word` on."""

    rows: np.ndarray
    first_word: int
    words: int
    row_words: int


@parallel_kernel
def settle(
    stack: np.ndarray,
    union: np.ndarray,
    slots: Slots,
    kind: int,
    region: Region,
    entropies: Entropies,
    workers: int,
) -> np.ndarray:
    """Make union[kind] what the slots of that kind hold, without those leaving, which are cleared; returns the
    change of the sums.

    stack uint64 (slots, words): what the sensor of each slot traverses, of which only informative voxels count; union
    uint64 (2, words): informative voxels covered by all cameras and by all LiDARs; kind: CAMERAS or LIDARS of
    `riglens.core.kernels.codes`; slots: those of this kind. Result int64 (2, 4): change of
    the sums of this kind, and of any sensor; columns as in COLUMNS. Integers, so neither the order of the edits nor
    the number of threads can matter.
    """
    words = region.words
    partial = np.zeros((workers, 16), np.int64)  # cache lines of its own for every worker
    for worker in numba.prange(workers):
        new, gone, where = (
            np.empty(words, np.uint64),
            np.empty(words, np.uint64),
            np.empty(words + 1, np.int32),
        )
        sums, tallies = partial[worker], np.zeros(entropies.palette_q.shape[0], np.int64)
        for i in range(worker, region.rows.size, workers):
            start = region.rows[i] * region.row_words + region.first_word
            end = start + words
            row = _Row(
                stack,
                start,
                entropies.keep[start:end],
                union[kind, start:end],
                union[1 - kind, start:end],
                entropies.starts[start:end],
                entropies.first[start:end],
            )
            _unite(stack, slots.arrived, start, new)
            _unite(stack, slots.leaving, start, gone)
            count = _differing(new, gone, where)
            if count > MANY * words:
                count = _renew_all(row, slots.staying, new, where)
            else:
                count = _renew_some(row, slots.staying, new, where, count)
            _tally(row, new, where[:count], entropies.codes, tallies)
            for slot in slots.leaving:
                stack[slot, start:end] = 0
        _weigh(tallies, entropies.palette_q, sums)
    change: np.ndarray = partial.sum(axis=0)[: 2 * COLUMNS].reshape(2, COLUMNS)
    return change
