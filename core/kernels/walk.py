"""One ray through the grid, exactly: the voxels in which it runs over a positive length.

A walk goes from grid column to grid column (x and y); in every column the voxels met are one run of levels
low..high along z, because z is monotone along a ray. Which face comes next, and on which level a column is
left, is decided in doubles where an error bound allows and exactly otherwise (`predicates`).
A ray running in a face belongs to the voxels on the positive side; crossing an edge or a corner steps all
tied axes at once, so voxels that are only touched are not visited.
"""

from __future__ import annotations

import math

import numpy as np

from core.kernels.jit import inlined, kernel
from core.kernels.predicates import MOMENT_BOUND, UNIT_ROUNDOFF, compare_moments, regular_ray

IRREGULAR = -1
LEVEL_BOUND = 16.0 * UNIT_ROUNDOFF

Moment = tuple[float, float, float]


@inlined
def compare(a: Moment, b: Moment) -> int:
    """Sign of moment a - moment b."""
    return compare_moments(a[0], a[1], a[2], b[0], b[1], b[2])


@inlined
def cell_after(g: float, d: float, moment: Moment) -> float:
    """Cell of one axis in which the ray is just after a moment."""
    if d == 0.0:
        return math.floor(g)
    cell = math.floor(g + d * ((moment[0] - moment[1]) / moment[2]))
    step = 1.0 if d > 0.0 else -1.0
    ahead, behind = (1.0, 0.0) if d > 0.0 else (0.0, 1.0)
    while compare((cell + ahead, g, d), moment) <= 0:
        cell += step
    while compare((cell + behind, g, d), moment) > 0:
        cell -= step
    return cell


@inlined
def cell_before(g: float, d: float, moment: Moment) -> float:
    """Cell of one axis in which the ray is just before a moment."""
    if d == 0.0:
        return math.floor(g)
    cell = math.floor(g + d * ((moment[0] - moment[1]) / moment[2]))
    step = 1.0 if d > 0.0 else -1.0
    ahead, behind = (1.0, 0.0) if d > 0.0 else (0.0, 1.0)
    while compare((cell + ahead, g, d), moment) < 0:
        cell += step
    while compare((cell + behind, g, d), moment) >= 0:
        cell -= step
    return cell


@inlined
def _clip_axis(g: float, d: float, low: int, high: int, entry: Moment, leave: Moment) -> tuple[Moment, Moment]:
    """Entry and exit moments after clipping to low <= position < high on one axis; a miss gives entry = exit."""
    if d == 0.0:
        return (entry, leave) if low <= math.floor(g) < high else (leave, leave)
    first, last = (float(low), float(high)) if d > 0.0 else (float(high), float(low))
    if compare((first, g, d), entry) > 0:
        entry = (first, g, d)
    if compare((last, g, d), leave) < 0:
        leave = (last, g, d)
    return entry, leave


@inlined
def clip_ray(g: Moment, d: Moment, near: float, far: float, box: np.ndarray) -> tuple[Moment, Moment]:
    """Exact entry and exit moments of a ray with parameter in [near, far] and a box of cells [lx hx ly hy lz hz)."""
    entry = (near, 0.0, 1.0)
    leave = (far, 0.0, 1.0)
    entry, leave = _clip_axis(g[0], d[0], box[0], box[1], entry, leave)
    entry, leave = _clip_axis(g[1], d[1], box[2], box[3], entry, leave)
    return _clip_axis(g[2], d[2], box[4], box[5], entry, leave)


@inlined
def _emit(runs: np.ndarray, count: int, column: float, from_level: float, to_level: float) -> int:
    runs[count, 0] = int(column)
    runs[count, 1] = int(min(from_level, to_level))
    runs[count, 2] = int(max(from_level, to_level))
    return count + 1


@kernel
def walk_exact(g: Moment, d: Moment, near: float, far: float, box: np.ndarray, ny: int, runs: np.ndarray) -> int:
    """Write the runs (column = ix * ny + iy, low level, high level) of one ray; returns how many.

    g, d: origin and direction in grid units; near, far: range in units of the direction's parameter;
    box: int64 (6,) cells to stay in; runs: int32 (>= nx + ny + 2, 3). IRREGULAR: nothing written, see module.
    """
    if not regular_ray(g[0], g[1], g[2], d[0], d[1], d[2]):
        return IRREGULAR
    entry, leave = clip_ray(g, d, near, far, box)
    if compare(entry, leave) >= 0:
        return 0
    ix, iy = cell_after(g[0], d[0], entry), cell_after(g[1], d[1], entry)
    level = cell_after(g[2], d[2], entry)
    step_x, step_y = (1.0 if d[0] > 0.0 else -1.0), (1.0 if d[1] > 0.0 else -1.0)
    face_x, face_y = ix + max(step_x, 0.0), iy + max(step_y, 0.0)
    slow_x, slow_y = 1.0 / d[0], 1.0 / d[1]
    t_x = (face_x - g[0]) * slow_x if d[0] != 0.0 else np.inf
    t_y = (face_y - g[1]) * slow_y if d[1] != 0.0 else np.inf
    t_leave = (leave[0] - leave[1]) / leave[2]
    blur = LEVEL_BOUND * (abs(g[2]) + abs(d[2]) * t_leave) if d[2] != 0.0 else -1.0
    count = 0
    while True:
        order = -1 if t_x < t_y else 1
        t_next = min(t_x, t_y)
        if abs(t_x - t_y) <= MOMENT_BOUND * t_next:
            order = compare((face_x, g[0], d[0]), (face_y, g[1], d[1]))
        crossing = (face_x, g[0], d[0]) if order < 0 else (face_y, g[1], d[1])
        if t_next >= t_leave - MOMENT_BOUND * t_leave and compare(crossing, leave) >= 0:
            return _emit(runs, count, ix * ny + iy, level, cell_before(g[2], d[2], leave))
        z = g[2] + t_next * d[2]
        last = math.floor(z)
        following = last
        if not (blur < z - last < 1.0 - blur):
            last, following = cell_before(g[2], d[2], crossing), cell_after(g[2], d[2], crossing)
        count = _emit(runs, count, ix * ny + iy, level, last)
        level = following
        if order <= 0:
            ix += step_x
            face_x += step_x
            t_x = (face_x - g[0]) * slow_x
        if order >= 0:
            iy += step_y
            face_y += step_y
            t_y = (face_y - g[1]) * slow_y


@kernel
def walk_bresenham(
    g: Moment, d: Moment, near: float, far: float, box: np.ndarray, ny: int, runs: np.ndarray
) -> int:
    """3D Bresenham between the first and the last voxel of a ray: one voxel per step of the driving axis."""
    if not regular_ray(g[0], g[1], g[2], d[0], d[1], d[2]):
        return IRREGULAR
    entry, leave = clip_ray(g, d, near, far, box)
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
        _emit(runs, i, float(cell[0] * ny + cell[1]), float(cell[2]), float(cell[2]))
        for axis in range(3):
            error[axis] += 2 * abs(delta[axis])
            if error[axis] >= 0:
                cell[axis] += 1 if delta[axis] > 0 else -1
                error[axis] -= 2 * steps
    return steps + 1
