"""Count the rays of a camera, or of a sector, on objects by bits: one for each ray that enters an object.

Objects come from near to far, so what has been met hides the rest. Of objects whose order is open, only the rays that
enter several of them are compared, one by one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    FrameBoxes,
    bounds_of,
    box_of,
    half_of,
    limit_of,
    local_direction,
    parts_of,
    ray_at,
    set_faces,
    start_of,
)
from riglens.core.kernels.objects.depth_order import DepthOrder
from riglens.core.kernels.objects.nearest import find_entries
from riglens.core.kernels.objects.silhouette import (
    HIDING,
    LIMITED,
    NOT_DRAWN,
    Outline,
    draw_box,
    find_spans,
    set_view,
    spans_mask,
    words_of,
)
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined
from riglens.core.kernels.voxels.bits import lowest_bit, popcount

RAYS, ALONE, FIRST_ROW, LAST_ROW = 0, 1, 2, 3
"""Rows of results on objects: rays that enter it first, rays that would without occlusion, first and last row of the
lattice among the former, of images (-1: none)."""


_STRIP, _LOG_STRIP = 16, 4
"""Rows of a strip."""


class Bits(NamedTuple):
    """A bit for each ray, (rows * words,) uint64: `seen` that has met something nearer, `once` and `twice` that enters
    one of a group of objects or several; touched (strips,): whether a strip of `seen` has bits. Of a pinhole, shown
    int32 (boxes, 4): first and end row and word of what may show each box of the depth order; sharers int32
    (strips, words): how many boxes may show there, the car's own body counted among them (own, of this shape)."""

    seen: np.ndarray
    once: np.ndarray
    twice: np.ndarray
    touched: np.ndarray
    shown: np.ndarray
    sharers: np.ndarray
    own: np.ndarray


class Ties(NamedTuple):
    """Of rays that enter several objects of a group, by slot: 1 / t of the first one, 0 where nothing, and its part, or
    -1 (rays,)."""

    inverse: np.ndarray
    owner: np.ndarray


@kernel
def new_bits(beams: Beams, boxes: int) -> Bits:
    """Return bits for a lattice, none of them set, and frames of at most `boxes` boxes."""
    rows, words = beams.row_of.size, words_of(beams.columns)
    strips, size = (rows + _STRIP - 1) >> _LOG_STRIP, rows * words
    is_image = not beams.turns and beams.row_at.size > 0
    own = np.zeros((strips, words) if is_image else (0, 0), np.int32)
    if is_image and beams.stops.size > 0:
        for row in range(rows):
            for word in range(words):
                own[row >> _LOG_STRIP, word] |= beams.stops[0, row * words + word] != 0
    return Bits(
        np.zeros(size, np.uint64), np.zeros(size, np.uint64), np.zeros(size, np.uint64), np.zeros(strips, np.bool_),
        np.empty((boxes, 4), np.int32), own.copy(), own,
    )  # fmt: skip


@lean_inlined
def forget(columns: int, bits: Bits) -> None:
    """Clear `seen` for another frame."""
    strip_size = words_of(columns) << _LOG_STRIP
    for strip in range(bits.touched.size):
        if bits.touched[strip]:
            bits.seen[strip * strip_size : (strip + 1) * strip_size] = 0
            bits.touched[strip] = False


@lean_inlined
def touch(first: int, end: int, bits: Bits) -> None:
    """Note that bits of `seen` may be set in rows first..end-1."""
    for strip in range(first >> _LOG_STRIP, (end + _STRIP - 1) >> _LOG_STRIP):
        bits.touched[strip] = True


@lean
def look_round(
    traffic: FrameBoxes, beams: Beams, rotation: np.ndarray, depth_order: DepthOrder, end: int, outline: Outline,
    bits: Bits,
) -> None:  # fmt: skip
    """Find where a pinhole may show the first `end` boxes of the depth order, and which places may show several."""
    for strip in range(bits.own.shape[0]):
        for word in range(bits.own.shape[1]):
            bits.sharers[strip, word] = bits.own[strip, word]
    for place in range(end):
        set_view(traffic, beams, depth_order.box[place], rotation, outline)
        for bound in range(4):
            bits.shown[place, bound] = outline.bounds[bound]
        row, until = outline.bounds[0], outline.bounds[1]
        for strip in range(row >> _LOG_STRIP, (until + _STRIP - 1) >> _LOG_STRIP if row < until else 0):
            for word in range(outline.bounds[2], outline.bounds[3]):
                bits.sharers[strip, word] += 1


