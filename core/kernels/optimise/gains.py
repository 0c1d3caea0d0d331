"""Gains of candidates over cells that are covered already. All values are integers: any order gives the same sums."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import kernel, lean, parallel_kernel


class Cover(NamedTuple):
    """Cells of n candidates on o objects, e different cells in all.

    Candidate c has the runs starts[c] to starts[c + 1]; run r has the cells ends[r] to ends[r + 1] of object `of[r]`.
    worth (rows, most + 1): value of an object with that many cells, by row[o]; more cells than `most` add nothing.
    """

    starts: np.ndarray
    of: np.ndarray
    ends: np.ndarray
    cells: np.ndarray
    worth: np.ndarray
    row: np.ndarray


@lean
def _gain(cover: Cover, one: int, covered: np.ndarray, known: np.ndarray) -> int:
    total, most = 0, cover.worth.shape[1] - 1
    for run in range(cover.starts[one], cover.starts[one + 1]):
        new = 0
        for place in range(cover.ends[run], cover.ends[run + 1]):
            new += covered[cover.cells[place]] == 0
        if new:
            thing = cover.of[run]
            worth, before = cover.worth[cover.row[thing]], known[thing]
            total += worth[min(before + new, most)] - worth[min(before, most)]
    return int(total)


@parallel_kernel
def gains(
    cover: Cover, ids: np.ndarray, covered: np.ndarray, known: np.ndarray, workers: int, to: np.ndarray
) -> None:
    """Write what each of some candidates adds to covered cells (e,) and to the cells known of objects (o,)."""
    for worker in numba.prange(workers):
        for place in range(worker, ids.size, workers):
            to[place] = _gain(cover, ids[place], covered, known)


@kernel
def few_gains(cover: Cover, ids: np.ndarray, covered: np.ndarray, known: np.ndarray, to: np.ndarray) -> None:
    """Write the same in one thread: to wake others takes longer than a few gains."""
    for place in range(ids.size):
        to[place] = _gain(cover, ids[place], covered, known)


@kernel
def change(cover: Cover, one: int, by: int, covered: np.ndarray, known: np.ndarray) -> None:
    """Add a candidate (by = 1), or take it away again (by = -1)."""
    for run in range(cover.starts[one], cover.starts[one + 1]):
        for place in range(cover.ends[run], cover.ends[run + 1]):
            cell = cover.cells[place]
            if by > 0:
                known[cover.of[run]] += covered[cell] == 0
            covered[cell] += by
            if by < 0:
                known[cover.of[run]] -= covered[cell] == 0


@kernel
def add_shares(cover: Cover, shares: np.ndarray, to: np.ndarray) -> None:
    """Add the shares of candidates (n,) up over the cells (e,) that they hit."""
    for one in range(shares.size):
        if shares[one] > 0.0:
            for place in range(cover.ends[cover.starts[one]], cover.ends[cover.starts[one + 1]]):
                to[cover.cells[place]] += shares[one]


@parallel_kernel
def slopes(cover: Cover, sums: np.ndarray, slope: np.ndarray, workers: int, to: np.ndarray) -> None:
    """Write a supergradient (n,) at cells' sums (e,), from the slopes of objects (o,)."""
    for worker in numba.prange(workers):
        for one in range(worker, to.size, workers):
            total = 0.0
            for run in range(cover.starts[one], cover.starts[one + 1]):
                new = 0
                for place in range(cover.ends[run], cover.ends[run + 1]):
                    new += sums[cover.cells[place]] < 1.0
                total += slope[cover.of[run]] * new
            to[one] = total


@kernel
def number_cells(
    starts: np.ndarray,
    counts: np.ndarray,
    keys: np.ndarray,
    base: np.ndarray,
    low: np.ndarray,
    span: np.ndarray,
    to: np.ndarray,
) -> bool:
    """Number the cells of objects (m,), three packed indices each, within the objects' blocks: lowest cells low (m, 3),
    cells along the axes span (m, 3), first number base (m,). False where one lies outside of its block."""
    filled, inside = 0, True
    for thing in range(starts.size):
        for place in range(starts[thing], starts[thing] + counts[thing]):
            key = keys[place]
            i = (key >> 42) - low[thing, 0]
            j = ((key >> 21) & 0x1FFFFF) - low[thing, 1]
            k = (key & 0x1FFFFF) - low[thing, 2]
            inside &= 0 <= i < span[thing, 0] and 0 <= j < span[thing, 1] and 0 <= k < span[thing, 2]
            to[filled] = base[thing] + (i * span[thing, 1] + j) * span[thing, 2] + k
            filled += 1
    return inside
