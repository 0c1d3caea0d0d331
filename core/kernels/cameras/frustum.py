"""Voxel walking for a camera of any pose: decide whether any ray of the lattice hits a voxel, column by column.

Where neighbouring rays are close, a voxel whose centre lies in the image is hit for certain: the ray nearest to
the centre passes through the inscribed ball. Along a grid column the image borders are linear inequalities, so
these voxels are one run of levels and cost nothing each. Voxels at the border are tested: the rays of the lattice
that can hit them follow from the outline of the voxel in the image, and each is decided exactly.

Camera frame: x forward, y left, z up; lengths in voxels; (u, v) are lattice columns and rows, which pixel centres
of the resized image have at whole numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.rays.cast import NONE_STOPPED
from riglens.core.kernels.rays.lattice import direction, rotated, rotated_back
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.rays.walk import FARTHEST, Cell, Ray, hits_cell
from riglens.core.kernels.runtime.codes import CAMERA
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.runtime.work_stealing import new_counter, take
from riglens.core.kernels.voxels.bits import mark_levels

BALL = 0.499
"""A little less than the radius of a voxel's inscribed ball."""
SPHERE = 0.8661
"""A little more than the radius of its circumscribed ball."""
NEAREST = 0.01
"""Corners closer to the camera's plane than this are not projected."""
SLACK = 1e-6
TILE = 8
NONE, SOME, ALL = 0, 1, 2
"""Share of a rectangle's rays that are stopped."""
AT_ONCE = 8
"""Levels of a column that are looked at together where the car's own body stops some rays."""
NO_TILES = np.zeros((0, 0), np.int64)


class Frustum(NamedTuple):
    """A camera for voxel walking: lattice tables, origin (3,) in grid units, rotation (3, 3), box (6,) cells, and the
    shape (3,) of the grid.

    sides (4, 3): inward unit normals of the planes through the image borders; image (4,): u = (0) - (1) y / x and
    v = (2) - (3) z / x; depth_limit: the forward distance up to which a ray is within BALL of any point; outline
    (n, 2): corners in plan, in order, of what holds the centres of all voxels that are marked or tested.
    is_stopped (rays,) as in `kernels.rays.cast.Cast`; stopped_before (m + 1, n + 1): how many are in tiles of
    TILE x TILE rays above and to the left; both empty where none is.
    """

    rows: np.ndarray
    planes: np.ndarray
    origin: np.ndarray
    rotation: np.ndarray
    box: np.ndarray
    shape: np.ndarray
    sides: np.ndarray
    image: np.ndarray
    depth_limit: float
    outline: np.ndarray
    is_stopped: np.ndarray = NONE_STOPPED
    stopped_before: np.ndarray = NO_TILES


class VoxelWork(NamedTuple):
    """Work space of one worker: the eight corners of a voxel in the camera frame, (8, 3), and in the image, (8, 2)."""

    corners: np.ndarray
    points: np.ndarray


