"""Decide which rays of a LiDAR return from an object, and find the cells of it that they enter.

Rays are listed, a few hundred at a time, and each step goes over the list in a loop of its own, so that the compiler
takes several at once. For the same end one array holds all columns of a list, at fixed distances, and lists are padded,
so that no rays are left to a slower loop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import FrameBoxes, bounds_of, is_glass, parts_of, turned
from riglens.core.kernels.objects.unique_cells import cell_key
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.rays.phases import mixed, unit
from riglens.core.kernels.runtime.codes import MOST_PARTS
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

_U = np.uint64
MOST_RAYS = 520
"""Length of a list: of columns a power of two apart, the same places share lines of a processor's cache."""
X, Y, Z, INVERSE = _U(0), _U(MOST_RAYS), _U(2 * MOST_RAYS), _U(3 * MOST_RAYS)
NUMBER, PART, _FATE, _CELL = X, Y, Z, INVERSE
_AT_ONCE = 8
"""Lists are padded to multiples of this."""
_LOST, _OPEN, _RETURNS = 0, 1, 2
"""Fates of rays."""
_NEARLY, _NEAR_BY = 1.0 - 1e-9, 1e-15
"""Factor, and difference of chances, by which a bound has to hold: far more than rounding takes."""


class RayList(NamedTuple):
    """Rays that meet an object first. Columns of MOST_RAYS, one after the other: of `hits` x, y, z of the direction and
    1 / t of the hit; of `marks`, int64, the number of the ray, that of the part of the object from 0, fate and cell.
    faces (MOST_PARTS, 4): by how much the sensor is beyond each part along the axes of the object, below 0 between its
    faces, and the draw from which on rays return from the part, 0 unless it is glass."""

    hits: np.ndarray
    marks: np.ndarray
    faces: np.ndarray


@kernel
def new_list() -> RayList:
    """Return room for a list."""
    return RayList(np.ones(4 * MOST_RAYS), np.zeros(4 * MOST_RAYS, np.int64), np.zeros((MOST_PARTS, 4)))


@lean_inlined
def look_at(traffic: FrameBoxes, box: int, start: Direction, glass: np.ndarray, faces: np.ndarray) -> None:
    """Write the faces of an object, as in `RayList`, for a sensor at `start` in its axes; glass as in `Beams`."""
    first, end = parts_of(traffic, box)
    for part in range(MOST_PARTS):
        faces[part, 3] = 0.0
    for part in range(first, end):
        mine = faces[part - first]
        mine[0], mine[1], mine[2] = overhang_of(traffic, part, start)
        mine[3] = glass[1] if is_glass(traffic, part) else 0.0


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
    for axis in range(3):  # the face entered is the one that is reached last
        slope = abs(along[axis])
        at = (over[axis] if over[axis] > 0.0 else -np.inf) / slope
        cosine, last = (slope, at) if at > last else (cosine, last)
    return float(cosine)


@lean_inlined
def is_returned(t: float, half_m: float, width: float, cosine: float, chance: float) -> bool:
    """Return whether a ray returns from a face at t metres, against a chance in [0, 1); half_m: range at which half of
    them would from a face towards the sensor; width: of the logistic, relative to that."""
    return bool(chance < 1.0 / (1.0 + np.exp((t / (half_m * np.sqrt(cosine)) - 1.0) / width)))


@lean_inlined
def _fate_of(inverse: float, half_m: float, steep: float, cosine: float, chance: float) -> int:
    """Return whether a ray returns, as `is_returned` with t = 1 / inverse and width = 1 / steep, as far as bounds of
    the exponential tell."""
    x = (1.0 / (inverse * half_m * np.sqrt(cosine)) - 1.0) * steep
    # exp(-abs(x)) is a power of exp(-z), which lies between two polynomials for z up to 1
    z = min(abs(x), 16.0) / 16.0
    most = 1.0 - z + 0.5 * z * z
    least = most - 0.16667 * z * z * z if abs(x) <= 16.0 else 0.0
    for _ in range(4):
        least, most = least * least, most * most
    # of x >= 0 chances below e / (1 + e) return; else those do whose complement is not below it
    c = chance if x >= 0.0 else 1.0 - chance
    is_below = (c + _NEAR_BY) * (1.0 + least) < least * _NEARLY
    is_above = (c - _NEAR_BY) * (1.0 + most) * _NEARLY > most
    below, above = (_RETURNS, _LOST) if x >= 0.0 else (_LOST, _RETURNS)
    return below if is_below else (above if is_above else _OPEN)


