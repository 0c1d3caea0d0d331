"""Find the voxels of one column that the rays of one beam traverse: the rays that pass it lie side by side, so the
search begins at the middle of the column and ends on either side with the first ray that misses it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.beams.cones import (
    A_TURN,
    CLEAR,
    LONGEST,
    Beams,
    Spinner,
    around,
    axis_times,
    azimuth_of,
    height,
    is_cast,
    place_of,
    ray_direction,
)
from riglens.core.kernels.beams.tiles import TILE, Tile, TileWork
from riglens.core.kernels.rays.walk import Ray, hits_cell
from riglens.core.kernels.runtime.jit import lean, lean_inlined
from riglens.core.kernels.voxels.bits import lowest_bit, mask_of

PAST, CLOSE, INSIDE = 0, 1, 2
"""Relation of a ray to a column: past it, too close to its edges for doubles to tell, or through it."""
NONE = (1, 0)
"""No levels: the first one is above the last."""


@lean_inlined
def first_turn(s: Spinner, beams: Beams, beam: int, x: float, y: float) -> int:
    """Return roughly the number of azimuths of a beam before the one that leads to a place in plan, seen from the
    sensor."""
    z = height(s.axis, beams, beam, x, y)
    r = s.rotation
    u, v = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z, r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
    past = azimuth_of(u, v) - beams.offset[beam] - s.azimuths[0]
    return place_of(s, past - np.floor(past / A_TURN) * A_TURN)


@lean_inlined
def _levels_in(s: Spinner, d: tuple[float, float, float], ix: int, iy: int) -> tuple[int, int, int]:
    """Return whether a ray passes through a column, and the first and last level in which it does; `NONE` where its
    range ends before or nothing is certain. Without branches, which could not be predicted."""
    t_in, t_out = axis_times(s.origin[0], 1.0 / d[0], ix, -LONGEST, LONGEST)
    t_in, t_out = axis_times(s.origin[1], 1.0 / d[1], iy, t_in, t_out)
    is_slanted = (d[0] != 0.0) & (d[1] != 0.0)
    is_past = is_slanted & (t_out < t_in - CLEAR)
    is_in = is_slanted & (t_out > t_in + CLEAR) & (t_in > -LONGEST) & (t_out < LONGEST)
    begin, end = max(t_in, s.reach[0]), min(t_out, s.reach[1])
    a, b = s.origin[2] + begin * d[2], s.origin[2] + end * d[2]
    low, high = min(a, b), max(a, b)
    first, last = np.floor(low), np.floor(high)
    room = min(min(low - first, first + 1.0 - low), min(high - last, last + 1.0 - high))
    is_met = is_in & (end > begin + CLEAR) & (room > CLEAR)
    is_out = is_in & (end < begin - CLEAR)
    passes = PAST if is_past else INSIDE if is_met | is_out else CLOSE
    return passes, (int(first) if is_met else NONE[0]), (int(last) if is_met else NONE[1])


@lean_inlined
def _turn_at(s: Spinner, turn: int) -> int:
    """Return the number in the table of an azimuth, at most one turn too far either way."""
    return int(s.turns[around(turn, s.azimuths.size)[0]])


class Column(NamedTuple):
    """A column listed: where it is in the grid and in its tile, its first word, and the levels that a beam can meet."""

    ix: int
    iy: int
    place: int
    word: int
    low: int
    high: int


@lean_inlined
def _column(s: Spinner, tile: Tile, work: TileWork, number: int) -> Column:
    """Return a column by its number in the list."""
    listed, place = work.listed, int(work.listed[0, number])
    ix, iy = tile.ix + place // TILE, tile.iy + place % TILE
    word = (ix * s.shape[1] + iy) * ((s.shape[2] + 63) // 64)
    return Column(ix, iy, place, word, int(listed[2, number]), int(listed[3, number]))


@lean_inlined
def _is_open(c: Column, keep: np.ndarray, marks: np.ndarray, sure: np.ndarray) -> bool:
    """Return whether a column has voxels worth a test that are not marked yet."""
    left = False
    for part in range(sure.shape[0]):
        wanted = keep[c.word + part] & ~marks[c.word + part] & ~sure[part, c.place]
        left |= wanted & mask_of(c.low, c.high, part) != 0
    return left


@lean
def _test_exactly(ray: Ray, c: Column, sure: np.ndarray) -> None:
    """Add the voxels of a column that a ray traverses, each decided exactly."""
    for part in range(sure.shape[0]):
        left = mask_of(c.low, c.high, part) & ~sure[part, c.place]
        while left != 0:
            bit = left & (~left + np.uint64(1))
            left ^= bit
            if hits_cell(ray, (c.ix, c.iy, 64 * part + int(np.int64(lowest_bit(bit))))):
                sure[part, c.place] |= bit


@lean_inlined
def _search(
    s: Spinner,
    row: int,
    c: Column,
    turn: int,
    step: int,
    keep: np.ndarray,
    marks: np.ndarray,
    sure: np.ndarray,
) -> None:
    """Add the voxels that the rays of a beam traverse from one azimuth on, one after the other up to the first that
    misses."""
    turn %= s.azimuths.size  # all rays of a narrow sector may pass a column: then this goes once round
    for _ in range(s.azimuths.size):
        here = _turn_at(s, turn)
        d = ray_direction(s, row, here)
        passes, first, last = _levels_in(s, d, c.ix, c.iy)
        if passes == PAST:
            return
        if is_cast(s, row, here):
            if passes == CLOSE:
                g = (s.origin[0], s.origin[1], s.origin[2])
                _test_exactly(Ray(g, d, s.reach[0], s.reach[1]), c, sure)
            for part in range(sure.shape[0]):
                sure[part, c.place] |= mask_of(first, last, part)
            if not _is_open(c, keep, marks, sure):
                return
        turn += step


@lean_inlined
def _keep_open(
    s: Spinner, tile: Tile, count: int, keep: np.ndarray, marks: np.ndarray, work: TileWork
) -> int:
    """Keep the listed columns that are still open; return their number."""
    left, listed, low, high = 0, work.listed, np.int32(s.box[4]), np.int32(s.box[5] - 1)
    for i in range(count):
        listed[0, left], listed[1, left] = listed[0, i], listed[1, i]
        listed[2, left], listed[3, left] = max(listed[2, i], low), min(listed[3, i], high)
        left += int(_is_open(_column(s, tile, work, left), keep, marks, work.sure))
    return left


@lean_inlined
def _look_beside(s: Spinner, beams: Beams, tile: Tile, count: int, work: TileWork) -> None:
    """Write for each listed column the first azimuth behind its middle, and the result of the rays on either side of
    it: into work.beside (7, LISTED_MOST). Without branches, which could not be predicted."""
    beside = work.beside
    for i in range(count):
        c = _column(s, tile, work, i)
        x, y = c.ix + 0.5 - s.origin[0], c.iy + 0.5 - s.origin[1]
        beside[0, i] = first_turn(s, beams, work.listed[1, i], x, y)
    for i in range(count):
        c, row = _column(s, tile, work, i), beams.number[work.listed[1, i]]
        for side in range(2):
            here, to = _turn_at(s, beside[0, i] - side), 1 + 3 * side
            passes, first, last = _levels_in(s, ray_direction(s, row, here), c.ix, c.iy)
            beside[to, i], beside[to + 1, i] = passes, first
            beside[to + 2, i] = last if is_cast(s, row, here) else first - 1


@lean
def test_listed(
    s: Spinner, beams: Beams, tile: Tile, count: int, keep: np.ndarray, marks: np.ndarray, work: TileWork
) -> None:
    """Decide the listed columns of a tile: first by the rays next to the middle of each, then, where something is still
    open and one of these passes, by those farther away."""
    sure, beside = work.sure, work.beside
    count = _keep_open(s, tile, count, keep, marks, work)
    _look_beside(s, beams, tile, count, work)
    for i in range(count):
        c = _column(s, tile, work, i)
        for part in range(sure.shape[0]):
            both = mask_of(beside[2, i], beside[3, i], part) | mask_of(beside[5, i], beside[6, i], part)
            sure[part, c.place] |= both
        for side in range(2):
            passes = beside[1 + 3 * side, i]
            if passes != PAST and _is_open(c, keep, marks, sure):
                step = 1 - 2 * side
                turn = beside[0, i] - side + (step if passes == INSIDE else 0)
                _search(s, beams.number[work.listed[1, i]], c, turn, step, keep, marks, sure)
