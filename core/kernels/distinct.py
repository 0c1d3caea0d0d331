"""Cells that rays hit on an object, each counted once: of one LiDAR, and of several together.

They are told apart by bits, one for each cell of the block around them; where that would be too many, by a hash table.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.jit import kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.lattice import Direction

CELL_M = 0.2
INSIDE_M = 1e-3
"""A cell is taken at the point this far along the ray after it enters."""
_HALF_CELLS, _BITS, _MASK = 1 << 20, 21, (1 << 21) - 1
"""Cell numbers along an axis are packed into 21 bits each: 200 km of cells, far more than any box has."""


@lean_inlined
def cell_key(start: Direction, along: Direction, t: float) -> int:
    """Number of the cell that a ray is in, INSIDE_M after it entered an object at distance t."""
    s = t + INSIDE_M
    i = np.int64(np.floor((start[0] + s * along[0]) / CELL_M)) + _HALF_CELLS
    j = np.int64(np.floor((start[1] + s * along[1]) / CELL_M)) + _HALF_CELLS
    k = np.int64(np.floor((start[2] + s * along[2]) / CELL_M)) + _HALF_CELLS
    return int((((i << _BITS) | j) << _BITS) | k)


@lean_inlined
def is_new(key: int, table: np.ndarray, mask: int) -> bool:
    """Put a key (>= 0) into a hash table, -1 where free, of mask + 1 places; whether it was not there yet."""
    word = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
    place = np.int64(word >> np.uint64(32)) & mask
    while table[place] != -1:
        if table[place] == key:
            return False
        place = (place + 1) & mask
    table[place] = key
    return True


@lean_inlined
def table_mask(keys: int) -> int:
    """Size, less one, of a hash table at most half full of that many keys."""
    size = 4
    while size < 2 * keys:
        size *= 2
    return size - 1


class Block(NamedTuple):
    """Cells from the first to the last along each axis."""

    i0: int
    j0: int
    k0: int
    i1: int
    j1: int
    k1: int


EMPTY = Block(_MASK, _MASK, _MASK, 0, 0, 0)


@lean_inlined
def cell_of(key: int) -> tuple[int, int, int]:
    """The numbers of a cell along the axes, as `cell_key` packs them."""
    return key >> (2 * _BITS), (key >> _BITS) & _MASK, key & _MASK


@lean_inlined
def widened(block: Block, key: int) -> Block:
    """A block that holds one more cell."""
    i, j, k = cell_of(key)
    return Block(
        min(block.i0, i),
        min(block.j0, j),
        min(block.k0, k),
        max(block.i1, i),
        max(block.j1, j),
        max(block.k1, k),
    )


@lean_inlined
def has_room(block: Block, table: np.ndarray) -> bool:
    """Whether a table has a bit for each cell of a block."""
    rows, columns, depth = block.i1 - block.i0 + 1, block.j1 - block.j0 + 1, block.k1 - block.k0 + 1
    return bool(np.float64(rows) * np.float64(columns) * np.float64(depth) <= 64.0 * table.size)


@lean_inlined
def clear(block: Block, table: np.ndarray) -> None:
    """Make the bits of a block 0."""
    cells = (block.i1 - block.i0 + 1) * (block.j1 - block.j0 + 1) * (block.k1 - block.k0 + 1)
    table[: (cells + 63) >> 6] = 0


@lean_inlined
def put(block: Block, key: int, table: np.ndarray) -> int:
    """Set the bit of a cell of the block; 1 if it was 0, else 0."""
    i, j, k = cell_of(key)
    columns, depth = block.j1 - block.j0 + 1, block.k1 - block.k0 + 1
    bit = ((i - block.i0) * columns + (j - block.j0)) * depth + (k - block.k0)
    word = table[bit >> 6]
    table[bit >> 6] = word | (1 << (bit & 63))
    return int(1 - ((word >> (bit & 63)) & 1))


@lean
def keep_distinct(number: int, cells: np.ndarray, table: np.ndarray) -> int:
    """Keep the first of equal ones among the first `number` cells, in their order; how many are left."""
    block, kept = EMPTY, 0
    for place in range(number):
        block = widened(block, cells[place])
    if not has_room(block, table):
        return _keep_hashed(number, cells, table)
    clear(block, table)
    for place in range(number):
        cell = cells[place]
        cells[kept] = cell
        kept += put(block, cell, table)
    return kept


@lean
def _keep_hashed(number: int, cells: np.ndarray, table: np.ndarray) -> int:
    """As `keep_distinct`, for cells however far apart."""
    kept, mask = 0, table_mask(number)
    table[: mask + 1] = -1
    for place in range(number):
        cell = cells[place]
        cells[kept] = cell
        kept += is_new(cell, table, mask)
    return kept


@parallel_kernel
def joined_cells(
    starts: np.ndarray, counts: np.ndarray, cells: np.ndarray, most: int, workers: int, to: np.ndarray
) -> None:
    """Distinct cells of each object over several LiDARs: to int32 (objects,).

    cells of LiDAR l on object o, which l alone has: counts[l, o] of them from cells[starts[l, o]] on; most: cells of
    all LiDARs on any object.
    """
    objects = to.size
    for worker in numba.prange(workers):
        table = np.empty(table_mask(most) + 1, np.int64)
        for one in range(worker, objects, workers):
            to[one] = _distinct(starts, counts, cells, one, table)


@kernel
def joined_cells_serial(
    starts: np.ndarray, counts: np.ndarray, cells: np.ndarray, most: int, to: np.ndarray
) -> None:
    """As `joined_cells`, for any thread."""
    table = np.empty(table_mask(most) + 1, np.int64)
    for one in range(to.size):
        to[one] = _distinct(starts, counts, cells, one, table)


@lean
def _distinct(starts: np.ndarray, counts: np.ndarray, cells: np.ndarray, one: int, table: np.ndarray) -> int:
    """Distinct cells of an object over several LiDARs."""
    total, most, block, number = 0, 0, EMPTY, 0
    for lidar in range(starts.shape[0]):
        total, most = total + counts[lidar, one], max(most, counts[lidar, one])
        for place in range(starts[lidar, one], starts[lidar, one] + counts[lidar, one]):
            block = widened(block, cells[place])
    if total == most:  # at most one LiDAR has any
        return total
    if not has_room(block, table):
        return _count_hashed(starts, counts, cells, one, total, table)
    clear(block, table)
    for lidar in range(starts.shape[0]):
        for place in range(starts[lidar, one], starts[lidar, one] + counts[lidar, one]):
            number += put(block, cells[place], table)
    return number


@lean
def _count_hashed(
    starts: np.ndarray, counts: np.ndarray, cells: np.ndarray, one: int, total: int, table: np.ndarray
) -> int:
    """As `_distinct`, for cells however far apart."""
    number, mask = 0, table_mask(total)
    table[: mask + 1] = -1
    for lidar in range(starts.shape[0]):
        for place in range(starts[lidar, one], starts[lidar, one] + counts[lidar, one]):
            number += is_new(cells[place], table, mask)
    return number
