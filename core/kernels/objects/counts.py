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
    bounds_of,
    box_of,
    is_lost,
    limit_of,
    local_direction,
    new_faces,
    parts_of,
    ray_at,
    set_turn,
    start_of,
    turned,
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
from riglens.core.kernels.objects.silhouette import Outline, outline_for, words_of
from riglens.core.kernels.objects.unique_cells import keep_distinct, note_cells
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.rays.phases import mixed, unit
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

__all__ = ["ALONE", "FIRST_ROW", "LAST_ROW", "RAYS"]

CELLS, FIRST_CELL, LAST_CELL = 4, 5, 8
"""Further rows of results on objects: distinct cells that rays enter (LiDARs), and along three axes, a row each, the
first and the last of these (none: the last before the first)."""
COLUMNS = 11
_NEARLY = 1.0 - 1e-9
"""Share of a bound that is below it for certain: far more room than rounding takes."""


class Scratch(NamedTuple):
    """Room for a worker: the depth order of a frame; the image of a box; what rays of a group have met, and of a frame
    so far; hits (4, rays): of rays that meet an object, their directions in its axes and 1 / t of the hit; table of
    cells."""

    depth_order: DepthOrder
    outline: Outline
    canvas: Canvas
    bits: Bits
    hits: np.ndarray
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
def overhang_of(traffic: FrameBoxes, part: int, start: Direction) -> Direction:
    """Return by how much a place, in the axes of an object, is beyond a part along each of these; below 0: between its
    faces."""
    middle, half = bounds_of(traffic, part)
    return (
        abs(start[0] - middle[0]) - half[0],
        abs(start[1] - middle[1]) - half[1],
        abs(start[2] - middle[2]) - half[2],
    )


@lean_inlined
def cosine_of(over: Direction, along: Direction) -> float:
    """Return the cosine of the angle between a ray, in the axes of an object, and the normal of the face by which it
    enters a part, from a place that far beyond it; 1 for a ray that starts inside."""
    last, cosine = -np.inf, 1.0
    for axis in range(3):
        s = over[axis]
        if s > 0.0:  # the face entered is the one that is reached last
            at = s / abs(along[axis])
            if at > last:
                last, cosine = at, abs(along[axis])
    return float(cosine)


@lean_inlined
def is_returned(t: float, half_m: float, width: float, cosine: float, chance: float) -> bool:
    """Return whether a ray returns from a face at t metres, against a chance in [0, 1); half_m: range at which half of
    them would from a face towards the sensor; width: of the logistic, relative to that."""
    x = (t / (half_m * np.sqrt(cosine)) - 1.0) / width
    least = 1.0 - x + 0.5 * x * x  # of exp(-x) for x below 0: most rays need no exponential
    if x < 0.0 and chance * (1.0 + least) < least * _NEARLY:
        return True
    return bool(chance < 1.0 / (1.0 + np.exp(x)))


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
    """Count the rays that enter an object of a group first without a nearer hit, and list the cells of a LiDAR's
    returning rays; return the number of the latter."""
    canvas, words, turn, rays = scratch.canvas, words_of(beams.columns), scratch.outline.faces.turn, 0
    start, one = start_of(traffic, beams, box), sweep.ranks[box]
    set_turn(traffic, sweep.rotation, box, turn)
    over, (first, last) = scratch.outline.corners, parts_of(traffic, box)
    for part in range(first, last if beams.law.size > 0 else first):
        over[part - first, 0], over[part - first, 1], over[part - first, 2] = overhang_of(
            traffic, part, start
        )
    for place in range(canvas.touched[0], canvas.touched[1]):
        base, before, low, high = place * beams.columns, rays, beams.columns, -1
        for column in range(canvas.spans[place, 0], canvas.spans[place, 1]):
            slot = base + column
            part = canvas.owner[slot]
            if part < 0 or box_of(part) != box:
                continue
            if scratch.bits.seen[place * words + (column >> 6)] >> np.uint64(column & 63) & np.uint64(1):
                continue
            if beams.turns and is_lost(traffic, beams, sweep.key, part, place, column):
                continue
            if beams.ends.size > 0 and is_stopped(beams, place, column, canvas.inverse[slot]):
                continue
            if beams.limits.size > 0 and not is_in_range(traffic, beams, box, place, canvas.inverse[slot]):
                continue
            if beams.turns:
                along, inverse = turned(turn, local_direction(beams, place, column)), canvas.inverse[slot]
                if beams.law.size > 0:
                    word = mixed(sweep.key, np.uint64(ray_at(beams, place, column)))
                    mine = over[part - first]
                    chance, cosine = unit(word), cosine_of((mine[0], mine[1], mine[2]), along)
                    half_m, width = beams.law[traffic.cls[box]], beams.law[3]
                    if not is_returned(1.0 / inverse, half_m, width, cosine, chance):
                        continue
                scratch.hits[0, rays], scratch.hits[1, rays], scratch.hits[2, rays] = along
                scratch.hits[3, rays] = inverse
            rays, low, high = rays + 1, min(low, column), column
        if rays > before:
            note_rays(beams, place, low, high, rays - before, one, found)
    if not beams.turns:
        return 0
    note_cells(start, scratch.hits, rays, cells)
    kept, block = keep_distinct(rays, cells, scratch.table)
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
        base, first = np.uint64(place * columns), np.uint64(place * words)
        for column in range(np.uint64(canvas.spans[place, 0]), np.uint64(canvas.spans[place, 1])):
            slot, bit = base + column, np.uint64(1) << (column & np.uint64(63))
            canvas.last[slot] = -1
            if canvas.owner[slot] >= 0:
                scratch.bits.seen[first + (column >> np.uint64(6))] |= bit
                canvas.inverse[slot], canvas.owner[slot] = 0.0, -1
        canvas.spans[place, 0], canvas.spans[place, 1] = columns, 0
    canvas.touched[0], canvas.touched[1] = canvas.spans.shape[0], 0


@lean_inlined
def wipe(columns: int, canvas: Canvas) -> None:
    """Leave the canvas empty."""
    for place in range(canvas.touched[0], canvas.touched[1]):
        base = place * columns
        for slot in range(base + canvas.spans[place, 0], base + canvas.spans[place, 1]):
            canvas.inverse[slot], canvas.owner[slot] = 0.0, -1
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
    return Scratch(new_depth_order(most), outline, canvas, bits, np.empty((4, rows * columns)), table)


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
