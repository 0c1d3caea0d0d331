"""Fans: all rays of an upright sensor that share a vertical plane, walked through the grid together.

The rays of one LiDAR azimuth, or of one image column of a camera without roll and pitch, run in one vertical
plane: they cross the same grid columns at the same distances and differ in slope only. Where the rays enter and
leave a level depends on the forward distance alone, the same for all planes. So the profile of the sensor - which
levels any ray is in, by distance - is made once, and laid over the columns that each plane crosses: the cost is
that of the columns and of the profile's events, however many rays there are.

Nothing is decided here within TOLERANCE of a grid face, edge or corner. Where a ray changes its level that close to
the face between two columns, it is walked through both of them exactly; a plane in which anything else comes so close
is walked ray by ray. So the set marked is exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.jit import inlined, kernel, parallel_kernel
from riglens.core.kernels.planes import Fan, FanWork, Space, clip_side, walk_alone
from riglens.core.kernels.profile import TOLERANCE, Profile
from riglens.core.kernels.spans import is_limited, limit_levels
from riglens.core.kernels.ties import Start, untie

FARTHEST_ORIGIN = 5e3
STRAIGHTEST = 1e-3
"""Along a heading closer to an axis, rounding of the heading would move the crossings by more than the tolerance."""
STRAIGHT = 1e-13
"""Along a heading this close to an axis, a plane does not drift by the tolerance in any grid."""
LEAST = 1e-300
"""For no drift at all: what is divided by it is huge, and keeps its sign."""
STEEPEST = 1e3
"""Rays with a larger slope are walked alone."""
PLANES_LOOKED_AT = 32
EVENTS_LOOKED_AT = 32
EVENT_COST = 1.0
"""Of an event of the profile, in columns crossed."""


class Course(NamedTuple):
    """How a plane crosses the columns: its place within the first one in voxels, counted towards the faces crossed,
    and the faces crossed by distance along the heading."""

    ox: float
    oy: float
    ax: float
    ay: float


@inlined
def _start_cell(g: float, h: float, s_in: float, low: int, high: int) -> tuple[float, bool]:
    """Cell of one axis where the plane enters the box, and whether that is certain."""
    if s_in == 0.0:
        return (np.floor(g) if h > 0.0 else np.ceil(g) - 1.0), True
    first = float(low) if h > 0.0 else float(high)
    if s_in == (first - g) / h:
        return (float(low) if h > 0.0 else float(high) - 1.0), True
    p = g + s_in * h
    return np.floor(p), abs(p - np.rint(p)) > TOLERANCE


@inlined
def _is_close(past: float) -> int:
    """1 where a place is within the tolerance of a face; `past`: how far it is past the face behind it."""
    return int((past < TOLERANCE) | (past > 1.0 - TOLERANCE))


@inlined
def _stays_between(g: float, h: float) -> bool:
    """Whether a plane stays between the same two faces of an axis, and clear of both."""
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
def _mark_columns(
    profile: Profile,
    first: int,
    end: int,
    start: int,
    count: int,
    limited: bool,
    work: FanWork,
    marks: np.ndarray,
) -> None:
    """Mark the levels of the profile in the columns crossed, from `start` on; the events first..end-1 happen there.
    limited: only those in work.allowed."""
    depth = profile.masks.shape[1]
    work.begins[:, :count], work.toggles[:, :count] = 0, 0
    for event in range(first, end):
        change, place = profile.changes[event], work.places[event - first]
        level = abs(change) - 1
        bit = np.uint64(1) << np.uint64(level & 63)
        work.toggles[level >> 6, place] ^= bit
        work.begins[level >> 6, place] |= bit if change > 0 else np.uint64(0)
    for part in range(depth):
        levels, word = profile.masks[first, part], np.int64(start * depth + part)
        if limited:
            for i in range(count):
                marks[word] |= (levels | work.begins[part, i]) & work.allowed[part, i]
                levels ^= work.toggles[part, i]
                word += np.int64(work.ways[i]) * depth
            continue
        for i in range(count):
            marks[word] |= levels | work.begins[part, i]
            levels ^= work.toggles[part, i]
            word += np.int64(work.ways[i]) * depth


@inlined
def _faces(course: Course, left_x: int, left_y: int, s_out: float) -> tuple[int, int, bool]:
    """Faces along x and y between the first column and the last one in the box, and whether both are certain.

    left_x, left_y: columns ahead of the first one in the box; s_out: distance at which the plane leaves the box.
    """
    x, y = course.ox + course.ax * s_out, course.oy + course.ay * s_out
    if x - left_x >= 1.0 - TOLERANCE:  # the plane leaves the box along x
        return left_x, int(np.floor(y)), _is_close(y - np.floor(y)) == 0
    return int(np.floor(x)), left_y, _is_close(x - np.floor(x)) == 0


@kernel
def _walk_plane(
    fan: Fan, space: Space, profile: Profile, plane: int, box: np.ndarray, work: FanWork, marks: np.ndarray
) -> bool:
    """Walk one plane through a box; False when it comes too close to a face or an edge to be decided here."""
    limited = is_limited(fan, plane)
    if limited and fan.span_starts[plane] == fan.span_starts[plane + 1]:
        return True
    hx, hy, scale, at = fan.headings[plane, 0], fan.headings[plane, 1], fan.scales[plane], profile.at
    gx, gy, ny = space.origin[0], space.origin[1], space.shape[1]
    if min(abs(hx), abs(hy)) < STRAIGHTEST and not (_stays_between(gx, hx) or _stays_between(gy, hy)):
        return False
    hx, hy = (LEAST if hx == 0.0 else hx), (LEAST if hy == 0.0 else hy)
    s_in, s_out = clip_side(gx, hx, box[0], box[1], 0.0, np.inf)
    s_in, s_out = clip_side(gy, hy, box[2], box[3], s_in, s_out)
    if s_out - s_in < TOLERANCE:
        return s_out - s_in < -TOLERANCE
    ix, certain_x = _start_cell(gx, hx, s_in, box[0], box[1])
    iy, certain_y = _start_cell(gy, hy, s_in, box[2], box[3])
    first = profile.begun
    if s_in > 0.0:
        first = int(np.searchsorted(at, scale * s_in + TOLERANCE))
        certain_x &= first == 0 or at[first - 1] < scale * s_in - TOLERANCE
    end = int(np.searchsorted(at, scale * s_out - TOLERANCE))
    if not (certain_x and certain_y) or at[end] < scale * s_out + TOLERANCE:
        return False
    if first == end and not profile.masks[first].any():
        return True
    ox, oy = (gx - ix if hx > 0.0 else ix + 1.0 - gx), (gy - iy if hy > 0.0 else iy + 1.0 - gy)
    course = Course(ox, oy, abs(hx), abs(hy))
    left_x = int(box[1] - 1 - ix if hx > 0.0 else ix - box[0])
    left_y = int(box[3] - 1 - iy if hy > 0.0 else iy - box[2])
    faces_x, faces_y, certain = _faces(course, left_x, left_y, s_out)
    count = faces_x + faces_y + 1
    way_x, way_y = (1 if hx > 0.0 else -1), (1 if hy > 0.0 else -1)
    if not (certain and _cross_columns(course, (way_x * ny, way_y), faces_x, count, work.ways)):
        return False
    if not _place_events(course, at[first:end], 1.0 / scale, work.places):
        origin = Start(int(ix), int(iy), way_x, way_y, ox, oy, course.ax / scale, course.ay / scale, count)
        if not untie(fan, space, profile, (first, end), plane, origin, box, work, marks):
            return False
    begin = int(ix) * ny + int(iy)
    if limited and not limit_levels(fan, space, plane, begin, count, s_in, box, work):
        return False
    _mark_columns(profile, first, end, begin, count, limited, work, marks)
    return True


@parallel_kernel
def mark_fan(
    fan: Fan,
    space: Space,
    profile: Profile,
    first: int,
    end: int,
    slabs: np.ndarray,
    marks: np.ndarray,
) -> None:
    """Mark the voxels that rays of the planes first..end-1 traverse; marks uint64 (words,).

    slabs int64 (workers, 2): the rows of the grid for each worker, apart from each other, so that no word is shared.
    """
    nx, ny, depth = space.shape[0], space.shape[1], profile.masks.shape[1]
    for worker in numba.prange(slabs.shape[0]):
        crossed = nx + ny + 3
        work = FanWork(
            np.empty(crossed, np.int32),
            np.empty(profile.at.size, np.int32),
            np.empty((depth, crossed), np.uint64),
            np.empty((depth, crossed), np.uint64),
            np.empty((crossed, 3), np.int32),
            np.empty((2, crossed), np.int32),
            np.empty((depth, crossed), np.uint64),
        )
        box = space.box.copy()
        box[0], box[1] = max(box[0], slabs[worker, 0]), min(box[1], slabs[worker, 1])
        for plane in range(first, end if box[0] < box[1] else first):
            if not _walk_plane(fan, space, profile, plane, box, work, marks):
                for row in fan.row_of:
                    walk_alone(fan, space, plane, row, box, marks, work.runs)
            for row in fan.steep:
                walk_alone(fan, space, plane, row, box, marks, work.runs)


@kernel
def work_by_row(fan: Fan, space: Space, profile: Profile) -> np.ndarray:
    """About how much there is to walk in each row of the grid along x, (rows,): a few planes stand for all."""
    work = np.zeros(space.shape[0])
    gx, gy, box = space.origin[0], space.origin[1], space.box
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
        work[first : last + 1] += (s_out - s_in) * (abs(hx) + abs(hy)) / (last + 1 - first)
        for event in range(0, events, stride):
            s = profile.at[event] / scale
            if s_in < s < s_out:
                work[min(max(int(gx + s * hx), box[0]), box[1] - 1)] += EVENT_COST * stride
    return work
