"""Points, pixels and cells on every road user: frame by frame, in parallel.

Frames share nothing, so any number of threads gives the same numbers.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.distinct import cell_key, keep_distinct
from riglens.core.kernels.jit import kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.lattice import Direction
from riglens.core.kernels.nearest import (
    Beams,
    Canvas,
    Faces,
    Traffic,
    local_direction,
    meet_frame,
    set_turn,
    start_of,
    turned,
)
from riglens.core.kernels.phases import mixed, unit

RAYS, ALONE, FIRST_ROW, LAST_ROW, CELLS = 0, 1, 2, 3, 4
"""Columns of what is found on an object: rays that enter it first, rays that would if it stood alone, first and last
row of the lattice among the former (-1: none), distinct cells that they enter (LiDARs)."""
COLUMNS = 5


@lean
def _count_rays(
    traffic: Traffic, beams: Beams, first: int, canvas: Canvas, found: np.ndarray, ends: np.ndarray
) -> None:
    """Count the rays that enter each object first, and their rows, in found (n, COLUMNS) and ends (objects of the
    frame,).

    Rays that the car's own body stops, and those of a LiDAR that enter glass, are taken from the canvas.
    """
    inverse, owner, spans = canvas.inverse, canvas.owner, canvas.spans
    for place in range(spans.shape[0]):
        row, base, before = beams.row_of[place], place * beams.columns, -1
        for slot in range(base + spans[place, 0], base + spans[place, 1]):
            part = owner[slot]
            if part < 0:
                continue
            box = traffic.box_of[part]
            if beams.turns and traffic.is_glass[part]:
                owner[slot] = -1
                continue
            if beams.ends.size > 0 and is_stopped(beams, row, slot, inverse[slot]):
                owner[slot] = -1
                continue
            ends[box - first] += 1
            if box != before:
                found[box, FIRST_ROW] = min(found[box, FIRST_ROW], row) if found[box, FIRST_ROW] >= 0 else row
                found[box, LAST_ROW] = max(found[box, LAST_ROW], row)
                before = box


@lean_inlined
def is_stopped(beams: Beams, row: int, slot: int, inverse: float) -> bool:
    """Whether the car's own body stops a ray before it gets where it went."""
    column = slot % beams.columns
    x, y, z = local_direction(beams, slot // beams.columns, column)
    length = np.sqrt(x * x + y * y + z * z)
    return not length / inverse < beams.ends[row * beams.columns + beams.column_of[column]]


@lean
def _by_object(
    traffic: Traffic, beams: Beams, first: int, canvas: Canvas, ends: np.ndarray, ordered: np.ndarray
) -> None:
    """Put the rays in the order of their objects: ordered (rays, 2) takes places of row and column; `ends`, where the
    rays of object first + k begin, takes where they end."""
    for place in range(canvas.spans.shape[0]):
        base = place * beams.columns
        for column in range(canvas.spans[place, 0], canvas.spans[place, 1]):
            part = canvas.owner[base + column]
            if part >= 0:
                k = traffic.box_of[part] - first
                ordered[ends[k], 0], ordered[ends[k], 1] = place, column
                ends[k] += 1


@lean_inlined
def cosine_of(traffic: Traffic, part: int, start: Direction, along: Direction) -> float:
    """Cosine of the angle between a ray, in the axes of an object, and the normal of the face by which it enters a
    part; 1 for a ray that starts inside."""
    offset, half = traffic.offsets[part], traffic.part_halves[part]
    last, cosine = -np.inf, 1.0
    for axis in range(3):
        s = abs(start[axis] - offset[axis]) - half[axis]
        if s > 0.0:  # the face entered is the one that is reached last
            at = s / abs(along[axis])
            if at > last:
                last, cosine = at, abs(along[axis])
    return float(cosine)


@lean_inlined
def is_returned(t: float, half_m: float, width: float, cosine: float, chance: float) -> bool:
    """Whether a ray comes back from a face at t metres, against a chance in [0, 1); half_m: where half of them would
    from one that looks at the sensor; width: of the logistic, relative to that."""
    limit = half_m * np.sqrt(cosine)
    return bool(chance < 1.0 / (1.0 + np.exp((t / limit - 1.0) / width)))


@lean
def _note_cells(
    traffic: Traffic, beams: Beams, rotation: np.ndarray, box: int, rays: np.ndarray, canvas: Canvas,
    turn: np.ndarray, key: np.uint64, table: np.ndarray, cells: np.ndarray,
) -> tuple[int, int]:  # fmt: skip
    """Put the distinct cells into which rays (k, 2) come on an object into `cells`; how many rays return, and cells.

    key: of the draws of the sensor in this frame, where it has a range law.
    """
    points, start = 0, start_of(traffic, beams, box)
    set_turn(traffic, rotation, box, turn)
    for k in range(rays.shape[0]):
        row, column = rays[k, 0], rays[k, 1]
        slot = row * beams.columns + column
        along, t = turned(turn, local_direction(beams, row, column)), 1.0 / canvas.inverse[slot]
        if beams.law.size > 0:
            ray = beams.row_of[row] * beams.columns + beams.column_of[column]
            chance = unit(mixed(key, np.uint64(ray)))
            cosine = cosine_of(traffic, canvas.owner[slot], start, along)
            if not is_returned(t, beams.law[traffic.cls[box]], beams.law[3], cosine, chance):
                continue
        cells[points] = cell_key(start, along, t)
        points += 1
    return points, keep_distinct(points, cells, table)


@lean
def wipe(columns: int, canvas: Canvas) -> None:
    """Leave the canvas empty."""
    for place in range(canvas.spans.shape[0]):
        base = place * columns
        for slot in range(base + canvas.spans[place, 0], base + canvas.spans[place, 1]):
            canvas.inverse[slot], canvas.owner[slot] = 0.0, -1
        canvas.spans[place, 0], canvas.spans[place, 1] = columns, 0


@kernel
def _cast_frame(
    traffic: Traffic, beams: Beams, frame: int, phase: float, key: np.uint64, canvas: Canvas, ordered: np.ndarray,
    table: np.ndarray, found: np.ndarray, cells: np.ndarray,
) -> int:  # fmt: skip
    """One frame: fills found of its objects and cells; returns the number of the latter. The canvas of a worker is
    left empty, as it was found."""
    first, end = traffic.starts[frame], traffic.starts[frame + 1]
    rotation = spun(beams.rotation, phase)
    faces = Faces(0, 0, np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3))
    meet_frame(traffic, beams, frame, rotation, faces, np.empty((8, 3)), np.empty(3), canvas, found[:, ALONE])
    ends = np.zeros(end - first, np.int64)
    found[first:end, FIRST_ROW] = -1
    found[first:end, LAST_ROW] = -1
    _count_rays(traffic, beams, first, canvas, found, ends)
    found[first:end, RAYS] = ends
    number = 0
    if beams.turns:
        ends[:] = np.cumsum(ends) - ends
        _by_object(traffic, beams, first, canvas, ends, ordered)
        for box in range(first, end):
            if found[box, RAYS] > 0 and traffic.counts[box]:
                rays = ordered[ends[box - first] - found[box, RAYS] : ends[box - first]]
                points, own = _note_cells(
                    traffic, beams, rotation, box, rays, canvas, faces.turn, key, table, cells[number:]
                )
                found[box, RAYS], found[box, CELLS] = points, own
                number += own
    wipe(beams.columns, canvas)
    return number