@lean_inlined
def count_one(
    traffic: FrameBoxes, beams: Beams, rotation: np.ndarray, ranks: np.ndarray, depth_order: DepthOrder, place: int,
    outline: Outline, bits: Bits, found: np.ndarray,
) -> bool:  # fmt: skip
    """Count the rays on an object that is no nearer than the hits so far; return False, and change nothing, where sides
    cannot decide."""
    box = depth_order.box[place]
    if bits.own.size > 0:
        for bound in range(4):
            outline.bounds[bound] = bits.shown[place, bound]
        if not find_spans(traffic, beams, box, rotation, outline):
            return False
        _count_spans(traffic, beams, box, outline, bits, ranks[box], found)
        return True
    way = draw_box(traffic, beams, box, rotation, outline)
    if way == NOT_DRAWN:
        return False
    _count(traffic, beams, box, way, outline, bits, False, ranks[box], found)
    touch(outline.bounds[0], outline.bounds[1], bits)
    return True


@lean_inlined
def _count_spans(
    traffic: FrameBoxes, beams: Beams, box: int, outline: Outline, bits: Bits, one: int, found: np.ndarray
) -> None:
    """Count the rays of a pinhole between the columns that have been found, strip by strip; where nothing else may be,
    all of them count, and hide nothing."""
    bounds, alone = outline.bounds, 0
    row = bounds[0]
    while row < bounds[1]:
        strip = row >> _LOG_STRIP
        end, is_shared, is_split = min((strip + 1) << _LOG_STRIP, bounds[1]), False, False
        for word in range(bounds[2], bounds[3]):
            is_shared |= bits.sharers[strip, word] > 1
        for at in range(np.uint64(row), np.uint64(end)):
            is_split |= outline.is_split[at]
        if is_shared or is_split:
            bits.touched[strip] |= is_shared
            for at in range(row, end):
                alone += _count_row(traffic, beams, box, at, is_shared, outline, bits, one, found)
        else:
            rays, last = 0, end - 1
            for at in range(np.uint64(row), np.uint64(end)):
                rays += outline.last[at] - outline.first[at]
            alone += rays
            if rays > 0 and one >= 0:
                while outline.last[row] <= outline.first[row]:
                    row += 1
                while outline.last[last] <= outline.first[last]:
                    last -= 1
                note_rays(beams, row, 0, 0, 0, one, found)
                note_rays(beams, last, 0, 0, rays, one, found)
        row = end
    if one >= 0:
        found[ALONE, one] = alone


@lean_inlined
def _count_row(
    traffic: FrameBoxes, beams: Beams, box: int, row: int, is_shared: bool, outline: Outline, bits: Bits, one: int,
    found: np.ndarray,
) -> int:  # fmt: skip
    """Count the rays of a row of a pinhole that nothing hides, let them hide others if any may be there, and return how
    many there are in all."""
    alone, rays, (part, last), words = 0, 0, parts_of(traffic, box), words_of(beams.columns)
    if outline.first[row] >= outline.last[row]:
        return 0
    for place in range(outline.first[row] >> 6, ((outline.last[row] - 1) >> 6) + 1):
        mask, word = spans_mask(last - part, row, place, outline), row * words + place
        alone += int(popcount(mask))
        free = mask
        if is_shared:
            free &= ~bits.seen[word]
            bits.seen[word] |= mask
            if one >= 0 and beams.stops.size > 0 and free & beams.stops[0, word]:
                free = _unstopped(traffic, beams, box, row, place, free, outline)
        rays += int(popcount(free))
    if rays > 0 and one >= 0:
        note_rays(beams, row, 0, 0, rays, one, found)
    return alone


