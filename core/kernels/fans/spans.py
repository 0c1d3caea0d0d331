"""Runs of free rays in the planes of a fan, and the levels that they reach: what is left where rays are stopped.

In a vertical plane a ray of larger slope is nowhere below one of smaller slope. So of the levels that all rays of a
plane traverse in a column, the rays a..b traverse those from the lowest level of ray a up to the highest of ray b: what
is there and belongs to a stopped ray below a is also traversed by a, and the same holds above b. Two rays therefore
turn what a whole plane marks into what a run of its rays marks: each is laid over the columns, from one change of its
level to the next, and walked exactly where one of these is within TOLERANCE of a face.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.fans.planes import Fan
from riglens.core.kernels.fans.profile import TOLERANCE
from riglens.core.kernels.rays.cast import Cast, direction_at
from riglens.core.kernels.rays.walk import FARTHEST, Ray, walk_exact
from riglens.core.kernels.runtime.jit import inlined, kernel
from riglens.core.kernels.voxels.bits import mask_of

CLOSEST = 1e-9
"""Slopes that differ by less are treated as equal; far more than their rounding."""


class Limits(NamedTuple):
    """Work space: ways to the next column crossed as in `kernels.fans.planes.FanWork`; runs of one ray, int32
    (columns, 3); lowest and highest level that a span reaches, int32 (2, columns); the levels that all spans of a plane
    reach, uint64 (words per column, columns)."""

    ways: np.ndarray
    runs: np.ndarray
    limits: np.ndarray
    allowed: np.ndarray


@kernel
def limits_for(depth: int, ways: np.ndarray) -> Limits:
    """Return work space for planes that cross columns by these ways; `depth` words make a column."""
    crossed = ways.size
    return Limits(
        ways,
        np.empty((crossed, 3), np.int32),
        np.empty((2, crossed), np.int32),
        np.empty((depth, crossed), np.uint64),
    )


@kernel
def find_spans(
    is_stopped: np.ndarray, has_stops: np.ndarray, row_of: np.ndarray, planes: int, starts: np.ndarray
) -> np.ndarray:
    """Return the runs (k, 2), first and last, of rays that are not stopped, by plane; of plane p starts[p]..starts[p +
    1].

    is_stopped (rays,) by row and plane, has_stops (rows,): whether a row has such rays, row_of (n,): rows in the order
    in which runs count; starts int64 (planes + 1,), zeros before.
    """
    last = row_of.size - 1
    for is_counted in (False, True):
        if is_counted:
            for plane in range(planes):
                starts[plane + 1] += starts[plane]
            spans, place = np.empty((starts[planes], 2), np.int32), starts.copy()
        else:
            spans, place = np.empty((0, 2), np.int32), starts
        is_open, closed = np.zeros(planes, np.bool_), planes
        for j in range(row_of.size):
            row = row_of[j]
            if closed == 0 and not has_stops[row]:
                continue
            closed = 0
            for plane in range(planes):
                free = not (has_stops[row] and is_stopped[row * planes + plane])
                closed += not free
                if free != is_open[plane]:
                    is_open[plane] = free
                    if not is_counted:
                        place[plane + 1] += free
                    elif free:
                        spans[place[plane], 0], spans[place[plane], 1] = j, last
                        place[plane] += 1
                    else:
                        spans[place[plane] - 1, 1] = j - 1
        if is_counted:
            return spans
    return np.empty((0, 2), np.int32)


@kernel
def _trace(
    rays: Cast, plane: int, row: int, side: int, start: int, count: int, near: float, box: np.ndarray,
    work: Limits,
) -> bool:  # fmt: skip
    """Write the lowest (side 0) or highest (side 1) level of a ray, however long its range is, in each of `count`
    columns crossed from `start` on; below or above the box where it is there. near: forward distance of the first."""
    d = direction_at(rays, row, plane)
    g, limits, runs = (
        (rays.origin[0], rays.origin[1], rays.origin[2]),
        work.limits[side],
        work.runs,
    )
    number = walk_exact(Ray(g, d, 0.0, FARTHEST), box, rays.shape[1], runs)
    above, below = np.int32(box[5]), np.int32(box[4] - 1)
    if number <= 0:
        flat = np.sqrt(d[0] * d[0] + d[1] * d[1])
        height = g[2] + d[2] / flat * near
        limits[:count] = above if height > 0.5 * (box[4] + box[5]) else below
        return number == 0
    before, after = (below, above) if d[2] > 0.0 else (above, below)
    i, column = 0, np.int64(start)
    while i < count and column != runs[0, 0]:
        limits[i] = before
        column += np.int64(work.ways[i])
        i += 1
    for r in range(number):
        if i >= count or column != runs[r, 0]:
            return False
        limits[i] = runs[r, 1 + side]
        column += np.int64(work.ways[i])
        i += 1
    limits[i:count] = after
    return True


class Climb(NamedTuple):
    """A ray over the columns that its plane crosses: its height at the sensor and by distance along the heading, at
    which distance it enters the first column, and its place and speed there, counted towards the faces crossed."""

    height: float
    rise: float
    near: float
    ox: float
    oy: float
    ax: float
    ay: float


@inlined
def _climb_of(fan: Fan, rays: Cast, plane: int, row: int, start: int, near: float) -> Climb:
    """Return the part of a ray over the columns from `start` on."""
    d = direction_at(rays, row, plane)
    hx, hy, ix, iy = (
        fan.headings[plane, 0],
        fan.headings[plane, 1],
        start // rays.shape[1],
        start % rays.shape[1],
    )
    gx, gy = rays.origin[0], rays.origin[1]
    ox, oy = (gx - ix if hx > 0.0 else ix + 1.0 - gx), (gy - iy if hy > 0.0 else iy + 1.0 - gy)
    rise = d[2] / np.sqrt(d[0] * d[0] + d[1] * d[1])
    return Climb(rays.origin[2], rise, near, ox, oy, abs(hx), abs(hy))


@inlined
def _first_level(climb: Climb) -> tuple[float, bool]:
    """Return the level of a ray where it enters the first column, and whether that is certain."""
    if climb.near == 0.0 and climb.rise != 0.0:
        return (np.floor(climb.height) if climb.rise > 0.0 else np.ceil(climb.height) - 1.0), True
    height = climb.height + climb.near * climb.rise
    return np.floor(height), abs(height - np.rint(height)) > TOLERANCE


@kernel
def _lay_ray(climb: Climb, side: int, count: int, box: np.ndarray, limits: np.ndarray) -> bool:
    """As `_trace`, from one change of the level to the next; False where one is too close to a face."""
    level, is_certain = _first_level(climb)
    if not is_certain:
        return False
    way = 1 if climb.rise > 0.0 else -1
    at, last = int(min(max(level, box[4] - 1.0), float(box[5]))), box[5] if way > 0 else box[4] - 1
    keeps = (side == 0) == (way > 0)  # the column of a change counts for the level before it
    i = 0
    while at != last and climb.rise != 0.0:
        s = (at + (1.0 if way > 0 else 0.0) - climb.height) / climb.rise
        x, y = climb.ox + s * climb.ax, climb.oy + s * climb.ay
        column_x, column_y = np.floor(x), np.floor(y)
        if not column_x + column_y <= count:
            break
        if (x - column_x < TOLERANCE and column_x > 0.0) or x - column_x > 1.0 - TOLERANCE:
            return False
        if (y - column_y < TOLERANCE and column_y > 0.0) or y - column_y > 1.0 - TOLERANCE:
            return False
        end = min(int(column_x + column_y) + keeps, count)
        while i < end:
            limits[i] = at
            i += 1
        at += way
    limits[i:count] = at
    return True


@inlined
def _limit(
    fan: Fan, rays: Cast, row: int, side: int, around: tuple[int, int, int], near: float, box: np.ndarray,
    work: Limits,
) -> bool:  # fmt: skip
    """Do the same as `_trace`, by the fastest safe method; around: the plane, and the first column and their number."""
    plane, start, count = around
    if _lay_ray(_climb_of(fan, rays, plane, row, start, near), side, count, box, work.limits[side]):
        return True
    return _trace(rays, plane, row, side, start, count, near, box, work)


@kernel
def limit_levels(
    fan: Fan, rays: Cast, plane: int, start: int, count: int, near: float, box: np.ndarray, work: Limits
) -> bool:
    """Write the levels that the free rays of a plane can reach in the columns crossed (see `_trace`) to work.allowed;
    return False where this cannot be decided."""
    if not fan.has_bounds:
        return False
    allowed, limits, last = work.allowed, work.limits, fan.slopes.size - 1
    around = (plane, start, count)
    allowed[:, :count] = 0
    for span in range(fan.span_starts[plane], fan.span_starts[plane + 1]):
        a, b = fan.spans[span, 0], fan.spans[span, 1]
        limits[0, :count], limits[1, :count] = box[4], box[5] - 1
        if a > 0 and not (
            fan.slopes[a] - fan.slopes[a - 1] > CLOSEST
            and _limit(fan, rays, fan.row_of[a], 0, around, near, box, work)
        ):
            return False
        if b < last and not (
            fan.slopes[b + 1] - fan.slopes[b] > CLOSEST
            and _limit(fan, rays, fan.row_of[b], 1, around, near, box, work)
        ):
            return False
        for part in range(allowed.shape[0]):
            low, high, mask = limits[0, 0], limits[1, 0], mask_of(limits[0, 0], limits[1, 0], part)
            for i in range(count):
                if limits[0, i] != low or limits[1, i] != high:
                    low, high = limits[0, i], limits[1, i]
                    mask = mask_of(low, high, part)
                allowed[part, i] |= mask
    return True
