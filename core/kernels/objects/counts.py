"""Count points, pixels and cells on every object, frame by frame.

Frames share nothing, so any number of threads gives the same numbers. In a frame the boxes come from near to far
(`depth_order`), and a bit for each ray says whether it has met something.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    Canvas,
    FrameBoxes,
    box_of,
    limit_of,
    new_faces,
    parts_of,
    set_turn,
    start_of,
)
from riglens.core.kernels.objects.depth_order import DepthOrder, line_up, new_depth_order
from riglens.core.kernels.objects.images import (
    ALONE,
    FIRST_ROW,
    LAST_ROW,
    RAYS,
    Bits,
    Ties,
    count_group,
    count_one,
    forget,
    is_stopped,
    look_round,
    new_bits,
    note_rays,
    touch,
)
from riglens.core.kernels.objects.nearest import meet_box
from riglens.core.kernels.objects.returns import (
    INVERSE,
    MOST_RAYS,
    NUMBER,
    PART,
    RayList,
    X,
    Y,
    Z,
    cells_of,
    look_at,
    new_list,
)
from riglens.core.kernels.objects.silhouette import Outline, outline_for, words_of
from riglens.core.kernels.objects.unique_cells import keep_distinct
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

__all__ = ["ALONE", "FIRST_ROW", "LAST_ROW", "RAYS"]

CELLS, FIRST_CELL, LAST_CELL = 4, 5, 8
"""Further rows of results on objects: distinct cells that rays enter (LiDARs), and along three axes, a row each, the
first and the last of these (none: the last before the first)."""
COLUMNS = 11


class Scratch(NamedTuple):
    """Room for a worker: the depth order of a frame; the image of a box; what rays of a group have met, and of a frame
    so far; columns uint64 (columns + 1,) of a row that belong to an object; rays of a LiDAR on it; table of cells."""

    depth_order: DepthOrder
    outline: Outline
    canvas: Canvas
    bits: Bits
    columns: np.ndarray
    rays: RayList
    table: np.ndarray


class Sweep(NamedTuple):
    """A sensor in one frame: its number, rotation (3, 3) of the sensor with the phase of the frame, key of the draws
    of returns; ranks (n,): places of boxes among the objects that count, below 0 for the others."""

    frame: int
    rotation: np.ndarray
    key: np.uint64
    ranks: np.ndarray


@lean_inlined
def is_in_range(traffic: FrameBoxes, beams: Beams, box: int, row: int, inverse: float) -> bool:
    """Return whether a ray of a place of rows, a unit vector, gets anything back from an object of that class where it
    meets it."""
    return bool(limit_of(traffic, beams, box, row) * inverse >= 1.0)


@lean_inlined
def _find(columns: int, box: int, place: int, scratch: Scratch) -> int:
    """List the columns of a row that belong to an object, and return their number."""
    owner, base, number = scratch.canvas.owner, np.uint64(place * columns), np.uint64(0)
    first, end = np.uint64(scratch.canvas.spans[place, 0]), np.uint64(scratch.canvas.spans[place, 1])
    for column in range(first, end):
        scratch.columns[number] = column  # overwritten unless it counts: a branch would cost more
        number += np.uint64(box_of(owner[base + column]) == box)
    return int(np.int64(number))


@lean_inlined
def _is_met(traffic: FrameBoxes, beams: Beams, box: int, place: int, column: int, scratch: Scratch) -> bool:
    """Return whether a ray that enters an object of a group first has no nearer hit, and gets something back."""
    word, slot = place * words_of(beams.columns) + (column >> 6), place * beams.columns + column
    if scratch.bits.seen[word] >> np.uint64(column & 63) & np.uint64(1):
        return False
    if beams.ends.size > 0 and is_stopped(beams, place, column, scratch.canvas.inverse[slot]):
        return False
    return beams.limits.size == 0 or is_in_range(traffic, beams, box, place, scratch.canvas.inverse[slot])


@lean_inlined
def _count_rays(
    traffic: FrameBoxes, beams: Beams, box: int, one: int, scratch: Scratch, found: np.ndarray
) -> None:
    """Count the rays of an image, or of a sector, that enter an object of a group first."""
    for place in range(scratch.canvas.touched[0], scratch.canvas.touched[1]):
        for at in range(_find(beams.columns, box, place, scratch)):
            column = int(np.int64(scratch.columns[at]))
            if _is_met(traffic, beams, box, place, column, scratch):
                note_rays(beams, place, column, column, 1, one, found)


@lean_inlined
def _list_row(
    traffic: FrameBoxes, beams: Beams, box: int, place: int, run: tuple[int, int], scratch: Scratch, number: int
) -> int:  # fmt: skip
    """Put rays of a run of the columns found in a row on the list; return how many there are then."""
    hits, marks, first = scratch.rays.hits, scratch.rays.marks, parts_of(traffic, box)[0]
    f, g, to = beams.scale[place, 0], beams.scale[place, 1], np.uint64(number)
    base, table = np.uint64(place * beams.columns), np.uint64(place * beams.stride)
    ray, step = beams.row_of[place] * beams.steps[0], beams.steps[1]
    for at in range(np.uint64(run[0]), np.uint64(run[1])):
        column = scratch.columns[at]
        hits[X + to], hits[Y + to] = f * beams.x[table + column], f * beams.y[table + column]
        hits[Z + to], hits[INVERSE + to] = g * beams.z[table + column], scratch.canvas.inverse[base + column]
        marks[NUMBER + to] = ray + beams.column_of[column] * step
        marks[PART + to] = scratch.canvas.owner[base + column] - first
        to += np.uint64(_is_met(traffic, beams, box, place, int(np.int64(column)), scratch))
    return int(np.int64(to))


@lean_inlined
def _take(
    traffic: FrameBoxes,
    beams: Beams,
    sweep: Sweep,
    box: int,
    scratch: Scratch,
    found: np.ndarray,
    cells: np.ndarray,
) -> int:
    """Count the returning rays of a LiDAR that enter an object of a group first, and list their cells; return the
    number of these."""
    canvas, turn, rays, one = scratch.canvas, scratch.outline.faces.turn, scratch.rays, sweep.ranks[box]
    start, half_m, width = start_of(traffic, beams, box), 0.0, 0.0
    set_turn(traffic, sweep.rotation, box, turn)
    look_at(traffic, box, start, beams.glass, rays.faces)
    if beams.law.size > 0:
        half_m, width = beams.law[traffic.cls[box]], beams.law[3]
    place, at, end, returning, listed = canvas.touched[0], 0, 0, 0, 0
    while at < end or place < canvas.touched[1]:
        number = 0
        while number < MOST_RAYS and (at < end or place < canvas.touched[1]):
            if at == end:
                at, end, place = 0, _find(beams.columns, box, place, scratch), place + 1
            until = min(end, at + MOST_RAYS - number)
            number = _list_row(traffic, beams, box, place - 1, (at, until), scratch, number)
            at = until
        more, listed = cells_of(
            sweep.key, start, turn, half_m, width, number, rays.hits, rays.marks, rays.faces, cells, listed
        )
        returning += more
    found[RAYS, one] = returning
    kept, block = keep_distinct(listed, cells, scratch.table)
    for axis in range(3):
        found[FIRST_CELL + axis, one], found[LAST_CELL + axis, one] = block[axis], block[axis + 3]
    return int(kept)


@lean_inlined
def _hide(columns: int, scratch: Scratch) -> None:
    """Note that the rays of a group have met something, and leave the canvas empty."""
    canvas, words = scratch.canvas, words_of(columns)
    touch(canvas.touched[0], canvas.touched[1], scratch.bits)
    for place in range(canvas.touched[0], canvas.touched[1]):
        # unsigned, as in `nearest`
        base, column = np.uint64(place * columns), np.uint64(canvas.spans[place, 0])
        end, word = np.uint64(canvas.spans[place, 1]), np.uint64(place * words) + (column >> np.uint64(6))
        while column < end:
            until, bits = min(end, (column | np.uint64(63)) + np.uint64(1)), np.uint64(0)
            for at in range(column, until):
                is_hit = np.uint64(canvas.owner[base + at] >= 0)
                bits |= is_hit << (at & np.uint64(63))
            scratch.bits.seen[word] |= bits
            column, word = until, word + np.uint64(1)
        for slot in range(base + np.uint64(canvas.spans[place, 0]), base + end):
            canvas.last[slot] = -1
    wipe(columns, canvas)


@lean_inlined
def wipe(columns: int, canvas: Canvas) -> None:
    """Leave the canvas empty."""
    for place in range(canvas.touched[0], canvas.touched[1]):
        base = np.uint64(place * columns)
        first, end = base + np.uint64(canvas.spans[place, 0]), base + np.uint64(canvas.spans[place, 1])
        for slot in range(first, end):
            canvas.inverse[slot] = 0.0
        for slot in range(first, end):
            canvas.owner[slot] = -1
        canvas.spans[place, 0], canvas.spans[place, 1] = columns, 0
    canvas.touched[0], canvas.touched[1] = canvas.spans.shape[0], 0


@lean
def _cast_frame(
    traffic: FrameBoxes, beams: Beams, sweep: Sweep, scratch: Scratch, found: np.ndarray, at: np.ndarray,
    cells: np.ndarray, number: int,
) -> int:  # fmt: skip
    """Count one frame: fill found of its objects, append cells behind the `number` present; return their new number."""
    depth_order, begin = scratch.depth_order, 0
    forget(beams.columns, scratch.bits)
    end, ties = (
        line_up(traffic, beams, sweep.frame, depth_order),
        Ties(scratch.canvas.inverse, scratch.canvas.owner),
    )
    if scratch.bits.own.size > 0:
        look_round(traffic, beams, sweep.rotation, depth_order, end, scratch.outline, scratch.bits)
    while begin < end:
        until = begin + 1
        while until < end and depth_order.first[until] == begin:
            until += 1
        is_done = False
        if not beams.turns and until == begin + 1:
            is_done = count_one(
                traffic,
                beams,
                sweep.rotation,
                sweep.ranks,
                depth_order,
                begin,
                scratch.outline,
                scratch.bits,
                found,
            )
        elif not beams.turns:
            is_done = count_group(
                traffic, beams, sweep.rotation, sweep.ranks, depth_order, begin, until, scratch.outline, scratch.bits,
                ties, found,
            )  # fmt: skip
        if not is_done:
            number = _meet_group(traffic, beams, sweep, begin, until, scratch, found, at, cells, number)
        begin = until
    return number


@lean_inlined
def _meet_group(
    traffic: FrameBoxes, beams: Beams, sweep: Sweep, begin: int, end: int, scratch: Scratch, found: np.ndarray,
    at: np.ndarray, cells: np.ndarray, number: int,
) -> int:  # fmt: skip
    """Let all rays meet the boxes of a group, places begin..end-1 of the depth order; returns the number of cells
    then."""
    depth_order, outline = scratch.depth_order, scratch.outline
    for place in range(begin, end):
        box = depth_order.box[place]
        one, alone = sweep.ranks[box], meet_box(
            traffic, beams, box, sweep.rotation, sweep.key, outline.faces, outline.corners, outline.centre,
            scratch.canvas,
        )  # fmt: skip
        if one >= 0:
            found[ALONE, one] = alone
    for place in range(begin, end):
        box = depth_order.box[place]
        one = sweep.ranks[box]
        if one >= 0 and found[ALONE, one] > 0:
            if not beams.turns:
                _count_rays(traffic, beams, box, one, scratch, found)
                continue
            own = _take(traffic, beams, sweep, box, scratch, found, cells[number:])
            found[CELLS, one], at[one] = own, number
            number += own
    _hide(beams.columns, scratch)
    return number


@kernel
def spun(rotation: np.ndarray, phase: float) -> np.ndarray:
    """Return R Rz(phase): the rotation (3, 3) of a sensor whose azimuths are all shifted by a phase in radians."""
    if phase == 0.0:
        return rotation
    cos, sin = np.cos(phase), np.sin(phase)
    to = np.empty((3, 3))
    for axis in range(3):
        x, y = rotation[axis, 0], rotation[axis, 1]
        to[axis, 0], to[axis, 1], to[axis, 2] = x * cos + y * sin, y * cos - x * sin, rotation[axis, 2]
    return to


@kernel
def _new_scratch(
    beams: Beams, most: int, inverse: np.ndarray, owner: np.ndarray, last: np.ndarray, table: np.ndarray
) -> Scratch:
    """Return room for the rays of a sensor and frames of at most `most` boxes, whose large parts are given."""
    rows, columns = beams.row_of.size, beams.columns
    spans = np.empty((rows, 2), np.int32)
    spans[:, 0], spans[:, 1] = columns, 0
    canvas = Canvas(inverse, owner, last, spans, np.empty(columns), np.array([rows, 0]))
    outline, bits = outline_for(new_faces(), beams), new_bits(beams, most)
    return Scratch(
        new_depth_order(most), outline, canvas, bits, np.empty(columns + 1, np.uint64), new_list(), table
    )


@kernel
def cast_frames(
    traffic: FrameBoxes, beams: Beams, first: int, end: int, phases: np.ndarray, keys: np.ndarray, ranks: np.ndarray,
    most: int, inverse: np.ndarray, owner: np.ndarray, last: np.ndarray, table: np.ndarray,
    found: np.ndarray, at: np.ndarray, cells: np.ndarray,
) -> int:  # fmt: skip
    """Cast a sensor in frames first..end-1, one after the other; return the number of cells entered.

    phases (frames,) radians; keys uint64 (frames,) of the draws; ranks (n,): places of boxes among the m objects that
    count, below 0 for the others; most: boxes in any frame. Scratch (rays,): inverse 0, owner and last -1, and left so;
    table (k,). Takes found int32 (COLUMNS, m), of no object met before, and writes the cells int64 (k,) entered; at
    (m,): where those of an object begin.
    """
    scratch, number = _new_scratch(beams, most, inverse, owner, last, table), 0
    for frame in range(first, end):
        sweep = Sweep(frame, spun(beams.rotation, phases[frame]), keys[frame], ranks)
        number = _cast_frame(traffic, beams, sweep, scratch, found, at, cells, number)
    return number
