"""Tiles of columns in which the beams of a LiDAR are processed together, and their work space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.beams.cones import HALF_COLUMN, Spinner
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined
from riglens.core.kernels.voxels.bits import lowest_bit, mask_of

TILE = 16
"""Columns along each edge of a tile."""
BLOCK = 4
HALF_BLOCK = 2.83
"""A little more than half the diagonal of a block of BLOCK x BLOCK columns."""
HALF_TILE = 11.4
"""A little more than half the diagonal of a tile."""
LISTED_MOST = 16 * TILE * TILE
"""Columns that are listed before they are tested."""
MISSES, MIXED, COVERS = 0, 1, 2
"""Coverage of a tile by a beam's rays: nowhere, perhaps, everywhere."""


class TileWork(NamedTuple):
    """Work space of one worker: heights (TILE + 1, TILE + 1) of a sheet at the corners of columns; meets, hits int32
    (2, TILE²): from, to of the levels that it meets and of those that it hits for certain; sure uint64 (words per
    column, TILE²): all levels that are hit; listed int32 (4, LISTED_MOST): columns in which a sheet may hit more, by
    place, beam and levels from, to; beside int32 (7, LISTED_MOST): the rays beside their middles, see
    `kernels.beams.crossings`; free int8 (beams,): whether all, some or none of the rays of a beam that pass the
    tile are cast: COVERS, MIXED, MISSES; is_wanted, is_open bool (TILE²): columns with voxels worth a test, and those
    in which a sheet may hit more; eights uint64: is_open, eight at a time; blocks int8: as `free`, of one beam, for
    blocks of BLOCK x BLOCK columns."""

    heights: np.ndarray
    meets: np.ndarray
    hits: np.ndarray
    sure: np.ndarray
    listed: np.ndarray
    beside: np.ndarray
    free: np.ndarray
    is_wanted: np.ndarray
    is_open: np.ndarray
    eights: np.ndarray
    blocks: np.ndarray


@kernel
def work_space(beams: int, depth: int) -> TileWork:
    """Return room for the tiles of one worker: for `beams` beams, and `depth` words per column."""
    is_open = np.empty(TILE * TILE, np.bool_)
    return TileWork(
        np.empty((TILE + 1, TILE + 1)),
        np.empty((2, TILE * TILE), np.int32),
        np.empty((2, TILE * TILE), np.int32),
        np.empty((depth, TILE * TILE), np.uint64),
        np.empty((4, LISTED_MOST), np.int32),
        np.empty((7, LISTED_MOST), np.int32),
        np.empty(beams, np.int8),
        np.empty(TILE * TILE, np.bool_),
        is_open,
        is_open.view(np.uint64),
        np.empty((TILE // BLOCK) ** 2, np.int8),
    )


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


@lean_inlined
def tile_at(s: Spinner, ix: int, iy: int) -> Tile:
    """Return the tile that begins at a column."""
    x, y = ix - s.origin[0], iy - s.origin[1]
    near_x, near_y = max(max(x, -x - TILE), 0.0), max(max(y, -y - TILE), 0.0)
    far_x, far_y = max(abs(x), abs(x + TILE)), max(abs(y), abs(y + TILE))
    return Tile(
        ix, iy, x, y, np.hypot(near_x, near_y), np.hypot(far_x, far_y),
        s.box[4] - s.origin[2], s.box[5] - s.origin[2],
    )  # fmt: skip


@lean_inlined
def reaches(tile: Tile) -> float:
    """Return the longest way from the sensor to a point of the tile in the box."""
    return float(np.hypot(tile.farthest, max(abs(tile.low), abs(tile.high))))


@lean_inlined
def add_levels(levels: np.ndarray, bits: np.ndarray) -> None:
    """Add levels from, to (2, columns) to the bits (words per column, columns)."""
    for part in range(bits.shape[0]):
        for place in range(TILE * TILE):
            bits[part, place] |= mask_of(levels[0, place], levels[1, place], part)


@lean_inlined
def level_of(height: float) -> np.int32:
    """Return the level of a height, as a number that fits into 32 bits."""
    return np.int32(np.floor(min(max(height, -1e6), 1e6)))


@lean_inlined
def find_wanted(s: Spinner, tile: Tile, radius: float, keep: np.ndarray, work: TileWork) -> bool:
    """Write which columns of a tile, within a radius in plan, hold a voxel of keep uint64 (words,); return whether one
    does."""
    ny, depth, is_any, most = s.shape[1], (s.shape[2] + 63) // 64, False, radius - HALF_COLUMN
    is_near = tile.farthest <= radius
    work.is_wanted[:] = False
    for i in range(min(TILE, s.box[1] - tile.ix)):
        for j in range(min(TILE, s.box[3] - tile.iy)):
            x, y = tile.x + i + 0.5, tile.y + j + 0.5
            if is_near or np.sqrt(x * x + y * y) <= most:
                for part in range(depth):
                    if keep[((tile.ix + i) * ny + tile.iy + j) * depth + part] != 0:
                        work.is_wanted[i * TILE + j] = is_any = True
    return is_any


@lean
def list_columns(s: Spinner, beam: int, count: int, work: TileWork) -> int:
    """Add the columns in which a cone may hit further levels; return the number listed."""
    end, low, high = count, np.int32(s.box[4]), np.int32(s.box[5] - 1)
    meets, hits, is_open = work.meets, work.hits, work.is_open
    for place in range(TILE * TILE):
        more = (meets[0, place] < hits[0, place]) | (meets[1, place] > hits[1, place])
        is_open[place] = more & (meets[0, place] <= high) & (meets[1, place] >= low) & work.is_wanted[place]
    for eight in range(TILE * TILE // 8):
        flags = work.eights[eight]
        while flags != 0:
            place = 8 * eight + int(np.int64(lowest_bit(flags) >> np.uint64(3)))
            flags &= flags - np.uint64(1)
            work.listed[0, end], work.listed[1, end] = place, beam
            work.listed[2, end], work.listed[3, end] = meets[0, place], meets[1, place]
            end += 1
    return end
