"""Find the box of a frame that each ray of a sensor enters first.

For each box the window of rows and columns that can meet it, and for each ray there a test without division: 1 / t at
which a ray crosses a face is linear in its direction, so the ray enters the box at the least of these numbers over the
faces towards the sensor and leaves it at the greatest over those away from it. The nearest entry counts; of two boxes
entered at the same distance the earlier one in the data.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    Canvas,
    Faces,
    FrameBoxes,
    bounds_of,
    distance_of,
    half_of,
    is_glass,
    is_inside,
    parts_of,
    radius_of,
    reach_of,
    set_centre,
    set_faces,
    set_turn,
    start_of,
)
from riglens.core.kernels.objects.part_sides import set_sides
from riglens.core.kernels.objects.windows import (
    TURN,
    Window,
    corners_of,
    place_at,
    slopes_between,
    window_of_image,
    window_of_turn,
)
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.rays.phases import mixed, unit
from riglens.core.kernels.rays.tiles import (
    AFTER,
    COLUMN,
    OWN_RAYS,
    ROW,
    cuts_of,
    rows_of,
    set_spans,
)
from riglens.core.kernels.runtime.jit import lean, lean_inlined

_LARGE = 400.0
"""Above about this many rays per box, each part of the box has its own window."""


@lean_inlined
def find_entries(beams: Beams, faces: Faces, row: int, column: int, number: int, run: np.ndarray) -> None:
    """Write 1 / t at which each ray of a run of slots of a row enters a part, or 0 where it does not."""
    turn, enter, rest, leave, other = faces.turn, faces.enter, faces.rest, faces.leave, faces.other
    f, g = beams.scale[row, 0], beams.scale[row, 1]
    p0, q0, r0 = turn[0, 0] * f, turn[0, 1] * f, turn[0, 2] * g
    p1, q1, r1 = turn[1, 0] * f, turn[1, 1] * f, turn[1, 2] * g
    p2, q2, r2 = turn[2, 0] * f, turn[2, 1] * f, turn[2, 2] * g
    e0, e1, e2, n0, n1, n2 = enter[0], enter[1], enter[2], rest[0], rest[1], rest[2]
    l0, l1, l2, o0, o1, o2 = leave[0], leave[1], leave[2], other[0], other[1], other[2]
    most, least = 1.0 / beams.reach[0], 1.0 / beams.reach[1]
    # unsigned, so that the compiler need not think of places counted from the end, and takes four rays at once
    xs, ys, zs, at = beams.x, beams.y, beams.z, np.uint64(row * beams.stride + column)
    for i in range(np.uint64(number)):
        x, y, z = xs[at + i], ys[at + i], zs[at + i]
        a0 = p0 * x + q0 * y + r0 * z
        a1 = p1 * x + q1 * y + r1 * z
        a2 = p2 * x + q2 * y + r2 * z
        enters = _less(_less(most, a0 * e0 + n0), _less(a1 * e1 + n1, a2 * e2 + n2))
        leaves = _more(_more(a0 * l0, a0 * o0), _more(a1 * l1, a1 * o1))
        leaves = _more(_more(a2 * l2, a2 * o2), _more(leaves, least))
        run[i] = enters if enters > leaves else 0.0


@lean_inlined
def _meet_run(beams: Beams, faces: Faces, row: int, column: int, number: int, canvas: Canvas) -> int:
    """Intersect a run of slots of a row with a box; return the number of rays that enter it."""
    if number <= 0:
        return 0
    run = canvas.run
    find_entries(beams, faces, row, column, number, run)
    entered, slot, inverse, owner = 0, np.uint64(row * beams.columns + column), canvas.inverse, canvas.owner
    box, part, before = faces.box, faces.part, canvas.last
    for i in range(np.uint64(number)):
        is_first = (run[i] > 0.0) & (before[slot + i] != box)
        before[slot + i] = box if is_first else before[slot + i]
        entered += is_first
    if faces.is_clear:
        _pass_glass(beams, faces.key, row, column, number, run)
    for i in range(np.uint64(number)):
        is_nearer = run[i] > inverse[slot + i]
        inverse[slot + i] = run[i] if is_nearer else inverse[slot + i]
        owner[slot + i] = part if is_nearer else owner[slot + i]
    canvas.spans[row, 0] = min(canvas.spans[row, 0], column)
    canvas.spans[row, 1] = max(canvas.spans[row, 1], column + number)
    canvas.touched[0] = min(canvas.touched[0], row)
    canvas.touched[1] = max(canvas.touched[1], row + 1)
    return entered


@lean_inlined
def _pass_glass(beams: Beams, key: np.uint64, row: int, column: int, number: int, run: np.ndarray) -> None:
    """Let rays of a run pass through a part that is glass, by the draws of `glass_draw`."""
    ray, step, passes = beams.row_of[row] * beams.steps[0], beams.steps[1], beams.glass[0]
    columns, at = beams.column_of, np.uint64(column)
    for i in range(np.uint64(number)):
        draw = unit(mixed(mixed(key, np.uint64(ray + columns[at + i] * step)), np.uint64(0)))
        run[i] = 0.0 if draw < passes else run[i]


@lean_inlined
def _less(a: float, b: float) -> float:
    return a if a < b else b


@lean_inlined
def _more(a: float, b: float) -> float:
    return a if a > b else b


@lean_inlined
def _columns_between(beams: Beams, left: float, width: float) -> tuple[int, int, int]:
    """Return the first and end place of the columns between left and left + width, and the end of those after a full
    turn."""
    at, right = beams.column_at, left + width
    start, end, again = place_at(at, left), place_after(at, right), 0
    if beams.turns and right > TURN:
        again = min(start, place_after(at, right - TURN))
    return start, end, again


@lean_inlined
def place_after(at: np.ndarray, value: float) -> int:
    """Return the first place of rising numbers that is above a value."""
    place = place_at(at, value)
    while place < at.size and at[place] <= value:
        place += 1
    return place


@lean_inlined
def _meet_rows(
    beams: Beams, faces: Faces, window: Window, first: int, columns: tuple[int, int, int], canvas: Canvas
) -> int:
    """Offer a part to all rays in its window, from its first row on; its columns are known but for rows that are
    shifted. How many of them enter it."""
    entered, row_at, shift = 0, beams.row_at, beams.shift
    start, end, again = columns
    for row in range(first, row_at.size):
        if row_at[row] > window.high:
            break
        if shift.size > 0:
            left = window.left - shift[row]
            start, end, again = _columns_between(beams, left + TURN if left < 0.0 else left, window.width)
        entered += _meet_run(beams, faces, row, start, end - start, canvas)
        if again > 0:
            entered += _meet_run(beams, faces, row, 0, again, canvas)
    return entered


@lean_inlined
def _rows_of_part(faces: Faces, start: Direction, half: Direction, window: Window) -> Window:
    """Return the window of a box around a spinning sensor, narrowed to the rows of a part of it."""
    turn, middle, wide = faces.turn, 0.0, 0.0
    for axis in range(3):
        middle, wide = middle - turn[axis, 2] * start[axis], wide + abs(turn[axis, 2]) * half[axis]
    low, high = slopes_between(middle - wide, middle + wide, window.near, window.far)
    return Window(low, high, window.left, window.width, window.near, window.far)


@lean
def _meet_tiles(beams: Beams, faces: Faces, canvas: Canvas) -> int:
    """As `_meet_rows` for a lattice without straight rows and columns."""
    entered, count, number, sides = 0, set_sides(beams.reach[0], beams.reach[1], faces), 0, faces.sides
    span = sides.span
    while number < beams.tiles.shape[0]:
        tile = beams.tiles[number]
        cuts = cuts_of(tile, count, sides)
        number += 1
        if cuts < 0:
            number = int(tile[AFTER])
        elif tile[OWN_RAYS] > 0.0:
            row, column = int(tile[ROW]), int(tile[COLUMN])
            rows = rows_of(tile, cuts, sides)
            set_spans(tile, rows, cuts, sides)
            for place in range(*rows):
                first, end = int(span[0, place]), int(span[1, place])
                entered += _meet_run(beams, faces, row + place, column + first, end - first, canvas)
    return entered


@lean_inlined
def cone_of(centre: np.ndarray, half: Direction) -> tuple[float, float, float]:
    """Return the distance of a box's centre, and sine and cosine of the half angle of a cone around the box."""
    radius2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
    far2 = centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2]
    if radius2 >= far2 * (1.0 - 1e-9):
        return np.sqrt(far2), 1.0, -1.0  # the sensor may be inside: everywhere
    return np.sqrt(far2), np.sqrt(radius2 / far2), np.sqrt(1.0 - radius2 / far2)


