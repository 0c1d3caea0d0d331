"""Boxes of frames, rays of a sensor, and the pose of one relative to the other: for all kernels that intersect rays and
boxes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.rays.lattice import Direction, rotated_back
from riglens.core.kernels.rays.phases import mixed, unit
from riglens.core.kernels.rays.tiles import Sides, new_sides
from riglens.core.kernels.runtime.codes import MOST_PARTS, PART_BITS
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

_TINY = 1e-300
"""Stand-in for a distance of zero between the sensor and the plane of a face, a divisor."""


class FrameBoxes(NamedTuple):
    """Boxes of all frames, in the vehicle frame: those of frame f are starts[f]..starts[f + 1] (frames + 1,);
    centres, halves (n, 3) metres, rotations (n, 3, 3) box to vehicle frame; counts (n,) bool: those that count;
    cls (n,): their classes; kind uint8 (n,): which of k kinds of shapes they have.

    Boxes are made of parts, boxes within them: numbers (k,) of parts, at most MOST_PARTS each; bounds
    (k, MOST_PARTS, 2, 2, 3): of a part of a low box, then of a tall one, middle and half size along the axes of the
    box, in half sizes of it; heights_m (k, 2): up to the first a box is a low one, from the second on a tall one, in
    metres; glass (k, MOST_PARTS): whether a part gives LiDARs no return. Part p of box b is number b * MOST_PARTS + p.
    """

    starts: np.ndarray
    centres: np.ndarray
    halves: np.ndarray
    rotations: np.ndarray
    counts: np.ndarray
    cls: np.ndarray
    kind: np.ndarray
    numbers: np.ndarray
    bounds: np.ndarray
    heights_m: np.ndarray
    glass: np.ndarray


class Beams(NamedTuple):
    """Rays of a sensor, or of one of its sectors. Their slots have rows and columns in rising order: slot = place of
    the row * columns + place of the column. The number of a ray as the sensor lists them is row * steps[0] + column *
    steps[1], of `row_of` and `column_of`; rows of a sector of even azimuths and elevations are the sensor's columns.

    Direction in the sensor frame of a slot: (f x, f y, g z) with f, g from `scale` (rows, 2) and x, y, z from arrays,
    (columns,) where `stride` is 0, else (slots,) with stride = columns; zero for a ray that the lens has not. Unit
    vectors, or for a pinhole that sees from 0 to infinity those with x = 1. turns: whether columns are azimuths
    (LiDAR) or places on the image plane; origin (3,); rotation (3, 3) sensor to vehicle frame; reach (2,) metres.
    row_at, column_at: where rows (slopes, or z on the image plane) and columns lie, rising, and row_of, column_of:
    their numbers; shift (rows,) or (0,): what is added to the columns of a row, radians in [0, 2 pi). is_upright: of a
    sector, whether rows are the sensor's columns. ends (rays,) or (0,): where the car's own body stops a ray by its
    number, metres. law (0,) or (4,): range in metres at which half of the rays return from a face that looks at the
    sensor, for the three classes, and the relative width of the logistic; none: all rays return. glass (2,): a ray of a
    LiDAR passes through glass where its draw is below the first, and returns from it where that is not below the
    second. tiles (t, FIELDS): of a lattice that has no straight rows, as in `kernels.rays.tiles`; none for the others.
    field: cosine and sine of the half angle of a cone around x that holds all rays. least: what comes nearer to the
    plane x = 0 of a camera than this, in metres, is in no image. stops (2, rows * words) uint64 or (0, 0): bits for the
    slots whose rays the car's own body stops somewhere, every row in words of its own, and for those of them that it
    stops before anything that counts; last_ends (rows * words,): where the last of the others of a word ends, metres.
    limits (3, rows of the sensor), (3, 1) where all rows are alike, or (0, 0): from where on rays get nothing back from
    objects of the three classes, metres.
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
    steps: np.ndarray
    shift: np.ndarray
    is_upright: bool
    ends: np.ndarray
    law: np.ndarray
    glass: np.ndarray
    tiles: np.ndarray
    field: np.ndarray
    least: float
    stops: np.ndarray
    last_ends: np.ndarray
    limits: np.ndarray


