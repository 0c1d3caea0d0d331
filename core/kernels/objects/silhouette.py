"""Find the rays of an image that enter an object, by the sides of its parts: planes through the sensor.

In the even rows and columns of a pinhole a side is a straight line, so the rays of a row that enter a part lie between
two columns, which are found for all rows at once. Rays nearer to a side than any rounding are tried one by one, with
the numbers of `nearest`. Rays of bent lenses and of sectors are taken tile by tile (`kernels.rays.tiles`).
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
from riglens.core.kernels.objects.nearest import cone_of, find_entries, is_apart, place_after, window_of
from riglens.core.kernels.objects.part_sides import set_sides
from riglens.core.kernels.objects.windows import place_at
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.rays.tiles import (
    AFTER,
    AXIS,
    COLUMN,
    COLUMNS,
    COSINE,
    IS_FULL,
    OWN_RAYS,
    ROW,
    SIDE_BLUR,
    SINE,
    cuts_of,
    rows_of,
    set_spans,
)
from riglens.core.kernels.runtime.codes import MOST_PARTS
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined
from riglens.core.kernels.voxels.bits import level_mask, mask_of

_WIDER = 1.0 + 1e-9
"""Distances are compared with ranges with as much room."""
_WIDEST = 0.25
"""Room of a side in columns beyond which it is a level one, which takes or leaves rows as a whole."""
_FEW = 16
"""Rows of a box up to which its parts have no rows of their own."""

NOT_DRAWN, DRAWN, LIMITED, HIDING = 0, 1, 2, 3
"""Results of `draw_box`: the sides cannot decide; they did; they did, and the range for its class ends within the box;
they did, for a box that is out of range for its class, but hides what is behind it."""


class Outline(NamedTuple):
    """Room for the image of a box: faces of a part; centre (3,), corners (8, 3). Of a pinhole, in columns: low, high
    (rows,) between which rays of a row enter a part; begin, end int32 (MOST_PARTS, rows) the first and end column of
    those; first, last int32 (rows,) of all parts; is_split (rows,): whether parts may leave a gap there. mask (2, rows
    * words) uint64: bits for each ray that enters the box, and for those that do within the range of its class; bounds
    (4,): first and end row and word of the mask; tiles (t,): those that may show it; run (columns,): of the rays that
    are tried, 1 / t at which they enter, or 0."""

    faces: Faces
    centre: np.ndarray
    corners: np.ndarray
    low: np.ndarray
    high: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    first: np.ndarray
    last: np.ndarray
    is_split: np.ndarray
    mask: np.ndarray
    bounds: np.ndarray
    tiles: np.ndarray
    run: np.ndarray


@kernel
def outline_for(faces: Faces, beams: Beams) -> Outline:
    """Return room for the rays of a sensor."""
    rows, columns = beams.row_of.size, beams.columns
    return Outline(
        faces, np.empty(3), np.empty((8, 3)), np.empty(rows), np.empty(rows),
        np.empty((MOST_PARTS, rows), np.int32), np.empty((MOST_PARTS, rows), np.int32), np.empty(rows, np.int32),
        np.empty(rows, np.int32), np.empty(rows, np.bool_), np.zeros((2, rows * words_of(columns)), np.uint64),
        np.zeros(4, np.int64), np.empty(beams.tiles.shape[0], np.int64), np.empty(columns),
    )  # fmt: skip


@lean_inlined
def words_of(columns: int) -> int:
    """Return the number of 64-bit words that hold a row of rays."""
    return (columns + 63) >> 6


@lean_inlined
def set_view(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> None:
    """Write the rows and words of a pinhole's picture in which a box may be, to the bounds."""
    set_turn(traffic, rotation, box, to.faces.turn)
    start, bounds = start_of(traffic, beams, box), to.bounds
    window = window_of(beams, start, half_of(traffic, box), to.faces.turn, to.centre, to.corners)
    bounds[:] = 0
    if window.width < 0.0:
        return
    column, last = (
        place_at(beams.column_at, window.left),
        place_after(beams.column_at, window.left + window.width),
    )
    if column < last:
        bounds[0], bounds[1] = place_at(beams.row_at, window.low), place_after(beams.row_at, window.high)
        bounds[2], bounds[3] = column >> 6, (last + 63) >> 6


