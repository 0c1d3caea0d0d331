"""Walk single rays through the grid in strides from face to face of one axis, in integers: the clear parts, quickly.

The axis of the larger component in plan is the *major* one. From one of its faces to the next a ray meets one column or
two, and its two other coordinates grow by the same amounts each time. So whole numbers of 2^-40 voxels hold them, and a
sum and a shift tell the next column and level, and a division how many strides end in a level. What comes close to a
face is not decided here: the exact walk does.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.fans.fan import FARTHEST_ORIGIN
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.lattice import direction, rotated
from riglens.core.kernels.runtime.jit import lean, lean_inlined, parallel_kernel
from riglens.core.kernels.runtime.work_stealing import new_counter, take
from riglens.core.kernels.voxels.bits import mark_levels

CLOSE = 2.0**-20
"""Distance to a face, in voxels, within which a ray is left to the exact walk."""
STEEPEST = 2.0**8
"""Levels in a stride beyond which the ray is left to the exact walk."""
SLANTED = 2.0**-10
"""Slant below which a crossing of faces is left to the exact walk."""
BITS = 40
_FRACTION = (1 << BITS) - 1
_CLOSE = 1 << (BITS - 20)
LONGEST = 4.0 * FARTHEST_ORIGIN
"""Voxels: a ray has left the box before."""
STRIP = 16
"""Planes whose rays are walked together, through all rows of the lattice."""
OPEN = -1
"""Stand-in for a cell that is not clear."""


class Axis(NamedTuple):
    """One axis: its number, where a ray begins and its component, the cells low..high-1 of the box, and words from one
    column to the next (of levels: none)."""

    number: int
    g: float
    d: float
    low: int
    high: int
    words: int


class Span(NamedTuple):
    """Part of a ray in the box: its first and last moment, and the axis through whose faces it enters and leaves; OPEN
    where it begins or ends inside."""

    begin: float
    end: float
    enters: int
    leaves: int


@lean_inlined
def _cut(axis: Axis, span: Span) -> Span:
    """Return the part of a span in which a ray is between the faces of one axis."""
    if axis.d == 0.0:
        return span if axis.low <= axis.g < axis.high else Span(span.begin, -1.0, OPEN, OPEN)
    a, b = (axis.low - axis.g) / axis.d, (axis.high - axis.g) / axis.d
    begin, enters = (min(a, b), axis.number) if min(a, b) > span.begin else (span.begin, span.enters)
    end, leaves = (max(a, b), axis.number) if max(a, b) < span.end else (span.end, span.leaves)
    return Span(begin, end, enters, leaves)


@lean_inlined
def _cell_near(place: float) -> int:
    """Return the cell of a place on one axis; OPEN where it is close to a face."""
    cell = np.floor(place)
    return int(cell) if CLOSE < place - cell < 1.0 - CLOSE else OPEN


@lean_inlined
def _first_cell(axis: Axis, span: Span) -> int:
    """Return the cell in which a span begins; at the origin of the ray it is always clear."""
    if span.enters == axis.number:
        return axis.low if axis.d > 0.0 else axis.high - 1
    if span.begin != 0.0:
        return _cell_near(axis.g + span.begin * axis.d)
    cell = np.floor(axis.g)
    return int(cell) - 1 if axis.d < 0.0 and cell == axis.g else int(cell)


@lean_inlined
def _last_cell(axis: Axis, span: Span) -> int:
    """Return the cell in which a span ends."""
    if span.leaves == axis.number:
        return axis.high - 1 if axis.d > 0.0 else axis.low
    return _cell_near(axis.g + span.end * axis.d)


@lean_inlined
def _is_close(fixed: int) -> bool:
    """Return whether a coordinate in whole numbers is close to a face."""
    return ((fixed + _CLOSE) & _FRACTION) <= 2 * _CLOSE


@lean_inlined
def _turn(
    minor: Axis, level: Axis, here: int, cells: tuple[int, int], levels: tuple[int, int], marks: np.ndarray
) -> bool:
    """Mark a stride in which the level may change; False, with nothing marked, where it is not clear in which column.

    here: the first word of the column of cell 0; cells, levels: at the beginning and at the end.
    """
    between = levels[1]
    if cells[0] != cells[1] and levels[0] != levels[1]:
        if abs(minor.d) < SLANTED:
            return False
        t = (max(cells[0], cells[1]) - minor.g) / minor.d
        between = _cell_near(level.g + t * level.d)
        if between == OPEN:
            return False
    mark_levels(marks, here + cells[0] * minor.words, min(levels[0], between), max(levels[0], between))
    mark_levels(marks, here + cells[1] * minor.words, min(between, levels[1]), max(between, levels[1]))
    return True


@lean_inlined
def _fixed(place: float) -> int:
    """Return a coordinate in whole numbers."""
    return int(np.floor(place * 2.0**BITS))


@lean_inlined
def _strides_in_level(above: int, rise: int) -> int:
    """Count the strides that end in a level, clear of its faces: the first one `above` its lower face, each later one
    by `rise` higher. The quotient of such integers is off by less than its distance to the next integer."""
    low, high = above - _CLOSE - 1, (1 << BITS) - _CLOSE - 1 - above
    room = high if rise > 0 else low
    return 1 + int(room / max(abs(rise), 1)) if min(low, high) >= 0 else 0


@lean_inlined
def _go(major: Axis, minor: Axis, level: Axis, span: Span, marks: np.ndarray) -> bool:
    """Mark the voxels of a span of a ray; False where one of them is not clear."""
    at, end = _first_cell(major, span), _last_cell(major, span)
    cell, end_cell = _first_cell(minor, span), _last_cell(minor, span)
    height, end_height = _first_cell(level, span), _last_cell(level, span)
    if min(at, end) < major.low or min(cell, end_cell) < minor.low or min(height, end_height) < level.low:
        return False
    here, step, strides = at * major.words, major.words if major.d > 0.0 else -major.words, abs(end - at)
    t = (at + (1 if major.d > 0.0 else 0) - major.g) / major.d
    y, dy = _fixed(minor.g + t * minor.d), _fixed(minor.d / abs(major.d))
    z, dz = _fixed(level.g + t * level.d), _fixed(level.d / abs(major.d))
    while strides > 0:
        count = min(_strides_in_level(z - (height << BITS), dz), strides)
        word, bit = np.uint64(height >> 6), np.uint64(1) << np.uint64(height & 63)
        for _ in range(count):
            if _is_close(y):
                return False
            next_cell = y >> BITS
            from_, to = np.uint64(here + cell * minor.words), np.uint64(here + next_cell * minor.words)
            first, second = marks[from_ + word] | bit, marks[to + word] | bit
            marks[from_ + word], marks[to + word] = (
                first,
                second,
            )  # written after both are read: quicker if they are one
            cell = next_cell
            here += step
            y += dy
        z += count * dz
        strides -= count
        if strides > 0:
            cells, levels = (cell, y >> BITS), (height, z >> BITS)
            if _is_close(y) or _is_close(z) or not _turn(minor, level, here, cells, levels, marks):
                return False
            cell, height = cells[1], levels[1]
            here += step
            y, z, strides = y + dy, z + dz, strides - 1
    return _turn(minor, level, here, (cell, end_cell), (height, end_height), marks)


@lean_inlined
def _place(g: float, d: float) -> float:
    """Return where a ray begins on one axis. For one that stays in a cell all its way, maybe in a face of it or next to
    one, the middle of the cell is as good, and is clear of both faces."""
    way = abs(d) * LONGEST
    if way >= 0.25:
        return g
    cell = np.floor(g) if d >= 0.0 else np.ceil(g) - 1.0
    return cell + 0.5 if way < (cell + 1.0 - g if d >= 0.0 else g - cell) else g


@lean
def stride(
    g: tuple[float, float, float],
    d: tuple[float, float, float],
    near: float,
    far: float,
    box: np.ndarray,
    shape: np.ndarray,
    marks: np.ndarray,
) -> bool:
    """Mark all voxels of a ray between two distances, in a box of cells (6,); False where one of them is not clear:
    those marked by then are correct."""
    depth = (shape[2] + 63) // 64
    x = Axis(0, _place(g[0], d[0]), d[0], box[0], box[1], shape[1] * depth)
    y = Axis(1, _place(g[1], d[1]), d[1], box[2], box[3], depth)
    z = Axis(2, _place(g[2], d[2]), d[2], box[4], box[5], 0)
    span = _cut(z, _cut(y, _cut(x, Span(near, far, OPEN, OPEN))))
    if span.begin > span.end - CLOSE:
        return span.begin > span.end + CLOSE
    if abs(d[0]) >= abs(d[1]):
        return abs(d[0]) * STEEPEST > abs(d[2]) and _go(x, y, z, span, marks)
    return abs(d[1]) * STEEPEST > abs(d[2]) and _go(y, x, z, span, marks)


@parallel_kernel
def mark_strides(
    rays: Cast, planes: int, first: int, end: int, marks: np.ndarray, spare: np.ndarray, left: np.ndarray
) -> None:
    """Mark the clear parts of the rays first..end-1 of each row, of `planes` planes.

    As `kernels.rays.cast.mark_rays`; but left bool (rays,) is of all rays, and remains set for those of which
    it is not clear.

    Rays of neighbouring planes meet the same columns, whatever their row: so strips of a few planes go through all
    rows, as long as these columns are at hand.
    """
    workers = spare.shape[0] + 1
    is_listed, counter = rays.planes.shape[0] == 1, new_counter()
    g = (rays.origin[0], rays.origin[1], rays.origin[2])
    for worker in numba.prange(workers):
        own = spare[worker - 1] if worker > 0 else marks
        strip = first + take(counter) * STRIP
        while strip < end:
            for row in range(left.size // planes):
                for plane in range(strip, min(strip + STRIP, end)):
                    ray = row * planes + plane
                    if rays.is_stopped.size > 0 and rays.is_stopped[ray]:
                        left[ray] = False
                        continue
                    table_row, table_plane = (ray, 0) if is_listed else (row, plane)
                    d = rotated(
                        rays.rotation, direction(rays.kind, rays.rows[table_row], rays.planes[table_plane])
                    )
                    far = min(rays.reach[1], rays.ends[ray]) if rays.ends.size > 0 else rays.reach[1]
                    left[ray] = not stride(g, d, rays.reach[0], far, rays.box, rays.shape, own)
            strip = first + take(counter) * STRIP
