"""Bring the union of one kind of sensor up to date and account for exactly the voxels whose cover changed."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from core.kernels.bits import first_run, popcount
from core.kernels.jit import inlined, kernel, parallel_kernel

BATCH = 1 << 15
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
def _account(
    changes: np.ndarray, count: int, codes: np.ndarray, palette_q: np.ndarray, sums: np.ndarray
) -> None:
    """Add to sums (8,) the entropies that this kind and any sensor gain in the changed words, run by run.

    All voxels of a run have the same entropies. The sums are made in doubles, which is quicker, and exact: they are
    whole numbers below 2^53 for up to 2^21 voxels, that is 2^15 words a call.
    """
    own0, own1, own2, any0, any1, any2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        gained, lost, alone, starts = changes[i, 0], changes[i, 1], changes[i, 2], changes[i, 3]
        changed = gained | lost
        while changed != 0:
            run, within = first_run(changed, starts)
            code = codes[np.int64(changes[i, 4]) + run]
            more = float(_gain(gained & within, lost & within))
            more_any = float(_gain(gained & within & alone, lost & within & alone))
            h0, h1 = float(np.int64(palette_q[code, 0])), float(np.int64(palette_q[code, 1]))
            h2 = float(np.int64(palette_q[code, 2]))
            own0, own1, own2 = own0 + more * h0, own1 + more * h1, own2 + more * h2
            any0, any1, any2 = any0 + more_any * h0, any1 + more_any * h1, any2 + more_any * h2
            changed ^= within
    for column, value in ((0, own0), (1, own1), (2, own2), (4, any0), (5, any1), (6, any2)):
        sums[column] += np.int64(value)


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
        sums = partial[worker]
        for x in range(window[0] + worker, window[1], workers):
            start, end = x * row_words + window[2], x * row_words + window[3]
            _unite(stack, slots.arrived, start, come)
            _unite(stack, slots.leaving, start, gone)
            differing = _differing(come, gone, where)
            own, other = union[kind, start:end], union[1 - kind, start:end]
            row = _Row(come, keep[start:end], own, other, starts[start:end], first[start:end])
            count = _note_changes(row, stack, slots.staying, start, where[:differing], changes, sums)
            for done in range(0, count, BATCH):
                _account(changes[done:], min(BATCH, count - done), codes, palette_q, sums)
            for slot in slots.leaving:
                stack[slot, start:end] = 0
    change: np.ndarray = partial.sum(axis=0)[: 2 * COLUMNS].reshape(2, COLUMNS)
    return change
