"""Which rays of a pinhole camera enter a road user, row by row from the outline of its parts.

The image of a box is convex, so the rays of a row that enter it lie between two places where the row crosses edges of
the box. Rays nearer to such a place than any rounding are tried one by one, with the numbers of `nearest`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.bits import FULL_WORD, level_mask, popcount
from riglens.core.kernels.jit import kernel, lean, lean_inlined
from riglens.core.kernels.lattice import Direction
from riglens.core.kernels.nearest import (
    Beams,
    Faces,
    Traffic,
    is_entered,
    set_centre,
    set_faces,
    set_turn,
    start_of,
)
from riglens.core.kernels.windows import corners_of

_BLUR = 1e-9
"""Rows nearer than this to a corner of an outline, relative to 1 + their place, are tried ray by ray."""
_STEEPEST = 1e3
"""So are rows that cross an edge which runs along them: more columns than rows by this factor."""
_BLUR_ACROSS = 2.0 * _STEEPEST * _BLUR
_AHEAD_M, _FAR_M, _THIN_M = 0.1, 1e4, 1e-3
"""Boxes with a corner nearer to the plane of the camera, farther away or thinner than this are left to `nearest`."""


class Outline(NamedTuple):
    """Room for the image of a box: faces of a part; centre (3,), corners (8, 3); y, z (8,) of the corners on the image
    plane; low, high (rows,): where a row enters and leaves a part; is_close (rows,): whether its rays are to be
    tried; mask (rows * words,) uint64: a bit for each ray that enters the box; bounds (4,): first and end row and word
    of the mask."""

    faces: Faces
    centre: np.ndarray
    corners: np.ndarray
    y: np.ndarray
    z: np.ndarray
    low: np.ndarray
    high: np.ndarray
    is_close: np.ndarray
    mask: np.ndarray
    bounds: np.ndarray


@kernel
def outline_for(faces: Faces, rows: int, columns: int) -> Outline:
    """Room for a camera of so many rows and columns."""
    return Outline(
        faces, np.empty(3), np.empty((8, 3)), np.empty(8), np.empty(8), np.empty(rows), np.empty(rows),
        np.empty(rows, np.bool_), np.empty(rows * words_of(columns), np.uint64), np.empty(4, np.int64),
    )  # fmt: skip


@lean_inlined
def words_of(columns: int) -> int:
    """Words of 64 bits for a row of rays."""
    return (columns + 63) >> 6


@lean_inlined
def draw_box(traffic: Traffic, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> bool:
    """Set the bits of the rays that enter a box; False where the outline cannot tell them."""
    start, half, turn = start_of(traffic, beams, box), traffic.halves[box], to.faces.turn
    set_turn(traffic, rotation, box, turn)
    if not _project(start, half, to):
        return False
    low, high = _bounds(to.z)
    left, right = _bounds(to.y)
    row, end = place_at(beams.row_at, low), place_at(beams.row_at, high)
    column, last = place_at(beams.column_at, left), place_at(beams.column_at, right)
    words, bounds = words_of(beams.columns), to.bounds
    bounds[0], bounds[1], bounds[2], bounds[3] = row, end, column >> 6, (last + 63) >> 6
    if row >= end or column >= last:
        bounds[1] = row
        return True
    to.mask[row * words : end * words] = 0
    for part in range(traffic.part_starts[box], traffic.part_starts[box + 1]):
        offset = traffic.offsets[part]
        place = (start[0] - offset[0], start[1] - offset[1], start[2] - offset[2])
        if not _project(place, traffic.part_halves[part], to):
            return False
        set_faces(place, traffic.part_halves[part], to.faces)
        _draw_part(beams, column, last, to)
    return True


@lean_inlined
def _project(start: Direction, half: np.ndarray, to: Outline) -> bool:
    """Take the corners of a box, in whose axes the sensor is at `start`, to the image plane; False where they are too
    near or too far for that."""
    set_centre(start, to.faces.turn, to.centre)
    corners_of(to.centre, to.faces.turn, half, to.corners)
    nearest, farthest = np.inf, 0.0
    for corner in range(8):
        x, y, z = to.corners[corner, 0], to.corners[corner, 1], to.corners[corner, 2]
        nearest, farthest = min(nearest, x), max(farthest, x, abs(y), abs(z))
        inverse = 1.0 / x
        to.y[corner], to.z[corner] = y * inverse, z * inverse
    return bool(
        nearest >= _AHEAD_M and farthest <= _FAR_M and min(half[0], half[1], half[2]) >= _THIN_M / 2.0
    )


@lean_inlined
def _bounds(values: np.ndarray) -> tuple[float, float]:
    """Least and greatest of the places of corners, a little more apart."""
    low, high = np.inf, -np.inf
    for corner in range(8):
        low, high = min(low, values[corner]), max(high, values[corner])
    return low - _BLUR_ACROSS * (1.0 + abs(low)), high + _BLUR_ACROSS * (1.0 + abs(high))


@lean_inlined
def place_at(at: np.ndarray, value: float) -> int:
    """First place of rising numbers, at about even steps, that is not below a value; their number if all are."""
    count = at.size
    if value <= at[0]:
        return 0
    if value > at[count - 1]:
        return count
    place = int((value - at[0]) * ((count - 1) / (at[count - 1] - at[0])))
    place = max(0, min(place, count - 1))
    while place > 0 and at[place - 1] >= value:
        place -= 1
    while at[place] < value:
        place += 1
    return place


@lean_inlined
def _draw_part(beams: Beams, column: int, last: int, to: Outline) -> None:
    """Set the bits of the rays that enter a part, between two columns."""
    low, high = _bounds(to.z)
    row, end = place_at(beams.row_at, low), place_at(beams.row_at, high)
    for place in range(row, end):
        to.low[place], to.high[place], to.is_close[place] = np.inf, -np.inf, False
    for corner in range(8):
        for axis in range(3):
            other = corner | (1 << axis)
            if other != corner:
                _cross(beams, corner, other, to)
    for place in range(row, end):
        if to.is_close[place]:
            _try(beams, place, column, last, to)
        elif to.low[place] <= to.high[place]:
            _fill(beams, place, to)


@lean_inlined
def _cross(beams: Beams, one: int, other: int, to: Outline) -> None:
    """Note where rows cross the edge between two corners."""
    if to.z[one] > to.z[other]:
        one, other = other, one
    bottom, top, y = to.z[one], to.z[other], to.y[one]
    rise, run, row_at = top - bottom, to.y[other] - y, beams.row_at
    blur = _BLUR * (1.0 + max(abs(bottom), abs(top)))
    row = place_at(row_at, bottom - blur)
    is_steep = abs(run) > _STEEPEST * rise
    slope = run / rise if rise > 0.0 else 0.0
    while row < row_at.size and row_at[row] <= top + blur:
        z = row_at[row]
        if is_steep or z < bottom + blur or z > top - blur:
            to.is_close[row] = True
        crossed = y + (z - bottom) * slope
        to.low[row], to.high[row] = min(to.low[row], crossed), max(to.high[row], crossed)
        row += 1


@lean_inlined
def _fill(beams: Beams, row: int, to: Outline) -> None:
    """Set the bits of a row between its two crossings."""
    at, low, high = beams.column_at, to.low[row], to.high[row]
    low_blur, high_blur = _BLUR_ACROSS * (1.0 + abs(low)), _BLUR_ACROSS * (1.0 + abs(high))
    first = place_at(at, low - low_blur)
    begin = first
    while begin < at.size and at[begin] < low + low_blur:
        begin += 1
    end = max(begin, place_at(at, high - high_blur))
    last = end
    while last < at.size and at[last] <= high + high_blur:
        last += 1
    base = row * words_of(beams.columns)
    if begin < end:
        _set_bits(to.mask, base, begin, end - 1)
    if first < begin:
        _try(beams, row, first, begin, to)
    if end < last:
        _try(beams, row, end, last, to)


@lean_inlined
def _set_bits(mask: np.ndarray, base: int, first: int, last: int) -> None:
    """Set bits first..last of a row whose words begin at `base`."""
    word, end = first >> 6, last >> 6
    if word == end:
        mask[base + word] |= level_mask(first & 63, last & 63)
        return
    mask[base + word] |= level_mask(first & 63, 63)
    for between in range(word + 1, end):
        mask[base + between] = FULL_WORD
    mask[base + end] |= level_mask(0, last & 63)


@lean
def _try(beams: Beams, row: int, column: int, last: int, to: Outline) -> None:
    """Set the bits of those rays of a row, from a column to before another, that enter a part."""
    base = row * words_of(beams.columns)
    for place in range(column, last):
        if is_entered(beams, to.faces, row, place):
            to.mask[base + (place >> 6)] |= np.uint64(1) << np.uint64(place & 63)


@lean_inlined
def is_stopped_before(beams: Beams, outline: Outline) -> bool:
    """Whether the car's own body stops any ray of an outline somewhere."""
    words, bounds = words_of(beams.columns), outline.bounds
    for row in range(bounds[0], bounds[1]):
        for word in range(row * words + bounds[2], row * words + bounds[3]):
            if outline.mask[word] & beams.stops[word]:
                return True
    return False


@lean_inlined
def count_outline(beams: Beams, outline: Outline, seen: np.ndarray) -> tuple[int, int, int, int]:
    """How many rays of an outline there are, how many of them have met nothing so far, and the first and last number
    of a row among these, -1 if none; `seen`, a bit for each ray that has, takes them all."""
    alone, rays, first, last = 0, 0, -1, -1
    words, bounds = words_of(beams.columns), outline.bounds
    for row in range(bounds[0], bounds[1]):
        free = 0
        for word in range(row * words + bounds[2], row * words + bounds[3]):
            mask = outline.mask[word]
            if mask:
                alone += int(popcount(mask))
                free += int(popcount(mask & ~seen[word]))
                seen[word] |= mask
        if free > 0:
            rays, number = rays + free, beams.row_of[row]
            first = min(first, number) if first >= 0 else number
            last = max(last, number)
    return alone, rays, first, last