@lean_inlined
def is_apart(
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
    """Return whether a cone of rays around (x, y, z) is certainly apart from the cone of a box."""
    if cosine < 0.0 or cos < 0.0 or sin * cosine + cos * sine < 0.0:
        return False
    return bool(x * centre[0] + y * centre[1] + z * centre[2] < (cos * cosine - sin * sine - 1e-9) * far)


@lean_inlined
def window_of(
    beams: Beams,
    start: Direction,
    half: Direction,
    turn: np.ndarray,
    centre: np.ndarray,
    corners: np.ndarray,
) -> Window:
    """Return the window of a box around the origin of its axes, in which the sensor is at `start`; centre (3,) and
    corners (8, 3) are overwritten."""
    set_centre(start, turn, centre)
    corners_of(centre, turn, half, corners)
    if not beams.turns:
        return window_of_image(corners, beams.least)
    is_upright = turn[0, 2] == 0.0 and turn[1, 2] == 0.0 and turn[2, 0] == 0.0 and turn[2, 1] == 0.0
    return window_of_turn(corners, is_upright)


@lean_inlined
def _faces_of(traffic: FrameBoxes, beams: Beams, box: int, part: int, key: np.uint64, faces: Faces) -> Faces:
    """Return the faces of a part of a box."""
    is_clear = beams.glass[0] > 0.0 and is_glass(traffic, part)
    return Faces(
        box, part, is_clear, key, faces.turn, faces.enter, faces.rest, faces.leave, faces.other, faces.sides
    )


@lean
def meet_frame(
    traffic: FrameBoxes, beams: Beams, frame: int, rotation: np.ndarray, key: np.uint64, faces: Faces,
    corners: np.ndarray, centre: np.ndarray, canvas: Canvas, alone: np.ndarray,
) -> None:  # fmt: skip
    """Write the nearest entries of a frame's boxes on the canvas; key: of the draws of returns; alone (n,) of all boxes
    takes the rays that enter each of them, without occlusion."""
    reach = reach_of(traffic, beams, frame)
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        if distance_of(traffic, beams, box) - radius_of(traffic, box) <= reach:
            alone[box] += meet_box(traffic, beams, box, rotation, key, faces, corners, centre, canvas)


@lean_inlined
def meet_box(
    traffic: FrameBoxes, beams: Beams, box: int, rotation: np.ndarray, key: np.uint64, faces: Faces,
    corners: np.ndarray, centre: np.ndarray, canvas: Canvas,
) -> int:  # fmt: skip
    """Write the nearest entries of a box on the canvas; return the number of rays that enter it, without occlusion."""
    entered, half, start = 0, half_of(traffic, box), start_of(traffic, beams, box)
    if is_inside(start, half):
        return 0
    set_turn(traffic, rotation, box, faces.turn)
    set_centre(start, faces.turn, centre)
    far, sine, cosine = cone_of(centre, half)
    if is_apart(1.0, 0.0, 0.0, beams.field[0], beams.field[1], centre, far, sine, cosine):
        return 0
    parts = range(*parts_of(traffic, box))
    if beams.tiles.shape[0] > 0:
        for part in parts:
            middle, part_half = bounds_of(traffic, part)
            set_faces((start[0] - middle[0], start[1] - middle[1], start[2] - middle[2]), part_half, faces)
            own = _faces_of(traffic, beams, box, part, key, faces)
            entered += _meet_tiles(beams, own, canvas)
        return entered
    window = window_of(beams, start, half, faces.turn, centre, corners)
    if window.width < 0.0:
        return 0
    is_large = beams.row_of.size * beams.columns * sine * sine > _LARGE
    columns = _columns_between(beams, window.left, window.width)
    for part in parts:
        (middle, part_half), mine = bounds_of(traffic, part), window
        place = (start[0] - middle[0], start[1] - middle[1], start[2] - middle[2])
        if is_large:
            mine = window_of(beams, place, part_half, faces.turn, centre, corners)
            if mine.width < 0.0:
                continue
            columns = _columns_between(beams, mine.left, mine.width)
        elif beams.turns:
            mine = _rows_of_part(faces, place, part_half, window)
        row = place_at(beams.row_at, mine.low)
        if row == beams.row_at.size or beams.row_at[row] > mine.high:
            continue
        set_faces(place, part_half, faces)
        own = _faces_of(traffic, beams, box, part, key, faces)
        entered += _meet_rows(beams, own, mine, row, columns, canvas)
    return entered