class Faces(NamedTuple):
    """Part of a box as the rays of a sensor hit it; is_clear: whether some rays pass through it, drawn by the key of
    returns. With a = turn d, d a direction in the sensor frame: a ray enters at 1 / t = least of 1 / near and a[k]
    enter[k] + rest[k], and leaves at the greatest of 1 / far, a[k] leave[k], a[k] other[k]; sides for a lattice in
    tiles."""

    box: int
    part: int
    is_clear: bool
    key: np.uint64
    turn: np.ndarray
    enter: np.ndarray
    rest: np.ndarray
    leave: np.ndarray
    other: np.ndarray
    sides: Sides


class Canvas(NamedTuple):
    """First hits of a worker's rays so far, by slot: 1 / t, or 0 where nothing, and the box, or -1 (rays,); spans
    (rows, 2): first and end of the columns in which a row may have met something, columns and 0 where it has not; `run`
    takes the numbers of one run of slots (columns,); touched (2,): first and end of the rows whose spans are not empty,
    rows and 0 if all are."""

    inverse: np.ndarray
    owner: np.ndarray
    last: np.ndarray
    spans: np.ndarray
    run: np.ndarray
    touched: np.ndarray


@kernel
def new_faces() -> Faces:
    """Return room for a box."""
    return Faces(
        0,
        0,
        False,
        np.uint64(0),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        new_sides(),
    )


@lean_inlined
def parts_of(traffic: FrameBoxes, box: int) -> tuple[int, int]:
    """Return the number of the first part of a box, and the number after the last one."""
    first = box << PART_BITS
    return first, first + traffic.numbers[traffic.kind[box]]


@lean_inlined
def box_of(part: int) -> int:
    """Return the box of a part."""
    return part >> PART_BITS


@lean_inlined
def bounds_of(traffic: FrameBoxes, part: int) -> tuple[Direction, Direction]:
    """Return the middle and the half size of a part in metres, in the axes of its box."""
    box = box_of(part)
    half, kind = half_of(traffic, box), traffic.kind[box]
    bounds, heights_m = traffic.bounds[kind, part & (MOST_PARTS - 1)], traffic.heights_m[kind]
    tall = 0.0
    if 2.0 * half[2] > heights_m[0]:
        tall = min((2.0 * half[2] - heights_m[0]) / (heights_m[1] - heights_m[0]), 1.0)
    return (
        (
            _between(bounds, 0, 0, half[0], tall),
            _between(bounds, 0, 1, half[1], tall),
            _between(bounds, 0, 2, half[2], tall),
        ),
        (
            _between(bounds, 1, 0, half[0], tall),
            _between(bounds, 1, 1, half[1], tall),
            _between(bounds, 1, 2, half[2], tall),
        ),
    )


@lean_inlined
def _between(bounds: np.ndarray, row: int, axis: int, half: float, tall: float) -> float:
    low, high = bounds[0, row, axis] * half, bounds[1, row, axis] * half
    return float(low + tall * (high - low))


@lean_inlined
def half_of(traffic: FrameBoxes, box: int) -> Direction:
    """Return the half size of a box, metres."""
    return traffic.halves[box, 0], traffic.halves[box, 1], traffic.halves[box, 2]


@lean_inlined
def is_glass(traffic: FrameBoxes, part: int) -> bool:
    """Return whether a part is glass."""
    return bool(traffic.glass[traffic.kind[box_of(part)], part & (MOST_PARTS - 1)])


@lean_inlined
def is_lost(traffic: FrameBoxes, beams: Beams, key: np.uint64, part: int, place: int, column: int) -> bool:
    """Return whether the ray of a LiDAR that meets a part is lost in its glass."""
    return bool(is_glass(traffic, part) and glass_draw(beams, key, place, column) < beams.glass[1])


@lean_inlined
def glass_draw(beams: Beams, key: np.uint64, place: int, column: int) -> float:
    """Return the draw, in [0, 1), that decides whether a ray passes through glass or returns from it."""
    return unit(mixed(mixed(key, np.uint64(ray_at(beams, place, column))), np.uint64(0)))


@lean_inlined
def ray_at(beams: Beams, row: int, column: int) -> int:
    """Return the number of the ray at a place of rows and columns."""
    return int(beams.row_of[row] * beams.steps[0] + beams.column_of[column] * beams.steps[1])


@lean_inlined
def limit_of(traffic: FrameBoxes, beams: Beams, box: int, row: int) -> float:
    """Return from where on the rays at a place of rows get nothing back from an object that counts, metres."""
    if beams.limits.size == 0 or not traffic.counts[box]:
        return np.inf
    return float(beams.limits[traffic.cls[box], beams.row_of[row] if beams.limits.shape[1] > 1 else 0])


