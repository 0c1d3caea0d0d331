"""Which voxels of one column the rays of one beam traverse: the rays that pass it lie side by side, so the search
begins at the middle of the column and ends on either side with the first ray that misses it."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.bits import lowest_bit
from riglens.core.kernels.cones import (
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
from riglens.core.kernels.jit import lean, lean_inlined
from riglens.core.kernels.tiles import TILE, Tile, TileWork, mask_of
from riglens.core.kernels.walk import Ray, hits_cell

PAST, CLOSE, INSIDE = 0, 1, 2
"""Whether a ray passes beside a column, too close to its edges to be told in doubles, or through it."""


@lean_inlined
def first_turn(s: Spinner, beams: Beams, beam: int, x: float, y: float) -> int:
    """How many azimuths of a beam come before the one that leads to a place in plan, seen from the sensor; roughly."""
    z = height(s.axis, beams, beam, x, y)
    r = s.rotation
    u, v = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z, r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
    past = azimuth_of(u, v) - beams.offset[beam] - s.azimuths[0]
    return place_of(s, past - np.floor(past / A_TURN) * A_TURN)


@lean_inlined
def _levels_in(s: Spinner, d: tuple[float, float, float], ix: int, iy: int) -> tuple[int, tuple[int, int]]:
    """Whether a ray passes through a column and the levels first..last, in that order, between which it does; none,
    (1, 0), where its range ends before."""
    if d[0] == 0.0 or d[1] == 0.0:
        return CLOSE, (1, 0)
    t_in, t_out = axis_times(s.origin[0], 1.0 / d[0], ix, -LONGEST, LONGEST)
    t_in, t_out = axis_times(s.origin[1], 1.0 / d[1], iy, t_in, t_out)
    if t_out < t_in - CLEAR:
        return PAST, (1, 0)
    begin, end = max(t_in, s.reach[0]), min(t_out, s.reach[1])
    if t_out > t_in + CLEAR and end < begin - CLEAR:
        return INSIDE, (1, 0)
    a, b = s.origin[2] + begin * d[2], s.origin[2] + end * d[2]
    low, high = np.floor(min(a, b)), np.floor(max(a, b))
    room = min(min(a, b) - low, high + 1.0 - max(a, b))
    room = min(room, min(low + 1.0 - min(a, b), max(a, b) - high))
    is_clear = end > begin + CLEAR and t_in > -LONGEST and t_out < LONGEST and room > CLEAR
    return (INSIDE, (int(low), int(high))) if is_clear else (CLOSE, (1, 0))


@lean_inlined
def _is_open(
    keep: np.ndarray, marks: np.ndarray, word: int, place: int, levels: tuple[int, int], sure: np.ndarray
) -> bool:
    """Whether a column has voxels worth a test, in some levels, that are not marked yet."""
    left = False
    for part in range(sure.shape[0]):
        wanted = keep[word + part] & ~marks[word + part] & ~sure[part, place]
        left |= wanted & mask_of(levels[0], levels[1], part) != 0
    return left


@lean
def _test_exactly(
    s: Spinner,
    d: tuple[float, float, float],
    column: tuple[int, int],
    place: int,
    levels: tuple[int, int],
    sure: np.ndarray,
) -> None:
    """Add the voxels of a column that a ray traverses, of some levels, each decided exactly."""
    ray = Ray((s.origin[0], s.origin[1], s.origin[2]), d, s.reach[0], s.reach[1])
    for part in range(sure.shape[0]):
        left = mask_of(levels[0], levels[1], part) & ~sure[part, place]
        while left != 0:
            bit = left & (~left + np.uint64(1))
            left ^= bit
            if hits_cell(ray, (column[0], column[1], 64 * part + int(np.int64(lowest_bit(bit))))):
                sure[part, place] |= bit


@lean
def test_column(
    s: Spinner,
    beams: Beams,
    beam: int,
    column: tuple[int, int],
    place: int,
    levels: tuple[int, int],
    word: int,
    keep: np.ndarray,
    marks: np.ndarray,
    sure: np.ndarray,
) -> None:
    """Add to sure (words per column, columns) what the rays of a beam traverse in one column, of the levels that the
    beam can meet there; ends early where all that is worth it is found."""
    x, y = column[0] + 0.5 - s.origin[0], column[1] + 0.5 - s.origin[1]
    middle, row = first_turn(s, beams, beam, x, y), beams.number[beam]
    for step in (1, -1):
        turn = middle if step > 0 else middle - 1
        for _ in range(s.azimuths.size):
            here = s.turns[around(turn, s.azimuths.size)[0]]
            d = ray_direction(s, row, here)
            passes, met = _levels_in(s, d, column[0], column[1])
            if passes == PAST:
                break
            if is_cast(s, row, here):
                if passes == CLOSE:
                    _test_exactly(s, d, column, place, levels, sure)
                for part in range(sure.shape[0]):
                    sure[part, place] |= mask_of(met[0], met[1], part)
                if not _is_open(keep, marks, word, place, levels, sure):
                    return
            turn += step


@lean
def test_listed(
    s: Spinner, beams: Beams, tile: Tile, count: int, keep: np.ndarray, marks: np.ndarray, work: TileWork
) -> None:
    """Decide the columns listed of a tile, one beam and column after the other."""
    depth = (s.shape[2] + 63) // 64
    for i in range(count):
        place, beam = work.listed[0, i], work.listed[1, i]
        levels = max(int(work.listed[2, i]), s.box[4]), min(int(work.listed[3, i]), s.box[5] - 1)
        ix, iy = tile.ix + place // TILE, tile.iy + place % TILE
        word = (ix * s.shape[1] + iy) * depth
        if _is_open(keep, marks, word, place, levels, work.sure):
            test_column(s, beams, beam, (ix, iy), place, levels, word, keep, marks, work.sure)