@lean_inlined
def find_spans(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> bool:
    """Write the columns of a pinhole between which rays enter a box, in the rows of the bounds; return whether its
    sides decide."""
    start, bounds, (part, last) = start_of(traffic, beams, box), to.bounds, parts_of(traffic, box)
    set_turn(traffic, rotation, box, to.faces.turn)
    for row in range(bounds[0], bounds[1]):
        to.first[row], to.last[row], to.is_split[row] = 0, 0, False
    for place in range(last - part):
        middle, half = bounds_of(traffic, part + place)
        mine = (start[0] - middle[0], start[1] - middle[1], start[2] - middle[2])
        row, end = bounds[0], bounds[1]
        if end - row > _FEW:
            window = window_of(beams, mine, half, to.faces.turn, to.centre, to.corners)
            row, end = place_at(beams.row_at, window.low), place_after(beams.row_at, window.high)
            row, end = max(row, bounds[0]), min(end, bounds[1])
            if window.width < 0.0:
                end = row
            to.begin[place, bounds[0] : bounds[1]] = to.end[place, bounds[0] : bounds[1]] = 0
        set_faces(mine, half, to.faces)
        if not _set_spans(beams, place, row, end, to):
            return False
    return True


@lean_inlined
def _set_spans(beams: Beams, part: int, first: int, end: int, to: Outline) -> bool:
    """Write the columns between which rays enter a part, in some rows, and add them to those of the box; return whether
    its sides decide."""
    room = _set_limits(beams, first, end, to)
    if room < 0.0:
        return False
    columns, unsure, low, high = np.int32(beams.columns), 0, to.low, to.high
    for row in range(np.uint64(first), np.uint64(end)):
        a, b = low[row], high[row]
        # from -0.5 to columns + 0.5: beyond these are no rays, so nothing to be tried
        i, j = np.int32(a), np.int32(b)
        unsure += _is_unsure(a - i, room) | _is_unsure(b - j, room)
        i, j = min(i + np.int32(a > i), columns), min(j + np.int32(b > j), columns)
        to.begin[part, row], to.end[part, row] = i, max(i, j)
    if unsure > 0:
        _settle_unsure(beams, part, first, end, room, to)
    for row in range(np.uint64(first), np.uint64(end)):
        i, j, left, right = to.begin[part, row], to.end[part, row], to.first[row], to.last[row]
        exists, is_first = i < j, right <= left
        to.is_split[row] |= exists & (not is_first) & ((i > right) | (j < left))
        to.first[row] = i if exists & (is_first | (i < left)) else left
        to.last[row] = j if exists & (is_first | (j > right)) else right
    return True


@lean_inlined
def _is_unsure(over: float, room: float) -> bool:
    """Return whether a place, that much over a column, is too near to one for certainty."""
    return (abs(over) <= room) | (over >= 1.0 - room)


@lean_inlined
def _set_limits(beams: Beams, first: int, end: int, to: Outline) -> float:
    """Write low and high of some rows; return the room around these in which rays are to be tried, or -1 where whole
    rows are."""
    columns, at, z = beams.columns, beams.column_at, beams.row_at
    step = (at[columns - 1] - at[0]) / (columns - 1) if columns > 1 else 1.0
    widest, room, unsure = max(abs(at[0]), abs(at[columns - 1])), 0.0, 0
    low, high = to.low, to.high
    for row in range(np.uint64(first), np.uint64(end)):
        low[row], high[row] = -0.5, columns + 0.5
    for side in range(set_sides(0.0, np.inf, to.faces)):
        plane = to.faces.sides.plane[side]
        p, q, r = plane[0], plane[1], plane[2]
        if abs(q) * step * _WIDEST <= SIDE_BLUR:
            blur = abs(q) * widest + SIDE_BLUR
            for row in range(np.uint64(first), np.uint64(end)):
                inner = p + r * z[row]
                unsure += abs(inner) <= blur
                low[row] = columns + 0.5 if inner < 0.0 else low[row]
            continue
        room = max(room, SIDE_BLUR / (abs(q) * step))
        begin, slope = (-p / q - at[0]) / step, -r / (q * step)
        if q > 0.0:
            for row in range(np.uint64(first), np.uint64(end)):
                place = begin + slope * z[row]
                place = place if place < columns + 0.5 else columns + 0.5
                low[row] = place if place > low[row] else low[row]
        else:
            for row in range(np.uint64(first), np.uint64(end)):
                place = begin + slope * z[row]
                place = place if place > -0.5 else -0.5
                high[row] = place if place < high[row] else high[row]
    return -1.0 if unsure > 0 else room


@lean
def _settle_unsure(beams: Beams, part: int, first: int, end: int, room: float, to: Outline) -> None:
    """Try the rays that are too near to low or high of a row, one each at most."""
    for row in range(first, end):
        column = int(np.rint(to.low[row]))
        if abs(to.low[row] - column) <= room and 0 <= column < beams.columns:
            to.begin[part, row] = column if _enters(beams, row, column, to) else column + 1
        column = int(np.rint(to.high[row]))
        if abs(to.high[row] - column) <= room and 0 <= column < beams.columns:
            to.end[part, row] = column + 1 if _enters(beams, row, column, to) else column
        to.end[part, row] = max(to.begin[part, row], to.end[part, row])


@lean_inlined
def _enters(beams: Beams, row: int, column: int, to: Outline) -> bool:
    find_entries(beams, to.faces, row, column, 1, to.run)
    return bool(to.run[0] > 0.0)


@lean_inlined
def spans_mask(parts: int, row: int, word: int, to: Outline) -> np.uint64:
    """Return the bits of the rays of a word of a row that enter a box."""
    if not to.is_split[row]:
        return mask_of(to.first[row], to.last[row] - 1, word)
    mask = np.uint64(0)
    for part in range(parts):
        mask |= mask_of(to.begin[part, row], to.end[part, row] - 1, word)
    return mask


@lean_inlined
def draw_box(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> int:
    """Set the bits of the rays that enter a box, and where it is LIMITED also of those that do within the range of its
    class; return NOT_DRAWN where the sides cannot decide."""
    if beams.row_at.size == 0:
        return draw_by_tiles(traffic, beams, box, rotation, to) if beams.limits.shape[1] <= 1 else NOT_DRAWN
    set_view(traffic, beams, box, rotation, to)
    if not find_spans(traffic, beams, box, rotation, to):
        return NOT_DRAWN
    bounds, words, (part, last) = to.bounds, words_of(beams.columns), parts_of(traffic, box)
    for row in range(bounds[0], bounds[1]):
        for word in range(bounds[2], bounds[3]):
            to.mask[0, row * words + word] = spans_mask(last - part, row, word, to)
    return DRAWN


@lean
def draw_by_tiles(traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, to: Outline) -> int:
    """As `draw_box`, for rays in any directions: those of a tile enter a part, miss it, or are cut row by row."""
    start, bounds, words = start_of(traffic, beams, box), to.bounds, words_of(beams.columns)
    way, limit = _way_of(traffic, beams, box, start), limit_of(traffic, beams, box, 0)
    if way == NOT_DRAWN:
        return way
    set_turn(traffic, rotation, box, to.faces.turn)
    for row in range(bounds[0], bounds[1]):  # of the box before
        to.mask[:, row * words + bounds[2] : row * words + bounds[3]] = 0
    bounds[0], bounds[1], bounds[2], bounds[3] = beams.row_of.size, 0, words, 0
    near = _list_tiles(beams, start, half_of(traffic, box), to)
    for part in range(*parts_of(traffic, box)):
        middle, part_half = bounds_of(traffic, part)
        place = (start[0] - middle[0], start[1] - middle[1], start[2] - middle[2])
        set_faces(place, part_half, to.faces)
        for layer in range(2 if way == LIMITED else 1):
            far = limit if layer == 1 else np.inf
            sides = set_sides(beams.reach[0], min(far, beams.reach[1]), to.faces)
            for number in range(near):
                tile = beams.tiles[to.tiles[number]]
                cuts = cuts_of(tile, sides, to.faces.sides)
                if cuts >= 0:
                    _draw_tile(beams, tile, cuts, layer, far, to)
    return way


@lean_inlined
def _list_tiles(beams: Beams, start: Direction, half: Direction, to: Outline) -> int:
    """List the tiles that may show a box, first by cones around both, then by its sides; return their number."""
    set_centre(start, to.faces.turn, to.centre)
    far, sine, cosine = cone_of(to.centre, half)
    set_faces(start, half, to.faces)
    sides, count, number = set_sides(0.0, np.inf, to.faces), 0, 0
    while number < beams.tiles.shape[0]:
        tile = beams.tiles[number]
        number += 1
        if is_apart(
            tile[AXIS], tile[AXIS + 1], tile[AXIS + 2], tile[COSINE], tile[SINE], to.centre, far, sine, cosine
        ) or cuts_of(tile, sides, to.faces.sides) < 0:  # fmt: skip
            number = int(tile[AFTER])
        elif tile[OWN_RAYS] > 0.0:
            to.tiles[count] = number - 1
            count += 1
    return count


@lean_inlined
def _draw_tile(beams: Beams, tile: np.ndarray, cuts: int, layer: int, far: float, to: Outline) -> None:
    """Set the bits, of a layer of the mask, of the rays of a tile that enter a part not beyond a distance; its columns
    share a word."""
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
            to.mask[layer, row * words + word] |= mask
        return
    set_spans(tile, places, cuts, to.faces.sides)
    for row in range(first, end):
        may, last_may = column + int(span[0, row - top]), column + int(span[1, row - top])
        does, last = column + int(span[2, row - top]), column + int(span[3, row - top])
        if is_full and does < last:
            to.mask[layer, row * words + word] |= level_mask(does & 63, (last - 1) & 63)
            if may < does:
                _try_run(beams, row, may, does, layer, far, to)
            if last < last_may:
                _try_run(beams, row, last, last_may, layer, far, to)
        elif may < last_may:
            _try_run(beams, row, may, last_may, layer, far, to)


@lean_inlined
def _way_of(traffic: FrameBoxes, beams: Beams, box: int, start: Direction) -> int:
    """Return LIMITED for a box in which the range for its class may end, HIDING for one beyond it, NOT_DRAWN for one
    whose rays may enter it no nearer than that ends."""
    if beams.limits.size == 0:
        return DRAWN
    half, near2, entry2 = half_of(traffic, box), 0.0, 0.0
    for axis in range(3):
        near = max(abs(start[axis]) - half[axis], 0.0)
        near2 += near * near
    limit = limit_of(traffic, beams, box, 0)
    if near2 > (limit * _WIDER) ** 2:
        return HIDING
    if limit >= beams.reach[1]:
        return DRAWN  # all that enter it do so within both
    for part in range(*parts_of(traffic, box)):
        middle, part_half = bounds_of(traffic, part)
        entry2 = max(entry2, _last_entry2(start, middle, part_half))
    if entry2 * _WIDER**2 < limit * limit:
        return DRAWN
    return LIMITED if limit > beams.reach[0] * _WIDER else NOT_DRAWN


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
def _try_run(beams: Beams, row: int, column: int, last: int, layer: int, far: float, to: Outline) -> None:
    """Set the bits of those rays of a row, from a column to before another, that enter a part not beyond a distance."""
    base, run = row * words_of(beams.columns), to.run
    find_entries(beams, to.faces, row, column, last - column, run)
    for place in range(column, last):
        inverse = run[place - column]
        if inverse > 0.0 and far * inverse >= 1.0:
            to.mask[layer, base + (place >> 6)] |= np.uint64(1) << np.uint64(place & 63)
