"""Numbering the distinct rows of a table: voxels share few combinations of counts, so a number serves for three."""

from __future__ import annotations

import numpy as np

from core.kernels.jit import kernel

EMPTY = -1


@kernel
def number_rows(
    rows: np.ndarray, numbers: np.ndarray, firsts: np.ndarray, uses: np.ndarray, slots: np.ndarray
) -> int:
    """Give equal rows (n, 3) equal numbers, in the order of their first appearance; returns how many there are.

    numbers (n,); firsts, uses (most,): first row and number of rows of each; slots int64 (power of two,) filled
    with EMPTY, the open-addressing table. Returns -1 when there are more than firsts can hold.
    """
    found = 0
    last = slots.size - 1
    for row in range(rows.shape[0]):
        a, b, c = np.uint64(rows[row, 0]), np.uint64(rows[row, 1]), np.uint64(rows[row, 2])
        mixed = (a * np.uint64(73856093)) ^ (b * np.uint64(19349663)) ^ (c * np.uint64(83492791))
        slot = np.int64((mixed ^ (mixed >> np.uint64(15))) & np.uint64(last))
        while True:
            number = slots[slot]
            if number == EMPTY:
                if found == firsts.size:
                    return -1
                slots[slot], firsts[found], uses[found] = found, row, 0
                number = found
                found += 1
                break
            first = firsts[number]
            if (
                rows[first, 0] == rows[row, 0]
                and rows[first, 1] == rows[row, 1]
                and rows[first, 2] == rows[row, 2]
            ):
                break
            slot = (slot + 1) & last
        numbers[row] = number
        uses[number] += 1
    return found


@kernel
def renumber(numbers: np.ndarray, ranks: np.ndarray, codes: np.ndarray) -> None:
    """codes (n,) = ranks[numbers], without a temporary array."""
    for row in range(numbers.size):
        codes[row] = ranks[numbers[row]]
