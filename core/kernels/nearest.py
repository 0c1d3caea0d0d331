"""Which box of a frame each ray of a sensor enters first.

For each box the window of rows and columns that can meet it, and for each ray there a test without division: 1 / t at
which a ray crosses a face is linear in its direction, so the ray enters the box at the least of these numbers over the
faces towards the sensor and leaves it at the greatest over those away from it. The nearest entry counts; of two boxes
entered at the same distance the earlier one in the data.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.jit import lean, lean_inlined
from riglens.core.kernels.lattice import Direction
from riglens.core.kernels.shapes import is_inside, turned_into
from riglens.core.kernels.windows import NOWHERE, TURN, Window, corners_of, window_of_image, window_of_turn

_LARGE = 400.0
"""Where about so many rays can meet a box, each of its parts has a window of its own."""
_TINY = 1e-300
"""Stands for no distance at all between the sensor and the plane of a face, by which numbers are divided."""


class Traffic(NamedTuple):
    """Boxes of all frames, in the vehicle frame: those of frame f are starts[f]..starts[f + 1] (frames + 1,);
    centres, halves (n, 3) metres, rotations (n, 3, 3) box to vehicle frame; counts (n,) bool: those that count;
    cls (n,): their classes.

    Each box is made of parts, boxes within it: those of box b are part_starts[b]..part_starts[b + 1] (n + 1,); box_of
    (m,) is the box of a part; offsets, part_halves (m, 3) in metres and in the axes of the box; is_glass (m,): whether
    it gives LiDARs no return.
    """

    starts: np.ndarray
    centres: np.ndarray
    halves: np.ndarray
    rotations: np.ndarray
    counts: np.ndarray
    cls: np.ndarray
    part_starts: np.ndarray
    box_of: np.ndarray
    offsets: np.ndarray
    part_halves: np.ndarray
    is_glass: np.ndarray


class Beams(NamedTuple):
    """Rays of a sensor. Ray number = row * columns + column as the sensor lists them; its slot is the same with
    rows and columns in rising order: slot = place of the row * columns + place of the column.

    Direction in the sensor frame of a slot: (f x, f y, g z) with f, g from `scale` (rows, 2) and x, y, z from
    arrays, (columns,) where `stride` is 0, else (slots,) with stride = columns; zero for a ray that the lens has
    not. Unit vectors, or for a pinhole that sees from 0 to infinity those with x = 1. turns: whether columns are
    azimuths (LiDAR) or places on the image plane; origin (3,); rotation (3, 3) sensor to vehicle frame; reach (2,)
    metres. row_at, column_at: where rows (slopes, or z on the image plane) and columns lie, rising, and row_of,
    column_of: their numbers; shift (rows,) or (0,): what is added to the columns of a row, radians in [0, 2 pi).
    ends (rays,) or (0,): where the car's own body stops a ray by its number, metres. law (0,) or (4,): range in
    metres at which half of the rays return from a face that looks at the sensor, for the three classes, and the
    relative width of the logistic; none: all rays return. blocks (b, 7): cones around
    runs of slots of a lattice that has no straight rows (axis, cosine and sine of the half angle, first slot,
    number), none for the others. field: cosine and sine of the half angle of a cone around x that holds all rays.
    least: what comes nearer to the plane x = 0 of a camera than this, in metres, is in no image. stops (rows * words,)
    uint64 or (0,): for a camera with straight rows and columns a bit for each slot whose ray the car's own body stops
    somewhere, every row in words of its own.
    """

    turns: bool
    columns: int
    stride: int
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    scale: np.ndarray
    origin: np.ndarray
    rotation: np.ndarray
    reach: np.ndarray
    row_at: np.ndarray
    row_of: np.ndarray
    column_at: np.ndarray
    column_of: np.ndarray
    shift: np.ndarray
    ends: np.ndarray
    law: np.ndarray
    blocks: np.ndarray
    field: np.ndarray
    least: float
    stops: np.ndarray


class Faces(NamedTuple):
    """A box as the rays of a sensor meet it. With a = turn d, d a direction in the sensor frame: a ray enters at 1
    / t = least of 1 / near and a[k] enter[k] + rest[k], and leaves at the greatest of 1 / far, a[k] leave[k], a[k]
    other[k]."""

    box: int
    part: int
    turn: np.ndarray
    enter: np.ndarray
    rest: np.ndarray
    leave: np.ndarray
    other: np.ndarray


class Canvas(NamedTuple):
    """What the rays of a worker have met so far, by slot: 1 / t, or 0 where nothing, and the box, or -1 (rays,);
    spans (rows, 2): first and end of the columns in which a row may have met something, columns and 0 where it has
    not; `run` takes the numbers of one run of slots (columns,); touched (2,): first and end of the rows whose spans are
    not empty, rows and 0 if all are."""

    inverse: np.ndarray
    owner: np.ndarray
    last: np.ndarray
    spans: np.ndarray
    run: np.ndarray
    touched: np.ndarray


@lean_inlined
def local_direction(beams: Beams, row: int, column: int) -> Direction:
    """Direction of the ray at a place of rows and columns in the sensor's own axes."""
    at = row * beams.stride + column
    f, g = beams.scale[row, 0], beams.scale[row, 1]
    return f * beams.x[at], f * beams.y[at], g * beams.z[at]


