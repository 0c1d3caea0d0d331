"""Find the share of an object's silhouette that lies inside a camera's picture, as solid angles.

A silhouette is that of the parts of a box without anything before it, outside the picture too: a pinhole's image plane
has no measure of what lies beside or behind it, so directions are counted, not pixels. Where an object may cross the
edge of the picture, directions are spread evenly over a window around it, by a Fibonacci lattice of 377 points.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    FrameBoxes,
    bounds_of,
    half_of,
    parts_of,
    set_centre,
    set_turn,
    start_of,
    turned,
)
from riglens.core.kernels.objects.windows import TURN, corners_of, window_of_turn
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.runtime.codes import MOST_PARTS
from riglens.core.kernels.runtime.jit import kernel, lean_inlined

POINTS, _STEP = 377, 233
_STEEPEST = 1e9
UNKNOWN = -1.0


@lean_inlined
def _set_ways(traffic: FrameBoxes, box: int, start: Direction, ways: np.ndarray) -> int:
    """Write ways (parts, 2, 3) along the axes of a box from `start` to the low and the high faces of its parts; return
    how many parts there are."""
    first, end = parts_of(traffic, box)
    for part in range(first, end):
        middle, half = bounds_of(traffic, part)
        for axis in range(3):
            at = start[axis] - middle[axis]
            ways[part - first, 0, axis], ways[part - first, 1, axis] = -half[axis] - at, half[axis] - at
    return end - first


@lean_inlined
def _is_met(ways: np.ndarray, parts: int, along: Direction) -> bool:
    """Return whether a ray, in the axes of a box, enters one of its parts."""
    for part in range(parts):
        enters, leaves = 0.0, np.inf
        for axis in range(3):
            to_low, to_high, step = ways[part, 0, axis], ways[part, 1, axis], along[axis]
            if step == 0.0:
                if to_low >= 0.0 or to_high <= 0.0:
                    leaves = -1.0
                continue
            low, high = to_low / step, to_high / step
            enters, leaves = max(enters, min(low, high)), min(leaves, max(low, high))
        if enters < leaves:
            return True
    return False


@lean_inlined
def _sine(slope: float) -> float:
    """Return the sine of an elevation from its slope, which may be infinite."""
    if abs(slope) > _STEEPEST:
        return float(np.sign(slope))
    return float(slope / np.sqrt(1.0 + slope * slope))


@lean_inlined
def _set_axes(centre: np.ndarray, axes: np.ndarray) -> None:
    """Write axes (3, 3), rows in the sensor frame, whose first looks at a centre (3,)."""
    length = np.sqrt(centre[0] ** 2 + centre[1] ** 2 + centre[2] ** 2)
    for k in range(3):
        axes[0, k] = centre[k] / length
    flat = np.sqrt(axes[0, 0] ** 2 + axes[0, 1] ** 2)
    if flat > 1e-6:
        axes[1, 0], axes[1, 1], axes[1, 2] = -axes[0, 1] / flat, axes[0, 0] / flat, 0.0
    else:
        axes[1, 0], axes[1, 1], axes[1, 2] = 0.0, 1.0, 0.0
    axes[2, 0] = axes[0, 1] * axes[1, 2] - axes[0, 2] * axes[1, 1]
    axes[2, 1] = axes[0, 2] * axes[1, 0] - axes[0, 0] * axes[1, 2]
    axes[2, 2] = axes[0, 0] * axes[1, 1] - axes[0, 1] * axes[1, 0]


@lean_inlined
def _is_whole(corners: np.ndarray, edges: np.ndarray, safe_cos: float) -> bool:
    """Return whether all corners (8, 3) of a box, and so all of it, lie inside the picture for certain."""
    in_cone = between = True
    for corner in range(8):
        x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        in_cone &= x >= safe_cos * np.sqrt(x * x + y * y + z * z)
        between &= _is_between(x, y, z, edges)
    return in_cone or between


@lean_inlined
def _is_between(x: float, y: float, z: float, edges: np.ndarray) -> bool:
    """Return whether a direction lies between slopes, as the picture of a pinhole has them at its edges."""
    return bool(x > 0.0 and edges[0] * x <= y <= edges[1] * x and edges[2] * x <= z <= edges[3] * x)


@lean_inlined
def _window_of_parts(
    traffic: FrameBoxes, box: int, start: Direction, turn: np.ndarray, axes: np.ndarray, corners: np.ndarray,
    centre: np.ndarray,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the least and greatest sine of elevation, and azimuth, of the parts of a box around axes (3, 3) that look
    at it; corners (8, 3) and centre (3,) are overwritten."""
    low, high, left, right = 1.0, -1.0, TURN, -TURN
    for part in range(*parts_of(traffic, box)):
        middle, half = bounds_of(traffic, part)
        set_centre((start[0] - middle[0], start[1] - middle[1], start[2] - middle[2]), turn, centre)
        corners_of(centre, turn, half, corners)
        for corner in range(8):
            x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
            for k in range(3):
                corners[corner, k] = axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z
        window = window_of_turn(corners, False)
        low, high = min(low, _sine(window.low)), max(high, _sine(window.high))
        first = window.left if window.left < np.pi else window.left - TURN
        left, right = min(left, first), max(right, first + window.width)
    return low, high, left, min(right, left + TURN)


