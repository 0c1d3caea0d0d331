"""Fans: all rays of an upright sensor that share a vertical plane, walked through the grid together.

The rays of one LiDAR azimuth, or of one image column of a camera without roll and pitch, run in one vertical
plane: they cross the same grid columns at the same horizontal distances and differ in slope only. One walk in
x and y therefore serves them all, and where neighbouring rays are less than a voxel apart every level between
the lowest and the highest ray is met, so a whole run of voxels costs no more than one.

Nothing is decided here within TOLERANCE of a grid face, edge or corner: a ray that comes so close is walked
through that column alone, and a plane that does is walked ray by ray, exactly. So the set marked is exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from core.kernels.jit import inlined, kernel, parallel_kernel
from core.kernels.lattice import direction, rotated
from core.kernels.levels import level_mask, level_masks
from core.kernels.walk import FARTHEST, walk_exact

TOLERANCE = 1e-8
"""Voxels. Below FARTHEST_ORIGIN voxels, crossings summed up step by step are good to half of this; what is closer
to a tie is decided exactly."""
FARTHEST_ORIGIN = 5e3
STRAIGHTEST = 1e-3
"""Along a heading closer to an axis, rounding of the heading would move the crossings by more than the tolerance."""
STEEPEST = 1e3
CLOSE = 0.999
"""Rays whose gap is below this many voxels leave no voxel between them out."""


class Fan(NamedTuple):
    """Rays of an upright sensor by plane: tables of `core.kernels.lattice` and what the fans need beside them.

    headings (planes, 2) unit vectors in x and y of the vehicle; scales (planes,) times slopes (rays,), ascending,
    are dz / ds; gap: largest step between slopes; row_of (rays,): table row of each slope; steep (k,): other rows.
    """

    kind: int
    rows: np.ndarray
    planes: np.ndarray
    headings: np.ndarray
    scales: np.ndarray
    slopes: np.ndarray
    gap: float
    row_of: np.ndarray
    steep: np.ndarray


class Space(NamedTuple):
    """Where a sensor casts: origin (3,) in grid units, rotation (3, 3), box (6,) cells, shape (3,)."""

    origin: np.ndarray
    rotation: np.ndarray
    box: np.ndarray
    shape: np.ndarray


@inlined
def _row(level: float, box: np.ndarray) -> int:
    """Column of the masks for a level, which may lie outside the box."""
    return int(min(max(level - box[4] + 1.0, 0.0), box[5] - box[4] + 1.0))


@inlined
def _bottom(z0: float, slope: float, s0: float, s1: float) -> tuple[float, bool]:
    """Lowest level between two distances, and whether it is in doubt; the sensor's own height is exact."""
    if slope == 0.0:
        return np.floor(z0), False
    z = z0 + slope * (s1 if slope < 0.0 else s0)
    tolerance = TOLERANCE if s0 > 0.0 or slope < 0.0 else 0.0
    level = np.floor(z + tolerance)
    return level, level != np.floor(z - tolerance)


@inlined
def _top(z0: float, slope: float, s0: float, s1: float) -> tuple[float, bool]:
    """Highest level between two distances, and whether it is in doubt."""
    if slope == 0.0:
        return np.floor(z0), False
    z = z0 + slope * (s1 if slope > 0.0 else s0)
    tolerance = TOLERANCE if s0 > 0.0 or slope > 0.0 else 0.0
    level = np.ceil(z - tolerance)
    return level - 1.0, level != np.ceil(z + tolerance)


@inlined
def _bits_at(
    z0: float, slopes: np.ndarray, stretch: float, box: np.ndarray
) -> tuple[np.uint64, np.uint64, bool]:
    """Levels of rays at a distance as bits of two words; True when one is within the tolerance of a face.

    Written for the vector units: no branch, two accumulators; what lies outside the box is no bit.
    """
    lower, upper = np.uint64(0), np.uint64(0)
    blurred = 0
    low, high = float(box[4]), float(box[5])
    for j in range(slopes.size):
        z = z0 + slopes[j] * stretch
        level = np.floor(z)
        close = (z - level < TOLERANCE) | (z - level > 1.0 - TOLERANCE)
        blurred |= int(close & (slopes[j] != 0.0))
        place = np.int64(level)
        bit = np.uint64(1) << np.uint64(place & 63)
        inside = (level >= low) & (level < high)
        lower |= bit if inside & (place < 64) else np.uint64(0)
        upper |= bit if inside & (place >= 64) else np.uint64(0)
    return lower, upper, blurred != 0


