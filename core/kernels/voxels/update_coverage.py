"""Update the union of one kind of sensor and count exactly the voxels whose coverage changed.

Arrays that a parallel kernel writes are arguments of their own: Numba removes a write to a member of a tuple as dead
code.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.codes import CLASS_COUNT, VOXELS
from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel
from riglens.core.kernels.runtime.work_stealing import new_counter, take
from riglens.core.kernels.voxels.bits import first_run, popcount
from riglens.core.kernels.voxels.entropy_codes import Entropies

COLUMNS = VOXELS + 1
"""Columns of the sums: three classes in fixed point, then the number of voxels."""
ROWS_AT_ONCE = 8
"""Rows of the grid that a worker takes."""


@inlined
def _gain(new: np.uint64, old: np.uint64) -> np.int64:
    """Return the number of bits set in one word minus that in the other."""
    return np.int64(popcount(new)) - np.int64(popcount(old))


@inlined
def _seen(stack: np.ndarray, slots: np.ndarray, start: int, room: np.ndarray) -> np.ndarray:
    """Return the voxels that any of some rows of a stack holds, for as many words as there is room: its own words,
    where it is one."""
    words = room.size
    if slots.size == 1:
        return stack[slots[0], start : start + words]
    room[:] = 0
    for slot in slots:
        part = stack[slot, start : start + words]
        for i in range(words):
            room[i] |= part[i]
    return room


@inlined
def _changing(come: np.ndarray, gone: np.ndarray, free: np.ndarray, where: np.ndarray) -> int:
    """List the words in which the union changes. Without a branch, which could not be predicted."""
    count = 0
    for w in range(come.size):
        where[count] = w
        count += int((come[w] ^ gone[w]) & free[w] != 0)
    return count


@inlined
def _seen_at(
    where: np.ndarray, union: np.ndarray, kinds: np.ndarray, start: int, room: np.ndarray
) -> np.ndarray:
    """As `_seen`, of some rows of the union (kinds, words), but only in the words listed, int32 (n,): few change."""
    if kinds.size == 1:
        return union[kinds[0], start : start + room.size]
    for word in where:
        w = np.uint64(word)
        room[w] = 0
        for kind in kinds:
            room[w] |= union[kind, np.uint64(start) + w]
    return room


class _Row(NamedTuple):
    """A row of the grid: what only those who come or go may see, the unions of this kind and of the other kinds, and
    the runs of equal entropies."""

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
def _weigh(tallies: np.ndarray, entropies_q: np.ndarray, sums: np.ndarray) -> None:
    """Add to sums (8,) the entropies of the voxels tallied, and their number: fewer than 2^31 of each code, so none
    spills over."""
    for code in range(tallies.size):
        if tallies[code] == 0:
            continue
        own = np.int64(np.int32(tallies[code]))
        any_sensor = (tallies[code] - own) >> np.int64(32)
        for c in range(CLASS_COUNT):
            h_q = np.int64(entropies_q[code, c])
            sums[c] += own * h_q
            sums[COLUMNS + c] += any_sensor * h_q
        sums[VOXELS] += own
        sums[COLUMNS + VOXELS] += any_sensor


class Slots(NamedTuple):
    """Rows of the stack that arrive and that leave, int64 (k,) each."""

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
def _take_rows(region: Region, counter: np.ndarray) -> tuple[int, int]:
    """Return the next free rows of a region, first and end; first >= end when all are taken."""
    first = region.first_row + take(counter) * ROWS_AT_ONCE
    return first, min(first + ROWS_AT_ONCE, region.end_row)


@kernel
def _room(workers: int) -> np.ndarray:
    """Return the sums of each worker, on cache lines of their own. A function of its own: see `new_counter`."""
    return np.zeros((workers, 16), np.int64)


@inlined
def _count_digit(
    arrived: np.ndarray, leaving: np.ndarray, digit: np.ndarray, come: np.ndarray, gone: np.ndarray
) -> np.uint64:
    """Count one more where only `arrived` sees, and one less where only `leaving` does, in one binary digit of each
    voxel's number; write the carries up and down. Return 0 if there are none."""
    carried = np.uint64(0)
    for w in range(digit.size):
        before, more, less = digit[w], arrived[w] & ~leaving[w], leaving[w] & ~arrived[w]
        digit[w] = before ^ (more | less)
        come[w], gone[w] = more & before, less & ~before
        carried |= come[w] | gone[w]
    return carried