@lean_inlined
def turned(turn: np.ndarray, d: Direction) -> Direction:
    """turn d, with turn (3, 3)."""
    return (
        turn[0, 0] * d[0] + turn[0, 1] * d[1] + turn[0, 2] * d[2],
        turn[1, 0] * d[0] + turn[1, 1] * d[1] + turn[1, 2] * d[2],
        turn[2, 0] * d[0] + turn[2, 1] * d[1] + turn[2, 2] * d[2],
    )


@lean_inlined
def set_faces(start: Direction, half: np.ndarray, faces: Faces) -> None:
    """The numbers of a box by which rays from `start`, in the axes of the box, meet it."""
    for axis in range(3):
        s, h = start[axis], half[axis]
        if -h < s < h:
            faces.enter[axis], faces.rest[axis] = 0.0, np.inf
            faces.leave[axis], faces.other[axis] = 1.0 / (h - s), -1.0 / (h + s)
        else:
            towards = -1.0 if s > 0.0 else 1.0
            faces.enter[axis], faces.rest[axis] = towards / max(abs(s) - h, _TINY), 0.0
            faces.leave[axis] = faces.other[axis] = towards / (abs(s) + h)


@lean_inlined
def _meet_run(beams: Beams, faces: Faces, row: int, column: int, number: int, canvas: Canvas) -> int:
    """Let a run of slots of a row meet a box; how many rays enter it."""
    if number <= 0:
        return 0
    turn, enter, rest, leave, other = faces.turn, faces.enter, faces.rest, faces.leave, faces.other
    f, g = beams.scale[row, 0], beams.scale[row, 1]
    p0, q0, r0 = turn[0, 0] * f, turn[0, 1] * f, turn[0, 2] * g
    p1, q1, r1 = turn[1, 0] * f, turn[1, 1] * f, turn[1, 2] * g
    p2, q2, r2 = turn[2, 0] * f, turn[2, 1] * f, turn[2, 2] * g
    e0, e1, e2, n0, n1, n2 = enter[0], enter[1], enter[2], rest[0], rest[1], rest[2]
    l0, l1, l2, o0, o1, o2 = leave[0], leave[1], leave[2], other[0], other[1], other[2]
    most, least = 1.0 / beams.reach[0], 1.0 / beams.reach[1]
    # unsigned, so that the compiler need not think of places counted from the end, and takes four rays at once
    xs, ys, zs, run, at = beams.x, beams.y, beams.z, canvas.run, np.uint64(row * beams.stride + column)
    for i in range(np.uint64(number)):
        x, y, z = xs[at + i], ys[at + i], zs[at + i]
        a0 = p0 * x + q0 * y + r0 * z
        a1 = p1 * x + q1 * y + r1 * z
        a2 = p2 * x + q2 * y + r2 * z
        enters = _less(_less(most, a0 * e0 + n0), _less(a1 * e1 + n1, a2 * e2 + n2))
        leaves = _more(_more(a0 * l0, a0 * o0), _more(a1 * l1, a1 * o1))
        leaves = _more(_more(a2 * l2, a2 * o2), _more(leaves, least))
        run[i] = enters if enters > leaves else 0.0
    entered, slot, inverse, owner = 0, np.uint64(row * beams.columns + column), canvas.inverse, canvas.owner
    box, part, before = faces.box, faces.part, canvas.last
    for i in range(np.uint64(number)):
        if run[i] > 0.0:
            if before[slot + i] != box:
                before[slot + i] = box
                entered += 1
            if run[i] > inverse[slot + i]:
                inverse[slot + i], owner[slot + i] = run[i], part
    canvas.spans[row, 0] = min(canvas.spans[row, 0], column)
    canvas.spans[row, 1] = max(canvas.spans[row, 1], column + number)
    canvas.touched[0] = min(canvas.touched[0], row)
    canvas.touched[1] = max(canvas.touched[1], row + 1)
    return entered