@lean_inlined
def local_direction(beams: Beams, row: int, column: int) -> Direction:
    """Return the direction of the ray at a place of rows and columns in the sensor's own axes."""
    at = row * beams.stride + column
    f, g = beams.scale[row, 0], beams.scale[row, 1]
    return f * beams.x[at], f * beams.y[at], g * beams.z[at]


@lean_inlined
def turned(turn: np.ndarray, d: Direction) -> Direction:
    """Return turn d, with turn (3, 3)."""
    return (
        turn[0, 0] * d[0] + turn[0, 1] * d[1] + turn[0, 2] * d[2],
        turn[1, 0] * d[0] + turn[1, 1] * d[1] + turn[1, 2] * d[2],
        turn[2, 0] * d[0] + turn[2, 1] * d[1] + turn[2, 2] * d[2],
    )


@lean_inlined
def set_faces(start: Direction, half: Direction, faces: Faces) -> None:
    """Write the faces of a box for rays from `start`, in the axes of the box."""
    for axis in range(3):
        s, h = start[axis], half[axis]
        if -h < s < h:
            faces.enter[axis], faces.rest[axis] = 0.0, np.inf
            faces.leave[axis], faces.other[axis] = 1.0 / (h - s), -1.0 / (h + s)
        else:
            towards = -1.0 if s > 0.0 else 1.0
            faces.enter[axis], faces.rest[axis] = towards / max(abs(s) - h, _TINY), 0.0
            faces.leave[axis] = faces.other[axis] = towards / (abs(s) + h)


@lean
def reach_of(traffic: FrameBoxes, beams: Beams, frame: int) -> float:
    """Return the distance from the sensor beyond which nothing can hide an object that counts."""
    reach = 0.0
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        if traffic.counts[box]:
            reach = max(reach, distance_of(traffic, beams, box) + radius_of(traffic, box))
            if reach >= beams.reach[1]:
                break
    return float(min(reach, beams.reach[1]) * (1.0 + 1e-9))


@lean_inlined
def distance_of(traffic: FrameBoxes, beams: Beams, box: int) -> float:
    """Return the distance from the sensor to the centre of a box, metres."""
    dx = traffic.centres[box, 0] - beams.origin[0]
    dy = traffic.centres[box, 1] - beams.origin[1]
    dz = traffic.centres[box, 2] - beams.origin[2]
    return float(np.sqrt(dx * dx + dy * dy + dz * dz))


@lean_inlined
def radius_of(traffic: FrameBoxes, box: int) -> float:
    """Return the distance from the centre of a box to its corners, metres."""
    a, b, c = half_of(traffic, box)
    return float(np.sqrt(a * a + b * b + c * c))


@lean_inlined
def start_of(traffic: FrameBoxes, beams: Beams, box: int) -> Direction:
    """Return the sensor's place in the axes of a box."""
    back = (
        -(traffic.centres[box, 0] - beams.origin[0]),
        -(traffic.centres[box, 1] - beams.origin[1]),
        -(traffic.centres[box, 2] - beams.origin[2]),
    )
    return rotated_back(traffic.rotations[box], back)


@lean_inlined
def set_turn(traffic: FrameBoxes, rotation: np.ndarray, box: int, turn: np.ndarray) -> None:
    """Write turn (3, 3), which converts directions from the sensor frame to the axes of a box."""
    for column in range(3):
        v = (rotation[0, column], rotation[1, column], rotation[2, column])
        turn[0, column], turn[1, column], turn[2, column] = rotated_back(traffic.rotations[box], v)


@lean_inlined
def set_centre(start: Direction, turn: np.ndarray, centre: np.ndarray) -> None:
    """Write centre (3,), the middle of a box in the axes of the sensor, which is at `start` in those of the box."""
    for axis in range(3):
        centre[axis] = -(turn[0, axis] * start[0] + turn[1, axis] * start[1] + turn[2, axis] * start[2])


@lean_inlined
def is_inside(start: Direction, half: Direction) -> bool:
    """Return whether a point in the axes of a box is in it or on its surface."""
    return bool(abs(start[0]) <= half[0] and abs(start[1]) <= half[1] and abs(start[2]) <= half[2])
