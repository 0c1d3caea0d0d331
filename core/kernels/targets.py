"""Which box each ray of a sensor enters first, frame by frame: points, pixels and cells on every road user.

For each box the window of rows and columns that can meet it, an exact test in the box's own axes for each ray there,
and the nearest entry per ray; of two boxes entered at the same distance the earlier one in the data counts. Frames
share nothing, so any number of threads gives the same numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.codes import LISTED
from riglens.core.kernels.jit import inlined, kernel, parallel_kernel
from riglens.core.kernels.lattice import Direction, direction, rotated
from riglens.core.kernels.shapes import MISSED, enter_box, is_inside, turned_into
from riglens.core.kernels.windows import TURN, Window, corners_of, window_of_image, window_of_turn

RAYS, ALONE, FIRST_ROW, LAST_ROW, CELLS = 0, 1, 2, 3, 4
"""Columns of what is found on an object: rays that enter it first, rays that would if it stood alone, first and last
row of the lattice among the former (-1: none), distinct cells that they enter (LiDARs)."""
COLUMNS = 5
CELL_M = 0.2
INSIDE_M = 1e-3
"""A cell is taken at the point this far along the ray after it enters."""
_HALF_CELLS, _BITS = 1 << 20, 21
"""Cell numbers along an axis are packed into 21 bits each: 200 km of cells, far more than any box has."""


class Traffic(NamedTuple):
    """Boxes of all frames, in the vehicle frame: those of frame f are starts[f]..starts[f + 1] (frames + 1,); centres,
    halves (n, 3) metres, rotations (n, 3, 3) box to vehicle frame; counts (n,) bool: those that count."""

    starts: np.ndarray
    centres: np.ndarray
    halves: np.ndarray
    rotations: np.ndarray
    counts: np.ndarray


class Beams(NamedTuple):
    """Rays of a sensor, ray = row * columns + column.

    kind, rows, planes: tables as in `riglens.core.kernels.lattice`, NaN for a listed ray that the lens has not; turns:
    whether windows are angles (LiDAR) or places on the image plane; origin (3,); rotation (3, 3) sensor to vehicle
    frame; reach (2,) metres; row_at, column_at: where rows and columns lie, rising, and row_of, column_of: their
    numbers; shift (rows,): what is added to the columns of a row; ends (rays,) or (0,): where the car's own body stops
    a ray, metres; blocks (b, 7): cones around runs of a listed camera's rays (axis, cosine and sine of the half angle,
    first ray, number of rays), none for the others; least: what comes nearer to the plane x = 0 of a camera than this,
    in metres, is in no image.
    """

    kind: int
    turns: bool
    rows: np.ndarray
    planes: np.ndarray
    columns: int
    origin: np.ndarray
    rotation: np.ndarray
    reach: np.ndarray
    row_at: np.ndarray
    row_of: np.ndarray
    column_at: np.ndarray
    column_of: np.ndarray
    shift: np.ndarray
    ends: np.ndarray
    blocks: np.ndarray
    least: float


class Seen(NamedTuple):
    """A box as seen by the sensor: number, its rotation and half sizes, and the sensor's place in its axes."""

    box: int
    turn: np.ndarray
    half: np.ndarray
    start: Direction


