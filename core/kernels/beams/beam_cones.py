"""Decide for spinning LiDARs in any pose whether any ray hits a voxel, tile by tile of the grid.

Three things are certain without testing a single ray. Between beams that are close together, and near enough, a voxel
is hit whose centre lies between them: the *core*. Beyond it each beam is a *sheet*, a cone that has a height over every
column; where the rays of a beam are closer than a voxel, one of them passes through a column near its middle, so the
level in which the sheet is there is hit. A level far from every sheet is missed. What remains is tested ray by ray:
voxels that a sheet only grazes, those around the sensor, and those at the borders of sector and range. Tiles in which
rays are too far apart are left to the ray walk.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.beams.cones import HALF_COLUMN, SLACK, Beams, Spinner, any_ray_hits, height
from riglens.core.kernels.beams.cores import (
    Shells,
    find_free,
    free_among,
    is_in_core,
    is_in_free_core,
    mark_core,
)
from riglens.core.kernels.beams.crossings import test_listed
from riglens.core.kernels.beams.tiles import (
    BLOCK,
    COVERS,
    HALF_BLOCK,
    HALF_TILE,
    LISTED_MOST,
    MISSES,
    MIXED,
    TILE,
    Tile,
    TileWork,
    add_levels,
    find_wanted,
    level_of,
    list_columns,
    reaches,
    tile_at,
    work_space,
)
from riglens.core.kernels.rays.walk import FARTHEST
from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel
from riglens.core.kernels.runtime.work_stealing import new_counter, take
from riglens.core.kernels.voxels.bits import lowest_bit, mask_of

NOWHERE = np.int32(-(1 << 30))
"""A level that no box has."""
ROUND_TIP = 6.0
"""Voxels in plan from the sensor within which sheets turn too much: everything there is tested."""


@inlined
def _sides(s: Spinner, sides: np.ndarray, x: float, y: float, z: float) -> tuple[float, float]:
    """Return how far a place is past the plane through a sector's first azimuth, and before that through its last."""
    r = s.rotation
    u = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z
    v = r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
    return sides[0] * v - sides[1] * u, sides[3] * u - sides[2] * v


@inlined
def _in_sector(s: Spinner, sides: np.ndarray, x: float, y: float, z: float, room: float) -> int:
    """Return whether all, none or maybe some of the points within `room` of a place are in the sector of a beam."""
    if not s.is_sector:
        return COVERS
    past, before = _sides(s, sides, x, y, z)
    narrow = s.azimuths[-1] - s.azimuths[0] <= np.pi
    inside = min(past, before) if narrow else max(past, before)
    return COVERS if inside > room else MISSES if inside < -room else MIXED


@inlined
def _in_reach(s: Spinner, nearest: float, farthest: float) -> int:
    """Return whether all, none or some of the distances are within the range of the rays."""
    if nearest > s.reach[0] + SLACK and farthest < s.reach[1] - SLACK:
        return COVERS
    return MISSES if nearest > s.reach[1] + SLACK or farthest < s.reach[0] - SLACK else MIXED


@inlined
def _drop(
    s: Spinner, beams: Beams, tile: Tile, beam: int, place: tuple[float, float, float], inset: float
) -> float:
    """Return the largest fall of a beam cone, in the tile around a place on it, on the way from the corner of a column
    to the point where the next ray, at most `inset` away, is certainly in the column; and from there to that ray.

    The way to that ray is a chord about the axis: along the azimuth, and no steeper than the axis leans.
    """
    x, y, z = place
    axis, r = s.axis, s.rotation
    q = axis[0] * x + axis[1] * y
    root = np.sqrt(q * q + beams.open[beam] * (x * x + y * y))
    along_x = abs(beams.fall[beam] * axis[0] + beams.rise[beam] * (q * axis[0] + beams.open[beam] * x) / root)
    along_y = abs(beams.fall[beam] * axis[1] + beams.rise[beam] * (q * axis[1] + beams.open[beam] * y) / root)
    turn = beams.bend[beam] * HALF_TILE / tile.nearest
    u = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z
    v = r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
    flat = np.sqrt(u * u + v * v)
    around = HALF_TILE * np.sqrt(1.0 + beams.slope[beam] ** 2)
    spread = 1.05 * around / (tile.nearest * beams.cosine[beam]) + s.step
    beside_x = min(abs(u * r[0, 1] - v * r[0, 0]) / flat + spread, 1.0)
    beside_y = min(abs(u * r[1, 1] - v * r[1, 0]) / flat + spread, 1.0)
    lean = np.sqrt(axis[0] * axis[0] + axis[1] * axis[1])
    climb = min(abs(u * r[2, 1] - v * r[2, 0]) / flat + spread * lean, lean)
    return float(inset * (beside_x * (along_x + turn) + beside_y * (along_y + turn) + climb) + SLACK)


