"""Find the rays that enter an object row by row from the outline of its parts, where rows are straight in an image.

The rows of a pinhole camera are, and the azimuths of a sector are upright lines. The image of a box is convex, so the
rays of a row that enter it lie between two places where the row crosses edges of the box. Rays nearer to such a place
than any rounding are tried one by one, with the numbers of `nearest`, and so are all of them where a range ends within
the box. Rays of a bent lens are taken tile by tile (`kernels.rays.tiles`).
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
    limit_of,
    parts_of,
    set_centre,
    set_faces,
    set_turn,
    start_of,
)
from riglens.core.kernels.objects.nearest import find_entries
from riglens.core.kernels.objects.part_sides import set_sides
from riglens.core.kernels.objects.windows import corners_of, place_at
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.rays.tiles import (
    AFTER,
    COLUMN,
    COLUMNS,
    IS_FULL,
    OWN_RAYS,
    ROW,
    cuts_of,
    rows_of,
    span_of,
)
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined
from riglens.core.kernels.voxels.bits import FULL_WORD, level_mask

_BLUR = 1e-9
"""Rows nearer than this to a corner of an outline, relative to 1 + their place, are tried ray by ray."""
_STEEPEST = 1e3
"""Slope, columns per row, of an edge beyond which the rows that cross it are tried ray by ray, too."""
_BLUR_ACROSS = 2.0 * _STEEPEST * _BLUR
_AHEAD_M, _FAR_M, _THIN_M = 0.1, 1e4, 1e-3
"""Distance to the plane of the camera at which boxes are cut. Boxes that may come nearer within the picture, and
farther or thinner ones, are left to `nearest`."""
_CORNERS, _CUTS = 8, 6
_WIDER = 1.0 + 1e-9
"""Distances are compared with ranges with as much room."""


NOT_DRAWN, DRAWN, TESTED, HIDING = 0, 1, 2, 3
"""Results of `draw_box`: the outline cannot decide; it did; each ray in it was tried against the ranges, too; it did,
for a box that is out of range for its class, but hides what is behind it."""


class Outline(NamedTuple):
    """Room for the image of a box: faces of a part; centre (3,), corners (8, 3); along, across (14,): places of the
    corners along the rows of the image and across them, and from the ninth on of where edges are cut; ahead (14,): the
    corner that is left of such an edge; low, high (rows,): where a row enters and leaves a part; is_close (rows,):
    whether its rays are to be tried; mask (2, rows * words) uint64: bits for each ray that enters the box, and for
    those that do within the range of its class; bounds (4,): first and end row and word of the mask; run (columns,): of
    the rays that are tried, 1 / t at which they enter, or 0."""

    faces: Faces
    centre: np.ndarray
    corners: np.ndarray
    along: np.ndarray
    across: np.ndarray
    ahead: np.ndarray
    low: np.ndarray
    high: np.ndarray
    is_close: np.ndarray
    mask: np.ndarray
    bounds: np.ndarray
    run: np.ndarray


@kernel
def outline_for(faces: Faces, rows: int, columns: int) -> Outline:
    """Return room for a lattice of `rows` rows and `columns` columns."""
    places = _CORNERS + _CUTS
    return Outline(
        faces, np.empty(3), np.empty((_CORNERS, 3)), np.empty(places), np.empty(places), np.empty(places, np.int64),
        np.empty(rows), np.empty(rows), np.empty(rows, np.bool_), np.zeros((2, rows * words_of(columns)), np.uint64),
        np.zeros(4, np.int64), np.empty(columns),
    )  # fmt: skip


@lean_inlined
def words_of(columns: int) -> int:
    """Return the number of 64-bit words that hold a row of rays."""
    return (columns + 63) >> 6


@lean_inlined
def draw_box(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> int:
    """Set the bits of the rays that enter a box, and where they are TESTED also of those that do
    within the range of its class; return NOT_DRAWN where the outline cannot decide."""
    if beams.row_at.size == 0:
        return draw_by_tiles(traffic, beams, box, rotation, to) if beams.limits.size == 0 else NOT_DRAWN
    start, half, turn = start_of(traffic, beams, box), half_of(traffic, box), to.faces.turn
    set_turn(traffic, rotation, box, turn)
    found = _way_of(traffic, beams, box, start)
    if found == NOT_DRAWN:
        return found
    count, bounds, words = _project(beams, start, half, to), to.bounds, words_of(beams.columns)
    row, end = _places_between(beams.row_at, to.across, count, to)
    column, last = _columns_between(beams, count, row, end, to)
    bounds[0], bounds[1], bounds[2], bounds[3] = row, end, column >> 6, (last + 63) >> 6
    if row >= end or column >= last:
        bounds[1] = row
        return found
    to.mask[0, row * words : end * words] = 0
    if found == TESTED:
        to.mask[1, row * words : end * words] = 0
    for part in range(*parts_of(traffic, box)):
        middle, part_half = bounds_of(traffic, part)
        place = (start[0] - middle[0], start[1] - middle[1], start[2] - middle[2])
        count = _project(beams, place, part_half, to)
        set_faces(place, part_half, to.faces)
        _draw_part(traffic, beams, box, found == TESTED, count, column, last, to)
    return found


@lean
def draw_by_tiles(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> int:
    """As `draw_box`, for rays in any directions: those of a tile enter a part, miss it, or are cut row by row."""
    start, bounds, words = start_of(traffic, beams, box), to.bounds, words_of(beams.columns)
    set_turn(traffic, rotation, box, to.faces.turn)
    for row in range(bounds[0], bounds[1]):  # of the box before
        to.mask[0, row * words + bounds[2] : row * words + bounds[3]] = 0
    bounds[0], bounds[1], bounds[2], bounds[3] = beams.row_of.size, 0, words, 0
    for part in range(*parts_of(traffic, box)):
        middle, part_half = bounds_of(traffic, part)
        place = (start[0] - middle[0], start[1] - middle[1], start[2] - middle[2])
        set_faces(place, part_half, to.faces)
        sides, number = set_sides(beams.reach[0], beams.reach[1], to.faces), 0
        while number < beams.tiles.shape[0]:
            tile = beams.tiles[number]
            cuts = cuts_of(tile, sides, to.faces.sides)
            number += 1
            if cuts < 0:
                number = int(tile[AFTER])
            elif tile[OWN_RAYS] > 0.0:
                _draw_tile(beams, tile, cuts, to)
    return DRAWN


@lean_inlined
def _draw_tile(beams: Beams, tile: np.ndarray, cuts: int, to: Outline) -> None:
    """Set the bits of the rays of a tile that enter a part; its columns share a word."""
    top, column, bounds, span = int(tile[ROW]), int(tile[COLUMN]), to.bounds, to.faces.sides.span
    places, word, words = rows_of(tile, cuts, to.faces.sides), column >> 6, words_of(beams.columns)
    first, end = top + places[0], top + places[1]
    if first >= end:
        return
    bounds[0], bounds[1] = min(bounds[0], first), max(bounds[1], end)
    bounds[2], bounds[3] = min(bounds[2], word), max(bounds[3], word + 1)
    is_full, low = tile[IS_FULL] > 0.0, column & 63
    if cuts == 0 and is_full:
        mask = level_mask(low, low + int(tile[COLUMNS]) - 1)
        for row in range(first, end):
            to.mask[0, row * words + word] |= mask
        return
    for row in range(first, end):
        span_of(tile, row - top, cuts, to.faces.sides)
        if is_full and span[2] < span[3]:
            to.mask[0, row * words + word] |= level_mask(low + span[2], low + span[3] - 1)
            if span[0] < span[2]:
                _try_run(beams, row, column + span[0], column + span[2], False, 0.0, to)
            if span[3] < span[1]:
                _try_run(beams, row, column + span[3], column + span[1], False, 0.0, to)
        elif span[0] < span[1]:
            _try_run(beams, row, column + span[0], column + span[1], False, 0.0, to)


@lean_inlined
def _way_of(traffic: FrameBoxes, beams: Beams, box: int, start: Direction) -> int:
    """Return NOT_DRAWN for a box that is so near that rays may meet it before they are as far
    ahead as boxes are cut or as their range begins, or too far or too thin for outlines; TESTED
    for one in which a range may end."""
    half, thin, near2, far2, entry2 = half_of(traffic, box), np.inf, 0.0, 0.0, 0.0
    is_endless = beams.limits.size == 0 and beams.reach[1] == np.inf
    for axis in range(3):
        near, far = max(abs(start[axis]) - half[axis], 0.0), abs(start[axis]) + half[axis]
        near2, far2 = near2 + near * near, far2 + far * far
    for part in range(*parts_of(traffic, box)):
        middle, part_half = bounds_of(traffic, part)
        thin = min(thin, part_half[0], part_half[1], part_half[2])
        if not is_endless:
            entry2 = max(entry2, _last_entry2(start, middle, part_half))
    ahead = np.sqrt(near2) * beams.field[0]
    if not (ahead > 1.001 * _AHEAD_M and far2 < _FAR_M * _FAR_M and 2.0 * thin >= _THIN_M):
        return NOT_DRAWN
    limit, least = limit_of(traffic, beams, box, 0) * _WIDER, beams.reach[0] * _WIDER
    if near2 <= least * least:
        return NOT_DRAWN
    if is_endless:
        return DRAWN
    if entry2 * _WIDER**2 >= beams.reach[1] * beams.reach[1]:
        return TESTED
    if near2 > limit * limit:
        return HIDING
    return TESTED if entry2 * _WIDER**4 >= limit * limit else DRAWN


@lean_inlined
def _last_entry2(start: Direction, middle: Direction, half: Direction) -> float:
    """Return the square of the distance beyond which no ray enters a part: that of the farthest corner of a face that
    looks at the sensor."""
    x, y, z = abs(start[0] - middle[0]), abs(start[1] - middle[1]), abs(start[2] - middle[2])
    far_x, far_y, far_z = (x + half[0]) ** 2, (y + half[1]) ** 2, (z + half[2]) ** 2
    found = 0.0
    if x > half[0]:
        found = max(found, (x - half[0]) ** 2 + far_y + far_z)
    if y > half[1]:
        found = max(found, far_x + (y - half[1]) ** 2 + far_z)
    if z > half[2]:
        found = max(found, far_x + far_y + (z - half[2]) ** 2)
    return float(found)


@lean_inlined
def _project(beams: Beams, start: Direction, half: Direction, to: Outline) -> int:
    """Project the corners of a box, in whose axes the sensor is at `start`, to the image plane, and behind them the
    places where its edges are cut; return the number filled."""
    set_centre(start, to.faces.turn, to.centre)
    corners_of(to.centre, to.faces.turn, half, to.corners)
    count, corners, is_sector = _CORNERS, to.corners, beams.squeeze.size > 0
    for corner in range(_CORNERS):
        x = corners[corner, 0]
        if x >= _AHEAD_M:
            y, z = corners[corner, 1] / x, corners[corner, 2] / x
            to.along[corner], to.across[corner] = z if is_sector else y, y if is_sector else z
            continue
        for axis in range(3):
            other = corner ^ (1 << axis)
            far = corners[other, 0]
            if far >= _AHEAD_M:
                share = (_AHEAD_M - x) / (far - x)
                y = (corners[corner, 1] + share * (corners[other, 1] - corners[corner, 1])) / _AHEAD_M
                z = (corners[corner, 2] + share * (corners[other, 2] - corners[corner, 2])) / _AHEAD_M
                to.along[count], to.across[count] = z if is_sector else y, y if is_sector else z
                to.ahead[count] = other
                count += 1
    return count


@lean_inlined
def _extent(values: np.ndarray, count: int, to: Outline) -> tuple[float, float]:
    """Return the least and the greatest of the places of all corners and cuts, a little more apart."""
    low, high = np.inf, -np.inf
    for corner in range(count):
        if corner >= _CORNERS or to.corners[corner, 0] >= _AHEAD_M:
            low, high = min(low, values[corner]), max(high, values[corner])
    return low - _BLUR_ACROSS * (1.0 + abs(low)), high + _BLUR_ACROSS * (1.0 + abs(high))


@lean_inlined
def _places_between(at: np.ndarray, values: np.ndarray, count: int, to: Outline) -> tuple[int, int]:
    """Return the first and end place of rising numbers between the places of all corners and cuts, a little more
    apart."""
    low, high = _extent(values, count, to)
    return (place_at(at, low), place_at(at, high)) if low <= high else (0, 0)


@lean_inlined
def _columns_between(beams: Beams, count: int, row: int, end: int, to: Outline) -> tuple[int, int]:
    """Return the first and end column in which rows before `end` may meet a box."""
    low, high = _extent(to.along, count, to)
    if not low <= high or row >= end:
        return 0, 0
    if beams.squeeze.size > 0:  # least at one of the outermost rows
        least = min(beams.squeeze[row], beams.squeeze[end - 1])
        low, high = low * (least if low > 0.0 else 1.0), high * (least if high < 0.0 else 1.0)
    return place_at(beams.column_at, low), place_at(beams.column_at, high)


@lean_inlined
def _draw_part(
    traffic: FrameBoxes, beams: Beams, box: int, is_tested: bool, count: int, column: int, last: int, to: Outline
) -> None:  # fmt: skip
    """Set the bits of the rays that enter a part of a box, between two columns."""
    row, end = _places_between(beams.row_at, to.across, count, to)
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
        limit = limit_of(traffic, beams, box, place) if is_tested else 0.0
        if to.is_close[place]:
            try_rays(beams, place, column, last, is_tested, limit, to)
        elif to.low[place] <= to.high[place]:
            _fill(beams, place, is_tested, limit, to)


@lean_inlined
def _cross(beams: Beams, one: int, other: int, to: Outline) -> None:
    """Note where rows cross the edge between two corners."""
    if to.across[one] > to.across[other]:
        one, other = other, one
    bottom, top, begin = to.across[one], to.across[other], to.along[one]
    rise, run, row_at = top - bottom, to.along[other] - begin, beams.row_at
    blur = _BLUR * (1.0 + max(abs(bottom), abs(top)))
    row = place_at(row_at, bottom - blur)
    is_steep = abs(run) > _STEEPEST * rise
    slope = run / rise if rise > 0.0 else 0.0
    while row < row_at.size and row_at[row] <= top + blur:
        at = row_at[row]
        if is_steep or at < bottom + blur or at > top - blur:
            to.is_close[row] = True
        crossed = begin + (at - bottom) * slope
        to.low[row], to.high[row] = min(to.low[row], crossed), max(to.high[row], crossed)
        row += 1


@lean_inlined
def _fill(beams: Beams, row: int, is_tested: bool, limit: float, to: Outline) -> None:
    """Set the bits of a row between its two crossings."""
    at, low, high = beams.column_at, to.low[row], to.high[row]
    if beams.squeeze.size > 0:
        low, high = low * beams.squeeze[row], high * beams.squeeze[row]
    low_blur, high_blur = _BLUR_ACROSS * (1.0 + abs(low)), _BLUR_ACROSS * (1.0 + abs(high))
    first = place_at(at, low - low_blur)
    begin = first
    while begin < at.size and at[begin] < low + low_blur:
        begin += 1
    end = max(begin, place_at(at, high - high_blur))
    last = end
    while last < at.size and at[last] <= high + high_blur:
        last += 1
    if begin < end:
        if is_tested and not _are_near(beams, row, begin, end - 1, limit, to):
            try_rays(beams, row, begin, end, is_tested, limit, to)
        else:
            _set_bits(to.mask[0], row * words_of(beams.columns), begin, end - 1)
            if is_tested:
                _set_bits(to.mask[1], row * words_of(beams.columns), begin, end - 1)
    if first < begin:
        try_rays(beams, row, first, begin, is_tested, limit, to)
    if end < last:
        try_rays(beams, row, end, last, is_tested, limit, to)


@lean_inlined
def _are_near(beams: Beams, row: int, first: int, last: int, limit: float, to: Outline) -> bool:
    """Return whether all rays of a row from one to another enter a part well within a limit: then
    both of these do, since what a ball around the sensor has of the part is convex, too."""
    least = 1.0 / min(limit, beams.reach[1]) * _WIDER
    find_entries(beams, to.faces, row, first, 1, to.run)
    if not to.run[0] > least:
        return False
    find_entries(beams, to.faces, row, last, 1, to.run)
    return bool(to.run[0] > least)


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


@lean_inlined
def _try_run(
    beams: Beams, row: int, column: int, last: int, is_tested: bool, limit: float, to: Outline
) -> None:  # fmt: skip
    """Set the bits of those rays of a row, from a column to before another, that enter a part, and
    where they are tested of those that do within a limit."""
    base, run = row * words_of(beams.columns), to.run
    find_entries(beams, to.faces, row, column, last - column, run)
    for place in range(column, last):
        inverse = run[place - column]
        if inverse > 0.0:
            word, bit = base + (place >> 6), np.uint64(1) << np.uint64(place & 63)
            to.mask[0, word] |= bit
            if is_tested and limit * inverse >= 1.0:
                to.mask[1, word] |= bit


@lean
def try_rays(
    beams: Beams, row: int, column: int, last: int, is_tested: bool, limit: float, to: Outline
) -> None:  # fmt: skip
    """As `_try_run`, out of line: a row's ends seldom need it."""
    _try_run(beams, row, column, last, is_tested, limit, to)