@inlined
def local_direction(beams: Beams, ray: int) -> Direction:
    """Direction of a ray in the sensor's own axes."""
    if beams.kind == LISTED:
        return direction(LISTED, beams.rows[ray], beams.planes[0])
    return direction(beams.kind, beams.rows[ray // beams.columns], beams.planes[ray % beams.columns])


@inlined
def _offer(
    beams: Beams, rotation: np.ndarray, seen: Seen, ray: int, nearest: np.ndarray, owner: np.ndarray,
    touched: np.ndarray, count: int,
) -> tuple[int, int]:  # fmt: skip
    """Let a ray meet a box; the number of touched rays, and 1 where it enters."""
    along = turned_into(seen.turn, rotated(rotation, local_direction(beams, ray)))
    if np.isnan(along[0]):
        return count, 0  # the lens has no such ray
    t = enter_box(seen.start, along, seen.half, beams.reach[0], beams.reach[1])
    if not t < MISSED:
        return count, 0
    if owner[ray] < 0:
        touched[count] = ray
        count += 1
    if t < nearest[ray]:
        nearest[ray], owner[ray] = t, seen.box
    return count, 1


@inlined
def _window(beams: Beams, corners: np.ndarray) -> Window:
    return window_of_turn(corners) if beams.turns else window_of_image(corners, beams.least)


@kernel
def _meet_rows(
    beams: Beams, rotation: np.ndarray, seen: Seen, window: Window, nearest: np.ndarray, owner: np.ndarray,
    touched: np.ndarray, count: int,
) -> tuple[int, int]:  # fmt: skip
    """Offer a box to all rays in its window; the number of touched rays, and how many rays enter the box."""
    entered, columns = 0, beams.columns
    first = np.searchsorted(beams.row_at, window.low)
    for place in range(first, beams.row_at.size):
        if beams.row_at[place] > window.high:
            break
        row = beams.row_of[place]
        left = window.left - beams.shift[row]
        if beams.turns:
            left = left % TURN
        start = np.searchsorted(beams.column_at, left)
        for step in range(columns):
            at = start + step
            lap = 0.0
            if at >= columns:
                if not beams.turns:
                    break
                at, lap = at - columns, TURN
            if beams.column_at[at] + lap > left + window.width:
                break
            ray = row * columns + beams.column_of[at]
            count, more = _offer(beams, rotation, seen, ray, nearest, owner, touched, count)
            entered += more
    return count, entered


@kernel
def _meet_blocks(
    beams: Beams, rotation: np.ndarray, seen: Seen, corners: np.ndarray, nearest: np.ndarray,
    owner: np.ndarray, touched: np.ndarray, count: int,
) -> tuple[int, int]:  # fmt: skip
    """As `_meet_rows` for a lattice without straight rows and columns: block by block of its directions."""
    entered = 0
    x = 0.5 * (corners[0, 0] + corners[7, 0])
    y = 0.5 * (corners[0, 1] + corners[7, 1])
    z = 0.5 * (corners[0, 2] + corners[7, 2])
    radius2 = seen.half[0] * seen.half[0] + seen.half[1] * seen.half[1] + seen.half[2] * seen.half[2]
    far2 = x * x + y * y + z * z
    is_around = radius2 >= far2 * (1.0 - 1e-9)
    far = np.sqrt(far2)
    sine = np.sqrt(radius2 / far2) if not is_around else 1.0
    cosine = np.sqrt(1.0 - sine * sine) if not is_around else 0.0
    for block in range(beams.blocks.shape[0]):
        cone = beams.blocks[block]
        block_cos, block_sin, first = cone[3], cone[4], int(cone[5])
        limit = block_cos * cosine - block_sin * sine
        is_wide = block_cos < 0.0 or block_sin * cosine + block_cos * sine < 0.0
        if not is_around and not is_wide and cone[0] * x + cone[1] * y + cone[2] * z < (limit - 1e-9) * far:
            continue
        for ray in range(first, first + int(cone[6])):
            count, more = _offer(beams, rotation, seen, ray, nearest, owner, touched, count)
            entered += more
    return count, entered


@kernel
def _reach_of(traffic: Traffic, beams: Beams, frame: int) -> float:
    """Nothing farther from the sensor than this can stand before an object that counts."""
    reach = 0.0
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        if traffic.counts[box]:
            reach = max(reach, _distance(traffic, beams, box) + _radius(traffic, box))
    return reach * (1.0 + 1e-9)


@inlined
def _distance(traffic: Traffic, beams: Beams, box: int) -> float:
    dx = traffic.centres[box, 0] - beams.origin[0]
    dy = traffic.centres[box, 1] - beams.origin[1]
    dz = traffic.centres[box, 2] - beams.origin[2]
    return float(np.sqrt(dx * dx + dy * dy + dz * dz))


@inlined
def _radius(traffic: Traffic, box: int) -> float:
    a, b, c = traffic.halves[box, 0], traffic.halves[box, 1], traffic.halves[box, 2]
    return float(np.sqrt(a * a + b * b + c * c))


@kernel
def _meet_frame(
    traffic: Traffic, beams: Beams, frame: int, rotation: np.ndarray, nearest: np.ndarray, owner: np.ndarray,
    touched: np.ndarray, found: np.ndarray,
) -> int:  # fmt: skip
    """Nearest entries of a frame's boxes in nearest, owner (rays,); touched (rays,) lists the rays that have one, and
    their number is returned. found (n, COLUMNS) of the objects takes the column ALONE."""
    corners, offset, count = np.empty((8, 3)), np.empty(3), 0
    reach = _reach_of(traffic, beams, frame)
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        distance, radius = _distance(traffic, beams, box), _radius(traffic, box)
        if distance - radius > min(reach, beams.reach[1] * (1.0 + 1e-9)):
            continue
        for axis in range(3):
            offset[axis] = traffic.centres[box, axis] - beams.origin[axis]
        turn, half = traffic.rotations[box], traffic.halves[box]
        start = turned_into(turn, (-offset[0], -offset[1], -offset[2]))
        if is_inside(start, half):
            continue
        seen = Seen(box, turn, half, start)
        corners_of(offset, rotation, turn, half, corners)
        if beams.blocks.shape[0] > 0:
            count, entered = _meet_blocks(beams, rotation, seen, corners, nearest, owner, touched, count)
        else:
            window = _window(beams, corners)
            if window.width < 0.0:
                continue
            count, entered = _meet_rows(beams, rotation, seen, window, nearest, owner, touched, count)
        found[box, ALONE] = entered
    return count


@kernel
def _by_object(
    owner: np.ndarray, touched: np.ndarray, count: int, first: int, ends: np.ndarray, ordered: np.ndarray
) -> None:
    """Put the touched rays in the order of their objects: `ordered` (rays,), those of object first + k end at
    ends[k]."""
    ends[:] = 0
    for place in range(count):
        ends[owner[touched[place]] - first] += 1
    total = 0
    for k in range(ends.size):
        total, ends[k] = total + ends[k], total
    for place in range(count):
        k = owner[touched[place]] - first
        ordered[ends[k]] = touched[place]
        ends[k] += 1


@inlined
def cell_key(start: Direction, along: Direction, t: float) -> int:
    """Number of the cell that a ray is in, INSIDE_M after it entered an object at distance t."""
    s = t + INSIDE_M
    i = np.int64(np.floor((start[0] + s * along[0]) / CELL_M)) + _HALF_CELLS
    j = np.int64(np.floor((start[1] + s * along[1]) / CELL_M)) + _HALF_CELLS
    k = np.int64(np.floor((start[2] + s * along[2]) / CELL_M)) + _HALF_CELLS
    return int((((i << _BITS) | j) << _BITS) | k)


@inlined
def is_new(key: int, table: np.ndarray, mask: int) -> bool:
    """Put a key (>= 0) into a hash table, -1 where free, of mask + 1 places; whether it was not there yet."""
    word = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
    place = np.int64(word >> np.uint64(32)) & mask
    while table[place] != -1:
        if table[place] == key:
            return False
        place = (place + 1) & mask
    table[place] = key
    return True


@inlined
def table_mask(keys: int) -> int:
    """Size, less one, of a hash table at most half full of that many keys."""
    size = 4
    while size < 2 * keys:
        size *= 2
    return size - 1


@kernel
def _note_object(
    traffic: Traffic, beams: Beams, rotation: np.ndarray, box: int, rays: np.ndarray, nearest: np.ndarray,
    found: np.ndarray, table: np.ndarray, cells: np.ndarray,
) -> int:  # fmt: skip
    """Count the rays (k,) that enter an object first, and the cells of a LiDAR's, which go to `cells`; how many."""
    turn, number, points = traffic.rotations[box], 0, 0
    first, last = np.int64(1 << 30), np.int64(-1)
    start = turned_into(
        turn,
        (
            -(traffic.centres[box, 0] - beams.origin[0]),
            -(traffic.centres[box, 1] - beams.origin[1]),
            -(traffic.centres[box, 2] - beams.origin[2]),
        ),
    )
    mask = table_mask(rays.size)
    if beams.turns:
        table[: mask + 1] = -1
    for ray in rays:
        if beams.ends.size > 0 and not nearest[ray] < beams.ends[ray]:
            continue
        points += 1
        row = ray // beams.columns
        first, last = min(first, row), max(last, row)
        if beams.turns:
            along = turned_into(turn, rotated(rotation, local_direction(beams, ray)))
            key = cell_key(start, along, nearest[ray])
            if is_new(key, table, mask):
                cells[number] = key
                number += 1
    found[box, RAYS], found[box, CELLS] = points, number
    found[box, FIRST_ROW], found[box, LAST_ROW] = (first if points else -1), last
    return number


@kernel
def _cast_frame(
    traffic: Traffic, beams: Beams, frame: int, phase: float, nearest: np.ndarray, owner: np.ndarray,
    touched: np.ndarray, ordered: np.ndarray, table: np.ndarray, found: np.ndarray, cells: np.ndarray,
) -> int:  # fmt: skip
    """One frame: fills found of its objects and cells; returns the number of the latter. The scratch of a worker,
    nearest and so on, is left as it was found."""
    first, end = traffic.starts[frame], traffic.starts[frame + 1]
    rotation = spun(beams.rotation, phase)
    count = _meet_frame(traffic, beams, frame, rotation, nearest, owner, touched, found)
    ends = np.empty(end - first, np.int64)
    _by_object(owner, touched, count, first, ends, ordered)
    begun, number = 0, 0
    for k in range(end - first):
        rays = ordered[begun : ends[k]]
        begun = ends[k]
        found[first + k, FIRST_ROW], found[first + k, LAST_ROW] = -1, -1
        if rays.size:
            number += _note_object(
                traffic, beams, rotation, first + k, rays, nearest, found, table, cells[number:]
            )
    for place in range(count):
        nearest[touched[place]], owner[touched[place]] = MISSED, -1
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
    traffic: Traffic, beams: Beams, first: int, end: int, phases: np.ndarray, nearest: np.ndarray,
    owner: np.ndarray, touched: np.ndarray, ordered: np.ndarray, tables: np.ndarray, found: np.ndarray,
    cells: np.ndarray, filled: np.ndarray,
) -> None:  # fmt: skip
    """Cast a sensor in frames first..end-1, dealt to as many workers as the scratch has rows.

    phases (frames,) radians. Scratch (workers, rays): nearest inf, owner -1, touched, ordered; tables (workers, k).
    Takes found int32 (n, COLUMNS) of all objects, zero before; cells int64 (end - first, rays) and filled (end -
    first,): the cells entered, object by object in each frame, and how many.
    """
    workers = nearest.shape[0]
    for worker in numba.prange(workers):
        for frame in range(first + worker, end, workers):
            filled[frame - first] = _cast_frame(
                traffic, beams, frame, phases[frame], nearest[worker], owner[worker], touched[worker],
                ordered[worker], tables[worker], found, cells[frame - first],
            )  # fmt: skip


@kernel
def cast_frames_serial(
    traffic: Traffic, beams: Beams, first: int, end: int, phases: np.ndarray, nearest: np.ndarray,
    owner: np.ndarray, touched: np.ndarray, ordered: np.ndarray, tables: np.ndarray, found: np.ndarray,
    cells: np.ndarray, filled: np.ndarray,
) -> None:  # fmt: skip
    """As `cast_frames`, with the first worker's scratch alone, for any thread."""
    for frame in range(first, end):
        filled[frame - first] = _cast_frame(
            traffic, beams, frame, phases[frame], nearest[0], owner[0], touched[0], ordered[0], tables[0], found,
            cells[frame - first],
        )  # fmt: skip


@parallel_kernel
def joined_cells(starts: np.ndarray, cells: np.ndarray, most: int, workers: int, to: np.ndarray) -> None:
    """Distinct cells of each object over several LiDARs: to int32 (objects,).

    cells of LiDAR l on object o: cells[starts[l, o]] up to starts[l, o + 1], which l alone has; most: cells of all
    LiDARs on any object.
    """
    objects = to.size
    for worker in numba.prange(workers):
        table = np.empty(table_mask(most) + 1, np.int64)
        for one in range(worker, objects, workers):
            to[one] = _distinct(starts, cells, one, table)


@kernel
def _distinct(starts: np.ndarray, cells: np.ndarray, one: int, table: np.ndarray) -> int:
    total, number = 0, 0
    for lidar in range(starts.shape[0]):
        total += starts[lidar, one + 1] - starts[lidar, one]
    mask = table_mask(total)
    table[: mask + 1] = -1
    for lidar in range(starts.shape[0]):
        for place in range(starts[lidar, one], starts[lidar, one + 1]):
            number += is_new(cells[place], table, mask)
    return number
