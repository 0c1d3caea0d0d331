"""Count the distinct cells that rays hit on an object: of one LiDAR, and of several together.

Each cell of the block around them has a bit; for one LiDAR, where that takes too much memory, a hash table replaces the
bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

CELL_M = 0.2
INSIDE_M = 1e-3
"""A cell is taken at the point this far along the ray after it enters."""
_HALF_CELLS, _BITS, _MASK = 1 << 20, 21, (1 << 21) - 1
"""Cell numbers along an axis are packed into 21 bits each: 200 km of cells, far more than any box has."""


@lean_inlined
def cell_key(start: Direction, along: Direction, t: float) -> int:
    """Return the number of the cell that a ray is in, INSIDE_M after it entered an object at distance t."""
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
    """Return the size, less one, of a hash table at most half full of that many keys."""
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
"""Of no cell: the first lies behind the last."""


@lean_inlined
def cell_of(key: int) -> tuple[int, int, int]:
    """Return the numbers of a cell along the axes, as `cell_key` packs them."""
    return key >> (2 * _BITS), (key >> _BITS) & _MASK, key & _MASK


@lean_inlined
def widened(block: Block, key: int) -> Block:
    """Return a block that holds one more cell."""
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
    """Return whether a table has a bit for each cell of a block."""
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
def keep_distinct(number: int, cells: np.ndarray, table: np.ndarray) -> tuple[int, Block]:
    """Keep the first of equal ones among the first `number` cells, in their order; return the number kept, and the
    block around them."""
    block, kept = EMPTY, 0
    for place in range(number):
        block = widened(block, cells[place])
    if not has_room(block, table):
        return _keep_hashed(number, cells, table), block
    clear(block, table)
    for place in range(number):
        cell = cells[place]
        cells[kept] = cell
        kept += put(block, cell, table)
    return kept, block


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


class Marks(NamedTuple):
    """A bit for each cell of a block of each of n objects: blocks from corners to corners + sides - 1, both int64
    (3, n), whose bits are in words int64 (m,), from word begins[o], (n,), on."""

    corners: np.ndarray
    sides: np.ndarray
    begins: np.ndarray
    words: np.ndarray


@kernel
def count_unmarked(
    marks: Marks, starts: np.ndarray, counts: np.ndarray, cells: np.ndarray, marks_them: bool, first: int, end: int,
    to: np.ndarray,
) -> None:  # fmt: skip
    """Add to `to` int64 (n,) the number of a LiDAR's cells on each of the objects first..end-1 without a mark; mark
    those in the block, if wanted. It has counts[o] distinct cells on object o, from cells[starts[o]] on."""
    for one in range(first, end):
        to[one] += _unmarked(marks, one, cells, starts[one], starts[one] + counts[one], marks_them)


@lean_inlined
def _unmarked(marks: Marks, one: int, cells: np.ndarray, start: int, end: int, marks_them: bool) -> int:
    """As `count_unmarked`, of cells start..end-1 on one object; a cell outside its block has no mark."""
    i0, j0, k0 = marks.corners[0, one], marks.corners[1, one], marks.corners[2, one]
    rows, columns, depth = marks.sides[0, one], marks.sides[1, one], marks.sides[2, one]
    first_bit, new = marks.begins[one] << 6, 0
    for place in range(start, end):
        i, j, k = cell_of(cells[place])
        i, j, k = i - i0, j - j0, k - k0
        if i < 0 or j < 0 or k < 0 or i >= rows or j >= columns or k >= depth:
            new += 1
            continue
        bit = first_bit + (i * columns + j) * depth + k
        word = marks.words[bit >> 6]
        new += 1 - ((word >> (bit & 63)) & 1)
        if marks_them:
            marks.words[bit >> 6] = word | (1 << (bit & 63))
    return int(new)