@lean_inlined
def is_entered(beams: Beams, faces: Faces, row: int, column: int) -> bool:
    """Whether a single ray enters a box, by the very numbers of `_meet_run`."""
    turn, enter, rest, leave, other = faces.turn, faces.enter, faces.rest, faces.leave, faces.other
    f, g, at = beams.scale[row, 0], beams.scale[row, 1], row * beams.stride + column
    x, y, z = beams.x[at], beams.y[at], beams.z[at]
    enters, leaves = 1.0 / beams.reach[0], 1.0 / beams.reach[1]
    for axis in range(3):
        a = turn[axis, 0] * f * x + turn[axis, 1] * f * y + turn[axis, 2] * g * z
        enters = _less(enters, a * enter[axis] + rest[axis])
        leaves = _more(leaves, _more(a * leave[axis], a * other[axis]))
    return bool(enters > leaves)


@lean_inlined
def _less(a: float, b: float) -> float:
    return a if a < b else b


@lean_inlined
def _more(a: float, b: float) -> float:
    return a if a > b else b


@lean_inlined
def _columns_between(beams: Beams, left: float, width: float) -> tuple[int, int, int]:
    """First and end place of the columns between left and left + width, and the end of those after a full turn."""
    at, right = beams.column_at, left + width
    start, end, again = int(np.searchsorted(at, left)), int(np.searchsorted(at, right, "right")), 0
    if beams.turns and right > TURN:
        again = min(start, int(np.searchsorted(at, right - TURN, "right")))
    return start, end, again


@lean_inlined
def _meet_rows(beams: Beams, faces: Faces, window: Window, canvas: Canvas) -> int:
    """Offer a box to all rays in its window; how many of them enter it."""
    entered, row_at, shift = 0, beams.row_at, beams.shift
    start, end, again = _columns_between(beams, window.left, window.width)
    for row in range(np.searchsorted(row_at, window.low), row_at.size):
        if row_at[row] > window.high:
            break
        if shift.size > 0:
            left = window.left - shift[row]
            start, end, again = _columns_between(beams, left + TURN if left < 0.0 else left, window.width)
        entered += _meet_run(beams, faces, row, start, end - start, canvas)
        entered += _meet_run(beams, faces, row, 0, again, canvas)
    return entered


@lean
def _meet_blocks(beams: Beams, faces: Faces, centre: np.ndarray, half: np.ndarray, canvas: Canvas) -> int:
    """As `_meet_rows` for a lattice without straight rows and columns: block by block of its directions."""
    entered = 0
    far, sine, cosine = _cone_of(centre, half)
    for block in range(beams.blocks.shape[0]):
        cone = beams.blocks[block]
        if _is_apart(cone[0], cone[1], cone[2], cone[3], cone[4], centre, far, sine, cosine):
            continue
        slot = int(cone[5])
        row, column = slot // beams.columns, slot % beams.columns
        entered += _meet_run(beams, faces, row, column, int(cone[6]), canvas)
    return entered


@lean_inlined
def _cone_of(centre: np.ndarray, half: np.ndarray) -> tuple[float, float, float]:
    """Distance of a box's centre, and sine and cosine of the half angle of a cone around the box."""
    radius2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
    far2 = centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2]
    if radius2 >= far2 * (1.0 - 1e-9):
        return np.sqrt(far2), 1.0, -1.0  # the sensor may be inside: everywhere
    return np.sqrt(far2), np.sqrt(radius2 / far2), np.sqrt(1.0 - radius2 / far2)


@lean_inlined
def _is_apart(
    x: float,
    y: float,
    z: float,
    cos: float,
    sin: float,
    centre: np.ndarray,
    far: float,
    sine: float,
    cosine: float,
) -> bool:
    """Whether a cone of rays around (x, y, z) is certainly apart from the cone of a box."""
    if cosine < 0.0 or cos < 0.0 or sin * cosine + cos * sine < 0.0:
        return False
    return bool(x * centre[0] + y * centre[1] + z * centre[2] < (cos * cosine - sin * sine - 1e-9) * far)


@lean
def reach_of(traffic: Traffic, beams: Beams, frame: int) -> float:
    """Nothing farther from the sensor than this can stand before an object that counts."""
    reach = 0.0
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        if traffic.counts[box]:
            reach = max(reach, _distance(traffic, beams, box) + _radius(traffic, box))
    return float(min(reach, beams.reach[1]) * (1.0 + 1e-9))


