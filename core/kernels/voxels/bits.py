"""Words of 64 voxels: counting bits, marking levels of a column, indexing the voxels of a mask, listing them.

A column of the grid is `depth` words in a row, and level z is bit z % 64 of its word z // 64.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.extending import intrinsic

from riglens.core.kernels.runtime.jit import kernel, lean_inlined

FULL_WORD = np.uint64(0xFFFFFFFFFFFFFFFF)


@intrinsic  # type: ignore[untyped-decorator]
def popcount(typingctx: Any, bits: Any) -> Any:
    """Return the number of set bits of a uint64."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.ctpop(args[0])

    return types.uint64(types.uint64), codegen


@intrinsic  # type: ignore[untyped-decorator]
def lowest_bit(typingctx: Any, bits: Any) -> Any:
    """Return the index of the lowest set bit of a nonzero uint64."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        from llvmlite import ir

        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 0))

    return types.uint64(types.uint64), codegen


@lean_inlined
def first_run(bits: np.uint64, starts: np.uint64) -> tuple[np.int64, np.uint64]:
    """Return the number (from 0) of the run that holds the lowest of some bits, and which of the bits lie in that run.

    starts: the first bit of each run, runs reach up to the next one.
    """
    one = np.uint64(1)
    lowest = bits & (~bits + one)
    later = starts & ~(lowest | (lowest - one))
    return np.int64(popcount(starts ^ later)) - 1, bits & ((later & (~later + one)) - one)


@lean_inlined
def level_mask(low: int | np.int64, high: int | np.int64) -> np.uint64:
    """Return the bits low..high (both 0..63, both included) of a word."""
    return (FULL_WORD << np.uint64(low)) & (FULL_WORD >> np.uint64(63 - high))


@lean_inlined
def mask_of(low: int | np.int32, high: int | np.int32, part: int) -> np.uint64:
    """Return the bits low..high of the word `part` of a column; none where low > high."""
    first, last = int(low) - 64 * part, int(high) - 64 * part
    shown = (first <= last) & (first < 64) & (last >= 0)
    mask = (FULL_WORD << np.uint64(min(max(first, 0), 63))) & (
        FULL_WORD >> np.uint64(63 - min(max(last, 0), 63))
    )
    return mask if shown else np.uint64(0)


@lean_inlined
def mark_levels(marks: np.ndarray, base: int | np.int64, low: int | np.int64, high: int | np.int64) -> None:
    """Set the levels low..high of the column whose first word is `base`; usually they share a word."""
    first, last = low >> 6, high >> 6
    if first == last:
        marks[np.uint64(base + first)] |= level_mask(low & 63, high & 63)
    else:
        for part in range(first, last + 1):
            marks[base + part] |= level_mask(max(low - 64 * part, 0), min(high - 64 * part, 63))


@kernel
def first_ids(words: np.ndarray) -> np.ndarray:
    """Return the running count of set bits before each word, uint32 (n + 1,)."""
    first = np.empty(words.size + 1, np.uint32)
    total = np.uint64(0)
    for w in range(words.size):
        first[w] = total
        total += popcount(words[w])
    first[words.size] = total
    return first


@kernel
def list_voxels(words: np.ndarray, first: np.ndarray, ny: int, depth: int) -> np.ndarray:
    """Return the indices (ix, iy, iz) of the voxels of a mask in the order of their ids, int32 (count, 3)."""
    voxels = np.empty((first[words.size], 3), np.int32)
    for w in range(words.size):
        bits = words[w]
        row = first[w]
        column = w // depth
        while bits != 0:
            voxels[row, 0] = column // ny
            voxels[row, 1] = column % ny
            voxels[row, 2] = (w % depth) * 64 + lowest_bit(bits)
            row += 1
            bits &= bits - np.uint64(1)
    return voxels


@kernel
def keep_flagged(words: np.ndarray, keep: np.ndarray) -> None:
    """Clear the bits of the voxels, in the order of their ids, whose flag is False; changes words in place."""
    row = 0
    for w in range(words.size):
        bits = words[w]
        while bits != 0:
            lowest = bits & (~bits + np.uint64(1))
            if not keep[row]:
                words[w] ^= lowest
            row += 1
            bits ^= lowest
