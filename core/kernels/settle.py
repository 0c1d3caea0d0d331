"""Bring the union of one kind of sensor up to date and account for exactly the voxels whose cover changed."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.bits import first_run, popcount
from riglens.core.kernels.jit import inlined, kernel, parallel_kernel

COLUMNS = 4
"""Sums are kept side by side: three classes in fixed point, then the number of voxels."""
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
        for c in range(3):
            h_q = np.int64(palette_q[code, c])
            sums[c] += own * h_q
            sums[COLUMNS + c] += any_sensor * h_q
        sums[COLUMNS - 1] += own
        sums[2 * COLUMNS - 1] += any_sensor


class Slots(NamedTuple):
    """Rows of the stack, by what becomes of them: int64 (k,) each."""

    arrived: np.ndarray
    staying: np.ndarray
    leaving: np.ndarray


@parallel_kernel
def settle(
    stack: np.ndarray,
    slots: Slots,
    union: np.ndarray,
    kind: int,
    keep: np.ndarray,
    starts: np.ndarray,
    first: np.ndarray,
    codes: np.ndarray,
    palette_q: np.ndarray,
    rows: np.ndarray,
    first_word: int,
    words: int,
    row_words: int,
    workers: int,
) -> np.ndarray:
    """Make union[kind] what the slots of that kind hold, without those leaving, which are cleared; returns the change
    of the sums.

    stack uint64 (slots, words): voxels that sensors traverse, of which only those in `keep` count; union (2, words):
    voxels covered by all cameras and by all LiDARs; starts, first, codes, palette_q: entropies of the voxels in
    `keep`, run by run (see `riglens.core.metric.entropy`); rows (n,), first_word, words: rows of the grid, and words of
    each, outside of which nothing changes; the workers take turns with the rows. Result int64 (2, 4): this kind, and
    any sensor; columns as in COLUMNS. Integers, so the order of the edits and the number of threads cannot matter.
    """
    partial = np.zeros((workers, 16), np.int64)  # cache lines of its own for every worker
    for worker in numba.prange(workers):
        new, gone, where = (
            np.empty(words, np.uint64),
            np.empty(words, np.uint64),
            np.empty(words + 1, np.int32),
        )
        sums, tallies = partial[worker], np.zeros(palette_q.shape[0], np.int64)
        for i in range(worker, rows.size, workers):
            start = rows[i] * row_words + first_word
            end = start + words
            own, other = union[kind, start:end], union[1 - kind, start:end]
            row = _Row(stack, start, keep[start:end], own, other, starts[start:end], first[start:end])
            _unite(stack, slots.arrived, start, new)
            _unite(stack, slots.leaving, start, gone)
            count = _differing(new, gone, where)
            if count > MANY * words:
                count = _renew_all(row, slots.staying, new, where)
            else:
                count = _renew_some(row, slots.staying, new, where, count)
            _tally(row, new, where[:count], codes, tallies)
            for slot in slots.leaving:
                stack[slot, start:end] = 0
        _weigh(tallies, palette_q, sums)
    change: np.ndarray = partial.sum(axis=0)[: 2 * COLUMNS].reshape(2, COLUMNS)
    return change
