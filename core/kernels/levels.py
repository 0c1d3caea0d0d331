"""Masks of levels within a column of 64-bit words."""

from __future__ import annotations

import numpy as np

from core.kernels.jit import inlined, kernel

FULL_WORD = np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def level_mask(low: int, high: int) -> np.uint64:
    """Bits low..high (both 0..63, both included) of a word."""
    return (FULL_WORD << np.uint64(low)) & (FULL_WORD >> np.uint64(63 - high))


@kernel
def level_masks(low: int, high: int, depth: int) -> np.ndarray:
    """Bits of the levels low..high-1 that lie at or above (0) and at or below (1) a level, uint64 (2, depth, n).

    Column i is level low - 1 + i, up to level high: one beyond the box on either side, where nothing is met.
    """
    masks = np.zeros((2, depth, high - low + 2), np.uint64)
    for i in range(high - low + 2):
        for level in range(low, high):
            bit = np.uint64(1) << np.uint64(level & 63)
            if level >= low - 1 + i:
                masks[0, level >> 6, i] |= bit
            if level <= low - 1 + i:
                masks[1, level >> 6, i] |= bit
    return masks
