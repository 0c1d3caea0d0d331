"""Masks of levels within a column of 64-bit words."""

from __future__ import annotations

import numpy as np

from core.kernels.jit import inlined

FULL_WORD = np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def level_mask(low: int, high: int) -> np.uint64:
    """Bits low..high (both 0..63, both included) of a word."""
    return (FULL_WORD << np.uint64(low)) & (FULL_WORD >> np.uint64(63 - high))
