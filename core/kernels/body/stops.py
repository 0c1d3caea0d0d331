"""Note which rays of a picture the car stops, in words of 64 columns."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.runtime.jit import kernel


@kernel
def set_stops(
    ends: np.ndarray,
    row_of: np.ndarray,
    column_of: np.ndarray,
    steps: np.ndarray,
    bits: np.ndarray,
    last_ends: np.ndarray,
) -> None:
    """Set the bits uint64 (2, rows * words) of rays that end, by ends (rays,), and of those that end at 0, and write
    the last end of each word (rows * words,); all 0 before. row_of, column_of, steps: as in `Beams`."""
    words = (column_of.size + 63) // 64
    for row in range(row_of.size):
        for column in range(column_of.size):
            end = ends[row_of[row] * steps[0] + column_of[column] * steps[1]]
            if end < np.inf:
                word, bit = row * words + (column >> 6), np.uint64(1) << np.uint64(column & 63)
                bits[0, word] |= bit
                if end == 0.0:
                    bits[1, word] |= bit
                last_ends[word] = max(last_ends[word], end)
