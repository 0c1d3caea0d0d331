"""Runs of free rays in the planes of a fan, and the levels that they reach: what is left where rays are stopped.

In a vertical plane a ray of larger slope is nowhere below one of smaller slope. So of the levels that all rays of a
plane traverse in a column, the rays a..b traverse those from the lowest level of ray a up to the highest of ray b: what
is there and belongs to a stopped ray below a is also traversed by a, and the same holds above b. Two rays walked
exactly therefore turn what a whole plane marks into what a run of its rays marks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.bits import FULL_WORD
from riglens.core.kernels.jit import inlined, kernel
from riglens.core.kernels.lattice import direction, rotated
from riglens.core.kernels.planes import Fan, Space
from riglens.core.kernels.walk import FARTHEST, Ray, walk_exact

CLOSEST = 1e-9
"""Slopes that differ by less are not told apart; far more than their rounding."""


class Limits(NamedTuple):
    """Work space: ways to the next column crossed as in `riglens.core.kernels.planes.FanWork`; runs of one ray, int32
    (columns, 3); lowest and highest level that a span reaches, int32 (2, columns); the levels that all spans of a plane
    reach, uint64 (words per column, columns)."""

    ways: np.ndarray
    runs: np.ndarray
    limits: np.ndarray
    allowed: np.ndarray


@kernel
def limits_for(depth: int, ways: np.ndarray) -> Limits:
    """Work space for planes that cross columns by these ways; `depth` words make a column."""
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
    """Runs (k, 2), first and last, of rays that are not stopped, by plane; of plane p starts[p]..starts[p + 1].

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


@inlined
def _mask(low: int | np.int32, high: int | np.int32, part: int) -> np.uint64:
    """Bits low..high of the word `part` of a column; none where low > high."""
    first, last = max(int(low) - 64 * part, 0), min(int(high) - 64 * part, 63)
    if first > last:
        return np.uint64(0)
    return (FULL_WORD << np.uint64(first)) & (FULL_WORD >> np.uint64(63 - last))


@kernel
def _trace(
    fan: Fan, space: Space, plane: int, row: int, side: int, start: int, count: int, near: float, box: np.ndarray,
    work: Limits,
) -> bool:  # fmt: skip
    """Write the lowest (side 0) or highest (side 1) level of a ray, however long its range is, in each of `count`
    columns crossed from `start` on; below or above the box where it is there. near: forward distance of the first."""
    d = rotated(space.rotation, direction(fan.kind, fan.rows[row], fan.planes[plane]))
    g, limits, runs = (space.origin[0], space.origin[1], space.origin[2]), work.limits[side], work.runs
    number = walk_exact(Ray(g, d, 0.0, FARTHEST), box, space.shape[1], runs)
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


@kernel
def limit_levels(
    fan: Fan, space: Space, plane: int, start: int, count: int, near: float, box: np.ndarray, work: Limits
) -> bool:
    """Write the levels that the free rays of a plane can reach in the columns crossed (see `_trace`) to work.allowed;
    False where this cannot be told."""
    if not fan.has_bounds:
        return False
    allowed, limits, last = work.allowed, work.limits, fan.slopes.size - 1
    allowed[:, :count] = 0
    for span in range(fan.span_starts[plane], fan.span_starts[plane + 1]):
        a, b = fan.spans[span, 0], fan.spans[span, 1]
        limits[0, :count], limits[1, :count] = box[4], box[5] - 1
        if a > 0 and not (
            fan.slopes[a] - fan.slopes[a - 1] > CLOSEST
            and _trace(fan, space, plane, fan.row_of[a], 0, start, count, near, box, work)
        ):
            return False
        if b < last and not (
            fan.slopes[b + 1] - fan.slopes[b] > CLOSEST
            and _trace(fan, space, plane, fan.row_of[b], 1, start, count, near, box, work)
        ):
            return False
        for part in range(allowed.shape[0]):
            for i in range(count):
                allowed[part, i] |= _mask(limits[0, i], limits[1, i], part)
    return True
