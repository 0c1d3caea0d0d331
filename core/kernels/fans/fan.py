"""Fans: all rays of an upright sensor that share a vertical plane, walked through the grid together.

The rays of one LiDAR azimuth, or of one image column of a camera without roll and pitch, run in one vertical
plane: they cross the same grid columns at the same distances and differ in slope only. Where the rays enter and
leave a level depends on the forward distance alone, the same for all planes. So the profile of the sensor - which
levels any ray is in, by distance - is made once, and laid over the columns that each plane crosses: the cost is
that of the columns and of the profile's events, however many rays there are.

Nothing is decided here within TOLERANCE of a grid face, edge or corner. Where a ray changes its level that close to
the face between two columns, it is left to an exact walk through both of them; a plane in which anything else comes so
close is left to it ray by ray (see `kernels.fans.leftover_rays`). So the set marked is exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.fans.planes import (
    ALL,
    Fan,
    FanWork,
    LeftoverRays,
    clip_side,
    is_limited,
    leave_over,
    work_for,
)
from riglens.core.kernels.fans.profile import TOLERANCE, Profile
from riglens.core.kernels.fans.spans import limit_levels, limits_for
from riglens.core.kernels.fans.ties import Start, untie
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel

FARTHEST_ORIGIN = 5e3
STRAIGHTEST = 1e-3
"""Closest heading to an axis at which rounding of the heading moves crossings by less than the tolerance."""
STRAIGHT = 1e-13
"""Heading so close to an axis that a plane drifts by less than the tolerance in any grid."""
LEAST = 1e-300
"""Stand-in for a drift of zero: quotients become huge but keep their sign."""
STEEPEST = 1e3
"""Slope beyond which rays are walked one by one."""
PLANES_LOOKED_AT = 32
EVENTS_LOOKED_AT = 32
EVENT_COST = 1.0
"""Of an event of the profile, in columns crossed."""
UNDECIDED, EMPTY, LAID = -1, 0, 1


class Course(NamedTuple):
    """Course of a plane through the columns: its place within the first one in voxels, measured towards the faces
    crossed, and the faces crossed per distance along the heading."""

    ox: float
    oy: float
    ax: float
    ay: float


class Laid(NamedTuple):
    """A plane over the columns that it crosses: the result, UNDECIDED, EMPTY or LAID; the first event of the profile
    there and the one after the last; the first column, their number, and the distance along the heading at which it is
    entered."""

    outcome: int
    first: int
    end: int
    start: int
    columns: int
    near: float


@inlined
def _start_cell(g: float, h: float, s_in: float, low: int, high: int) -> tuple[float, bool]:
    """Return the cell of one axis where the plane enters the box, and whether that is certain."""
    if s_in == 0.0:
        return (np.floor(g) if h > 0.0 else np.ceil(g) - 1.0), True
    first = float(low) if h > 0.0 else float(high)
    if s_in == (first - g) / h:
        return (float(low) if h > 0.0 else float(high) - 1.0), True
    p = g + s_in * h
    return np.floor(p), abs(p - np.rint(p)) > TOLERANCE


@inlined
def _is_close(past: float) -> int:
    """Return 1 where a place is within the tolerance of a face; `past`: its distance past the face behind it."""
    return int((past < TOLERANCE) | (past > 1.0 - TOLERANCE))


@inlined
def _stays_between(g: float, h: float) -> bool:
    """Return whether a plane stays between the same two faces of an axis, and clear of both."""
    return abs(h) < STRAIGHT and _is_close(g - np.floor(g)) == 0


@kernel
def _cross_columns(
    course: Course, steps: tuple[int, int], faces_x: int, count: int, ways: np.ndarray
) -> bool:
    """Write the ways from each of `count` columns crossed to the next; False where an edge is too close.

    steps: from a column to the next along x and y; faces_x: faces crossed along x.
    """
    ways[:count] = steps[1]
    close, pace = 0, 1.0 / course.ax
    for i in range(faces_x):
        y = course.oy + course.ay * ((i + 1.0 - course.ox) * pace)
        passed = np.floor(y)
        close |= _is_close(y - passed)
        ways[min(i + int(passed), count - 1)] = steps[0]
    return close == 0


@kernel
def _place_events(course: Course, at: np.ndarray, stretch: float, places: np.ndarray) -> bool:
    """Write in which of the columns crossed each event happens; False when one is too close to a face.

    at (n,): ascending forward distances, stretch: distance along the heading by forward distance.
    """
    ox, oy, ax, ay = course
    close = 0
    for i in range(at.size):
        s = at[i] * stretch
        x, y = ox + s * ax, oy + s * ay
        column_x, column_y = np.floor(x), np.floor(y)
        past_x, past_y = x - column_x, y - column_y
        close |= int(((past_x < TOLERANCE) & (column_x > 0.0)) | (past_x > 1.0 - TOLERANCE))
        close |= int(((past_y < TOLERANCE) & (column_y > 0.0)) | (past_y > 1.0 - TOLERANCE))
        places[i] = np.int32(column_x + column_y)
    return close == 0


@inlined
def _place_changes(profile: Profile, laid: Laid, work: FanWork) -> None:
    """Write which levels begin, and which begin or end, in each of the columns crossed."""
    work.begins[:, : laid.columns], work.toggles[:, : laid.columns] = 0, 0
    for event in range(laid.first, laid.end):
        change, place = profile.changes[event], work.places[event - laid.first]
        level = abs(change) - 1
        bit = np.uint64(1) << np.uint64(level & 63)
        work.toggles[level >> 6, place] ^= bit
        work.begins[level >> 6, place] |= bit if change > 0 else np.uint64(0)


@inlined
def _mark_columns(
    profile: Profile, laid: Laid, work: FanWork, allowed: np.ndarray | None, marks: np.ndarray
) -> None:
    """Mark the levels of the profile in the columns crossed, as far as they are allowed there, uint64 (words per
    column, columns)."""
    depth = profile.masks.shape[1]
    _place_changes(profile, laid, work)
    for part in range(depth):
        levels, word = profile.masks[laid.first, part], np.int64(laid.start * depth + part)
        for i in range(laid.columns):
            here = levels | work.begins[part, i]
            marks[word] |= here if allowed is None else here & allowed[part, i]
            levels ^= work.toggles[part, i]
            word += np.int64(work.ways[i]) * depth


@inlined
def _faces(course: Course, left_x: int, left_y: int, s_out: float) -> tuple[int, int, bool]:
    """Return the faces along x and y between the first column and the last one in the box, and whether both are
    certain.

    left_x, left_y: columns ahead of the first one in the box; s_out: distance at which the plane leaves the box.
    """
    x, y = course.ox + course.ax * s_out, course.oy + course.ay * s_out
    if x - left_x >= 1.0 - TOLERANCE:  # the plane leaves the box along x
        return left_x, int(np.floor(y)), _is_close(y - np.floor(y)) == 0
    return int(np.floor(x)), left_y, _is_close(x - np.floor(x)) == 0


@inlined
def _without(outcome: int) -> Laid:
    """Return a plane that is not laid over columns."""
    return Laid(outcome, 0, 0, 0, 0, 0.0)


@kernel
def lay_plane(
    fan: Fan,
    rays: Cast,
    profile: Profile,
    plane: int,
    box: np.ndarray,
    work: FanWork,
    leftover: LeftoverRays,
) -> Laid:
    """Lay one plane over the columns of a box; UNDECIDED when it comes too close to a face or an edge. Write the ways
    between the columns, and the column of each event, to work.
    """
    hx, hy, scale, at = fan.headings[plane, 0], fan.headings[plane, 1], fan.scales[plane], profile.at
    gx, gy, ny = rays.origin[0], rays.origin[1], rays.shape[1]
    if min(abs(hx), abs(hy)) < STRAIGHTEST and not (_stays_between(gx, hx) or _stays_between(gy, hy)):
        return _without(UNDECIDED)
    hx, hy = (LEAST if hx == 0.0 else hx), (LEAST if hy == 0.0 else hy)
    s_in, s_out = clip_side(gx, hx, box[0], box[1], 0.0, np.inf)
    s_in, s_out = clip_side(gy, hy, box[2], box[3], s_in, s_out)
    if s_out - s_in < TOLERANCE:
        return _without(EMPTY if s_out - s_in < -TOLERANCE else UNDECIDED)
    ix, certain_x = _start_cell(gx, hx, s_in, box[0], box[1])
    iy, certain_y = _start_cell(gy, hy, s_in, box[2], box[3])
    first = profile.begun
    if s_in > 0.0:
        first = int(np.searchsorted(at, scale * s_in + TOLERANCE))
        certain_x &= first == 0 or at[first - 1] < scale * s_in - TOLERANCE
    end = int(np.searchsorted(at, scale * s_out - TOLERANCE))
    if not (certain_x and certain_y) or at[end] < scale * s_out + TOLERANCE:
        return _without(UNDECIDED)
    if first == end and not profile.masks[first].any():
        return _without(EMPTY)
    ox, oy = (gx - ix if hx > 0.0 else ix + 1.0 - gx), (gy - iy if hy > 0.0 else iy + 1.0 - gy)
    course = Course(ox, oy, abs(hx), abs(hy))
    left_x = int(box[1] - 1 - ix if hx > 0.0 else ix - box[0])
    left_y = int(box[3] - 1 - iy if hy > 0.0 else iy - box[2])
    faces_x, faces_y, certain = _faces(course, left_x, left_y, s_out)
    count = faces_x + faces_y + 1
    way_x, way_y = (1 if hx > 0.0 else -1), (1 if hy > 0.0 else -1)
    if not (certain and _cross_columns(course, (way_x * ny, way_y), faces_x, count, work.ways)):
        return _without(UNDECIDED)
    if not _place_events(course, at[first:end], 1.0 / scale, work.places):
        origin = Start(int(ix), int(iy), way_x, way_y, ox, oy, course.ax / scale, course.ay / scale, count)
        if not untie(fan, rays, profile, (first, end), plane, origin, box, work, leftover):
            return _without(UNDECIDED)
    return Laid(LAID, first, end, int(ix) * ny + int(iy), count, s_in)


@inlined
def _finish_plane(
    fan: Fan, plane: int, is_marked: bool, before: int, box: np.ndarray, leftover: LeftoverRays
) -> bool:
    """Leave to the exact walk the unmarked rays of a plane: its steep rays, or all of them. Return False where the list
    is full and this plane must be walked again; a plane too long for an empty list is left as a whole.

    before: how many rays were noted before this plane.
    """
    most = leftover.rays.shape[0]
    if is_marked:
        for row in fan.steep:
            leave_over(leftover, plane, row, box)
        if leftover.noted[0] <= most:
            return True
    leftover.noted[0] = before
    if before == most or (is_marked and before > 0):
        return False
    leave_over(leftover, plane, ALL, box)
    return True


@kernel
def _mark_slab(
    fan: Fan, rays: Cast, profile: Profile, limited: bool | None, planes: tuple[int, int], rows: np.ndarray,
    leftover: LeftoverRays, marks: np.ndarray,
) -> int:  # fmt: skip
    """Mark what planes, from the first up to an end, mark in some rows of the grid; returns the plane to go on with
    when the list of rays left alone is full."""
    work, box = work_for(rays, profile), rays.box.copy()
    if limited is not None:
        limits = limits_for(profile.masks.shape[1], work.ways)
    box[0], box[1] = max(box[0], rows[0]), min(box[1], rows[1])
    for plane in range(planes[0], planes[1] if box[0] < box[1] else planes[0]):
        if is_limited(fan, plane) != (limited is not None):
            continue
        before, is_marked = leftover.noted[0], True
        if limited is None or fan.span_starts[plane] < fan.span_starts[plane + 1]:
            laid = lay_plane(fan, rays, profile, plane, box, work, leftover)
            is_marked = laid.outcome != UNDECIDED
            if laid.outcome == LAID:
                if limited is None:
                    _mark_columns(profile, laid, work, None, marks)
                else:
                    is_marked = limit_levels(
                        fan, rays, plane, laid.start, laid.columns, laid.near, box, limits
                    )
                    if is_marked:
                        _mark_columns(profile, laid, work, limits.allowed, marks)
        if not _finish_plane(fan, plane, is_marked, before, box, leftover):
            return plane
    return planes[1]


@parallel_kernel
def mark_fan(
    fan: Fan, rays: Cast, profile: Profile, limited: bool | None, end: int, slabs: np.ndarray, done: np.ndarray,
    listed: np.ndarray, counts: np.ndarray, marks: np.ndarray,
) -> None:  # fmt: skip
    """Mark the voxels that rays of planes without stopped rays traverse (`limited` None), or free rays of planes with
    some (True); marks uint64 (words,). These are two codes: most rigs are first scored without a solid body, and the
    second takes long to compile.

    slabs int64 (workers, 2): the rows of the grid for each worker, apart from each other, so that no word is shared.
    done int64 (workers,): the first plane of each worker; afterwards `end`, or less where its list was full. listed
    int32 (workers, most, 6), counts int64 (workers,): what is left to `kernels.fans.leftover_rays.mark_alone`.
    """
    for worker in numba.prange(slabs.shape[0]):
        leftover, planes = LeftoverRays(listed[worker], counts[worker : worker + 1]), (done[worker], end)
        done[worker] = _mark_slab(fan, rays, profile, limited, planes, slabs[worker], leftover, marks)


@kernel
def work_by_row(fan: Fan, rays: Cast, profile: Profile) -> np.ndarray:
    """Estimate the work in each row of the grid along x, (rows,): from a sample of planes."""
    work = np.zeros(rays.shape[0])
    gx, gy, box = rays.origin[0], rays.origin[1], rays.box
    events = profile.at.size - 1
    stride = max(1, events // EVENTS_LOOKED_AT)
    for plane in range(0, fan.scales.size, max(1, fan.scales.size // PLANES_LOOKED_AT)):
        hx, hy, scale = fan.headings[plane, 0], fan.headings[plane, 1], fan.scales[plane]
        s_in, s_out = clip_side(gx, hx, box[0], box[1], 0.0, np.inf)
        s_in, s_out = clip_side(gy, hy, box[2], box[3], s_in, s_out)
        if not s_in < s_out:
            continue
        a, b = gx + s_in * hx, gx + s_out * hx
        first, last = max(int(min(a, b)), box[0]), min(int(max(a, b)), box[1] - 1)
        share = (s_out - s_in) * (abs(hx) + abs(hy)) / (last + 1 - first)
        for row in range(first, last + 1):
            work[row] += share
        for event in range(0, events, stride):
            s = profile.at[event] / scale
            if s_in < s < s_out:
                work[min(max(int(gx + s * hx), box[0]), box[1] - 1)] += EVENT_COST * stride
    return work
