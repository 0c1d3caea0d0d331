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

from core.kernels.jit import inlined, kernel, parallel_kernel
from core.kernels.lattice import direction, rotated
from core.kernels.levels import mark_levels
from core.kernels.profile import TOLERANCE, Profile
from core.kernels.walk import walk_exact

FARTHEST_ORIGIN = 5e3
STRAIGHTEST = 1e-3
"""Along a heading closer to an axis, rounding of the heading would move the crossings by more than the tolerance."""
STEEPEST = 1e3
AROUND = 1e-6
"""Much more than TOLERANCE allows: rays that change their level within so many voxels are walked alone."""
TOGETHER = 1e-10
"""Events this close are met by one walk: at the slope STEEPEST still within AROUND of each other's level."""


class Fan(NamedTuple):
    """Rays of an upright sensor by plane: tables of `core.kernels.lattice` and what the fans need beside them.

    headings (planes, 2) unit vectors in x and y of the vehicle; slopes (rays,), ascending, are dz by forward
    distance, which is scales (planes,) times the distance along the heading; near, far (rays,): forward distances
    at which they begin and end, reach (2,) the distances along the rays; row_of (rays,): table row of each slope;
    steep (k,): other rows.
    """

    kind: int
    rows: np.ndarray
    planes: np.ndarray
    headings: np.ndarray
    scales: np.ndarray
    slopes: np.ndarray
    near: np.ndarray
    far: np.ndarray
    reach: np.ndarray
    row_of: np.ndarray
    steep: np.ndarray


class Space(NamedTuple):
    """Where a sensor casts: origin (3,) in grid units, rotation (3, 3), box (6,) cells, shape (3,)."""

    origin: np.ndarray
    rotation: np.ndarray
    box: np.ndarray
    shape: np.ndarray


@kernel
def _walk_alone(
    fan: Fan, space: Space, plane: int, row: int, box: np.ndarray, marks: np.ndarray, runs: np.ndarray
) -> None:
    """Walk one ray exactly through a box of cells and mark what it meets."""
    d = rotated(space.rotation, direction(fan.kind, fan.rows[row], fan.planes[plane]))
    g = (space.origin[0], space.origin[1], space.origin[2])
    depth = (space.shape[2] + 63) // 64
    for r in range(walk_exact(g, d, fan.reach[0], fan.reach[1], box, space.shape[1], runs)):
        mark_levels(marks, np.int64(runs[r, 0]) * depth, np.int64(runs[r, 1]), np.int64(runs[r, 2]))


@inlined
def _clip_side(g: float, h: float, low: int, high: int, s_in: float, s_out: float) -> tuple[float, float]:
    first, last = (float(low), float(high)) if h > 0.0 else (float(high), float(low))
    return max(s_in, (first - g) / h), min(s_out, (last - g) / h)


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


class _Work(NamedTuple):
    """Work space of one worker: way to the next column crossed, place of each event among the columns, and what
    changes in a column: levels that begin there, and levels that begin or end, uint64 (words per column, columns)."""

    ways: np.ndarray
    places: np.ndarray
    begins: np.ndarray
    toggles: np.ndarray
    runs: np.ndarray


@inlined
def _is_close(past: float) -> int:
    """1 where a place is within the tolerance of a face; `past`: how far it is past the face behind it."""
    return int((past < TOLERANCE) | (past > 1.0 - TOLERANCE))


@kernel
def _cross_columns(
    step_x: int,
    step_y: int,
    faces_x: int,
    ax: float,
    ox: float,
    ay: float,
    oy: float,
    count: int,
    ways: np.ndarray,
) -> bool:
    """Write the ways from each of `count` columns crossed to the next; False where an edge is too close.

    ax, ay: faces crossed by distance, counted from ox, oy in the first column; faces_x: faces crossed along x.
    """
    ways[:count] = step_y
    close, pace = 0, 1.0 / ax
    for i in range(faces_x):
        y = oy + ay * ((i + 1.0 - ox) * pace)
        passed = np.floor(y)
        close |= _is_close(y - passed)
        ways[min(i + int(passed), count - 1)] = step_x
    return close == 0


