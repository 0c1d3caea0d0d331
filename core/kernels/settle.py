"""Bring the union of one kind of sensor up to date and account for exactly the voxels whose cover changed."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from core.kernels.bits import first_run, popcount
from core.kernels.jit import inlined, kernel, parallel_kernel

COLUMNS = 4
"""Sums are kept side by side: three classes in fixed point, then the number of voxels."""


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
    """A row of the grid: what arrives, what counts, the unions of both kinds, and the runs of equal entropies."""

    come: np.ndarray
    keep: np.ndarray
    own: np.ndarray
    other: np.ndarray
    starts: np.ndarray
    first: np.ndarray


@inlined
def _note_changes(
    row: _Row,
    stack: np.ndarray,
    staying: np.ndarray,
    start: int,
    where: np.ndarray,
    changes: np.ndarray,
    sums: np.ndarray,
) -> int:
    """Bring the union up to date in the words `where`, count the voxels in sums (8,), and note what changes.

    changes uint64 (words + 1, 5): voxels gained, voxels lost, voxels that the other kind does not see, starts of
    runs, number of the first run. Without a branch, as before.
    """
    count, own_gain, any_gain = 0, np.int64(0), np.int64(0)
    for word in where:
        w = np.uint64(word)
        new = row.come[w]
        for slot in staying:
            new |= stack[slot, np.uint64(start) + w]
        new &= row.keep[w]
        old, alone = row.own[w], ~row.other[w]
        row.own[w] = new
        own_gain += _gain(new, old)
        any_gain += _gain(new & alone, old & alone)
        changes[count, 0], changes[count, 1], changes[count, 2] = new & ~old, old & ~new, alone
        changes[count, 3], changes[count, 4] = row.starts[w], np.uint64(row.first[w])
        count += int(old != new)
    sums[3] += own_gain
    sums[7] += any_gain
    return count


@kernel
def _tally(changes: np.ndarray, count: int, codes: np.ndarray, tallies: np.ndarray) -> None:
    """Count, by code of their entropies, the voxels that this kind (low 32 bits) and any sensor (high bits) gain in
    the changed words; run by run, as all voxels of a run have the same code."""
    for i in range(np.uint64(count)):
        gained, lost, alone, starts = changes[i, 0], changes[i, 1], changes[i, 2], changes[i, 3]
        changed = gained | lost
        while changed != 0:
            run, within = first_run(changed, starts)
            code = np.uint64(codes[np.uint64(np.int64(changes[i, 4]) + run)])
            more_any = _gain(gained & within & alone, lost & within & alone)
            tallies[code] += _gain(gained & within, lost & within) + (more_any << np.int64(32))
            changed ^= within


@inlined
def _weigh(tallies: np.ndarray, palette_q: np.ndarray, sums: np.ndarray) -> None:
    """Add to sums (8,) the entropies of the voxels tallied: fewer than 2^31 of each code, so none spills over."""
    for code in range(tallies.size):
        own = np.int64(np.int32(tallies[code]))
        any_sensor = (tallies[code] - own) >> np.int64(32)
        for c in range(3):
            h_q = np.int64(palette_q[code, c])
            sums[c] += own * h_q
            sums[COLUMNS + c] += any_sensor * h_q


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
    window: np.ndarray,
    row_words: int,
    workers: int,
) -> np.ndarray:
    """Make union[kind] what the slots of that kind hold, without those leaving, which are cleared; returns the change
    of the sums.

    stack uint64 (slots, words): voxels that sensors traverse, of which only those in `keep` count; union (2, words):
    voxels covered by all cameras and by all LiDARs; starts, first, codes, palette_q: entropies of the voxels in
    `keep`, run by run (see `core.metric.entropy`); window: rows x0..x1-1 and words w0..w1-1 of each row outside of
    which nothing changes. Result int64 (2, 4): this kind, and any sensor; columns as in COLUMNS. Integers, so the
    order of the edits and the number of threads cannot matter.
    """
    partial = np.zeros((workers, 16), np.int64)  # cache lines of its own for every worker
    for worker in numba.prange(workers):
        words = window[3] - window[2]
        come, gone = np.empty(words, np.uint64), np.empty(words, np.uint64)
        where, changes = np.empty(words + 1, np.int32), np.empty((words + 1, 5), np.uint64)
        sums, tallies = partial[worker], np.zeros(palette_q.shape[0], np.int64)
        for x in range(window[0] + worker, window[1], workers):
            start, end = x * row_words + window[2], x * row_words + window[3]
            _unite(stack, slots.arrived, start, come)
            _unite(stack, slots.leaving, start, gone)
            differing = _differing(come, gone, where)
            own, other = union[kind, start:end], union[1 - kind, start:end]
            row = _Row(come, keep[start:end], own, other, starts[start:end], first[start:end])
            count = _note_changes(row, stack, slots.staying, start, where[:differing], changes, sums)
            _tally(changes, count, codes, tallies)
            for slot in slots.leaving:
                stack[slot, start:end] = 0
        _weigh(tallies, palette_q, sums)
    change: np.ndarray = partial.sum(axis=0)[: 2 * COLUMNS].reshape(2, COLUMNS)
    return change
