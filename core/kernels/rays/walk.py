"""One ray through the grid, exactly: the voxels in which it runs over a positive length.

A walk goes from grid column to grid column (x and y); in every column the voxels met are one run of levels
low..high along z, because z is monotone along a ray. Which face comes next, and on which level a column is
left, is decided in doubles where an error bound allows and exactly otherwise (`predicates`).
A ray running in a face belongs to the voxels on the positive side; crossing an edge or a corner steps all
tied axes at once, so voxels that are only touched are not visited.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.rays.predicates import UNIT_ROUNDOFF, Moment, Vector, compare, regular_ray
from riglens.core.kernels.runtime.jit import inlined, kernel, lean, lean_inlined

IRREGULAR = -1
FARTHEST = 1e30
"""Stand-in for "no limit" along a ray: beyond any ROI, and small enough for the exact predicates."""

Cell = tuple[int, int, int]


class Ray(NamedTuple):
    """A ray in grid units: g + t d for near <= t <= far (g and d per axis; d need not be a unit vector)."""

    g: Vector
    d: Vector
    near: float
    far: float


@lean_inlined
def cell_after(g: float, d: float, moment: Moment) -> float:
    """Return the cell of one axis in which the ray is just after a moment."""
    if d == 0.0:
        return float(np.floor(g))
    cell = float(np.floor(g + d * ((moment.face - moment.origin) / moment.direction)))
    step = 1.0 if d > 0.0 else -1.0
    ahead, behind = (1.0, 0.0) if d > 0.0 else (0.0, 1.0)
    while compare(Moment(cell + ahead, g, d), moment) <= 0:
        cell += step
    while compare(Moment(cell + behind, g, d), moment) > 0:
        cell -= step
    return cell


@lean_inlined
def cell_before(g: float, d: float, moment: Moment) -> float:
    """Return the cell of one axis in which the ray is just before a moment."""
    if d == 0.0:
        return float(np.floor(g))
    cell = float(np.floor(g + d * ((moment.face - moment.origin) / moment.direction)))
    step = 1.0 if d > 0.0 else -1.0
    ahead, behind = (1.0, 0.0) if d > 0.0 else (0.0, 1.0)
    while compare(Moment(cell + ahead, g, d), moment) < 0:
        cell += step
    while compare(Moment(cell + behind, g, d), moment) >= 0:
        cell -= step
    return cell


@lean_inlined
def _clip_axis(
    g: float, d: float, low: int, high: int, entry: Moment, leave: Moment
) -> tuple[Moment, Moment]:
    """Return entry and exit moments after clipping to low <= position < high on one axis; a miss gives entry = exit."""
    if d == 0.0:
        return (entry, leave) if low <= np.floor(g) < high else (leave, leave)
    first, last = (float(low), float(high)) if d > 0.0 else (float(high), float(low))
    into, out = Moment(first, g, d), Moment(last, g, d)
    if compare(into, entry) > 0:
        entry = into
    if compare(out, leave) < 0:
        leave = out
    return entry, leave


@lean_inlined
def clip_ray(ray: Ray, box: np.ndarray) -> tuple[Moment, Moment]:
    """Return the exact moments at which a ray enters and leaves a box of cells [lx hx ly hy lz hz), int64 (6,); it
    misses the box unless the first is before the second."""
    entry, leave = Moment(float(ray.near), 0.0, 1.0), Moment(float(ray.far), 0.0, 1.0)
    entry, leave = _clip_axis(ray.g[0], ray.d[0], box[0], box[1], entry, leave)
    entry, leave = _clip_axis(ray.g[1], ray.d[1], box[2], box[3], entry, leave)
    return _clip_axis(ray.g[2], ray.d[2], box[4], box[5], entry, leave)


@lean
def hits_cell(ray: Ray, cell: Cell) -> bool:
    """Return whether a ray runs inside one voxel over a positive length, exactly (for regular rays)."""
    entry, leave = Moment(float(ray.near), 0.0, 1.0), Moment(float(ray.far), 0.0, 1.0)
    entry, leave = _clip_axis(ray.g[0], ray.d[0], cell[0], cell[0] + 1, entry, leave)
    entry, leave = _clip_axis(ray.g[1], ray.d[1], cell[1], cell[1] + 1, entry, leave)
    entry, leave = _clip_axis(ray.g[2], ray.d[2], cell[2], cell[2] + 1, entry, leave)
    return compare(entry, leave) < 0


@inlined
def _emit(runs: np.ndarray, count: int, column: int, from_level: int, to_level: int) -> None:
    runs[count, 0] = np.int32(column)
    runs[count, 1] = np.int32(min(from_level, to_level))
    runs[count, 2] = np.int32(max(from_level, to_level))


@inlined
def _stepping(g: float, d: float, entry: Moment) -> tuple[int, int, float, float]:
    """Return the start cell and step of one axis, the moment of its next face and the time between faces."""
    cell = cell_after(g, d, entry)
    if d == 0.0:
        return int(cell), 0, np.inf, np.inf
    face = cell + 1.0 if d > 0.0 else cell
    return int(cell), (1 if d > 0.0 else -1), (face - g) / d, abs(1.0 / d)


@kernel
def _resolve(g: Vector, d: Vector, ix: int, iy: int, leave: Moment) -> tuple[int, bool, int, int]:
    """Return the exact order of the next crossings: x first (-1), both (0) or y first (1); whether the ray leaves
    before them; the levels just before and just after."""
    face_x, face_y = ix + (1.0 if d[0] > 0.0 else 0.0), iy + (1.0 if d[1] > 0.0 else 0.0)
    order = -1 if d[1] == 0.0 else 1
    if d[0] != 0.0 and d[1] != 0.0:
        order = compare(Moment(face_x, g[0], d[0]), Moment(face_y, g[1], d[1]))
    crossing = Moment(face_x, g[0], d[0]) if order < 0 else Moment(face_y, g[1], d[1])
    if crossing.direction == 0.0 or compare(crossing, leave) >= 0:
        return order, True, int(cell_before(g[2], d[2], leave)), 0
    return order, False, int(cell_before(g[2], d[2], crossing)), int(cell_after(g[2], d[2], crossing))


@kernel
def walk_exact(ray: Ray, box: np.ndarray, ny: int, runs: np.ndarray) -> int:
    """Write the runs (column = ix * ny + iy, low level, high level) of one ray; return their number.

    box: int64 (6,) cells to stay in, [lx hx ly hy lz hz); ny: columns of the grid along y; runs: int32 (>= nx + ny + 2,
    3). Return IRREGULAR, with nothing written, for a ray that the predicates do not hold for. Moments are summed up
    step by step; `blur` bounds their rounding, and what is closer is resolved exactly.
    """
    g, d = ray.g, ray.d
    if not regular_ray(g, d):
        return IRREGULAR
    entry, leave = clip_ray(ray, box)
    if compare(entry, leave) >= 0:
        return 0
    ix, step_x, t_x, pace_x = _stepping(g[0], d[0], entry)
    iy, step_y, t_y, pace_y = _stepping(g[1], d[1], entry)
    level = int(cell_after(g[2], d[2], entry))
    t_leave = (leave.face - leave.origin) / leave.direction
    blur = 4.0 * UNIT_ROUNDOFF * (box[1] - box[0] + box[3] - box[2] + 16)
    tie, quiet = blur * t_leave, 0.5 - blur * (abs(g[2]) + abs(d[2]) * t_leave)
    if d[2] == 0.0:
        quiet = 1.0
    t_stop = t_leave - tie
    count = 0
    while True:
        t_next = min(t_x, t_y)
        z = g[2] + t_next * d[2]
        floor_z = np.floor(z)
        order = -1 if t_x < t_y else 1
        clear = (abs(t_x - t_y) > tie) & (t_next < t_stop) & (abs(z - floor_z - 0.5) < quiet)
        if clear:
            last = int(floor_z)
            following = last
        else:
            order, leaves, last, following = _resolve(g, d, ix, iy, leave)
            if leaves:
                _emit(runs, count, ix * ny + iy, level, last)
                return count + 1
        _emit(runs, count, ix * ny + iy, level, last)
        count += 1
        level = following
        if order <= 0:
            ix += step_x
            t_x += pace_x
        if order >= 0:
            iy += step_y
            t_y += pace_y


@kernel
def walk_bresenham(ray: Ray, box: np.ndarray, ny: int, runs: np.ndarray) -> int:
    """Walk by 3D Bresenham between the first and the last voxel of a ray: one voxel per step of the driving axis.

    Arguments and result as in `walk_exact`, one run for each voxel: runs int32 (>= max(nx, ny, nz), 3).
    """
    g, d = ray.g, ray.d
    if not regular_ray(g, d):
        return IRREGULAR
    entry, leave = clip_ray(ray, box)
    if compare(entry, leave) >= 0:
        return 0
    cell = np.empty(3, np.int64)
    delta = np.empty(3, np.int64)
    for axis in range(3):
        cell[axis] = int(cell_after(g[axis], d[axis], entry))
        delta[axis] = int(cell_before(g[axis], d[axis], leave)) - cell[axis]
    steps = np.abs(delta).max()
    error = np.full(3, -steps, np.int64)
    for i in range(steps + 1):
        _emit(runs, i, cell[0] * ny + cell[1], cell[2], cell[2])
        for axis in range(3):
            error[axis] += 2 * abs(delta[axis])
            if error[axis] >= 0:
                cell[axis] += 1 if delta[axis] > 0 else -1
                error[axis] -= 2 * steps
    return int(steps) + 1