@inlined
def _levels(
    s: Spinner, beams: Beams, tile: Tile, beam: int, inset: float, drop: float, work: TileWork
) -> None:
    """Levels that a sheet meets in each column of a tile, and of these the ones that are hit for certain.

    A sheet that is in one level is hit where rays are closer than a column. Of several levels, those are hit in which
    it remains after `drop` from its highest corner, or up to as much above the lowest.
    """
    axis, heights, meets, hits = s.axis, work.heights, work.meets, work.hits
    fall, rise, opening = beams.fall[beam], beams.rise[beam], beams.open[beam]
    for i in range(TILE + 1):
        x = tile.x + i
        for j in range(TILE + 1):
            y = tile.y + j
            q = axis[0] * x + axis[1] * y
            heights[i, j] = s.origin[2] + fall * q + rise * np.sqrt(q * q + opening * (x * x + y * y))
    room = 0.25 * beams.bend[beam] / tile.nearest + SLACK
    close = inset < 0.5
    can = close and inset * np.sqrt(axis[0] * axis[0] + axis[1] * axis[1]) < 0.5 - SLACK
    for i in range(TILE):
        for j in range(TILE):
            a, b, c, d = heights[i, j], heights[i, j + 1], heights[i + 1, j], heights[i + 1, j + 1]
            low, high = min(min(a, b), min(c, d)), max(max(a, b), max(c, d))
            place = i * TILE + j
            first, last = level_of(low - room), level_of(high + room)
            one = close and first == last
            meets[0, place], meets[1, place] = first, last
            hits[0, place] = first if one else level_of(low + drop) if can else np.int32(1)
            hits[1, place] = last if one else level_of(high - drop) if can else np.int32(0)