@kernel
def _count_row(
    stack: np.ndarray, slots: Slots, start: int, none: np.ndarray, counts: np.ndarray, carry: np.ndarray
) -> None:
    """As `count_others`, the counts of a row that begins with some word; none (words,): zeros, carry (2, words): room
    to work in."""
    words = none.size
    for i in range(max(slots.arrived.size, slots.leaving.size)):
        arrived = stack[slots.arrived[i], start : start + words] if i < slots.arrived.size else none
        leaving = stack[slots.leaving[i], start : start + words] if i < slots.leaving.size else none
        carried = _count_digit(arrived, leaving, counts[0, start : start + words], carry[0], carry[1])
        digit = 1
        while carried != 0 and digit < counts.shape[0]:  # of what is carried up and down nothing is in both
            carried = _count_digit(
                carry[0], carry[1], counts[digit, start : start + words], carry[0], carry[1]
            )
            digit += 1


@parallel_kernel
def count_others(
    stack: np.ndarray,
    slots: Slots,
    region: Region,
    keep: np.ndarray,
    workers: int,
    counts: np.ndarray,
    free: np.ndarray,
) -> None:
    """Count, in a region, the sensors in arrived slots as others from now on, and those in leaving slots no longer.

    Others are those that stay while some sensors move. counts uint64 (digits, words): binary digits, lowest first, of
    how many of them see each voxel; free uint64 (words,): voxels of keep that none of them sees.
    """
    counter = new_counter()
    for _ in numba.prange(workers):
        none, carry = np.zeros(region.words, np.uint64), np.empty((2, region.words), np.uint64)
        first, end = _take_rows(region, counter)
        while first < end:
            for ix in range(first, end):
                a = ix * region.row_words + region.first_word
                b = a + region.words
                _count_row(stack, slots, a, none, counts, carry)
                part, kept = free[a:b], keep[a:b]
                for w in range(part.size):
                    part[w] = kept[w] & ~counts[0, a + w]
                for digit in range(1, counts.shape[0]):
                    more = counts[digit, a:b]
                    for w in range(part.size):
                        part[w] &= ~more[w]
            first, end = _take_rows(region, counter)


@parallel_kernel
def settle(
    stack: np.ndarray,
    union: np.ndarray,
    free: np.ndarray,
    slots: Slots,
    kinds: np.ndarray,
    region: Region,
    entropies: Entropies,
    workers: int,
) -> np.ndarray:
    """Remove the sets of leaving slots from union[kinds[0]], and add those of arriving ones; leaving slots are cleared.
    Return the change of the sums.

    stack uint64 (slots, words): what the sensor of each slot traverses, of which only informative voxels count; union
    uint64 (kinds, words): informative voxels covered by all sensors of each kind; free uint64 (words,): see
    `count_others`, of the other slots of this kind; kinds int64 (k,): rows of the union, first the one that changes,
    then the others that are not empty.
    Result int64 (2, 4): change of the sums of this kind, and of any sensor; columns as in COLUMNS. Integers, so neither
    the order of the edits nor the number of threads can matter.
    """
    words, partial, counter, others = region.words, _room(workers), new_counter(), kinds[1:]
    for worker in numba.prange(workers):
        rooms, where = np.empty((3, words), np.uint64), np.empty(words + 1, np.int32)
        tallies = np.zeros(entropies.entropies_q.shape[0], np.int64)
        first, end = _take_rows(region, counter)
        while first < end:
            for ix in range(first, end):
                a = ix * region.row_words + region.first_word
                b = a + words
                come = _seen(stack, slots.arrived, a, rooms[0])
                gone = _seen(stack, slots.leaving, a, rooms[1])
                changing = where[: _changing(come, gone, free[a:b], where)]
                row = _Row(
                    free[a:b],
                    union[kinds[0], a:b],
                    _seen_at(changing, union, others, a, rooms[2]),
                    entropies.starts[a:b],
                    entropies.first[a:b],
                )
                _tally(row, come, gone, changing, entropies.codes, tallies)
                for slot in slots.leaving:
                    stack[slot, a:b] = 0
            first, end = _take_rows(region, counter)
        _weigh(tallies, entropies.entropies_q, partial[worker])
    change = np.zeros((2, COLUMNS), np.int64)
    for worker in range(workers):  # numpy's own sum takes seconds to compile
        for c in range(2 * COLUMNS):
            change[c // COLUMNS, c % COLUMNS] += partial[worker, c]
    return change