@lean
def count_group(
    traffic: FrameBoxes, beams: Beams, rotation: np.ndarray, ranks: np.ndarray, depth_order: DepthOrder, begin: int,
    end: int, outline: Outline, bits: Bits, ties: Ties, found: np.ndarray,
) -> bool:  # fmt: skip
    """As `count_one`, for a group of objects, places begin..end-1 of the depth order."""
    first, last, is_drawn = beams.row_of.size, 0, True
    for place in range(begin, end):
        if draw_box(traffic, beams, depth_order.box[place], rotation, outline) == NOT_DRAWN:
            is_drawn = False
            break
        _lay(beams, outline, bits)
        first, last = min(first, outline.bounds[0]), max(last, outline.bounds[1])
    if is_drawn:
        for place in range(begin, end):
            box = depth_order.box[place]
            way = draw_box(traffic, beams, box, rotation, outline)
            _count(traffic, beams, box, way, outline, bits, True, ranks[box], found)
            _compare(traffic, beams, box, outline, bits, ties)
        _share(traffic, beams, ranks, first, last, bits, ties, found)
    words = words_of(beams.columns)
    for word in range(first * words, last * words):
        if is_drawn:
            bits.seen[word] |= bits.once[word]
        bits.once[word] = bits.twice[word] = 0
    if is_drawn:
        touch(first, last, bits)
    return is_drawn


@lean_inlined
def _lay(beams: Beams, outline: Outline, bits: Bits) -> None:
    """Add an outline to those of a group."""
    words, bounds = words_of(beams.columns), outline.bounds
    for row in range(bounds[0], bounds[1]):
        for word in range(row * words + bounds[2], row * words + bounds[3]):
            mask = outline.mask[0, word]
            bits.twice[word] |= bits.once[word] & mask
            bits.once[word] |= mask


@lean_inlined
def _count(
    traffic: FrameBoxes, beams: Beams, box: int, way: int, outline: Outline, bits: Bits, is_one_of_many: bool, one: int,
    found: np.ndarray,
) -> None:  # fmt: skip
    """Count the rays of an outline, and those of them that meet nothing else of the group and nothing
    nearer; one < 0: of an object that does not count. Of a box alone, the rays have met something then."""
    alone, words, bounds = 0, words_of(beams.columns), outline.bounds
    has_stops = beams.stops.size > 0
    for row in range(bounds[0], bounds[1]):
        rays, low, high = 0, beams.columns, -1
        for place in range(bounds[2], bounds[3]):
            word = row * words + place
            mask = outline.mask[0, word]
            if mask == 0:
                continue
            alone += int(popcount(mask))
            free = mask & ~bits.seen[word]
            if not is_one_of_many:
                bits.seen[word] |= mask
            if one < 0:
                continue
            if way == LIMITED:
                free &= outline.mask[1, word]
            elif way == HIDING:
                free = np.uint64(0)
            if is_one_of_many:
                free &= ~bits.twice[word]
            if has_stops and free & beams.stops[0, word]:
                free = _unstopped(traffic, beams, box, row, place, free, outline)
            if free:
                rays += int(popcount(free))
                if beams.is_upright:
                    low, high = min(low, 64 * place + int(lowest_bit(free))), 64 * place + _highest_bit(free)
        if rays > 0:
            note_rays(beams, row, low, high, rays, one, found)
    if one >= 0:
        found[ALONE, one] = alone


@lean_inlined
def _highest_bit(bits: np.uint64) -> int:
    """Return the index of the highest set bit of a nonzero word."""
    at = 0
    for step in (32, 16, 8, 4, 2, 1):
        if bits >> np.uint64(at + step):
            at += step
    return at


@lean_inlined
def note_rays(beams: Beams, row: int, low: int, high: int, rays: int, one: int, found: np.ndarray) -> None:
    """Add rays of a row, between two columns, to those of an object."""
    found[RAYS, one] += rays
    first = last = beams.row_of[row]
    if beams.is_upright:  # the sensor's rows lie along those of the slots
        first, last = beams.column_of[low], beams.column_of[high]
    found[FIRST_ROW, one] = min(found[FIRST_ROW, one], first) if found[FIRST_ROW, one] >= 0 else first
    found[LAST_ROW, one] = max(found[LAST_ROW, one], last)


@lean_inlined
def _nearest(traffic: FrameBoxes, beams: Beams, box: int) -> float:
    """Return how far away a box is at least, metres."""
    start, half, near2 = start_of(traffic, beams, box), half_of(traffic, box), 0.0
    for axis in range(3):
        near = max(abs(start[axis]) - half[axis], 0.0)
        near2 += near * near
    return float(np.sqrt(near2) * (1.0 - 1e-9))


@lean_inlined
def is_stopped(beams: Beams, row: int, column: int, inverse: float) -> bool:
    """Return whether the car's own body stops a ray, by its place of rows and columns, before it gets where it went."""
    x, y, z = local_direction(beams, row, column)
    length = np.sqrt(x * x + y * y + z * z)
    return not length / inverse < beams.ends[ray_at(beams, row, column)]


