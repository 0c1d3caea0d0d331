"""Find the lowest height that sensors see in the columns of a grid, around each column, and the three lowest of
them."""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import lean_inlined, parallel_kernel
from riglens.core.kernels.voxels.bits import lowest_bit

MOST_COUNTED = 3
"""Number of lowest levels that are kept apart."""


@parallel_kernel
def lowest_levels(
    voxels: np.ndarray, keep: np.ndarray, depth: int, none: int, workers: int, lowest: np.ndarray
) -> None:
    """Write the lowest level in each column of a set of voxels uint64 (words,) within keep (words,), uint16 (columns,);
    `none` without any. depth: words of a column."""
    columns = lowest.size
    for worker in numba.prange(workers):
        for column in range(columns * worker // workers, columns * (worker + 1) // workers):
            found = none
            for part in range(depth - 1, -1, -1):
                word = voxels[column * depth + part] & keep[column * depth + part]
                if word != 0:
                    found = 64 * part + int(lowest_bit(word))
            lowest[column] = found


@lean_inlined
def _around(levels: np.ndarray, ix: int, offsets: np.ndarray, row: np.ndarray) -> None:
    """Lower each column of a row (ny,) to the lowest level (nx, ny) around it."""
    nx, ny = levels.shape
    for k in range(offsets.shape[0]):
        x, step = ix + offsets[k, 0], offsets[k, 1]
        if 0 <= x < nx and abs(step) < ny:
            to, of = row[max(0, -step) : ny - max(0, step)], levels[x, max(0, step) : ny - max(0, -step)]
            for i in range(np.uint64(to.size)):
                to[i] = min(to[i], of[i])


@parallel_kernel
def lowest_around(
    lowest: np.ndarray, offsets: np.ndarray, none: int, workers: int, around: np.ndarray
) -> None:
    """Write the lowest level around each column, uint16 (nx, ny).

    lowest uint16 (nx, ny): as `lowest_levels` writes; offsets (m, 2): which columns count as around one, by steps along
    x and y.
    """
    nx = lowest.shape[0]
    for worker in numba.prange(workers):
        for ix in range(nx * worker // workers, nx * (worker + 1) // workers):
            around[ix, :] = none
            _around(lowest, ix, offsets, around[ix])


@lean_inlined
def _sink(row: np.ndarray, first: np.ndarray, second: np.ndarray, third: np.ndarray) -> None:
    """Put the levels of a row among the three lowest of each of its columns; without a branch, many at once."""
    for i in range(np.uint64(row.size)):
        level, best, next_best = row[i], first[i], second[i]
        third[i] = min(third[i], max(next_best, level))
        second[i] = min(next_best, max(best, level))
        first[i] = min(best, level)


@parallel_kernel
def three_lowest(
    around: np.ndarray, rows: np.ndarray, kinds: np.ndarray, none: int, workers: int, levels: np.ndarray
) -> None:
    """Write the three lowest of the sensors' levels in each column, uint16 (kinds + 1, 3, nx, ny): of all sensors,
    then of each kind; `none` where there is no such sensor.

    around uint16 (r, nx, ny): as `lowest_around` writes, of which rows (n,) count; kinds (n,): of the sensors, from 0.
    """
    nx = around.shape[1]
    for worker in numba.prange(workers):
        for ix in range(nx * worker // workers, nx * (worker + 1) // workers):
            for kind in range(levels.shape[0]):
                for k in range(MOST_COUNTED):
                    levels[kind, k, ix, :] = none
            for i in range(rows.size):
                own = levels[1 + kinds[i]]
                _sink(around[rows[i], ix], own[0, ix], own[1, ix], own[2, ix])
            for kind in range(1, levels.shape[0]):
                for k in range(MOST_COUNTED):
                    _sink(levels[kind, k, ix], levels[0, 0, ix], levels[0, 1, ix], levels[0, 2, ix])
