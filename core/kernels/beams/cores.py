"""Cores of a LiDAR: between beams that are close together, and near enough, every voxel with its centre inside is hit.

Where some rays are stopped, only beams count of which all rays that pass the tile are cast.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.beams.cones import SLACK, Beams, Spinner, height, stopped_among
from riglens.core.kernels.beams.tiles import (
    COVERS,
    HALF_TILE,
    MISSES,
    MIXED,
    TILE,
    Tile,
    TileWork,
    add_levels,
    level_of,
)
from riglens.core.kernels.runtime.jit import inlined, kernel

NEARLY_ONE = 0.88
"""Voxels: more than from any point of a voxel to its centre."""


class Shells(NamedTuple):
    """Cores by number: the beams low and high (shells,) between which neighbours are close, and the squared radius of
    each; since (shells, beams): from which distance on, and until (shells,) which, all that a beam meets is in it."""

    low: np.ndarray
    high: np.ndarray
    squared: np.ndarray
    since: np.ndarray
    until: np.ndarray


@kernel
def mark_core(s: Spinner, beams: Beams, shells: Shells, tile: Tile, work: TileWork) -> None:
    """Set the bits of all voxels of a tile whose centre is in a core, between beams whose rays here are all cast."""
    for shell in range(shells.low.size):
        if tile.nearest * tile.nearest >= shells.squared[shell]:
            continue
        low, last = shells.low[shell], shells.high[shell]
        while low < last:
            high = low
            while high < last and work.free[high] == COVERS and work.free[high + 1] == COVERS:
                high += 1
            if high > low:
                _mark_between(s, beams, low, high, shells.squared[shell], tile, work)
            low = high + 1


@inlined
def _mark_between(
    s: Spinner, beams: Beams, low: int, high: int, squared: float, tile: Tile, work: TileWork
) -> None:
    """Set the bits of all voxels of a tile whose centre is between two beams and within a squared radius."""
    axis, levels = s.axis, work.hits
    fall_low, rise_low, open_low = beams.fall[low], beams.rise[low], beams.open[low]
    fall_high, rise_high, open_high = beams.fall[high], beams.rise[high], beams.open[high]
    for i in range(TILE):
        x = tile.x + i + 0.5
        for j in range(TILE):
            y = tile.y + j + 0.5
            flat, q = x * x + y * y, axis[0] * x + axis[1] * y
            tall = np.sqrt(max(squared - flat, 0.0))
            bottom = fall_low * q + rise_low * np.sqrt(q * q + open_low * flat)
            top = fall_high * q + rise_high * np.sqrt(q * q + open_high * flat)
            bottom, top = max(max(bottom, -tall), tile.low), min(min(top, tall), tile.high)
            levels[0, i * TILE + j] = level_of(bottom + (SLACK + 0.5 + s.origin[2]))
            levels[1, i * TILE + j] = level_of(top + (s.origin[2] - SLACK - 0.5))
    add_levels(levels, work.sure)


@inlined
def free_among(s: Spinner, beams: Beams, beam: int, place: tuple[float, float, float], around: float) -> int:
    """Return whether all, some or none of the rays of a beam that may pass a ball at a place on its cone are cast."""
    rays, stopped = stopped_among(s, beams, beam, place, around)
    return COVERS if stopped == 0 else MISSES if stopped == rays else MIXED


@kernel
def find_free(s: Spinner, beams: Beams, tile: Tile, work: TileWork) -> bool:
    """Write whether the rays of each beam that pass a tile are cast; returns whether all of all beams are."""
    work.free[:] = COVERS
    if s.is_stopped.size == 0:
        return True
    x, y, turns, all_free = tile.x + 0.5 * TILE, tile.y + 0.5 * TILE, s.azimuths.size, True
    for beam in range(beams.elevation.size):
        if not np.isfinite(beams.bend[beam]) or s.stopped_before[beam, turns] == 0:
            continue
        z = height(s.axis, beams, beam, x, y)
        spread = HALF_TILE * beams.slope[beam] + SLACK
        if z - spread > tile.high or z + spread < tile.low:
            continue
        around = HALF_TILE * np.sqrt(1.0 + beams.slope[beam] ** 2) + SLACK
        work.free[beam] = free_among(s, beams, beam, (x, y, z), around)
        all_free &= work.free[beam] == COVERS
    return all_free


@inlined
def is_in_core(shells: Shells, beam: int, nearest: float, farthest: float) -> bool:
    """Return whether all that a beam meets between two distances is in a core."""
    for shell in range(shells.low.size):
        if nearest >= shells.since[shell, beam] and farthest <= shells.until[shell]:
            return True
    return False


@inlined
def is_in_free_core(
    beams: Beams, shells: Shells, beam: int, nearest: float, farthest: float, free: np.ndarray
) -> bool:
    """Return the same where some rays are not cast: in a core between beams whose rays in the tile are all cast."""
    for shell in range(shells.low.size):
        first, last = shells.low[shell], shells.high[shell]
        if not first < beam < last or nearest < shells.since[shell, beam] or farthest > shells.until[shell]:
            continue
        low, high = beam, beam
        while low > first and free[low - 1] == COVERS:
            low -= 1
        while high < last and free[high + 1] == COVERS:
            high += 1
        inside = min(
            beams.elevation[beam] - beams.elevation[low], beams.elevation[high] - beams.elevation[beam]
        )
        if inside > 0.0 and nearest >= NEARLY_ONE / np.sin(min(inside, 1.5)):
            return True
    return False