@kernel
def _place_events(
    at: np.ndarray, stretch: float, ax: float, ox: float, ay: float, oy: float, places: np.ndarray
) -> bool:
    """Write in which of the columns crossed each event happens; False when one is too close to a face.

    at (n,): ascending forward distances, stretch: distance along the heading by forward distance; ax, ay: faces
    crossed by distance, counted from ox, oy in the first column.
    """
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


class _Start(NamedTuple):
    """Where a plane starts: its column, the direction along each axis, and the place within the column, counted
    towards the faces crossed; speeds: faces crossed by forward distance; columns: how many are crossed."""

    ix: int
    iy: int
    step_x: int
    step_y: int
    ox: float
    oy: float
    speed_x: float
    speed_y: float
    columns: int


@inlined
def _side(place: float) -> int:
    """-1 or 1 where the face behind or ahead is too close to tell on which side of it a place is, else 0."""
    past = place - np.floor(place)
    if past < TOLERANCE and place >= 1.0 - TOLERANCE:
        return -1
    return 1 if past > 1.0 - TOLERANCE else 0


@kernel
def _walk_pair(
    fan: Fan,
    space: Space,
    plane: int,
    start: _Start,
    at: float,
    box: np.ndarray,
    work: _Work,
    marks: np.ndarray,
) -> None:
    """Walk the rays that change their level, begin or end about the distance `at` through the columns around it."""
    x, y = start.ox + at * start.speed_x, start.oy + at * start.speed_y
    pair = box.copy()
    for axis, cell, step, place in ((0, start.ix, start.step_x, x), (1, start.iy, start.step_y, y)):
        here = cell + step * int(np.floor(place))
        there = here + step * _side(place)
        pair[2 * axis] = max(pair[2 * axis], min(here, there))
        pair[2 * axis + 1] = min(pair[2 * axis + 1], max(here, there) + 1)
    for j in range(fan.slopes.size):
        z = space.origin[2] + fan.slopes[j] * at
        ends = min(abs(fan.near[j] - at), abs(fan.far[j] - at))
        if min(abs(z - np.rint(z)), ends) < AROUND:
            _walk_alone(fan, space, plane, fan.row_of[j], pair, marks, work.runs)


@kernel
def _untie(
    fan: Fan,
    space: Space,
    profile: Profile,
    events: tuple[int, int],
    plane: int,
    start: _Start,
    box: np.ndarray,
    work: _Work,
    marks: np.ndarray,
) -> bool:
    """Decide the events close to a face: levels begin after it and end before it, and the rays concerned are walked
    exactly through the columns on both sides. False where this is not enough."""
    opened, walked = np.zeros(64 * profile.masks.shape[1], np.int64), -1.0
    for event in range(events[0], events[1]):
        at, change = profile.at[event], profile.changes[event]
        x, y = start.ox + at * start.speed_x, start.oy + at * start.speed_y
        side_x, side_y, place = _side(x), _side(y), int(np.floor(x)) + int(np.floor(y))
        if side_x != 0 or side_y != 0:
            before = place - int(side_x + side_y < 0)
            if (side_x != 0 and side_y != 0) or before < 0 or before + 1 >= start.columns:
                return False
            place = before + 1 if change > 0 else before
            if at - walked > TOGETHER:
                _walk_pair(fan, space, plane, start, at, box, work, marks)
                walked = at
        work.places[event - events[0]] = place
        level = abs(change) - 1
        if change > 0:
            opened[level] = place
        elif place < opened[level]:
            return False
    return True


@inlined
def _mark_columns(
    profile: Profile, first: int, end: int, start: int, count: int, work: _Work, marks: np.ndarray
) -> None:
    """Mark the levels of the profile in the columns crossed, from `start` on; the events first..end-1 happen there."""
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
        for i in range(count):
            marks[word] |= levels | work.begins[part, i]
            levels ^= work.toggles[part, i]
            word += np.int64(work.ways[i]) * depth


