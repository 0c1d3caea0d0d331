"""Exchange the contribution of one sensor and account for exactly the voxels whose cover changed."""

from __future__ import annotations

import numba
import numpy as np

from core.kernels.bits import popcount
from core.kernels.jit import inlined, kernel, parallel_kernel

COLUMNS = 4
"""Sums are kept side by side: three classes in fixed point, then the number of voxels."""
PENDING = 4096
ELSEWHERE, LOST = 1, 2
"""Flags in the two lowest bits of a pending voxel: seen by the other kind of sensor; no longer seen."""


@kernel
def _settle(
    pending: np.ndarray, count: int, codes: np.ndarray, palette_q: np.ndarray, sums: np.ndarray
) -> None:
    """Add the entropies of the pending voxels; apart from finding them, so that their loads overlap."""
    own0, own1, own2 = 0, 0, 0
    any0, any1, any2, any3 = 0, 0, 0, 0
    own3 = 0
    for i in range(count):
        code = codes[pending[i] >> 2]
        sign = 1 - (pending[i] & LOST)
        alone = sign * (1 - (pending[i] & ELSEWHERE))
        h0, h1, h2 = np.int64(palette_q[code, 0]), np.int64(palette_q[code, 1]), np.int64(palette_q[code, 2])
        own0, own1, own2, own3 = own0 + sign * h0, own1 + sign * h1, own2 + sign * h2, own3 + sign
        any0, any1, any2, any3 = any0 + alone * h0, any1 + alone * h1, any2 + alone * h2, any3 + alone
    for column, value in enumerate((own0, own1, own2, own3, any0, any1, any2, any3)):
        sums[column] += value


@inlined
def _take_marks(parts: np.ndarray, w: int) -> np.uint64:
    """The marks of all workers in one word; they are cleared."""
    bits = np.uint64(0)
    for worker in range(parts.shape[0]):
        if parts[worker, w] != 0:
            bits |= parts[worker, w]
            parts[worker, w] = 0
    return bits


@kernel
def _exchange_words(
    stack: np.ndarray,
    slot: int,
    parts: np.ndarray,
    same_kind: np.ndarray,
    union: np.ndarray,
    kind: int,
    keep: np.ndarray,
    first: np.ndarray,
    start: int,
    end: int,
    pending: np.ndarray,
    count: int,
    codes: np.ndarray,
    palette_q: np.ndarray,
    sums: np.ndarray,
) -> int:
    """The exchange for the words start..end-1; returns how many changed voxels are pending."""
    one = np.uint64(1)
    for w in range(start, end):
        old, new = stack[slot, w], _take_marks(parts, w)
        if old | new == 0:
            continue
        new &= keep[w]
        if old == new:
            continue
        stack[slot, w] = new
        others = np.uint64(0)
        for other in same_kind:
            others |= stack[other, w]
        union[kind, w] = others | new
        changed = (old ^ new) & ~others
        elsewhere = union[1 - kind, w]
        while changed != 0:
            bit = changed & (~changed + one)
            changed ^= bit
            voxel = np.int64(first[w]) + np.int64(popcount(keep[w] & (bit - one)))
            flags = (LOST if new & bit == 0 else 0) | (ELSEWHERE if elsewhere & bit != 0 else 0)
            pending[count] = (voxel << 2) | flags
            count += 1
        if count > PENDING - 64:
            _settle(pending, count, codes, palette_q, sums)
            count = 0
    return count


@parallel_kernel
def exchange(
    stack: np.ndarray,
    slot: int,
    parts: np.ndarray,
    same_kind: np.ndarray,
    union: np.ndarray,
    kind: int,
    keep: np.ndarray,
    first: np.ndarray,
    codes: np.ndarray,
    palette_q: np.ndarray,
    window: np.ndarray,
    row_words: int,
) -> np.ndarray:
    """Put the marks in the place of stack[slot], clear them, update union[kind]; returns the change of the sums.

    stack (slots, words) contributions; parts (workers, words): the marks in parts, of which only voxels in `keep`
    count; same_kind: the other slots of this kind; union (2, words) covered by all cameras and by all LiDARs;
    window: rows x0..x1-1 and words w0..w1-1 of each row that can hold a mark or an old contribution.
    Result int64 (2, 4): this kind, and any sensor; columns as in COLUMNS. Integers, so the order of the edits and
    the number of threads cannot matter.
    """
    workers = parts.shape[0]
    partial = np.zeros((workers, 2 * COLUMNS), np.int64)
    for worker in numba.prange(workers):
        pending = np.empty(PENDING, np.int64)
        sums = partial[worker]
        count = 0
        for row in range(window[0] + worker, window[1], workers):
            start, end = row * row_words + window[2], row * row_words + window[3]
            count = _exchange_words(
                stack,
                slot,
                parts,
                same_kind,
                union,
                kind,
                keep,
                first,
                start,
                end,
                pending,
                count,
                codes,
                palette_q,
                sums,
            )
        _settle(pending, count, codes, palette_q, sums)
    change: np.ndarray = partial.sum(axis=0).reshape(2, COLUMNS)
    return change