@lean_inlined
def _distance(traffic: Traffic, beams: Beams, box: int) -> float:
    dx = traffic.centres[box, 0] - beams.origin[0]
    dy = traffic.centres[box, 1] - beams.origin[1]
    dz = traffic.centres[box, 2] - beams.origin[2]
    return float(np.sqrt(dx * dx + dy * dy + dz * dz))


@lean_inlined
def _radius(traffic: Traffic, box: int) -> float:
    a, b, c = traffic.halves[box, 0], traffic.halves[box, 1], traffic.halves[box, 2]
    return float(np.sqrt(a * a + b * b + c * c))


@lean_inlined
def start_of(traffic: Traffic, beams: Beams, box: int) -> Direction:
    """The sensor's place in the axes of a box."""
    back = (
        -(traffic.centres[box, 0] - beams.origin[0]),
        -(traffic.centres[box, 1] - beams.origin[1]),
        -(traffic.centres[box, 2] - beams.origin[2]),
    )
    return turned_into(traffic.rotations[box], back)


@lean_inlined
def set_turn(traffic: Traffic, rotation: np.ndarray, box: int, turn: np.ndarray) -> None:
    """turn (3, 3): directions in the sensor frame to those in the axes of a box."""
    for column in range(3):
        v = (rotation[0, column], rotation[1, column], rotation[2, column])
        turn[0, column], turn[1, column], turn[2, column] = turned_into(traffic.rotations[box], v)


@lean_inlined
def set_centre(start: Direction, turn: np.ndarray, centre: np.ndarray) -> None:
    """centre (3,): the middle of a box in the axes of the sensor, which is at `start` in those of the box."""
    for axis in range(3):
        centre[axis] = -(turn[0, axis] * start[0] + turn[1, axis] * start[1] + turn[2, axis] * start[2])


@lean_inlined
def _window_of(
    beams: Beams,
    start: Direction,
    half: np.ndarray,
    turn: np.ndarray,
    centre: np.ndarray,
    corners: np.ndarray,
) -> Window:
    """The window of a box around the origin of its axes, in which the sensor is at `start`; centre (3,) and corners (8,
    3) are overwritten."""
    set_centre(start, turn, centre)
    corners_of(centre, turn, half, corners)
    return window_of_turn(corners) if beams.turns else window_of_image(corners, beams.least)


@lean
def meet_frame(
    traffic: Traffic, beams: Beams, frame: int, rotation: np.ndarray, faces: Faces, corners: np.ndarray,
    centre: np.ndarray, canvas: Canvas, alone: np.ndarray,
) -> None:  # fmt: skip
    """Nearest entries of a frame's boxes on the canvas; alone (n,) of all boxes takes the rays that enter each of
    them, whatever stands before it."""
    reach = reach_of(traffic, beams, frame)
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        if _distance(traffic, beams, box) - _radius(traffic, box) <= reach:
            alone[box] += meet_box(traffic, beams, box, rotation, faces, corners, centre, canvas)


@lean_inlined
def meet_box(
    traffic: Traffic, beams: Beams, box: int, rotation: np.ndarray, faces: Faces, corners: np.ndarray,
    centre: np.ndarray, canvas: Canvas,
) -> int:  # fmt: skip
    """Nearest entries of a box on the canvas; how many rays enter it, whatever stands before it."""
    entered, half, start = 0, traffic.halves[box], start_of(traffic, beams, box)
    if is_inside(start, half):
        return 0
    set_turn(traffic, rotation, box, faces.turn)
    set_centre(start, faces.turn, centre)
    far, sine, cosine = _cone_of(centre, half)
    if _is_apart(1.0, 0.0, 0.0, beams.field[0], beams.field[1], centre, far, sine, cosine):
        return 0
    window = NOWHERE
    if beams.blocks.shape[0] == 0:
        window = _window_of(beams, start, half, faces.turn, centre, corners)
        if window.width < 0.0:
            return 0
    is_large = beams.blocks.shape[0] == 0 and beams.row_of.size * beams.columns * sine * sine > _LARGE
    for part in range(traffic.part_starts[box], traffic.part_starts[box + 1]):
        offset = traffic.offsets[part]
        place = (start[0] - offset[0], start[1] - offset[1], start[2] - offset[2])
        if is_large:
            window = _window_of(beams, place, traffic.part_halves[part], faces.turn, centre, corners)
            if window.width < 0.0:
                continue
        set_faces(place, traffic.part_halves[part], faces)
        own = Faces(box, part, faces.turn, faces.enter, faces.rest, faces.leave, faces.other)
        if beams.blocks.shape[0] > 0:
            entered += _meet_blocks(beams, own, centre, half, canvas)
        else:
            entered += _meet_rows(beams, own, window, canvas)
    return entered