@inlined
def _start_bits(z0: float, slopes: np.ndarray, box: np.ndarray) -> tuple[np.uint64, np.uint64]:
    """Levels in which rays start at the sensor's own height, exactly, as bits of two words."""
    lower, upper = np.uint64(0), np.uint64(0)
    for level, met in ((np.floor(z0), slopes[slopes.size - 1] >= 0.0), (np.ceil(z0) - 1.0, slopes[0] < 0.0)):
        if met and box[4] <= level < box[5]:
            bit = np.uint64(1) << np.uint64(int(level) & 63)
            lower |= bit if level < 64 else np.uint64(0)
            upper |= bit if level >= 64 else np.uint64(0)
    return lower, upper


@inlined
def _set(base: int, part: int, bits: np.uint64, marks: np.ndarray) -> None:
    marks[base + part] |= bits


@inlined
def _mark_span(masks: np.ndarray, low: int, high: int, base: int, marks: np.ndarray) -> None:
    """Mark one run of levels in a column."""
    for part in range(masks.shape[1]):
        _set(base, part, masks[0, part, low] & masks[1, part, high], marks)


@kernel
def _walk_alone(
    fan: Fan, space: Space, plane: int, row: int, box: np.ndarray, marks: np.ndarray, runs: np.ndarray
) -> None:
    """Walk one ray exactly through a box of cells and mark what it meets."""
    d = rotated(space.rotation, direction(fan.kind, fan.rows[row], fan.planes[plane]))
    g = (space.origin[0], space.origin[1], space.origin[2])
    depth = (space.shape[2] + 63) // 64
    for r in range(walk_exact(g, d, 0.0, FARTHEST, box, space.shape[1], runs)):
        low, high = runs[r, 1], runs[r, 2]
        for part in range(low >> 6, (high >> 6) + 1):
            bits = level_mask(max(low - 64 * part, 0), min(high - 64 * part, 63))
            _set(runs[r, 0] * depth, part, bits, marks)


@kernel
def _mark_with_care(
    fan: Fan,
    space: Space,
    plane: int,
    first: int,
    end: int,
    s0: float,
    s1: float,
    column: int,
    masks: np.ndarray,
    marks: np.ndarray,
    runs: np.ndarray,
) -> None:
    """Mark one column ray by ray; a ray in doubt is walked through the column exactly."""
    ix, iy = column // space.shape[1], column % space.shape[1]
    cells = np.array([ix, ix + 1, iy, iy + 1, space.box[4], space.box[5]])
    for j in range(first, end):
        slope = fan.slopes[j] * fan.scales[plane]
        low, low_blurred = _bottom(space.origin[2], slope, s0, s1)
        high, high_blurred = _top(space.origin[2], slope, s0, s1)
        if low_blurred or high_blurred:
            _walk_alone(fan, space, plane, fan.row_of[j], cells, marks, runs)
        elif low <= high:
            base = column * masks.shape[1]
            _mark_span(masks, _row(low, space.box), _row(high, space.box), base, marks)


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


@inlined
def _trim(
    z0: float, slopes: np.ndarray, stretch: float, first: int, end: int, box: np.ndarray
) -> tuple[int, int]:
    """Leave out the rays that have left the box below or above for good."""
    while first < end and slopes[first] < 0.0 and z0 + slopes[first] * stretch < box[4] - TOLERANCE:
        first += 1
    while first < end and slopes[end - 1] > 0.0 and z0 + slopes[end - 1] * stretch > box[5] + TOLERANCE:
        end -= 1
    return first, end