@kernel
def silhouettes(
    traffic: FrameBoxes, beams: Beams, boxes: np.ndarray, is_pinhole: bool, edges: np.ndarray, safe_cos: float,
    share: np.ndarray, hits: np.ndarray, directions: np.ndarray,
) -> int:  # fmt: skip
    """Write share (k,) of the silhouette of each of boxes (k,) inside a camera's picture.

    edges (4,): least and greatest slope to the left, then upwards, of a pinhole's picture, which has straight edges;
    of another lens those of a rectangle that its picture holds, as it does a cone around x of that cosine. Of objects
    that may cross its edge, the share is UNKNOWN, hits (k,) takes how many directions of the lattice meet them, and
    directions (m, 3) these, in the sensor frame, one object after the other. Return how many objects have been done:
    fewer than k where `directions` is full.
    """
    turn, axes, centre = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    corners, ways, filled = np.empty((8, 3)), np.empty((MOST_PARTS, 2, 3)), 0
    for one in range(boxes.size):
        box = boxes[one]
        start = start_of(traffic, beams, box)
        set_turn(traffic, beams.rotation, box, turn)
        set_centre(start, turn, centre)
        corners_of(centre, turn, half_of(traffic, box), corners)
        share[one], hits[one] = 1.0, 0
        if _is_whole(corners, edges, safe_cos):
            continue
        if not is_pinhole and filled + POINTS > directions.shape[0]:
            return one
        _set_axes(centre, axes)
        low, high, left, right = _window_of_parts(traffic, box, start, turn, axes, corners, centre)
        met, inside, parts = 0, 0, _set_ways(traffic, box, start, ways)
        for point in range(POINTS):
            azimuth = left + ((point * _STEP) % POINTS + 0.5) / POINTS * (right - left)
            up = low + (point + 0.5) / POINTS * (high - low)
            flat = np.sqrt(max(1.0 - up * up, 0.0))
            a, b = flat * np.cos(azimuth), flat * np.sin(azimuth)
            x = a * axes[0, 0] + b * axes[1, 0] + up * axes[2, 0]
            y = a * axes[0, 1] + b * axes[1, 1] + up * axes[2, 1]
            z = a * axes[0, 2] + b * axes[1, 2] + up * axes[2, 2]
            if not _is_met(ways, parts, turned(turn, (x, y, z))):
                continue
            met += 1
            if is_pinhole:
                inside += _is_between(x, y, z, edges)
                continue
            directions[filled, 0], directions[filled, 1], directions[filled, 2] = x, y, z
            filled += 1
        if is_pinhole:
            share[one] = inside / met if met > 0 else 1.0
        elif met > 0:
            share[one], hits[one] = UNKNOWN, met
    return int(boxes.size)