@lean_inlined
def _of_part(part: int, values: tuple[float, float, float, float]) -> float:
    """Return the value of a part, without the place in an array that would keep the compiler from taking several."""
    low = values[0] if part == 0 else values[1]
    return low if part < 2 else (values[2] if part == 2 else values[3])


@lean_inlined
def _turn(turn: np.ndarray, number: int, hits: np.ndarray, marks: np.ndarray) -> None:
    """Convert directions to the axes of the object, and let all rays return."""
    for ray in range(_U(number)):
        along = turned(turn, (hits[X + ray], hits[Y + ray], hits[Z + ray]))
        hits[X + ray], hits[Y + ray], hits[Z + ray] = along
        marks[_FATE + ray] = _RETURNS


@lean_inlined
def _lose_in_glass(key: np.uint64, faces: np.ndarray, number: int, marks: np.ndarray) -> None:
    """Lose rays in parts that are glass, by the draws of `box_frames.glass_draw`."""
    limits = (faces[0, 3], faces[1, 3], faces[2, 3], faces[3, 3])
    for ray in range(_U(number)):
        draw = unit(mixed(mixed(key, _U(marks[NUMBER + ray])), _U(0)))
        if draw < _of_part(marks[PART + ray], limits):
            marks[_FATE + ray] = _LOST


@lean_inlined
def _judge(
    key: np.uint64, half_m: float, width: float, faces: np.ndarray, number: int, hits: np.ndarray, marks: np.ndarray
) -> None:  # fmt: skip
    """Find the fates of rays that are not lost yet, as far as bounds tell."""
    xs = (faces[0, 0], faces[1, 0], faces[2, 0], faces[3, 0])
    ys = (faces[0, 1], faces[1, 1], faces[2, 1], faces[3, 1])
    zs = (faces[0, 2], faces[1, 2], faces[2, 2], faces[3, 2])
    steep = 1.0 / width
    for ray in range(_U(number)):
        part = marks[PART + ray]
        over = (_of_part(part, xs), _of_part(part, ys), _of_part(part, zs))
        cosine = cosine_of(over, (hits[X + ray], hits[Y + ray], hits[Z + ray]))
        chance = unit(mixed(key, _U(marks[NUMBER + ray])))
        fate = _fate_of(hits[INVERSE + ray], half_m, steep, cosine, chance)
        marks[_FATE + ray] = fate if marks[_FATE + ray] != _LOST else _LOST


@lean_inlined
def _note_cells(start: Direction, number: int, hits: np.ndarray, marks: np.ndarray) -> None:
    for ray in range(_U(number)):
        along = (hits[X + ray], hits[Y + ray], hits[Z + ray])
        marks[_CELL + ray] = cell_key(start, along, 1.0 / hits[INVERSE + ray])


@lean
def cells_of(
    key: np.uint64, start: Direction, turn: np.ndarray, half_m: float, width: float, number: int, hits: np.ndarray,
    marks: np.ndarray, faces: np.ndarray, cells: np.ndarray, listed: int,
) -> tuple[int, int]:  # fmt: skip
    """Append the cells of the listed rays that return, equal ones in a row once, to the first `listed`; return how many
    rays do, and the new number of cells.

    key: of the draws of returns; start: the sensor in the axes of the object; turn (3, 3): from its axes to these, to
    which the directions are turned; half_m, width: as in `is_returned`, for the class; width 0: all rays return that
    are not lost in glass.
    """
    size, returning, before = (number + _AT_ONCE - 1) & ~(_AT_ONCE - 1), 0, np.int64(-1)
    _turn(turn, size, hits, marks)
    if faces[0, 3] + faces[1, 3] + faces[2, 3] + faces[3, 3] > 0.0:
        _lose_in_glass(key, faces, size, marks)
    if width > 0.0:
        _judge(key, half_m, width, faces, size, hits, marks)
    _note_cells(start, size, hits, marks)
    to = _U(listed)
    for ray in range(_U(number)):
        fate, cell = marks[_FATE + ray], marks[_CELL + ray]
        if fate == _OPEN:
            over, along = faces[marks[PART + ray]], (hits[X + ray], hits[Y + ray], hits[Z + ray])
            cosine, word = cosine_of((over[0], over[1], over[2]), along), mixed(key, _U(marks[NUMBER + ray]))
            fate = _RETURNS * is_returned(1.0 / hits[INVERSE + ray], half_m, width, cosine, unit(word))
        cells[to] = cell  # overwritten unless it counts: a branch would cost more
        to += _U((fate == _RETURNS) & (cell != before))
        before = cell if fate == _RETURNS else before
        returning += fate == _RETURNS
    return returning, int(np.int64(to))