@kernel
def spun(rotation: np.ndarray, phase: float) -> np.ndarray:
    """R Rz(phase): the rotation (3, 3) of a sensor whose azimuths are all shifted by a phase in radians."""
    if phase == 0.0:
        return rotation
    cos, sin = np.cos(phase), np.sin(phase)
    to = np.empty((3, 3))
    for axis in range(3):
        x, y = rotation[axis, 0], rotation[axis, 1]
        to[axis, 0], to[axis, 1], to[axis, 2] = x * cos + y * sin, y * cos - x * sin, rotation[axis, 2]
    return to


@parallel_kernel
def cast_frames(
    traffic: Traffic, beams: Beams, first: int, end: int, phases: np.ndarray, keys: np.ndarray,
    inverse: np.ndarray, owner: np.ndarray, last: np.ndarray, spans: np.ndarray, ordered: np.ndarray,
    runs: np.ndarray, tables: np.ndarray,
    found: np.ndarray, cells: np.ndarray, filled: np.ndarray,
) -> None:  # fmt: skip
    """Cast a sensor in frames first..end-1, dealt to as many workers as the scratch has rows.

    phases (frames,) radians; keys uint64 (frames,) of the draws. Scratch (workers, rays): inverse 0, owner and last -1;
    spans (workers, rows, 2) columns and 0; ordered (workers, rays, 2), runs (workers, columns), tables (workers, k).
    Takes found int32 (n, COLUMNS) of all objects, zero before; cells int64 (end - first, rays) and filled (end -
    first,): the cells entered, object by object in each frame, and how many.
    """
    workers = inverse.shape[0]
    for worker in numba.prange(workers):
        canvas = Canvas(inverse[worker], owner[worker], last[worker], spans[worker], runs[worker])
        begin = (
            first + (end - first) * worker // workers
        )  # a worker's frames lie together, and so do its objects
        for frame in range(begin, first + (end - first) * (worker + 1) // workers):
            filled[frame - first] = _cast_frame(
                traffic, beams, frame, phases[frame], keys[frame], canvas, ordered[worker], tables[worker], found,
                cells[frame - first],
            )  # fmt: skip


@kernel
def cast_frames_serial(
    traffic: Traffic, beams: Beams, first: int, end: int, phases: np.ndarray, keys: np.ndarray,
    inverse: np.ndarray, owner: np.ndarray, last: np.ndarray, spans: np.ndarray, ordered: np.ndarray,
    runs: np.ndarray, tables: np.ndarray,
    found: np.ndarray, cells: np.ndarray, filled: np.ndarray,
) -> None:  # fmt: skip
    """As `cast_frames`, with the first worker's scratch alone, for any thread."""
    canvas = Canvas(inverse[0], owner[0], last[0], spans[0], runs[0])
    for frame in range(first, end):
        filled[frame - first] = _cast_frame(
            traffic,
            beams,
            frame,
            phases[frame],
            keys[frame],
            canvas,
            ordered[0],
            tables[0],
            found,
            cells[frame - first],
        )
