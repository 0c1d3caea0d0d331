"""Masks of levels within a column of 64-bit words."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.jit import inlined

FULL_WORD = np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def level_mask(low: int | np.int64, high: int | np.int64) -> np.uint64:
    """Bits low..high (both 0..63, both included) of a word."""
    return (FULL_WORD << np.uint64(low)) & (FULL_WORD >> np.uint64(63 - high))


@inlined
def mark_levels(marks: np.ndarray, base: int | np.int64, low: int | np.int64, high: int | np.int64) -> None:
    """Set the levels low..high of the column whose first word is `base`; most often they share a word."""
    first, last = low >> 6, high >> 6
    if first == last:
        marks[np.uint64(base + first)] |= level_mask(low & 63, high & 63)
    else:
        for part in range(first, last + 1):
            marks[base + part] |= level_mask(max(low - 64 * part, 0), min(high - 64 * part, 63))
