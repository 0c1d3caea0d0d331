"""Find the rays of a pinhole camera that enter an object, row by row from the outline of its parts.

The image of a box is convex, so the rays of a row that enter it lie between two places where the row crosses edges of
the box. Rays nearer to such a place than any rounding are tried one by one, with the numbers of `nearest`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    Faces,
    FrameBoxes,
    bounds_of,
    half_of,
    parts_of,
    set_centre,
    set_faces,
    set_turn,
    start_of,
)
from riglens.core.kernels.objects.nearest import is_entered
from riglens.core.kernels.objects.windows import corners_of, place_at
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined
from riglens.core.kernels.voxels.bits import FULL_WORD, level_mask, popcount

_BLUR = 1e-9
"""Rows nearer than this to a corner of an outline, relative to 1 + their place, are tried ray by ray."""
_STEEPEST = 1e3
"""Slope, columns per row, of an edge beyond which the rows that cross it are tried ray by ray, too."""
_BLUR_ACROSS = 2.0 * _STEEPEST * _BLUR
_AHEAD_M, _FAR_M, _THIN_M = 0.1, 1e4, 1e-3
"""Distance to the plane of the camera at which boxes are cut. Boxes that may come nearer within the picture, and
farther or thinner ones, are left to `nearest`."""
_CORNERS, _CUTS = 8, 6


class Outline(NamedTuple):
    """Room for the image of a box: faces of a part; centre (3,), corners (8, 3); y, z (14,): places of the corners on
    the image plane, and from the ninth on of where edges are cut; ahead (14,): the corner that is left of such an edge;
    low, high (rows,): where a row enters and leaves a part; is_close (rows,): whether its rays are to be tried; mask
    (rows * words,) uint64: a bit for each ray that enters the box; bounds (4,): first and end row and word of the
    mask."""

    faces: Faces
    centre: np.ndarray
    corners: np.ndarray
    y: np.ndarray
    z: np.ndarray
    ahead: np.ndarray
    low: np.ndarray
    high: np.ndarray
    is_close: np.ndarray
    mask: np.ndarray
    bounds: np.ndarray


@kernel
def outline_for(faces: Faces, rows: int, columns: int) -> Outline:
    """Return room for a camera of `rows` rows and `columns` columns."""
    return Outline(
        faces, np.empty(3), np.empty((_CORNERS, 3)), np.empty(_CORNERS + _CUTS), np.empty(_CORNERS + _CUTS),
        np.empty(_CORNERS + _CUTS, np.int64), np.empty(rows), np.empty(rows),
        np.empty(rows, np.bool_), np.empty(rows * words_of(columns), np.uint64), np.empty(4, np.int64),
    )  # fmt: skip


@lean_inlined
def words_of(columns: int) -> int:
    """Return the number of 64-bit words that hold a row of rays."""
    return (columns + 63) >> 6


@lean_inlined
def draw_box(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> bool:
    """Set the bits of the rays that enter a box; return False where the outline cannot decide."""
    start, half, turn = start_of(traffic, beams, box), half_of(traffic, box), to.faces.turn
    set_turn(traffic, rotation, box, turn)
    if not _can_be_drawn(traffic, beams, box, start):
        return False
    count, bounds, words = _project(start, half, to), to.bounds, words_of(beams.columns)
    row, end = _places_between(beams.row_at, to.z, count, to)
    column, last = _places_between(beams.column_at, to.y, count, to)
    bounds[0], bounds[1], bounds[2], bounds[3] = row, end, column >> 6, (last + 63) >> 6
    if row >= end or column >= last:
        bounds[1] = row
        return True
    to.mask[row * words : end * words] = 0
    for part in range(*parts_of(traffic, box)):
        middle, part_half = bounds_of(traffic, part)
        place = (start[0] - middle[0], start[1] - middle[1], start[2] - middle[2])
        count = _project(place, part_half, to)
        set_faces(place, part_half, to.faces)
        _draw_part(beams, count, column, last, to)
    return True


@lean_inlined
def _can_be_drawn(traffic: FrameBoxes, beams: Beams, box: int, start: Direction) -> bool:
    """Return whether a box is not so near that rays may meet it before they are as far ahead as boxes are cut, nor too
    far or too thin for outlines."""
    half, thin, near2, far2 = half_of(traffic, box), np.inf, 0.0, 0.0
    for axis in range(3):
        near, far = max(abs(start[axis]) - half[axis], 0.0), abs(start[axis]) + half[axis]
        near2, far2 = near2 + near * near, far2 + far * far
    for part in range(*parts_of(traffic, box)):
        _, part_half = bounds_of(traffic, part)
        thin = min(thin, part_half[0], part_half[1], part_half[2])
    ahead = np.sqrt(near2) * beams.field[0]
    return bool(ahead > 1.001 * _AHEAD_M and far2 < _FAR_M * _FAR_M and 2.0 * thin >= _THIN_M)


@lean_inlined
def _project(start: Direction, half: Direction, to: Outline) -> int:
    """Project the corners of a box, in whose axes the sensor is at `start`, to the image plane, and behind them the
    places where its edges are cut; return the number filled."""
    set_centre(start, to.faces.turn, to.centre)
    corners_of(to.centre, to.faces.turn, half, to.corners)
    count = _CORNERS
    for corner in range(_CORNERS):
        x = to.corners[corner, 0]
        if x >= _AHEAD_M:
            to.y[corner], to.z[corner] = to.corners[corner, 1] / x, to.corners[corner, 2] / x
            continue
        for axis in range(3):
            other = corner ^ (1 << axis)
            far = to.corners[other, 0]
            if far >= _AHEAD_M:
                share = (_AHEAD_M - x) / (far - x)
                y = to.corners[corner, 1] + share * (to.corners[other, 1] - to.corners[corner, 1])
                z = to.corners[corner, 2] + share * (to.corners[other, 2] - to.corners[corner, 2])
                to.y[count], to.z[count] = y / _AHEAD_M, z / _AHEAD_M
                to.ahead[count] = other
                count += 1
    return count


@lean_inlined
def _places_between(at: np.ndarray, values: np.ndarray, count: int, to: Outline) -> tuple[int, int]:
    """Return the first and end place of rising numbers between the places of all corners and cuts, a little more
    apart."""
    low, high = np.inf, -np.inf
    for corner in range(count):
        if corner >= _CORNERS or to.corners[corner, 0] >= _AHEAD_M:
            low, high = min(low, values[corner]), max(high, values[corner])
    if not low <= high:
        return 0, 0
    low, high = low - _BLUR_ACROSS * (1.0 + abs(low)), high + _BLUR_ACROSS * (1.0 + abs(high))
    return place_at(at, low), place_at(at, high)


@lean_inlined
def _draw_part(beams: Beams, count: int, column: int, last: int, to: Outline) -> None:
    """Set the bits of the rays that enter a part, between two columns."""
    row, end = _places_between(beams.row_at, to.z, count, to)
    for place in range(row, end):
        to.low[place], to.high[place], to.is_close[place] = np.inf, -np.inf, False
    for corner in range(_CORNERS):
        for axis in range(3):
            other = corner | (1 << axis)
            if other != corner and min(to.corners[corner, 0], to.corners[other, 0]) >= _AHEAD_M:
                _cross(beams, corner, other, to)
    for cut in range(_CORNERS, count):
        _cross(beams, to.ahead[cut], cut, to)
        for other in range(_CORNERS, cut):
            _cross(beams, other, cut, to)
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
    """Return whether the car's own body stops any ray of an outline somewhere."""
    words, bounds = words_of(beams.columns), outline.bounds
    for row in range(bounds[0], bounds[1]):
        for word in range(row * words + bounds[2], row * words + bounds[3]):
            if outline.mask[word] & beams.stops[word]:
                return True
    return False


@lean_inlined
def count_outline(beams: Beams, outline: Outline, seen: np.ndarray) -> tuple[int, int, int, int]:
    """Count the rays of an outline and those without a hit so far, and return the first and last number of a row among
    the latter, -1 if none; `seen`, a bit for each ray with a hit, takes them all."""
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