@inlined
def _faces(
    ix: float, iy: float, hx: float, hy: float, s_out: float, ox: float, oy: float, box: np.ndarray
) -> tuple[int, int, bool]:
    """Faces along x and y between the first column and the last one in the box, and whether both are certain."""
    left_x = int(box[1] - 1 - ix if hx > 0.0 else ix - box[0])
    left_y = int(box[3] - 1 - iy if hy > 0.0 else iy - box[2])
    x, y = ox + abs(hx) * s_out, oy + abs(hy) * s_out
    if x - left_x >= 1.0 - TOLERANCE:  # the plane leaves the box along x
        return left_x, int(np.floor(y)), _is_close(y - np.floor(y)) == 0
    return int(np.floor(x)), left_y, _is_close(x - np.floor(x)) == 0


@kernel
def _walk_plane(
    fan: Fan, space: Space, profile: Profile, plane: int, box: np.ndarray, work: _Work, marks: np.ndarray
) -> bool:
    """Walk one plane through a box; False when it comes too close to a face or an edge to be decided here."""
    hx, hy, scale, at = fan.headings[plane, 0], fan.headings[plane, 1], fan.scales[plane], profile.at
    gx, gy, ny = space.origin[0], space.origin[1], space.shape[1]
    if min(abs(hx), abs(hy)) < STRAIGHTEST:
        return False
    s_in, s_out = _clip_side(gx, hx, box[0], box[1], 0.0, np.inf)
    s_in, s_out = _clip_side(gy, hy, box[2], box[3], s_in, s_out)
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
    ax, ay, step_x, step_y = abs(hx), abs(hy), (ny if hx > 0.0 else -ny), (1 if hy > 0.0 else -1)
    faces_x, faces_y, certain = _faces(ix, iy, hx, hy, s_out, ox, oy, box)
    count = faces_x + faces_y + 1
    if not (certain and _cross_columns(step_x, step_y, faces_x, ax, ox, ay, oy, count, work.ways)):
        return False
    if not _place_events(at[first:end], 1.0 / scale, ax, ox, ay, oy, work.places):
        way_x, way_y = (1 if hx > 0.0 else -1), (1 if hy > 0.0 else -1)
        origin = _Start(int(ix), int(iy), way_x, way_y, ox, oy, ax / scale, ay / scale, count)
        if not _untie(fan, space, profile, (first, end), plane, origin, box, work, marks):
            return False
    _mark_columns(profile, first, end, int(ix) * ny + int(iy), count, work, marks)
    return True


@parallel_kernel
def mark_fan(
    fan: Fan,
    space: Space,
    profile: Profile,
    plane_from: int,
    plane_to: int,
    slabs: np.ndarray,
    workers: int,
    marks: np.ndarray,
) -> None:
    """Mark the voxels that rays of the planes plane_from..plane_to-1 traverse; marks uint64 (words,).

    slabs (k, 2): the rows of the grid, cut into parts: each is walked by one worker, so that no word is shared.
    """
    nx, ny, depth = space.shape[0], space.shape[1], profile.masks.shape[1]
    for worker in numba.prange(workers):
        crossed = nx + ny + 3
        work = _Work(
            np.empty(crossed, np.int32),
            np.empty(profile.at.size, np.int32),
            np.empty((depth, crossed), np.uint64),
            np.empty((depth, crossed), np.uint64),
            np.empty((crossed, 3), np.int32),
        )
        for slab in range(worker, slabs.shape[0], workers):
            box = space.box.copy()
            box[0], box[1] = max(box[0], slabs[slab, 0]), min(box[1], slabs[slab, 1])
            if box[0] >= box[1]:
                continue
            for plane in range(plane_from, plane_to):
                if not _walk_plane(fan, space, profile, plane, box, work, marks):
                    for row in fan.row_of:
                        _walk_alone(fan, space, plane, row, box, marks, work.runs)
                for row in fan.steep:
                    _walk_alone(fan, space, plane, row, box, marks, work.runs)