@kernel
def _walk_plane(
    fan: Fan, space: Space, plane: int, masks: np.ndarray, marks: np.ndarray, runs: np.ndarray
) -> bool:
    """Walk one plane; False when it comes too close to a grid edge to be decided here. runs: work space."""
    hx, hy, scale, slopes = fan.headings[plane, 0], fan.headings[plane, 1], fan.scales[plane], fan.slopes
    gx, gy, z0 = space.origin[0], space.origin[1], space.origin[2]
    box, ny, depth = space.box, space.shape[1], masks.shape[1]
    if min(abs(hx), abs(hy)) < STRAIGHTEST:
        return False
    s_in, s_out = _clip_side(gx, hx, box[0], box[1], 0.0, np.inf)
    s_in, s_out = _clip_side(gy, hy, box[2], box[3], s_in, s_out)
    if s_out - s_in < TOLERANCE:
        return s_out - s_in < -TOLERANCE
    ix, certain_x = _start_cell(gx, hx, s_in, box[0], box[1])
    iy, certain_y = _start_cell(gy, hy, s_in, box[2], box[3])
    if not (certain_x and certain_y):
        return False
    column_x, column_y = (ny if hx > 0.0 else -ny), (1 if hy > 0.0 else -1)
    t_x, pace_x = (ix + (1.0 if hx > 0.0 else 0.0) - gx) / hx, abs(1.0 / hx)
    t_y, pace_y = (iy + (1.0 if hy > 0.0 else 0.0) - gy) / hy, abs(1.0 / hy)
    nearest = TOLERANCE / abs(hx * hy)
    first, end, s0, column = 0, slopes.size, s_in, int(ix) * ny + int(iy)
    known, blurred = False, False
    lower_now, upper_now = np.uint64(0), np.uint64(0)
    while True:
        if abs(t_x - t_y) < nearest:
            return False
        s1 = min(t_x, t_y)
        base = column * depth
        first, end = _trim(z0, slopes, scale * s0, first, end, box)
        if first == end:
            return True
        if fan.gap * scale * s1 < CLOSE:
            low, low_blurred = _bottom(z0, slopes[first] * scale, s0, s1)
            high, high_blurred = _top(z0, slopes[end - 1] * scale, s0, s1)
            if low <= high:
                _mark_span(masks, _row(low, box), _row(high, box), base, marks)
            if low_blurred or high_blurred:
                _mark_with_care(fan, space, plane, first, first + 1, s0, s1, column, masks, marks, runs)
                _mark_with_care(fan, space, plane, end - 1, end, s0, s1, column, masks, marks, runs)
            known = False
        elif depth > 2 or max(-slopes[first], slopes[end - 1]) * scale * (s1 - s0) >= CLOSE:
            _mark_with_care(fan, space, plane, first, end, s0, s1, column, masks, marks, runs)
            known = False
        else:  # every ray meets the level it comes from and the level it goes to, and no other
            if s0 == 0.0:
                lower_now, upper_now = _start_bits(z0, slopes[first:end], box)
                blurred = False
            elif not known:
                lower_now, upper_now, blurred = _bits_at(z0, slopes[first:end], scale * s0, box)
            lower, upper, blurred_then = _bits_at(z0, slopes[first:end], scale * s1, box)
            if blurred or blurred_then:
                _mark_with_care(fan, space, plane, first, end, s0, s1, column, masks, marks, runs)
            else:
                marks[base] |= lower_now | lower
                if depth == 2:
                    marks[base + 1] |= upper_now | upper
            lower_now, upper_now, known, blurred = lower, upper, True, blurred_then
        if s1 >= s_out - TOLERANCE:
            return True
        s0 = s1
        if t_x < t_y:
            column += column_x
            t_x += pace_x
        else:
            column += column_y
            t_y += pace_y


@parallel_kernel
def mark_fan(fan: Fan, space: Space, plane_from: int, plane_to: int, marks: np.ndarray) -> None:
    """Mark the voxels that rays of the planes plane_from..plane_to-1 traverse.

    Every worker writes its own row of marks uint64 (workers, words): no atomic operations, no shared words.
    """
    workers, planes, shape = marks.shape[0], plane_to - plane_from, space.shape
    masks = level_masks(space.box[4], space.box[5], (shape[2] + 63) // 64)
    for worker in numba.prange(workers):  # neighbouring planes share columns: a sector for every worker
        own = marks[worker]
        runs = np.empty((shape[0] + shape[1] + 3, 3), np.int32)
        for plane in range(
            plane_from + planes * worker // workers, plane_from + planes * (worker + 1) // workers
        ):
            if not _walk_plane(fan, space, plane, masks, own, runs):
                for row in fan.row_of:
                    _walk_alone(fan, space, plane, row, space.box, own, runs)
            for row in fan.steep:
                _walk_alone(fan, space, plane, row, space.box, own, runs)
