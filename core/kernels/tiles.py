"""Tiles of columns in which the beams of a LiDAR are looked at together, and work space for them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.bits import FULL_WORD
from riglens.core.kernels.cones import Spinner
from riglens.core.kernels.jit import inlined

TILE = 16
"""Columns along each edge of a tile."""
BLOCK = 4
HALF_BLOCK = 2.83
"""A little more than half the diagonal of a block of BLOCK x BLOCK columns."""
HALF_TILE = 11.4
"""A little more than half the diagonal of a tile."""
MISSES, MIXED, COVERS = 0, 1, 2
"""Whether a beam has rays all over a tile: nowhere, perhaps, everywhere."""


class TileWork(NamedTuple):
    """Work space of one worker: heights (TILE + 1, TILE + 1) of a sheet at the corners of columns; meets, hits int32
    (2, TILE²): from, to of the levels that it meets and of those that it hits for certain; asked, sure uint64 (words
    per column, TILE²): all of these levels; has_rays, is_full uint64 (TILE²): all bits where a sheet may have rays,
    and where it has them all over the column; free int8 (beams,): whether all, some or none of the rays of a beam
    that pass the tile are cast: COVERS, MIXED, MISSES; is_wanted bool (TILE²): columns with voxels worth a test;
    blocks int8: as `free`, of one beam, for blocks of BLOCK x BLOCK columns."""

    heights: np.ndarray
    meets: np.ndarray
    hits: np.ndarray
    asked: np.ndarray
    sure: np.ndarray
    has_rays: np.ndarray
    is_full: np.ndarray
    free: np.ndarray
    is_wanted: np.ndarray
    blocks: np.ndarray


class Tile(NamedTuple):
    """A tile: first column ix, iy; place x, y of that corner seen from the sensor; nearest, farthest in plan; tall: the
    largest height in the box, seen from the sensor; low, high: heights of the box seen from the sensor."""

    ix: int
    iy: int
    x: float
    y: float
    nearest: float
    farthest: float
    low: float
    high: float


@inlined
def tile_at(s: Spinner, ix: int, iy: int) -> Tile:
    """The tile that begins at a column."""
    x, y = ix - s.origin[0], iy - s.origin[1]
    near_x, near_y = max(max(x, -x - TILE), 0.0), max(max(y, -y - TILE), 0.0)
    far_x, far_y = max(abs(x), abs(x + TILE)), max(abs(y), abs(y + TILE))
    return Tile(
        ix, iy, x, y, np.hypot(near_x, near_y), np.hypot(far_x, far_y),
        s.box[4] - s.origin[2], s.box[5] - s.origin[2],
    )  # fmt: skip


@inlined
def reaches(tile: Tile) -> float:
    """The longest way from the sensor to a point of the tile in the box."""
    return float(np.hypot(tile.farthest, max(abs(tile.low), abs(tile.high))))


@inlined
def mask_of(low: int | np.int32, high: int | np.int32, part: int) -> np.uint64:
    """Bits low..high of the word `part` of a column; none where low > high."""
    first, last = int(low) - 64 * part, int(high) - 64 * part
    shown = (first <= last) & (first < 64) & (last >= 0)
    mask = (FULL_WORD << np.uint64(min(max(first, 0), 63))) & (
        FULL_WORD >> np.uint64(63 - min(max(last, 0), 63))
    )
    return mask if shown else np.uint64(0)


@inlined
def add_levels(levels: np.ndarray, bits: np.ndarray) -> None:
    """Add levels from, to (2, columns) to the bits (words per column, columns)."""
    for part in range(bits.shape[0]):
        for place in range(TILE * TILE):
            bits[part, place] |= mask_of(levels[0, place], levels[1, place], part)


@inlined
def level_of(height: float) -> np.int32:
    """The level of a height, as a number that fits into 32 bits."""
    return np.int32(np.floor(min(max(height, -1e6), 1e6)))


@inlined
def find_wanted(s: Spinner, tile: Tile, keep: np.ndarray, work: TileWork) -> bool:
    """Write which columns of a tile hold a voxel of keep uint64 (words,); returns whether one does."""
    ny, depth, is_any = s.shape[1], (s.shape[2] + 63) // 64, False
    work.is_wanted[:] = False
    for i in range(min(TILE, s.box[1] - tile.ix)):
        for j in range(min(TILE, s.box[3] - tile.iy)):
            for part in range(depth):
                if keep[((tile.ix + i) * ny + tile.iy + j) * depth + part] != 0:
                    work.is_wanted[i * TILE + j] = is_any = True
    return is_any