@lean_inlined
def _to_camera(f: Frustum, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Convert a point of the grid to the camera frame."""
    return rotated_back(f.rotation, (x - f.origin[0], y - f.origin[1], z - f.origin[2]))


@lean_inlined
def _narrow(value: float, slope: float, low: float, high: float) -> tuple[float, float]:
    """Return the part of low..high in which value + k slope >= 0."""
    if slope > 0.0:
        return max(low, -value / slope), high
    if slope < 0.0:
        return low, min(high, -value / slope)
    return (low, high) if value >= 0.0 else (1.0, 0.0)


@lean_inlined
def _levels_within(f: Frustum, x: float, y: float, z: float, room: float) -> tuple[float, float]:
    """Return the levels k of a column, counted from the point (x, y, z), whose centre is at most `room` outside the
    view."""
    ex, ey, ez = f.rotation[2, 0], f.rotation[2, 1], f.rotation[2, 2]
    low, high = _narrow(x + room, ex, -1e9, 1e9)
    low, high = _narrow(f.depth_limit - x, -ex, low, high)
    for side in range(4):
        nx, ny, nz = f.sides[side, 0], f.sides[side, 1], f.sides[side, 2]
        low, high = _narrow(nx * x + ny * y + nz * z + room, nx * ex + ny * ey + nz * ez, low, high)
    return low, high


@lean_inlined
def _hits(f: Frustum, u: int, v: int, cell: Cell) -> bool:
    """Return whether the ray (u, v) is cast and traverses a voxel, exactly."""
    if f.is_stopped.size > 0 and f.is_stopped[v * f.planes.shape[0] + u]:
        return False
    d = rotated(f.rotation, direction(CAMERA, f.rows[v], f.planes[u]))
    return hits_cell(Ray((f.origin[0], f.origin[1], f.origin[2]), d, 0.0, FARTHEST), cell)


@kernel
def count_stopped(is_stopped: np.ndarray, has_stops: np.ndarray, before: np.ndarray) -> None:
    """Write `Frustum.stopped_before` of is_stopped (rows, columns), zeros before; has_stops (rows,): rows with any."""
    rows, columns = is_stopped.shape
    for v in range(rows):
        for u in range(columns if has_stops[v] else 0):
            before[v // TILE + 1, u // TILE + 1] += is_stopped[v, u]
    for i in range(1, before.shape[0]):
        for j in range(1, before.shape[1]):
            before[i, j] += before[i - 1, j] + before[i, j - 1] - before[i - 1, j - 1]


@lean_inlined
def _stopped_within(f: Frustum, u0: float, u1: float, v0: float, v1: float) -> int:
    """Return whether none, some or all rays of the tiles around the rectangle u0..u1, v0..v1 of the lattice are
    stopped."""
    if f.is_stopped.size == 0:
        return NONE
    rows, columns = f.rows.shape[0], f.planes.shape[0]
    left, top = int(min(max(u0, 0.0), columns - 1.0)) // TILE, int(min(max(v0, 0.0), rows - 1.0)) // TILE
    right = int(min(max(np.ceil(u1), 0.0), columns - 1.0)) // TILE + 1
    bottom = int(min(max(np.ceil(v1), 0.0), rows - 1.0)) // TILE + 1
    before = f.stopped_before
    count = before[bottom, right] - before[top, right] - before[bottom, left] + before[top, left]
    if count == 0:
        return NONE
    every = (min(bottom * TILE, rows) - top * TILE) * (min(right * TILE, columns) - left * TILE)
    return ALL if count == every else SOME


@lean_inlined
def _pixel(f: Frustum, x: float, y: float, z: float) -> tuple[float, float]:
    """Return the place in the lattice of a point in the camera frame, before the camera."""
    return f.image[0] - f.image[1] * y / x, f.image[2] - f.image[3] * z / x


@lean_inlined
def _extent(places: np.ndarray, axis: int) -> tuple[float, float]:
    """Return the least and the largest of eight places along an axis."""
    low, high = places[0, axis], places[0, axis]
    for corner in range(1, 8):
        low, high = min(low, places[corner, axis]), max(high, places[corner, axis])
    return low, high


@lean
def _corners(f: Frustum, cell: Cell, corners: np.ndarray) -> bool:
    """Return the corners (8, 3) of a voxel in the camera frame; False when one plane has them all outside: no ray
    hits."""
    for corner in range(8):
        x, y, z = cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + (corner >> 2)
        corners[corner, 0], corners[corner, 1], corners[corner, 2] = _to_camera(
            f, float(x), float(y), float(z)
        )
    if _extent(corners, 0)[1] < -SLACK:
        return False
    for side in range(4):
        most = -np.inf
        for corner in range(8):
            x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
            most = max(most, f.sides[side, 0] * x + f.sides[side, 1] * y + f.sides[side, 2] * z)
        if most < -SLACK:
            return False
    return True


@lean
def _outline_in_row(points: np.ndarray, v: float) -> tuple[float, float]:
    """Return the span in u in which the outline of eight projected corners (8, 2) crosses the row v (empty: from >
    to)."""
    low, high = np.inf, -np.inf
    for corner in range(8):
        for axis in range(3):
            other = corner | (1 << axis)
            if other == corner:
                continue
            v0, v1 = points[corner, 1] - v, points[other, 1] - v
            if (v0 < -SLACK and v1 < -SLACK) or (v0 > SLACK and v1 > SLACK):
                continue
            u0, u1 = points[corner, 0], points[other, 0]
            if abs(v0 - v1) < 4.0 * SLACK:
                low, high = min(low, min(u0, u1)), max(high, max(u0, u1))
            else:
                share = min(max(v0 / (v0 - v1), 0.0), 1.0)
                u = u0 + share * (u1 - u0)
                low, high = min(low, u), max(high, u)
    if low > high:
        return 1.0, 0.0
    slant = SLACK + 1e-9 * (abs(low) + abs(high))
    return low - slant, high + slant


@lean
def _row_hits(f: Frustum, v: int, first: int, last: int, cell: Cell) -> bool:
    """Return whether one of the rays first..last of the row v hits; the middle one first, as it most likely does."""
    if first > last:
        return False
    if _hits(f, (first + last) // 2, v, cell):
        return True
    for u in range(first, last + 1):
        if _hits(f, u, v, cell):
            return True
    return False


@lean
def _any_hits(f: Frustum, cell: Cell, work: VoxelWork) -> bool:
    """Return whether any ray of the lattice traverses a voxel, exactly."""
    corners, points = work.corners, work.points
    if not _corners(f, cell, corners):
        return False
    columns, rows = f.planes.shape[0], f.rows.shape[0]
    x, y, z = _to_camera(f, cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5)
    if x > 0.0:
        u = int(min(max(np.rint(f.image[0] - f.image[1] * y / x), 0.0), columns - 1.0))
        v = int(min(max(np.rint(f.image[2] - f.image[3] * z / x), 0.0), rows - 1.0))
        if _hits(f, u, v, cell):
            return True
    if _extent(corners, 0)[0] < NEAREST:  # at the camera itself: too wide to be projected, and rare
        for v in range(rows):
            if _row_hits(f, v, 0, columns - 1, cell):
                return True
        return False
    for corner in range(8):
        points[corner, 0] = f.image[0] - f.image[1] * corners[corner, 1] / corners[corner, 0]
        points[corner, 1] = f.image[2] - f.image[3] * corners[corner, 2] / corners[corner, 0]
    u0, u1 = _extent(points, 0)
    v0, v1 = _extent(points, 1)
    if _stopped_within(f, u0 - 1.0, u1 + 1.0, v0 - 1.0, v1 + 1.0) == ALL:
        return False
    first_v, last_v = max(int(np.ceil(v0 - SLACK)), 0), min(int(np.floor(v1 + SLACK)), rows - 1)
    for v in range(first_v, last_v + 1):
        low, high = _outline_in_row(points, float(v))
        first_u, last_u = int(max(np.ceil(low), 0.0)), int(min(np.floor(high), columns - 1.0))
        if _row_hits(f, v, first_u, last_u, cell):
            return True
    return False


@lean_inlined
def _is_free(f: Frustum, start: Vector, step: Vector, first: int, last: int) -> bool:
    """Return whether no ray is stopped that is the nearest to the centre of a voxel at start + level step, in camera
    frame."""
    x0, x1 = start[0] + first * step[0], start[0] + last * step[0]
    if min(x0, x1) < 0.5:
        return False
    u0, v0 = _pixel(f, x0, start[1] + first * step[1], start[2] + first * step[2])
    u1, v1 = _pixel(f, x1, start[1] + last * step[1], start[2] + last * step[2])
    return (
        _stopped_within(f, min(u0, u1) - 1.0, max(u0, u1) + 1.0, min(v0, v1) - 1.0, max(v0, v1) + 1.0) == NONE
    )


@lean_inlined
def _is_hidden(f: Frustum, start: Vector, step: Vector, first: int, last: int) -> bool:
    """Return whether all rays are stopped that may meet a voxel whose centre is at start + level step,
    in camera frame."""
    x0, x1 = start[0] + first * step[0], start[0] + last * step[0]
    least = min(x0, x1) - SPHERE
    if least < 0.5:
        return False
    u0, v0 = _pixel(f, x0, start[1] + first * step[1], start[2] + first * step[2])
    u1, v1 = _pixel(f, x1, start[1] + last * step[1], start[2] + last * step[2])
    # what is SPHERE away from a place at depth x is at most SPHERE (1 + |y / x|) / (x - SPHERE) away in y / x
    aside = max(abs(u0 - f.image[0]), abs(u1 - f.image[0]))
    above = max(abs(v0 - f.image[2]), abs(v1 - f.image[2]))
    wide, high = (f.image[1] + aside) * SPHERE / least + 1.0, (f.image[3] + above) * SPHERE / least + 1.0
    left, right, top, bottom = min(u0, u1) - wide, max(u0, u1) + wide, min(v0, v1) - high, max(v0, v1) + high
    return _stopped_within(f, left, right, top, bottom) == ALL


@lean_inlined
def _is_nearest_free(f: Frustum, centre: Vector) -> bool:
    """Return whether the ray nearest to a place in the view, in camera frame, is not stopped."""
    if centre[0] < 0.5:
        return False
    columns, rows = f.planes.shape[0], f.rows.shape[0]
    u, v = _pixel(f, centre[0], centre[1], centre[2])
    column, row = int(min(max(np.rint(u), 0.0), columns - 1.0)), int(min(max(np.rint(v), 0.0), rows - 1.0))
    return not f.is_stopped[row * columns + column]


@lean
def _mark_column(f: Frustum, ix: int, iy: int, keep: np.ndarray, marks: np.ndarray, work: VoxelWork) -> None:
    """Mark the voxels of one column that a ray traverses and whose centre is nearer than the depth limit."""
    base = (ix * f.shape[1] + iy) * ((f.shape[2] + 63) // 64)
    x, y, z = _to_camera(f, ix + 0.5, iy + 0.5, 0.5)
    low, high = _levels_within(f, x, y, z, SPHERE)
    first, last = (
        max(int(np.floor(max(low, -1.0))), f.box[4]),
        min(int(np.ceil(min(high, 1e6))), f.box[5] - 1),
    )
    if first > last:
        return
    low, high = _levels_within(f, x, y, z, 0.0)
    sure_first, sure_last = max(int(np.ceil(max(low, -1.0))), first), min(int(np.floor(min(high, 1e6))), last)
    if sure_first > sure_last:
        _test_levels(f, (ix, iy, base), (x, y, z), first, last, False, keep, marks, work)
        return
    _test_levels(f, (ix, iy, base), (x, y, z), first, sure_first - 1, False, keep, marks, work)
    _test_levels(f, (ix, iy, base), (x, y, z), sure_last + 1, last, False, keep, marks, work)
    ez = (f.rotation[2, 0], f.rotation[2, 1], f.rotation[2, 2])
    if f.is_stopped.size == 0 or _is_free(f, (x, y, z), ez, sure_first, sure_last):
        mark_levels(marks, base, sure_first, sure_last)
        return
    for begin in range(sure_first, sure_last + 1, AT_ONCE):
        end = min(begin + AT_ONCE - 1, sure_last)
        if _is_free(f, (x, y, z), ez, begin, end):
            mark_levels(marks, base, begin, end)
        elif not _is_hidden(f, (x, y, z), ez, begin, end):
            _test_levels(f, (ix, iy, base), (x, y, z), begin, end, True, keep, marks, work)


@lean
def _test_levels(
    f: Frustum, column: Cell, start: Vector, first: int, last: int, is_in_view: bool, keep: np.ndarray,
    marks: np.ndarray, work: VoxelWork,
) -> None:  # fmt: skip
    """Mark the voxels of some levels of a column (ix, iy, first word) that a ray traverses, one by one;
    is_in_view: their centres are, in the camera frame at start + level times the grid's z."""
    ez = (f.rotation[2, 0], f.rotation[2, 1], f.rotation[2, 2])
    for level in range(first, last + 1):
        word, bit = column[2] + (level >> 6), np.uint64(1) << np.uint64(level & 63)
        if keep[word] & bit == 0:
            continue
        centre = (start[0] + level * ez[0], start[1] + level * ez[1], start[2] + level * ez[2])
        if (is_in_view and _is_nearest_free(f, centre)) or _any_hits(f, (column[0], column[1], level), work):
            marks[word] |= bit


@lean_inlined
def columns_in_row(outline: np.ndarray, x: float) -> tuple[float, float]:
    """Return the span along y in which a row of columns at x crosses a convex outline, given by its corners (empty:
    from > to)."""
    low, high = np.inf, -np.inf
    for a in range(outline.shape[0]):
        b = a - 1 if a > 0 else outline.shape[0] - 1
        x0, x1 = outline[a, 0] - x, outline[b, 0] - x
        if min(x0, x1) <= 0.0 <= max(x0, x1) and x0 != x1:
            y = outline[a, 1] + x0 / (x0 - x1) * (outline[b, 1] - outline[a, 1])
            low, high = min(low, y), max(high, y)
    return low, high


@parallel_kernel
def mark_frustum(
    f: Frustum, first_row: int, end_row: int, keep: np.ndarray, workers: int, marks: np.ndarray
) -> None:
    """Mark the voxels of the rows first_row..end_row-1 along x that are nearer than the depth limit and that a ray
    traverses.

    keep uint64 (words,): voxels worth a test; marks uint64 (words,): every row of the grid is marked by one worker.
    """
    ny, depth, counter = f.shape[1], (f.shape[2] + 63) // 64, new_counter()
    for _ in numba.prange(workers):
        work = VoxelWork(np.empty((8, 3)), np.empty((8, 2)))
        for _turn in range(first_row, end_row):
            ix = first_row + take(counter)
            if ix >= end_row:
                break
            low, high = columns_in_row(f.outline, ix + 0.5)
            if low > high:
                continue
            first, last = max(np.floor(low) - 1.0, float(f.box[2])), min(np.ceil(high) + 1.0, float(f.box[3]))
            for iy in range(int(first), int(last)):
                base = (ix * ny + iy) * depth
                occupied = keep[base]
                for part in range(1, depth):
                    occupied |= keep[base + part]
                if occupied != 0:
                    _mark_column(f, ix, iy, keep, marks, work)