@lean_inlined
def _unstopped(
    traffic: FrameBoxes, beams: Beams, box: int, row: int, place: int, free: np.uint64, outline: Outline
) -> np.uint64:  # fmt: skip
    """Return those of some rays, bits of a word of a row, that the car's own body does not stop before a box."""
    word = row * words_of(beams.columns) + place
    if _nearest(traffic, beams, box) > beams.last_ends[word]:
        return np.uint64(free & ~beams.stops[0, word])
    return np.uint64(_passed(traffic, beams, box, row, place, free & ~beams.stops[1, word], outline))


@lean
def _passed(
    traffic: FrameBoxes, beams: Beams, box: int, row: int, place: int, free: np.uint64, outline: Outline
) -> np.uint64:  # fmt: skip
    """Return those of some rays, bits of a word of a row, that the car's own body stops only behind a box."""
    start = start_of(traffic, beams, box)
    left = free & beams.stops[0, row * words_of(beams.columns) + place]
    while left:
        bit = left & (~left + np.uint64(1))
        column = 64 * place + int(lowest_bit(left))
        inverse = 0.0
        for part in range(*parts_of(traffic, box)):
            inverse = max(inverse, _entry(traffic, beams, part, start, row, column, outline))
        if is_stopped(beams, row, column, inverse):
            free ^= bit
        left ^= bit
    return free


@lean_inlined
def _set_part(traffic: FrameBoxes, part: int, start: Direction, outline: Outline) -> None:
    """Write the faces of a part of the box that is drawn."""
    middle, half = bounds_of(traffic, part)
    set_faces((start[0] - middle[0], start[1] - middle[1], start[2] - middle[2]), half, outline.faces)


@lean_inlined
def _entry(
    traffic: FrameBoxes, beams: Beams, part: int, start: Direction, row: int, column: int, outline: Outline
) -> float:  # fmt: skip
    """Return 1 / t at which a ray enters a part, 0 where it does not."""
    _set_part(traffic, part, start, outline)
    find_entries(beams, outline.faces, row, column, 1, outline.run)
    return float(outline.run[0])


@lean_inlined
def _compare(
    traffic: FrameBoxes, beams: Beams, box: int, outline: Outline, bits: Bits, ties: Ties
) -> None:  # fmt: skip
    """Let a box have those rays of its outline that enter other objects of the group, too, where it is the nearest."""
    start, words, bounds, run = (
        start_of(traffic, beams, box),
        words_of(beams.columns),
        outline.bounds,
        outline.run,
    )
    for part in range(*parts_of(traffic, box)):
        _set_part(traffic, part, start, outline)
        for row in range(bounds[0], bounds[1]):
            for place in range(bounds[2], bounds[3]):
                word = row * words + place
                left = outline.mask[0, word] & bits.twice[word] & ~bits.seen[word]
                if left == 0:
                    continue
                first, number = (
                    64 * place + int(lowest_bit(left)),
                    _highest_bit(left) - int(lowest_bit(left)) + 1,
                )
                find_entries(beams, outline.faces, row, first, number, run)
                while left:
                    column = 64 * place + int(lowest_bit(left))
                    left &= left - np.uint64(1)
                    inverse, slot = run[column - first], row * beams.columns + column
                    if inverse > ties.inverse[slot]:
                        ties.inverse[slot], ties.owner[slot] = inverse, part


@lean_inlined
def _share(
    traffic: FrameBoxes, beams: Beams, ranks: np.ndarray, first: int, last: int, bits: Bits, ties: Ties,
    found: np.ndarray,
) -> None:  # fmt: skip
    """Count the rays that enter several objects of a group for the nearest of them, and leave no ties."""
    words = words_of(beams.columns)
    for row in range(first, last):
        for place in range(words):
            left = bits.twice[row * words + place] & ~bits.seen[row * words + place]
            while left:
                column = 64 * place + int(lowest_bit(left))
                left &= left - np.uint64(1)
                slot = row * beams.columns + column
                box, inverse = box_of(ties.owner[slot]), ties.inverse[slot]
                ties.inverse[slot], ties.owner[slot] = 0.0, -1
                one = ranks[box]
                if one < 0 or limit_of(traffic, beams, box, row) * inverse < 1.0:
                    continue
                if beams.ends.size > 0 and is_stopped(beams, row, column, inverse):
                    continue
                note_rays(beams, row, column, column, 1, one, found)