@inlined
def _find_free_blocks(s: Spinner, beams: Beams, tile: Tile, beam: int, work: TileWork) -> None:
    """Write whether the rays of a beam that pass blocks of columns of a tile are cast; COVERS where none is needed."""
    around = HALF_BLOCK * np.sqrt(1.0 + beams.slope[beam] ** 2) + SLACK
    for a in range(0, TILE, BLOCK):
        for b in range(0, TILE, BLOCK):
            wanted = False
            for i in range(a, a + BLOCK):
                for j in range(b, b + BLOCK):
                    wanted |= work.is_wanted[i * TILE + j]
            free = COVERS
            if wanted:
                middle_a, middle_b = a + BLOCK // 2, b + BLOCK // 2
                z = work.heights[middle_a, middle_b] - s.origin[2]
                place = (tile.x + middle_a, tile.y + middle_b, z)
                free = free_among(s, beams, beam, place, around)
            work.blocks[a // BLOCK * (TILE // BLOCK) + b // BLOCK] = free


@kernel
def _cut_border(s: Spinner, beams: Beams, tile: Tile, beam: int, work: TileWork) -> None:
    """Keep of the levels of a sheet that ends in the tile, at the border of sector or range or where rays are stopped,
    only those where it has rays, and call only those certain where it has all of them."""
    heights, meets, hits = work.heights, work.meets, work.hits
    room = HALF_COLUMN * np.sqrt(1.0 + beams.slope[beam] ** 2) + 0.5 * beams.bend[beam] / tile.nearest + SLACK
    sides, begin, end = beams.sides[beam], s.reach[0], s.reach[1]
    narrow, all_free = s.azimuths[-1] - s.azimuths[0] <= np.pi, work.free[beam] == COVERS
    if not all_free:
        _find_free_blocks(s, beams, tile, beam, work)
    for i in range(TILE):
        x = tile.x + i + 0.5
        for j in range(TILE):
            y = tile.y + j + 0.5
            total = heights[i, j] + heights[i, j + 1] + heights[i + 1, j] + heights[i + 1, j + 1]
            z = 0.25 * total - s.origin[2]
            distance = np.sqrt(x * x + y * y + z * z)
            past, before = _sides(s, sides, x, y, z)
            inside = min(past, before) if narrow else max(past, before)
            if not s.is_sector:
                inside = FARTHEST
            inside = min(inside, min(distance - begin, end - distance))
            free = COVERS if all_free else work.blocks[i // BLOCK * (TILE // BLOCK) + j // BLOCK]
            if free == MIXED and work.is_wanted[i * TILE + j]:
                free = free_among(s, beams, beam, (x, y, z), room)
            some, every = free != MISSES, free == COVERS
            if not (some and inside >= -room):
                meets[0, i * TILE + j], meets[1, i * TILE + j] = NOWHERE, NOWHERE
            if not (every and inside > room):
                hits[0, i * TILE + j], hits[1, i * TILE + j] = 1, 0


@kernel
def _forget_far(tile: Tile, radius: float, work: TileWork) -> None:
    """Leave the columns that are not within the radius to the ray walk."""
    for place in range(TILE * TILE):
        x, y = tile.x + place // TILE + 0.5, tile.y + place % TILE + 0.5
        if np.sqrt(x * x + y * y) > radius - HALF_COLUMN:
            work.sure[:, place] = 0


@kernel
def _add_beams(
    s: Spinner,
    beams: Beams,
    shells: Shells,
    tile: Tile,
    radius: float,
    has_core: bool,
    all_free: bool,
    keep: np.ndarray,
    marks: np.ndarray,
    work: TileWork,
) -> None:
    """Add the sheets of all beams that meet a tile in the box, as far as the radius, in tiles within their own."""
    axis, listed = s.axis, 0
    x, y, farthest = tile.x + 0.5 * TILE, tile.y + 0.5 * TILE, reaches(tile)
    longest = np.hypot(min(tile.farthest, radius), max(abs(tile.low), abs(tile.high)))
    for beam in range(beams.elevation.size):
        if not np.isfinite(beams.bend[beam]) or work.free[beam] == MISSES:
            continue
        if tile.nearest >= beams.radius[beam]:
            continue
        z = height(axis, beams, beam, x, y)
        spread = HALF_TILE * beams.slope[beam] + SLACK
        if z - spread > tile.high or z + spread < tile.low:
            continue
        if has_core and all_free and is_in_core(shells, beam, tile.nearest, farthest):
            continue
        is_sure = work.free[beam] == COVERS
        mixed = has_core and not all_free and is_sure
        if mixed and is_in_free_core(beams, shells, beam, tile.nearest, farthest, work.free):
            continue
        around = HALF_TILE * np.sqrt(1.0 + beams.slope[beam] ** 2) + SLACK
        distance = np.sqrt(x * x + y * y + z * z)
        reach = _in_reach(s, distance - around, distance + around)
        sector = _in_sector(s, beams.sides[beam], x, y, z, around)
        if reach == MISSES or sector == MISSES:
            continue
        inset = 0.5 * longest * beams.cosine[beam] * s.step + SLACK
        _levels(s, beams, tile, beam, inset, _drop(s, beams, tile, beam, (x, y, z), inset), work)
        if not (is_sure and reach == COVERS and sector == COVERS):
            _cut_border(s, beams, tile, beam, work)
        add_levels(work.hits, work.sure)
        listed = list_columns(s, beam, listed, work)
        if listed + TILE * TILE > LISTED_MOST:
            test_listed(s, beams, tile, listed, keep, marks, work)
            listed = 0
    test_listed(s, beams, tile, listed, keep, marks, work)


@inlined
def _core_holds(s: Spinner, beams: Beams, tile: Tile) -> bool:
    """Return whether a whole tile is so well inside sector and range that a core may be marked there."""
    begins = s.reach[0] > 0.0 and tile.nearest < s.reach[0] + 1.0
    if begins or reaches(tile) > s.reach[1] - 1.0:
        return False
    if not s.is_sector:
        return True
    x, y = tile.x + 0.5 * TILE, tile.y + 0.5 * TILE
    narrow = s.azimuths[-1] - s.azimuths[0] <= np.pi
    for beam in (np.argmin(beams.offset), np.argmax(beams.offset)):
        past_low, before_low = _sides(s, beams.sides[beam], x, y, tile.low)
        past_high, before_high = _sides(s, beams.sides[beam], x, y, tile.high)
        past, before = min(past_low, past_high), min(before_low, before_high)
        if (min(past, before) if narrow else max(past, before)) <= HALF_TILE:
            return False
    return True


@kernel
def _mark_tile(
    s: Spinner,
    beams: Beams,
    shells: Shells,
    tile: Tile,
    radius: float,
    keep: np.ndarray,
    marks: np.ndarray,
    work: TileWork,
) -> None:
    """Mark the voxels of one tile that a ray traverses, as far as the radius."""
    ny, depth = s.shape[1], (s.shape[2] + 63) // 64
    work.sure[:] = 0
    if not find_wanted(s, tile, radius, keep, work):
        return
    has_core, all_free = _core_holds(s, beams, tile), find_free(s, beams, tile, work)
    if has_core:
        mark_core(s, beams, shells, tile, work)
    is_round = tile.nearest < ROUND_TIP
    if not is_round:
        _add_beams(s, beams, shells, tile, radius, has_core, all_free, keep, marks, work)
    if tile.farthest > radius:
        _forget_far(tile, radius, work)
    for i in range(min(TILE, s.box[1] - tile.ix)):
        for j in range(min(TILE, s.box[3] - tile.iy)):
            for part in range(depth):
                word = ((tile.ix + i) * ny + tile.iy + j) * depth + part
                sure = work.sure[part, i * TILE + j] & mask_of(s.box[4], s.box[5] - 1, part)
                open_ = (
                    keep[word] & ~sure & ~marks[word]
                    if work.is_wanted[i * TILE + j] and is_round
                    else np.uint64(0)
                )
                while open_ != 0:
                    level = lowest_bit(open_)
                    bit = np.uint64(1) << level
                    open_ ^= bit
                    if any_ray_hits(s, beams, (tile.ix + i, tile.iy + j, 64 * part + int(np.int64(level)))):
                        sure |= bit
                marks[word] |= sure


@parallel_kernel
def mark_sheets(
    s: Spinner,
    beams: Beams,
    shells: Shells,
    radius: float,
    first_row: int,
    end_row: int,
    keep: np.ndarray,
    workers: int,
    marks: np.ndarray,
) -> None:
    """Mark the voxels of the rows first_row..end_row-1 along x, a whole number of tiles, that a ray traverses, as far
    as the tiles lie within a radius in plan.

    keep uint64 (words,): voxels worth a test; marks uint64 (words,): every tile is marked by one worker.
    """
    depth, counter = (s.shape[2] + 63) // 64, new_counter()
    in_row = (s.box[3] - s.box[2] + TILE - 1) // TILE
    tiles = (end_row - first_row + TILE - 1) // TILE * in_row
    for _ in numba.prange(workers):
        work = work_space(beams.elevation.size, depth)
        place = take(counter)
        while place < tiles:
            tile = tile_at(s, first_row + place // in_row * TILE, s.box[2] + place % in_row * TILE)
            if tile.nearest < radius:
                _mark_tile(s, beams, shells, tile, radius, keep, marks, work)
            place = take(counter)
